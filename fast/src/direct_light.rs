//! One shadow ray per visible point: `reference::direct_light`, over a batch.
//!
//! ```text
//! for each packet: choose a lamp and a point on it; what it may bring; walls in between
//! for the batch: balls in between
//! ```

use crate::hierarchy::{BLOCKED, Rays, Scratch};
use crate::intersect::{RayLanes, from_either_side, from_inside, occluded};
use crate::lanes::{Lanes, MOST_LANES, Row};
use crate::light_choice::LightChoice;
use crate::paths::{Floats, ROOM, Vectors, Words};
use crate::sampling::{cosine_hemisphere, uniform_cone};
use crate::tables::{Shape, Tables, shape};
use crate::vec3::V3;
use scene::Still;
use std::f32::consts::PI;

/// The lights as lanes fetch them: centre, squared radius, radiance over probability, and sphere.
pub(crate) struct LightTable {
    rows: Vec<Row>,
    /// How one of them is chosen.
    pub(crate) choice: LightChoice,
    /// The lights seen from within, which are few: their numbers and shapes.
    shells: Vec<(u32, Shape)>,
}

impl LightTable {
    pub(crate) fn new(still: &Still) -> Self {
        let row = |light: &scene::still::Light| {
            let s = &still.spheres[light.sphere as usize];
            let (c, e) = (s.center, light.radiance);
            Row([c.x, c.y, c.z, s.radius * s.radius, e.x, e.y, e.z, f32::from_bits(light.sphere)])
        };
        let shells = still.lights.entries.iter().enumerate().filter(|(_, light)| light.inside);
        let shells = shells.map(|(number, light)| (number as u32, shape(still, light.sphere)));
        Self {
            rows: still.lights.entries.iter().map(row).collect(),
            choice: LightChoice::new(&still.lights.cumulative),
            shells: shells.collect(),
        }
    }

    /// True if nothing glows.
    pub(crate) fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }
}

/// The uniform numbers of a shadow ray.
pub(crate) struct ShadowNumbers<L: Lanes> {
    pub(crate) choice: L::F,
    pub(crate) u: L::F,
    pub(crate) v: L::F,
}

/// Points that want light.
pub(crate) struct Receivers<L: Lanes> {
    /// Which lanes there are.
    pub(crate) live: L::M,
    pub(crate) point: V3<L>,
    pub(crate) normal: V3<L>,
    pub(crate) sphere: L::U,
}

/// The shadow rays of a batch.
pub(crate) struct ShadowRays {
    direction: Vectors,
    /// Distance of the lamp; negative for what need not be followed.
    t: Floats,
    lamp: Words,
    /// Irradiance, if nothing is in between.
    irradiance: Vectors,
}

impl ShadowRays {
    pub(crate) fn new() -> Self {
        Self { direction: Vectors::ZERO, t: [0.0; ROOM], lamp: [0; ROOM], irradiance: Vectors::ZERO }
    }

    /// Aims one ray per lane, the rays from `at` on, and follows them as far as walls are concerned.
    #[inline(always)]
    pub(crate) fn aim<L: Lanes>(
        &mut self,
        at: usize,
        tables: &Tables,
        lights: &LightTable,
        to: &Receivers<L>,
        numbers: &ShadowNumbers<L>,
    ) {
        let zero = L::f(0.0);
        let &Receivers { live, point, normal, sphere } = to;
        let number = lights.choice.choose::<L>(numbers.choice);
        let mut index = [0; MOST_LANES];
        L::store_u(number, &mut index);
        let [cx, cy, cz, r2, er, eg, eb, lamp] = L::gather_rows(&lights.rows, &index);
        let lamp = L::bits(lamp);
        let (mut direction, mut t, mut weight) =
            from_outside(V3::new(cx, cy, cz), r2, point, normal, numbers);
        let mut valid = L::lt(zero, weight) & !L::eq(sphere, lamp);
        for (shell_number, shape) in &lights.shells {
            let chosen = L::eq(number, L::u(*shell_number));
            let within = cosine_hemisphere(normal, numbers.u, numbers.v);
            let (t_within, is_within) =
                distance_within(shape, &RayLanes { origin: point, direction: within, leaves: sphere });
            direction = V3::select(chosen, within, direction);
            t = L::select(chosen, t_within, t);
            weight = L::select(chosen, L::f(PI), weight);
            valid = (chosen & is_within) | (!chosen & valid);
        }
        let ray = RayLanes { origin: point, direction, leaves: sphere };
        let lit = live & valid & !occluded(&tables.shadow_casters, &ray, t, lamp);
        let irradiance = V3::<L>::new(er, eg, eb).scale(weight);
        self.direction.store(at, direction);
        L::store(L::select(lit, t, L::f(-1.0)), &mut self.t[at..]);
        L::store_u(lamp, &mut self.lamp[at..]);
        self.irradiance.store(at, V3::select(lit, irradiance, V3::new(zero, zero, zero)));
    }

