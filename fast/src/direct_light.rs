//! Direct light: one shadow ray per visible point, `reference::direct_light` over a batch.
//!
//! ```text
//! for each packet of visible points:
//!     choose a lamp (light_tree.rs) and a point on it; compute the irradiance if nothing blocks it
//! for the batch: test the shadow rays against what casts a shadow
//! ```

use crate::hierarchy::SearchBuffers;
use crate::intersect::{RayLanes, from_inside, meet};
use crate::light_choice::LightChoice;
use crate::light_tree::{Choice, LightTree};
use crate::paths::{Floats, ROOM, Vectors, Words};
use crate::rays::{BLOCKED, Rays};
use crate::rows;
use crate::sampling::{cosine_hemisphere, uniform_cone};
use crate::tables::Tables;
use bytemuck::{Pod, Zeroable};
use lanes::{Kernel, Lanes, MOST_LANES, Row, V3};
use scene::Still;
use scene::ray::SphereId;
use scene::still::{Enclosure, Light, Role};
use std::f32::consts::PI;

/// The bit of a light's sphere that is set if it is glass, of which both sides glow.
const IS_GLASS: u32 = 1 << 31;

/// A light's row in the table.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct LightRow {
    center: [f32; 3],
    radius_squared: f32,
    emission: [f32; 3],
    /// The sphere, and perhaps [`IS_GLASS`].
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
    /// Indices and shapes of the glowing enclosures, which are few.
    enclosures: Vec<(u32, Enclosure)>,
}

impl LightTable {
    pub(crate) fn new(still: &Still) -> Self {
        let row = |light: &Light| {
            let s = &still.spheres[light.sphere as usize];
            let is_glass = still.roles[light.sphere as usize] == Role::Glass;
            bytemuck::cast(LightRow {
                center: s.center.into(),
                radius_squared: s.radius * s.radius,
                emission: s.emission.into(),
                sphere: light.sphere | if is_glass { IS_GLASS } else { 0 },
            })
        };
        let mut enclosures = Vec::new();
        for (index, light) in (0..).zip(&still.lights.entries) {
            if let Role::Enclosure(e) = still.roles[light.sphere as usize] {
                enclosures.push((index, still.enclosures[e as usize]));
            }
        }
        Self {
            rows: still.lights.entries.iter().map(row).collect(),
            choice: LightChoice::new(&still.lights.cumulative),
            tree: LightTree::new(still),
            enclosures,
        }
    }

    /// True if nothing glows.
    pub(crate) fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// The lights that `u` chooses for the receivers, of which there must be one.
    #[inline(always)]
    pub(crate) fn choose<L: Lanes>(&self, to: &Receivers<L>, u: L::F) -> ChosenLights<L> {
        let Choice { found, light, probability } = match &self.tree {
            Some(tree) => tree.choose(to.live, to.point, to.normal, u),
            None => Choice { found: to.live, light: L::u(0), probability: L::f(1.0) },
        };
        let mut indices = [0; MOST_LANES];
        L::store_u(light, &mut indices);
        let [cx, cy, cz, radius_squared, r, g, b, sphere] = rows::gather::<L>(&self.rows, &indices);
        let (center, sphere) = (V3::new(cx, cy, cz), L::bits(sphere));
        let to_center = center - to.point;
        let is_glass = L::eq(sphere & L::u(IS_GLASS), L::u(IS_GLASS));
        ChosenLights {
            found,
            light,
            probability,
            center,
            radius_squared,
            emission: V3::new(r, g, b),
            sphere: sphere & L::u(!IS_GLASS),
            is_around: is_glass & L::lt(to_center.dot(to_center), radius_squared),
        }
    }
}

/// The light that each lane has chosen.
pub(crate) struct ChosenLights<L: Lanes> {
    /// The lanes that have chosen one.
    pub(crate) found: L::M,
    /// Its index. For a lamp of glass, that of its outer side.
    pub(crate) light: L::U,
    pub(crate) probability: L::F,
    center: V3<L>,
    radius_squared: L::F,
    emission: V3<L>,
    sphere: L::U,
    /// Is it a lamp of glass around the point, which sees its inner side?
    pub(crate) is_around: L::M,
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

