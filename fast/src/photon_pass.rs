//! Photon pass: `reference::photon_pass` over batches of photons, up to the deposits that may matter.
//!
//! ```text
//! for each batch of up to 256 photons:
//!     emit all
//!     until none is left, at most max_depth times:
//!         intersect all
//!         for each packet: fetch surface and material; deposit; roulette; scatter; survivors to the front
//! ```
//!
//! How it differs from the plain loop, and why:
//!
//! 1. Stages over a batch: see [`crate::paths`].
//! 2. A deposit is dropped at once unless a visible point touches its cell (a bit per cell, [`Occupancy`]): what
//!    cannot count need not be sorted.
//! 3. Whether a photon arrives on the visible side is mostly known from its own surface: on the same sphere, within
//!    reach, normals differ little. Such deposits are marked, and the join skips the test.

use crate::hierarchy::Scratch;
use crate::join::cells::Cells;
use crate::join::deposits::{Binned, SAFE, bin_shift};
use crate::join::occupancy::Occupancy;
use crate::lanes::{Lanes, MOST_LANES, Row};
use crate::light_choice::LightChoice;
use crate::paths::{BATCH, Packet, Paths, Vectors};
use crate::sampling::{cosine_hemisphere, next_uniform, stream_state, uniform_sphere, unit_float};
use crate::scatter::{dielectric, reflect};
use crate::tables::{Materials, Surface, Tables, kind, tag};
use crate::trace::{hits, intersect_batch};
use crate::vec3::V3;
use scene::film::FLUX_ONE;
use scene::rng::{Family, StreamKey};
use scene::sobol::{DIMENSIONS, sobol};
use scene::still::Role;
use scene::{Settings, Still, Vec3};
use std::ops::Range;

/// How the dimensions of a photon's stratified point are used; as in `reference::photon_pass`.
mod dimension {
    pub(super) const DIRECTION: [usize; 2] = [0, 1];
    pub(super) const POSITION: [usize; 2] = [2, 3];
    pub(super) const FIRST_BOUNCE: [usize; 3] = [4, 5, 7];
    pub(super) const LIGHT: usize = 6;
}

/// The bit of a lamp's sphere that says: it shines inwards.
const INWARDS: u32 = 1 << 31;

/// What emission reads, the same for all iterations of a still.
pub(crate) struct Emitters {
    /// Per light: centre, radius, photon power, sphere and perhaps [`INWARDS`].
    rows: Vec<Row>,
    /// The Sobol digits of indices 0..256: what the low bits of any index contribute.
    low_digits: Box<[[u32; BATCH]; DIMENSIONS]>,
}

impl Emitters {
    pub(crate) fn new(still: &Still) -> Self {
        let row = |light: &scene::still::Light| {
            let s = &still.spheres[light.sphere as usize];
            let (c, e) = (s.center, light.photon_power);
            let sphere = light.sphere | if light.inside { INWARDS } else { 0 };
            Row([c.x, c.y, c.z, s.radius, e.x, e.y, e.z, f32::from_bits(sphere)])
        };
        Self {
            rows: still.lights.entries.iter().map(row).collect(),
            low_digits: Box::new(std::array::from_fn(|d| std::array::from_fn(|i| sobol(i as u32, d)))),
        }
    }
}

/// What the photon pass of one iteration reads.
pub(crate) struct PhotonPass<'a> {
    pub(crate) still: &'a Still<'a>,
    pub(crate) tables: &'a Tables,
    pub(crate) emitters: &'a Emitters,
    pub(crate) lights: &'a LightChoice,
    pub(crate) settings: &'a Settings,
    pub(crate) iteration: u32,
    /// The cells of the join.
    pub(crate) cells: Cells,
    /// Where visible points are.
    pub(crate) occupancy: &'a Occupancy,
    /// The largest search radius.
    pub(crate) reach: f32,
    /// Bound on the rounding of points on solid balls.
    pub(crate) slack: f32,
    /// Digital shifts of the iteration.
    pub(crate) shifts: [u32; DIMENSIONS],
    /// Photons in flight at once: a multiple of the lanes, at most [`BATCH`].
    pub(crate) at_once: usize,
}

