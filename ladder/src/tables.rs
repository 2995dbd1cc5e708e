//! A still scene in the form that kernels read: shapes that are broadcast to the lanes, and the properties of hit
//! spheres, as an array of structures and as a structure of arrays.

use lanes::{Lanes, Row};
use scene::ray::SphereId;
use scene::still::{Enclosure, Ground, Light, Role};
use scene::{Material, Still, Vec3};

/// The low bits of a surface's tag.
pub(crate) mod tag {
    /// Hit from inside only.
    pub(crate) const ENCLOSURE: u32 = 1;
    /// Hit from both sides.
    pub(crate) const GLASS: u32 = 2;
    /// Hit from outside, close to the eye.
    pub(crate) const GROUND: u32 = 4;
}

/// The kinds of material.
pub(crate) mod kind {
    pub(crate) const DIFFUSE: u32 = 0;
    pub(crate) const SPECULAR: u32 = 1;
    pub(crate) const DIELECTRIC: u32 = 2;
}

/// A sphere, as intersection reads it.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Shape {
    Solid(Ball),
    Glass(Ball),
    Ground(Ground),
    Enclosure(Enclosure),
}

/// A sphere that is hit from outside, or from both sides.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ball {
    pub(crate) sphere: SphereId,
    pub(crate) center: Vec3,
    pub(crate) radius_squared: f32,
}

/// The words that lanes read of a sphere: `a.x a.y a.z scale b.x b.y b.z tag`, then `albedo ior emission kind`.
///
/// For p on the sphere, the vector from its centre is `(p - a) + b`. For an enclosure, a is the anchor, b its offset
/// and the scale is `-1 / radius`; for a ground likewise, with `1 / radius`. For others, a is the centre, b is zero and the scale is the radius.
const WORDS: usize = 16;

/// The tables of one still.
pub(crate) struct Tables<'a> {
    pub(crate) still: &'a Still<'a>,
    /// The shapes that rays may hit, in the order of the spheres.
    pub(crate) shapes: Vec<Shape>,
    /// The shapes that can cast shadows.
    pub(crate) shadow_casters: Vec<Shape>,
    /// Two rows per sphere.
    rows: Vec<Row>,
    /// The same words, with one array per word. The lengths are powers of two.
    columns: Vec<Vec<u32>>,
    /// Two rows per light: centre, squared radius, emission, and sphere; then photon power, radius, whether it emits
    /// inwards, and its probability.
    pub(crate) lights: Vec<Row>,
    /// The indices and shapes of lights that can be seen from inside.
    pub(crate) shells: Vec<(u32, Shape)>,
}

impl<'a> Tables<'a> {
    pub(crate) fn new(still: &'a Still<'a>) -> Self {
        let ids = 0..still.spheres.len() as SphereId;
        let shapes: Vec<Shape> = ids.clone().map(|id| shape(still, id)).collect();
        let casts_shadow = |s: &&Shape| !matches!(s, Shape::Enclosure(e) if !e.casts_shadow);
        let shadow_casters = shapes.iter().filter(casts_shadow).copied().collect();
        let rows: Vec<Row> = ids.flat_map(|id| sphere_rows(still, id)).collect();
        let padded = still.spheres.len().next_power_of_two();
        let mut columns = vec![vec![0; padded]; WORDS];
        for (number, pair) in rows.chunks_exact(2).enumerate() {
            for (word, column) in pair.iter().flat_map(|row| row.0).zip(&mut columns) {
                column[number] = word.to_bits();
            }
        }
        let entries = &still.lights.entries;
        let lights = entries.iter().flat_map(|light| light_rows(still, light)).collect();
        let shells = entries.iter().enumerate().filter(|(_, light)| light.inside);
        let shells = shells.map(|(number, light)| (number as u32, shape(still, light.sphere))).collect();
        Self { still, shapes, shadow_casters, rows, columns, lights, shells }
    }

    /// The words of the spheres `ids`, one per lane and each valid, from rows or from columns.
    #[inline(always)]
    pub(crate) fn fetch<L: Lanes>(&self, ids: &[u32], from_columns: bool) -> [[L::F; 8]; 2] {
        if from_columns {
            let id = L::load_u(ids);
            let mut words = [[L::f(0.0); 8]; 2];
            for (word, column) in self.columns.iter().enumerate() {
                words[word / 8][word % 8] = L::from_bits(L::gather_u(column, id));
            }
            return words;
        }
        fetch_pairs::<L>(&self.rows, ids)
    }

