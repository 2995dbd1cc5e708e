//! Photons that surfaces guide: [`scene::guide`], in lanes.

use crate::sampling::cosine_hemisphere;
use lanes::{Lanes, MOST_LANES, Row, V3};
use scene::guide::{FACES, Guide, PARTS, ROWS, SIDE};
use std::sync::Arc;

// A row of a table is a row of lanes' memory.
const _: () = assert!(size_of::<Row>() == SIDE * size_of::<f32>());

/// The guide's tables, in rows.
pub(crate) struct GuideTables {
    guide: Arc<Guide>,
    rows: Vec<Row>,
}

/// Two uniform numbers bent by a table, and the weight of a photon.
struct Bent<L: Lanes> {
    u: L::F,
    v: L::F,
    weight: L::F,
}

impl GuideTables {
    pub(super) fn new(guide: Arc<Guide>) -> Self {
        let rows = guide.rows.iter().map(|row| bytemuck::cast(*row)).collect();
        Self { guide, rows }
    }

    /// The directions of photons that surfaces scatter, guided, and the weights.
    #[inline(always)]
    pub(super) fn scatter<L: Lanes>(&self, point: V3<L>, normal: V3<L>, u: L::F, v: L::F) -> (V3<L>, L::F) {
        let Bent { u, v, weight } = self.guided::<L>(self.surface(point, normal), u, v);
        (cosine_hemisphere(normal, u, v), weight)
    }

    /// As [`Guide::surface`].
    #[inline(always)]
    fn surface<L: Lanes>(&self, point: V3<L>, normal: V3<L>) -> L::U {
        let place = (point - V3::splat(self.guide.low)).scale(L::f(self.guide.scale));
        let (zero, last) = (L::f(0.0), L::f((PARTS - 1) as f32));
        let part = |x: L::F| L::truncate(L::min(L::max(x, zero), last));
        let (parts, faces) = (L::u(PARTS), L::u(FACES));
        ((part(place.x) * parts + part(place.y)) * parts + part(place.z)) * faces + face(normal)
    }

    /// As [`Guide::guided`].
    #[inline(always)]
    fn guided<L: Lanes>(&self, table: L::U, u: L::F, v: L::F) -> Bent<L> {
        let first = table * L::u(ROWS as u32);
        let (cell, u, of_u) = self.bend::<L>(first, u);
        let (_, v, of_v) = self.bend::<L>(first + L::u(1) + cell, v);
        Bent { u, v, weight: L::f(1.0 / (SIDE * SIDE) as f32) / (of_u * of_v) }
    }

    /// The cells that numbers choose in these rows, the numbers bent into them, and the cells' probabilities.
    #[inline(always)]
    fn bend<L: Lanes>(&self, rows: L::U, u: L::F) -> (L::U, L::F, L::F) {
        let mut ids = [0; MOST_LANES];
        L::store_u(rows, &mut ids);
        let ends = L::gather_rows(&self.rows, &ids);
        let Found { cell, before, after } = find::<L>(&ends, u);
        let probability = after - before;
        let bent = (cell + (u - before) / probability) * L::f(1.0 / SIDE as f32);
        (L::truncate(cell), bent, probability)
    }
}

/// The cell of a row in which a number lies, and its ends.
struct Found<L: Lanes> {
    cell: L::F,
    before: L::F,
    after: L::F,
}

/// Finds the cells by halving: ends ascend, so one comparison tells in which half of the cells the number lies. Of the ends
/// that are left, the last closes the half.
#[inline(always)]
fn find<L: Lanes>(ends: &[L::F; SIDE], u: L::F) -> Found<L> {
    const { assert!(SIDE == 8) };
    let pick = |is_upper: L::M, lower: L::F, upper: L::F| L::select(is_upper, upper, lower);
    let [a, b, c, d, e, f, g, h] = *ends;
    let half = L::le(d, u);
    let (cell, before) = (pick(half, L::f(0.0), L::f(4.0)), pick(half, L::f(0.0), d));
    let [a, b, c, d] = [pick(half, a, e), pick(half, b, f), pick(half, c, g), pick(half, d, h)];
    let half = L::le(b, u);
    let (cell, before) = (pick(half, cell, cell + L::f(2.0)), pick(half, before, b));
    let [a, b] = [pick(half, a, c), pick(half, b, d)];
    let half = L::le(a, u);
    Found { cell: pick(half, cell, cell + L::f(1.0)), before: pick(half, before, a), after: pick(half, a, b) }
}