/// The digital shifts of an iteration.
pub(crate) fn emission_shifts(seed: u64, iteration: u32) -> [u32; DIMENSIONS] {
    let mut shifts = StreamKey::new(seed, Family::Emission, iteration).stream(0);
    std::array::from_fn(|_| shifts.next_u32())
}

/// Buffers of one batch.
pub(crate) struct PhotonBatch {
    paths: Box<Paths>,
    scratch: Scratch,
    /// The stratified numbers of bounce 0.
    first_bounce: Box<Vectors>,
}

/// Counted work.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PhotonCounts {
    pub(crate) segments: u64,
    pub(crate) deposits: u64,
}

impl PhotonBatch {
    pub(crate) fn new() -> Self {
        Self { paths: Paths::new(), scratch: Scratch::new(), first_bounce: Box::new(Vectors::ZERO) }
    }
}

/// The shifted Sobol points of [`BATCH`] photons: exclusive ors of what the low bits of the index and the others
/// contribute.
struct StratifiedPoints<'a> {
    low: &'a [[u32; BATCH]; DIMENSIONS],
    high: [u32; DIMENSIONS],
}

impl StratifiedPoints<'_> {
    /// Dimension `d` of the photons from `photon` on, a multiple of the lanes.
    #[inline(always)]
    fn at<L: Lanes>(&self, photon: u32, d: usize) -> L::F {
        let low = L::load_u(&self.low[d][photon as usize % BATCH..]);
        unit_float::<L>(low ^ L::u(self.high[d]))
    }
}

