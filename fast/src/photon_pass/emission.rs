//! Emission: where photons start and in which directions, and the numbers of their first bounce.

use crate::light_choice::LightChoice;
use crate::paths::{BATCH, Packet, Paths, Vectors};
use crate::sampling::{cosine_hemisphere, stream_state, uniform_sphere, unit_float};
use bytemuck::{Pod, Zeroable};
use lanes::{Lanes, MOST_LANES, Row, V3};
use scene::ray::SphereId;
use scene::rng::{Family, StreamKey};
use scene::sobol::{DIMENSIONS, sobol};
use scene::still::{Light, Role};
use scene::{Still, Vec3};

/// What the dimensions of a photon's stratified point are used for; as in `reference::photon_pass`.
mod dimension {
    pub(super) const DIRECTION: [usize; 2] = [0, 1];
    pub(super) const POSITION: [usize; 2] = [2, 3];
    pub(super) const FIRST_BOUNCE: [usize; 3] = [4, 5, 7];
    pub(super) const LIGHT: usize = 6;
}

/// The bit of an emitter's sphere that is set if it shines inwards.
const INWARDS: u32 = 1 << 31;

/// A light's row in the table of emitters.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct EmitterRow {
    center: [f32; 3],
    radius: f32,
    /// What each photon carries.
    power: [f32; 3],
    /// The sphere, and perhaps [`INWARDS`].
    sphere: SphereId,
}

/// [`EmitterRow`]s in lanes.
struct EmitterLanes<L: Lanes> {
    center: V3<L>,
    radius: L::F,
    power: V3<L>,
    sphere: L::U,
    shines_inwards: L::M,
}

/// The tables of emission: the same for all iterations of a still.
pub(crate) struct Emitters {
    /// [`EmitterRow`]s.
    rows: Vec<Row>,
    /// The Sobol digits of indices 0..256: what the low bits of any index contribute.
    low_digits: Box<[[u32; BATCH]; DIMENSIONS]>,
}

impl Emitters {
    pub(crate) fn new(still: &Still) -> Self {
        let row = |light: &Light| {
            let s = &still.spheres[light.sphere as usize];
            bytemuck::cast(EmitterRow {
                center: s.center.into(),
                radius: s.radius,
                power: light.photon_power.into(),
                sphere: light.sphere | if light.inside { INWARDS } else { 0 },
            })
        };
        Self {
            rows: still.lights.entries.iter().map(row).collect(),
            low_digits: Box::new(std::array::from_fn(|d| std::array::from_fn(|i| sobol(i as u32, d)))),
        }
    }

    /// The lights with these numbers.
    #[inline(always)]
    fn gather<L: Lanes>(&self, numbers: &[u32]) -> EmitterLanes<L> {
        let [cx, cy, cz, radius, r, g, b, sphere] = L::gather_rows(&self.rows, numbers);
        let sphere = L::bits(sphere);
        EmitterLanes {
            center: V3::new(cx, cy, cz),
            radius,
            power: V3::new(r, g, b),
            sphere: sphere & L::u(!INWARDS),
            shines_inwards: L::eq(sphere & L::u(INWARDS), L::u(INWARDS)),
        }
    }
}

/// The shifted Sobol points of [`BATCH`] photons: exclusive ors of what the low bits of the index and the other bits
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

/// Emission in one iteration.
pub(crate) struct Emission<'a> {
    still: &'a Still<'a>,
    emitters: &'a Emitters,
    lights: &'a LightChoice,
    /// Digital shifts of the iteration.
    shifts: [u32; DIMENSIONS],
    /// The key of the photons' random streams.
    key: StreamKey,
}

impl<'a> Emission<'a> {
    pub(crate) fn new(
        still: &'a Still<'a>,
        emitters: &'a Emitters,
        lights: &'a LightChoice,
        (seed, iteration): (u64, u32),
    ) -> Self {
        let mut shifts = StreamKey::new(seed, Family::Emission, iteration).stream(0);
        let shifts = std::array::from_fn(|_| shifts.next_u32());
        Self { still, emitters, lights, shifts, key: StreamKey::new(seed, Family::Photon, iteration) }
    }

    /// The stratified points of the photons whose indices differ from `photon` in their low bits only.
    fn points_around(&self, photon: u32) -> StratifiedPoints<'_> {
        let high = photon - photon % BATCH as u32;
        StratifiedPoints {
            low: &self.emitters.low_digits,
            high: std::array::from_fn(|d| sobol(high, d) ^ self.shifts[d]),
        }
    }

    /// Emits the `count` photons from index `first` on. Returns how many start in free space: those are the first paths,
    /// and have their numbers in `first_bounce`.
    #[inline(always)]
    pub(super) fn emit<L: Lanes>(
        &self,
        paths: &mut Paths,
        first_bounce: &mut Vectors,
        first: u32,
        count: usize,
    ) -> usize {
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
            let mut lights = [0; MOST_LANES];
            L::store_u(self.lights.choose::<L>(u), &mut lights);
            let packet = self.packet::<L>(&points, start, &lights);
            let free = L::first(count - at) & self.is_free(packet.origin, &lights);
            let [u, v, roulette] = dimension::FIRST_BOUNCE;
            let numbers = V3::<L>::new(
                points.at::<L>(start, u),
                points.at::<L>(start, v),
                points.at::<L>(start, roulette),
            );
            first_bounce.compress(free, numbers, live);
            live = paths.append(live, free, &packet);
        }
        live
    }

    /// The photons from index `start` on, from the lights with these numbers.
    #[inline(always)]
    fn packet<L: Lanes>(&self, points: &StratifiedPoints, start: u32, lights: &[u32]) -> Packet<L> {
        let emitter = self.emitters.gather::<L>(lights);
        let [u, v] = dimension::POSITION;
        let outward = uniform_sphere::<L>(points.at::<L>(start, u), points.at::<L>(start, v));
        let normal = V3::select(emitter.shines_inwards, -outward, outward);
        let [u, v] = dimension::DIRECTION;
        Packet {
            origin: emitter.center + outward.scale(emitter.radius),
            direction: cosine_hemisphere(normal, points.at::<L>(start, u), points.at::<L>(start, v)),
            weight: emitter.power,
            leaves: emitter.sphere,
            stream: stream_state::<L>(self.key, L::u(start) + L::iota()),
            // Deposits do not name their photon.
            slot: L::u(0),
        }
    }

    /// The lanes whose photon starts in free space. Lamps sunk into other spheres are rare, so lane by lane.
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
