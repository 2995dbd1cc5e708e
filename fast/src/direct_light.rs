//! Direct light: one shadow ray per visible point, `reference::direct_light` over a batch.
//!
//! ```text
//! for each packet of visible points:
//!     choose a lamp (light_tree.rs) and a point on it; compute the irradiance if nothing blocks it
//!     test the shadow rays against the walls
//! for the batch: test the shadow rays against the balls
//! ```

use crate::hierarchy::{BLOCKED, Rays, SearchBuffers};
use crate::intersect::{RayLanes, from_either_side, from_inside, occluded};
use crate::light_choice::LightChoice;
use crate::light_tree::{Choice, LightTree};
use crate::paths::{Floats, ROOM, Vectors, Words};
use crate::sampling::{cosine_hemisphere, uniform_cone};
use crate::shapes::Shape;
use crate::tables::Tables;
use bytemuck::{Pod, Zeroable};
use lanes::{Lanes, MOST_LANES, Row, V3};
use scene::Still;
use scene::ray::SphereId;
use std::f32::consts::PI;

/// A light's row in the table.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct LightRow {
    center: [f32; 3],
    radius_squared: f32,
    emission: [f32; 3],
    sphere: SphereId,
}

/// The lights, for lanes to choose and to fetch.
pub(crate) struct LightTable {
    /// [`LightRow`]s.
    rows: Vec<Row>,
    /// Chooses a light for a photon.
    pub(crate) choice: LightChoice,
    /// Chooses a light for a point; `None` if there is one light at most.
    tree: Option<LightTree>,
    /// The numbers and shapes of the lights that shine inwards, which are few.
    shells: Vec<(u32, Shape)>,
}

impl LightTable {
    pub(crate) fn new(still: &Still) -> Self {
        let row = |light: &scene::still::Light| {
            let s = &still.spheres[light.sphere as usize];
            bytemuck::cast(LightRow {
                center: s.center.into(),
                radius_squared: s.radius * s.radius,
                emission: s.emission.into(),
                sphere: light.sphere,
            })
        };
        let shells = still.lights.entries.iter().enumerate().filter(|(_, light)| light.inside);
        let shells = shells.map(|(number, light)| (number as u32, Shape::of(still, light.sphere)));
        Self {
            rows: still.lights.entries.iter().map(row).collect(),
            choice: LightChoice::new(&still.lights.cumulative),
            tree: LightTree::new(still),
            shells: shells.collect(),
        }
    }

    /// True if nothing glows.
    pub(crate) fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// The lights that `u` chooses for the receivers, of which there must be one.
    #[inline(always)]
    pub(crate) fn choose<L: Lanes>(&self, to: &Receivers<L>, u: L::F) -> Choice<L> {
        match &self.tree {
            Some(tree) => tree.choose(to.live, to.point, to.normal, u),
            None => Choice { found: to.live, light: L::u(0), probability: L::f(1.0) },
        }
    }

    /// The lights with these numbers.
    #[inline(always)]
    fn gather<L: Lanes>(&self, numbers: &[u32]) -> LightLanes<L> {
        let [cx, cy, cz, radius_squared, r, g, b, sphere] = L::gather_rows(&self.rows, numbers);
        LightLanes {
            center: V3::new(cx, cy, cz),
            radius_squared,
            emission: V3::new(r, g, b),
            sphere: L::bits(sphere),
        }
    }
}

/// [`LightRow`]s in lanes.
struct LightLanes<L: Lanes> {
    center: V3<L>,
    radius_squared: L::F,
    emission: V3<L>,
    sphere: L::U,
}

/// The uniform numbers of a shadow ray.
pub(crate) struct ShadowNumbers<L: Lanes> {
    pub(crate) choice: L::F,
    pub(crate) u: L::F,
    pub(crate) v: L::F,
}

/// Points to be lit.
pub(crate) struct Receivers<L: Lanes> {
    /// The lanes that hold a point.
    pub(crate) live: L::M,
    pub(crate) point: V3<L>,
    pub(crate) normal: V3<L>,
    pub(crate) sphere: L::U,
}

/// The shadow rays of a batch.
pub(crate) struct ShadowRays {
    direction: Vectors,
    /// Distance of the lamp; negative if the ray need not be traced.
    t: Floats,
    lamp: Words,
    /// Irradiance if nothing blocks the lamp.
    irradiance: Vectors,
}

impl ShadowRays {
    pub(crate) fn new() -> Self {
        Self { direction: Vectors::ZERO, t: [0.0; ROOM], lamp: [0; ROOM], irradiance: Vectors::ZERO }
    }

    /// Aims one shadow ray per lane, the rays from `at` on, and tests them against the shapes outside of the hierarchy.
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
        let &Receivers { point, normal, sphere, .. } = to;
        let Choice { found, light: number, probability } = lights.choose::<L>(to, numbers.choice);
        let mut index = [0; MOST_LANES];
        L::store_u(number, &mut index);
        let LightLanes { center, radius_squared, emission, sphere: lamp } = lights.gather::<L>(&index);
        let (mut direction, mut t, mut weight) = from_outside(center, radius_squared, point, normal, numbers);
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
        let lit = found & valid & !occluded(&tables.shadow_casters, &ray, t, lamp);
        let irradiance = emission.scale(if lights.tree.is_some() { weight / probability } else { weight });
        self.direction.store(at, direction);
        L::store(L::select(lit, t, L::f(-1.0)), &mut self.t[at..]);
        L::store_u(lamp, &mut self.lamp[at..]);
        self.irradiance.store(at, V3::select(lit, irradiance, V3::new(zero, zero, zero)));
    }

    /// Tests the first `count` rays, from `points` on `spheres`, against the hierarchy.
    #[inline(always)]
    pub(crate) fn follow<L: Lanes>(
        &mut self,
        tables: &Tables,
        points: &Vectors,
        spheres: &Words,
        buffers: &mut SearchBuffers,
        count: usize,
    ) {
        let rays =
            Rays { origin: points, direction: &self.direction, leaves: spheres, ignores: &self.lamp, count };
        tables.hierarchy.occlude::<L>(&tables.surfaces, &rays, buffers, &mut self.t);
    }

    /// The irradiance by the rays from `at` on; zero where something blocks them.
    #[inline(always)]
    pub(crate) fn irradiance<L: Lanes>(&self, at: usize) -> V3<L> {
        let is_blocked = L::eq(L::bits(L::load(&self.t[at..])), L::u(BLOCKED.to_bits()));
        let zero = L::f(0.0);
        V3::select(is_blocked, V3::new(zero, zero, zero), self.irradiance.load(at))
    }
}

/// A direction in the cone of the lamp, the distance to it, and the weight, which is zero where the lamp does not count.
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

/// The distance to a glowing shell from inside, and whether the ray starts inside and hits it.
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