impl PhotonPass<'_> {
    /// Traces the photons of a range of indices, whose start is a multiple of the lanes.
    #[inline(always)]
    pub(crate) fn run<L: Lanes>(
        &self,
        batch: &mut PhotonBatch,
        photons: Range<u32>,
        out: &mut Binned,
    ) -> PhotonCounts {
        let mut counts = PhotonCounts::default();
        for first in photons.clone().step_by(self.at_once) {
            let count = (photons.end - first).min(self.at_once as u32);
            let mut live = self.emit::<L>(batch, first, count as usize);
            for bounce in 0..self.settings.max_depth {
                if live == 0 {
                    break;
                }
                counts.segments += live as u64;
                intersect_batch::<L>(self.tables, &mut batch.paths, &mut batch.scratch, live);
                live = self.bounce::<L>(batch, live, bounce, out, &mut counts);
            }
        }
        counts
    }

    /// The stratified points of the photons around `photon` whose indices differ in their low bits only.
    fn points_around(&self, photon: u32) -> StratifiedPoints<'_> {
        let high = photon - photon % BATCH as u32;
        StratifiedPoints {
            low: &self.emitters.low_digits,
            high: std::array::from_fn(|d| sobol(high, d) ^ self.shifts[d]),
        }
    }

    #[inline(always)]
    fn emit<L: Lanes>(&self, batch: &mut PhotonBatch, first: u32, count: usize) -> usize {
        let key = StreamKey::new(self.settings.seed, Family::Photon, self.iteration);
        let mut live = 0;
        if self.emitters.rows.is_empty() {
            return 0;
        }
        let mut points = self.points_around(first);
        for at in (0..count).step_by(L::N) {
            let start = first + at as u32;
            if start.is_multiple_of(BATCH as u32) {
                points = self.points_around(start);
            }
            let u = points.at::<L>(start, dimension::LIGHT);
            let choice = self.lights.choose::<L>(u);
            let mut index = [0; MOST_LANES];
            L::store_u(choice, &mut index);
            let [cx, cy, cz, radius, r, g, b, lamp] = L::gather_rows(&self.emitters.rows, &index);
            let [u, v] = dimension::POSITION;
            let outward = uniform_sphere::<L>(points.at::<L>(start, u), points.at::<L>(start, v));
            let origin = V3::new(cx, cy, cz) + outward.scale(radius);
            let inwards = L::eq(L::bits(lamp) & L::u(INWARDS), L::u(INWARDS));
            let normal = V3::select(inwards, -outward, outward);
            let [right, up] = dimension::DIRECTION;
            let packet = Packet {
                origin,
                direction: cosine_hemisphere(normal, points.at::<L>(start, right), points.at::<L>(start, up)),
                weight: V3::new(r, g, b),
                leaves: L::bits(lamp) & L::u(!INWARDS),
                stream: stream_state::<L>(key, L::u(start) + L::iota()),
                // Nobody asks which photon a deposit came from.
                slot: L::u(0),
            };
            let free = L::first(count - at) & self.is_free(origin, &index);
            let [u, v, roulette] = dimension::FIRST_BOUNCE;
            let numbers = V3::<L>::new(
                points.at::<L>(start, u),
                points.at::<L>(start, v),
                points.at::<L>(start, roulette),
            );
            batch.first_bounce.compress(free, numbers, live);
            live = batch.paths.append(live, free, &packet);
        }
        live
    }

    /// The lanes whose photon starts in free space: lamps sunk into others are rare, so lane by lane.
    #[inline(always)]
    fn is_free<L: Lanes>(&self, origin: V3<L>, lights: &[u32]) -> L::M {
        if self.still.lights.blockers.is_empty() {
            return L::first(L::N);
        }
        let mut points = [[0.0; MOST_LANES]; 3];
        L::store(origin.x, &mut points[0]);
        L::store(origin.y, &mut points[1]);
        L::store(origin.z, &mut points[2]);
        let is_free = |lane: usize| {
            let point = Vec3::new(points[0][lane], points[1][lane], points[2][lane]);
            !is_blocked(self.still, lights[lane], point)
        };
        L::mask_from_bits((0..L::N).map(|lane| u32::from(is_free(lane)) << lane).sum())
    }

    /// One bounce of the first `live` photons; gives the number of those that go on.
    #[inline(always)]
    fn bounce<L: Lanes>(
        &self,
        batch: &mut PhotonBatch,
        live: usize,
        bounce: u32,
        out: &mut Binned,
        counts: &mut PhotonCounts,
    ) -> usize {
        let mut go_on = 0;
        for at in (0..live).step_by(L::N) {
            let here = L::first(live - at);
            let mut p = batch.paths.load::<L>(at);
            let (t, hit, arrived) = hits::<L>(&batch.paths, at, here);
            let mut ids = [0; MOST_LANES];
            L::store_u(hit, &mut ids);
            let surface = Surface::<L>::at(self.tables, p.origin, p.direction, t, &ids);
            let material = Materials::<L>::of(self.tables, surface.tag);
            let is_diffuse = L::eq(material.kind, L::u(kind::DIFFUSE));
            if bounce > 0 {
                let lands = arrived & is_diffuse;
                counts.deposits += u64::from(L::mask_bits(lands).count_ones());
                self.deposit::<L>(lands, &surface, hit, &p, out);
            }
            let V3 { x: u, y: v, z: roulette } = if bounce == 0 {
                batch.first_bounce.load::<L>(at)
            } else {
                let u = next_uniform::<L>(&mut p.stream);
                let v = next_uniform::<L>(&mut p.stream);
                V3::new(u, v, next_uniform::<L>(&mut p.stream))
            };
            let (survives, survivor) = survive::<L>(p.weight, material.albedo, roulette);
            let survives = arrived & survives;
            p.weight = survivor;
            let mut direction = cosine_hemisphere(surface.normal, u, v);
            if L::any(survives & !is_diffuse) {
                let is_glass = L::eq(material.kind, L::u(kind::DIELECTRIC));
                let (through, _) = dielectric(p.direction, surface.normal, surface.inside, material.ior, u);
                let smooth = V3::select(is_glass, through, reflect(p.direction, surface.normal));
                direction = V3::select(is_diffuse, direction, smooth);
            }
            p.direction = direction;
            p.origin = surface.point;
            p.leaves = hit;
            go_on = batch.paths.append(go_on, survives, &p);
        }
        go_on
    }

    /// Throws the photons of the lanes `lands` into their bins, those aside that no visible point can want.
    #[inline(always)]
    fn deposit<L: Lanes>(
        &self,
        lands: L::M,
        surface: &Surface<L>,
        hit: L::U,
        p: &Packet<L>,
        out: &mut Binned,
    ) {
        let wanted = lands & self.occupancy.touches::<L>(surface.point);
        let mut rest = L::mask_bits(wanted);
        if rest == 0 {
            return;
        }
        let safe = L::select_u(self.is_safe::<L>(surface, p), L::u(SAFE), L::u(0));
        let bucket = L::from_bits(self.cells.buckets::<L>(surface.point));
        let (point, power) = (surface.point, p.weight);
        let (r, g, b) = (quantise::<L>(power.x), quantise::<L>(power.y), quantise::<L>(power.z));
        let columns = [point.x, point.y, point.z, L::from_bits(hit | safe), r, g, b, bucket];
        let mut records = [Row::default(); MOST_LANES];
        L::transpose(columns, &mut records);
        let mut directions = [[0.0; MOST_LANES]; 3];
        L::store(-p.direction.x, &mut directions[0]);
        L::store(-p.direction.y, &mut directions[1]);
        L::store(-p.direction.z, &mut directions[2]);
        let shift = bin_shift(self.cells);
        while rest != 0 {
            let lane = rest.trailing_zeros() as usize;
            rest &= rest - 1;
            let from = [directions[0][lane], directions[1][lane], directions[2][lane], 0.0];
            out.push(records[lane], from, shift);
        }
    }

    /// The lanes whose photon counts on the visible side of every point of its sphere within reach.
    ///
    /// That is so inside of a shell, by definition; on a ball, where the cosine at the photon's own point is large enough.
    #[inline(always)]
    fn is_safe<L: Lanes>(&self, surface: &Surface<L>, p: &Packet<L>) -> L::M {
        let in_shell = L::eq(surface.tag & L::u(tag::ENCLOSURE), L::u(tag::ENCLOSURE));
        let cos = -p.direction.dot(surface.normal);
        in_shell | L::lt(safe_cosine::<L>(self.reach, self.slack, surface.scale), cos)
    }
}

