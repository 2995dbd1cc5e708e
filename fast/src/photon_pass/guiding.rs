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
        let part = |x: L::F| {
            let inner = L::select(L::lt(zero, x), x, zero);
            L::truncate(L::select(L::lt(inner, last), inner, last))
        };
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
        let (mut cell, mut before, mut after) = (L::f(0.0), L::f(0.0), ends[0]);
        for (end, next) in ends.iter().zip(&ends[1..]) {
            let is_before = L::le(*end, u);
            cell = L::select(is_before, cell + L::f(1.0), cell);
            before = L::select(is_before, *end, before);
            after = L::select(is_before, *next, after);
        }
        let probability = after - before;
        let bent = (cell + (u - before) / probability) * L::f(1.0 / SIDE as f32);
        (L::truncate(cell), bent, probability)
    }
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