/// The axis nearest to a normal, and whether it points backwards.
#[inline(always)]
fn face<L: Lanes>(normal: V3<L>) -> L::U {
    let V3 { x, y, z } = normal;
    let [ax, ay, az] = [x, y, z].map(|component| L::max(component, -component));
    let is_x = L::le(ay, ax) & L::le(az, ax);
    let is_y = L::le(az, ay);
    let along = L::select(is_x, x, L::select(is_y, y, z));
    let axis = L::select_u(is_x, L::u(0), L::select_u(is_y, L::u(2), L::u(4)));
    axis + L::select_u(L::lt(along, L::f(0.0)), L::u(1), L::u(0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use lanes::Emulated;
    use scene::Vec3;
    use scene::guide::{Guided, SURFACES, Shares};

    /// Tables that all differ, some cells of which have the least share.
    fn guide() -> Guide {
        let shares = |table: usize| -> Shares {
            let value = |u: usize, v: usize| ((u * 5 + v * 3 + table * 7) % 13 % 6) as f64;
            let sum: f64 = (0..SIDE * SIDE).map(|cell| value(cell / SIDE, cell % SIDE)).sum();
            std::array::from_fn(|u| std::array::from_fn(|v| value(u, v) / sum))
        };
        Guide::of_shares(Vec3::new(-2.0, 0.5, 10.0), 0.25, (0..SURFACES as usize).map(shares), &shares(0))
    }

    fn first(lanes: <Emulated as Lanes>::F) -> f32 {
        let mut stored = [0.0; MOST_LANES];
        Emulated::store(lanes, &mut stored);
        stored[0]
    }

    fn table(tables: &GuideTables, point: Vec3, normal: Vec3) -> u32 {
        let mut stored = [0; MOST_LANES];
        Emulated::store_u(tables.surface::<Emulated>(V3::splat(point), V3::splat(normal)), &mut stored);
        stored[0]
    }

    /// Where components of a normal are alike, at borders of parts, and outside of them too.
    #[test]
    fn surfaces_have_the_tables_that_the_scene_gives_them() {
        let guide = guide();
        let tables = GuideTables::new(Arc::new(guide.clone()));
        let sides = [-0.8, -0.5, -0.0, 0.0, 0.5, 0.8];
        let places = [-9.0, 0.0, 3.999, 4.0, 7.0, 8.0, 11.0, 12.0, 15.9, 16.0, 900.0];
        for x in sides {
            for normal in sides.iter().flat_map(|&y| sides.map(|z| Vec3::new(x, y, z))) {
                for (k, place) in places.into_iter().enumerate() {
                    let point = guide.low + Vec3::new(place, places[(k + 3) % 11], places[(k + 7) % 11]);
                    let expected = guide.surface(point, normal);
                    assert_eq!(table(&tables, point, normal), expected, "{normal} at {point}");
                }
            }
        }
    }

    /// Also at the borders of cells, to the bit.
    #[test]
    fn numbers_are_bent_as_the_scene_bends_them() {
        let guide = guide();
        let tables = GuideTables::new(Arc::new(guide.clone()));
        for number in [0, 1, 5, 100, SURFACES - 1] {
            let rows = &guide.rows[number as usize * ROWS..][..ROWS];
            let ends = rows.as_flattened().iter().flat_map(|end| [end.next_down(), *end]);
            let numbers: Vec<f32> = ends.filter(|end| *end < 1.0).chain([0.0, 0.99]).step_by(5).collect();
            for (&u, &v) in numbers.iter().zip(numbers.iter().rev()) {
                let Guided { u: bent_u, v: bent_v, weight } = guide.guided(number, u, v);
                let lanes = <Emulated as Lanes>::f;
                let found = tables.guided::<Emulated>(<Emulated as Lanes>::u(number), lanes(u), lanes(v));
                let found = [found.u, found.v, found.weight].map(first);
                assert_eq!(found, [bent_u, bent_v, weight], "table {number}, {u}, {v}");
            }
        }
    }
}