/// Above this cosine at one point of a ball of radius r, cosines at all points within `reach` are positive: normals at a
/// distance d differ by d / r. Points are off by `slack`, and cosines by some roundings.
#[inline(always)]
fn safe_cosine<L: Lanes>(reach: f32, slack: f32, radius: L::F) -> L::F {
    L::f(reach + slack) / radius + L::f(1e-5)
}

/// As `reference::photon_pass::survive`: which lanes do, and the survivors' power.
#[inline(always)]
pub(crate) fn survive<L: Lanes>(power: V3<L>, albedo: V3<L>, roulette: L::F) -> (L::M, V3<L>) {
    let scattered = power * albedo;
    let (before, after) = (power.max_component(), scattered.max_component());
    (L::lt(roulette * before, after), scattered.scale(before / after))
}

/// As `reference::photon_pass::quantise`, as the bits of a float.
#[inline(always)]
pub(crate) fn quantise<L: Lanes>(power: L::F) -> L::F {
    let flux = power * L::f(FLUX_ONE as f32) + L::f(0.5);
    L::from_bits(L::min_u(L::truncate(flux), L::u(FLUX_ONE)))
}

/// As `reference::photon_pass::is_blocked`.
fn is_blocked(still: &Still, light: u32, point: Vec3) -> bool {
    let light = &still.lights.entries[light as usize];
    let blockers = light.blockers.start as usize..light.blockers.end as usize;
    still.lights.blockers[blockers].iter().any(|&id| {
        let sphere = &still.spheres[id as usize];
        let from_center = point - sphere.center;
        let within = from_center.dot(from_center) < sphere.radius * sphere.radius;
        within == (still.roles[id as usize] == Role::Solid)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::Emulated;

    /// A dot product of unit vectors that are themselves rounded is off by some 10 roundings of 1.
    const LEAST: f64 = 10.0 * f32::EPSILON as f64;
    /// So little more costs but one photon in some 25 000 the test of its side.
    const MOST: f64 = 2e-5;

    #[test]
    fn safe_cosines_allow_for_reach_slack_and_roundings_and_hardly_more() {
        for (reach, slack, radius) in [(1e-3_f32, 0.0_f32, 1.0_f32), (0.2, 1e-2, 0.5), (3.0, 0.5, 16.0)] {
            let mut cosines = [0.0; MOST_LANES];
            let radii = <Emulated as Lanes>::f(radius);
            Emulated::store(safe_cosine::<Emulated>(reach, slack, radii), &mut cosines);
            let exact = (f64::from(reach) + f64::from(slack)) / f64::from(radius);
            let spare = f64::from(cosines[0]) - exact;
            assert!((LEAST..MOST).contains(&spare), "{} at {exact}", cosines[0]);
        }
    }
}