    /// The colour of sphere `id`.
    pub(crate) fn albedo(&self, id: SphereId) -> Vec3 {
        let [r, g, b, ..] = self.rows[2 * id as usize + 1].0;
        Vec3::new(r, g, b)
    }

    /// The colours of the spheres `ids`.
    #[inline(always)]
    pub(crate) fn albedos<L: Lanes>(&self, ids: L::U) -> [L::F; 3] {
        let mut numbers = [0; lanes::MOST_LANES];
        L::store_u(ids + ids + L::u(1), &mut numbers);
        let [r, g, b, ..] = L::gather_rows(&self.rows, &numbers);
        [r, g, b]
    }

    /// True if sphere `id` is a shell: photons that arrive there count at any angle for visible points on it.
    #[inline(always)]
    pub(crate) fn is_shell(&self, id: SphereId) -> bool {
        matches!(self.still.roles[id as usize], Role::Enclosure(_))
    }
}

/// Reads two rows per lane: `rows[2 i]` and `rows[2 i + 1]` for every index i.
#[inline(always)]
pub(crate) fn fetch_pairs<L: Lanes>(rows: &[Row], index: &[u32]) -> [[L::F; 8]; 2] {
    let (mut first, mut second) = ([0; lanes::MOST_LANES], [0; lanes::MOST_LANES]);
    for lane in 0..L::N {
        first[lane] = 2 * index[lane];
        second[lane] = 2 * index[lane] + 1;
    }
    [L::gather_rows(rows, &first), L::gather_rows(rows, &second)]
}

/// The shape of sphere `id`.
fn shape(still: &Still, id: SphereId) -> Shape {
    let s = &still.spheres[id as usize];
    let ball = Ball { sphere: id, center: s.center, radius_squared: s.radius * s.radius };
    match still.roles[id as usize] {
        Role::Solid => Shape::Solid(ball),
        Role::Glass => Shape::Glass(ball),
        Role::Ground(g) => Shape::Ground(still.grounds[g as usize]),
        Role::Enclosure(e) => Shape::Enclosure(still.enclosures[e as usize]),
    }
}

fn sphere_rows(still: &Still, id: SphereId) -> [Row; 2] {
    let sphere = &still.spheres[id as usize];
    let (a, scale, b, tag) = match still.roles[id as usize] {
        Role::Solid => (sphere.center, sphere.radius, Vec3::ZERO, 0),
        Role::Glass => (sphere.center, sphere.radius, Vec3::ZERO, tag::GLASS),
        Role::Ground(g) => {
            let g = &still.grounds[g as usize];
            (g.anchor, g.inverse_radius, g.offset, tag::GROUND)
        }
        Role::Enclosure(e) => {
            let e = &still.enclosures[e as usize];
            (e.anchor, e.minus_inverse_radius, e.offset, tag::ENCLOSURE)
        }
    };
    let material = still.material(id);
    let (ior, kind) = match *material {
        Material::Diffuse { .. } => (1.0, kind::DIFFUSE),
        Material::Specular { .. } => (1.0, kind::SPECULAR),
        Material::Dielectric { ior, .. } => (ior, kind::DIELECTRIC),
    };
    let (c, e) = (material.albedo(), sphere.emission);
    [
        Row([a.x, a.y, a.z, scale, b.x, b.y, b.z, f32::from_bits(tag)]),
        Row([c.x, c.y, c.z, ior, e.x, e.y, e.z, f32::from_bits(kind)]),
    ]
}

fn light_rows(still: &Still, light: &Light) -> [Row; 2] {
    let s = &still.spheres[light.sphere as usize];
    let (c, e, p) = (s.center, s.emission, light.photon_power);
    let inwards = f32::from_bits(u32::from(light.inside));
    [
        Row([c.x, c.y, c.z, s.radius * s.radius, e.x, e.y, e.z, f32::from_bits(light.sphere)]),
        Row([p.x, p.y, p.z, s.radius, inwards, light.probability, 0.0, 0.0]),
    ]
}