    /// Follows the first `count` rays, from `points` on `spheres`, as far as balls are concerned.
    #[inline(always)]
    pub(crate) fn follow<L: Lanes>(
        &mut self,
        tables: &Tables,
        points: &Vectors,
        spheres: &Words,
        scratch: &mut Scratch,
        count: usize,
    ) {
        let rays =
            Rays { origin: points, direction: &self.direction, leaves: spheres, passes: &self.lamp, count };
        tables.hierarchy.occlude::<L>(&tables.surfaces, &rays, scratch, &mut self.t);
    }

    /// The irradiance that the rays from `at` on have brought.
    #[inline(always)]
    pub(crate) fn irradiance<L: Lanes>(&self, at: usize) -> V3<L> {
        let is_blocked = L::eq(L::bits(L::load(&self.t[at..])), L::u(BLOCKED.to_bits()));
        let zero = L::f(0.0);
        V3::select(is_blocked, V3::new(zero, zero, zero), self.irradiance.load(at))
    }
}

/// Direction in the cone of the lamp, distance to it, and weight: not positive where the lamp does not count.
#[inline(always)]
fn from_outside<L: Lanes>(
    center: V3<L>,
    r2: L::F,
    point: V3<L>,
    normal: V3<L>,
    numbers: &ShadowNumbers<L>,
) -> (V3<L>, L::F, L::F) {
    let (zero, one, two) = (L::f(0.0), L::f(1.0), L::f(2.0));
    let to_center = center - point;
    let d2 = to_center.dot(to_center);
    let d = L::sqrt(d2);
    let sin2_max = r2 / d2;
    let height = sin2_max / (one + L::sqrt(one - sin2_max));
    let (direction, h) = uniform_cone(to_center.scale(one / d), height, numbers.u, numbers.v);
    let cos = normal.dot(direction);
    let half_chord2 = r2 - d2 * (h * (two - h));
    let half_chord = L::select(L::lt(zero, half_chord2), L::sqrt(half_chord2), zero);
    let t = d * (one - h) - half_chord;
    let counts = L::lt(zero, cos) & L::lt(r2, d2);
    (direction, t, L::select(counts, cos * (L::f(2.0 * PI) * height), zero))
}

/// Distance to a glowing shell from within, and whether the ray starts there.
#[inline(always)]
fn distance_within<L: Lanes>(shape: &Shape, ray: &RayLanes<L>) -> (L::F, L::M) {
    let infinity = L::f(f32::INFINITY);
    match shape {
        Shape::Enclosure(e) => {
            let t = from_inside(e, ray);
            (t, L::lt(t, infinity))
        }
        Shape::Solid(ball) | Shape::Glass(ball) => {
            let (t, valid) = from_either_side(ball, ray);
            let f = ray.origin - V3::splat(ball.center);
            let within = L::lt(f.dot(f), L::f(ball.radius_squared));
            (t, valid & L::lt(t, infinity) & within)
        }
    }
}