    /// Aims one shadow ray per lane, the rays from `at` on.
    #[inline(always)]
    pub(crate) fn aim<L: Lanes>(
        &mut self,
        at: usize,
        lights: &LightTable,
        to: &Receivers<L>,
        numbers: &ShadowNumbers<L>,
    ) {
        let zero = L::f(0.0);
        let &Receivers { point, normal, sphere, .. } = to;
        let chosen = lights.choose::<L>(to, numbers.choice);
        let (mut direction, mut t, mut weight) = from_outside(&chosen, point, normal, numbers);
        let mut valid = L::lt(zero, weight) & !L::eq(sphere, chosen.sphere);
        if L::any(chosen.is_around) || !lights.enclosures.is_empty() {
            let inwards = cosine_hemisphere(normal, numbers.u, numbers.v);
            let ray = RayLanes { origin: point, direction: inwards, leaves: sphere };
            let from_glass = distance_to_glass(&chosen, &ray);
            let mut from_within = chosen.is_around;
            let (mut t_within, mut valid_within) = (from_glass, L::lt(from_glass, L::f(f32::INFINITY)));
            for (index, enclosure) in &lights.enclosures {
                let is_it = L::eq(chosen.light, L::u(*index));
                let distance = from_inside(enclosure, &ray);
                t_within = L::select(is_it, distance, t_within);
                valid_within = (is_it & L::lt(distance, L::f(f32::INFINITY))) | (!is_it & valid_within);
                from_within = from_within | is_it;
            }
            direction = V3::select(from_within, inwards, direction);
            t = L::select(from_within, t_within, t);
            weight = L::select(from_within, L::f(PI), weight);
            valid = (from_within & valid_within) | (!from_within & valid);
        }
        let lit = chosen.found & valid;
        let irradiance =
            chosen.emission.scale(if lights.tree.is_some() { weight / chosen.probability } else { weight });
        self.direction.store(at, direction);
        L::store(L::select(lit, t, L::f(-1.0)), &mut self.t[at..]);
        L::store_u(chosen.sphere, &mut self.lamp[at..]);
        self.irradiance.store(at, V3::select(lit, irradiance, V3::new(zero, zero, zero)));
    }

    /// Tests the first `count` rays, from `points` on `spheres`, against all that casts a shadow. Those of
    /// neighbouring pixels' first visible points `are_close`.
    #[inline(always)]
    pub(crate) fn follow<L: Lanes>(
        &mut self,
        tables: &Tables,
        points: &Vectors,
        spheres: &Words,
        buffers: &mut SearchBuffers,
        count: usize,
        are_close: bool,
    ) {
        let rays = Rays {
            origin: points,
            direction: &self.direction,
            leaves: spheres,
            ignores: &self.lamp,
            count,
            are_close,
        };
        L::call(Occlusion { tables, rays, buffers, t: &mut self.t });
    }

    /// The ways to the lamps of the rays from `at` on, where nothing blocks them.
    #[inline(always)]
    pub(crate) fn to_lamp<L: Lanes>(&self, at: usize) -> V3<L> {
        self.direction.load(at).scale(L::load(&self.t[at..]))
    }

    /// The irradiance by the rays from `at` on; zero where something blocks them.
    #[inline(always)]
    pub(crate) fn irradiance<L: Lanes>(&self, at: usize) -> V3<L> {
        let is_blocked = L::eq(L::bits(L::load(&self.t[at..])), L::u(BLOCKED.to_bits()));
        let zero = L::f(0.0);
        V3::select(is_blocked, V3::new(zero, zero, zero), self.irradiance.load(at))
    }
}

/// The test of shadow rays, as a function that all passes share: it is large, and takes long to build.
struct Occlusion<'a> {
    tables: &'a Tables,
    rays: Rays<'a>,
    buffers: &'a mut SearchBuffers,
    t: &'a mut Floats,
}

impl Kernel for Occlusion<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        self.tables.occlude::<L>(&self.rays, self.buffers, self.t);
    }
}

/// A direction in the cone of the lamp, the distance to it, and the weight, which is zero where the lamp does not count.
#[inline(always)]
fn from_outside<L: Lanes>(
    lamp: &ChosenLights<L>,
    point: V3<L>,
    normal: V3<L>,
    numbers: &ShadowNumbers<L>,
) -> (V3<L>, L::F, L::F) {
    let (zero, one, two) = (L::f(0.0), L::f(1.0), L::f(2.0));
    let r2 = lamp.radius_squared;
    let to_center = lamp.center - point;
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

/// The distance to the inner side of a lamp of glass; infinite where the ray misses it, or is not within.
#[inline(always)]
fn distance_to_glass<L: Lanes>(lamp: &ChosenLights<L>, ray: &RayLanes<L>) -> L::F {
    let leaves = L::eq(ray.leaves, lamp.sphere);
    let RayLanes { origin, direction, .. } = *ray;
    let (t, hits) = meet(origin, direction, leaves, lamp.center, lamp.radius_squared, lamp.is_around);
    L::select(hits & lamp.is_around, t, L::f(f32::INFINITY))
}
