//! Emission: where photons start and in which directions, and the numbers of their first bounce.

use super::aiming::{AimTables, Departures, LampLanes};
use super::guiding::GuideTables;
use crate::light_choice::LightChoice;
use crate::paths::{BATCH, Packet, Paths, Vectors};
use crate::rows;
use crate::sampling::{cosine_hemisphere, stream_state, uniform_sphere, unit_float};
use bytemuck::{Pod, Zeroable};
use lanes::{Lanes, MOST_LANES, Row, V3};
use scene::aim::Aim;
use scene::guide::{Cell, Departures as Cells, SIDE};
use scene::ray::SphereId;
use scene::rng::{Family, StreamKey};
use scene::sobol::{DIMENSIONS, low_digits, sobol};
use scene::still::Light;
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
    /// The sphere, and perhaps [`INWARDS`] and [`IS_FAR`].
    sphere: SphereId,
}

/// The bit of an emitter's sphere that is set if it is far: its photons may start at the core of what is aimed.
const IS_FAR: u32 = 1 << 30;

/// The tables of emission: the same for all iterations of a still.
pub(crate) struct Emitters {
    /// [`EmitterRow`]s.
    rows: Vec<Row>,
    /// `None` if photons are aimed at nothing.
    aim: Option<AimTables>,
    /// `None` if surfaces do not guide them.
    guide: Option<GuideTables>,
    /// `None` if lamps do not.
    departures: Option<Cells>,
    /// What multiplies powers before they are rounded to units; `None` if all photons weigh the same.
    scale: Option<f32>,
    /// The Sobol digits of indices 0..256: what the low bits of any index contribute.
    low_digits: Box<[[u32; BATCH]; DIMENSIONS]>,
}

impl Emitters {
    /// Those of a still whose photons are aimed as `aim` says.
    pub(crate) fn new(still: &Still, aim: Aim) -> Self {
        let is_far = |index: usize| aim.core.as_ref().is_some_and(|core| core.is_far[index]);
        let row = |(index, light): (usize, &Light)| {
            let s = &still.spheres[light.sphere as usize];
            bytemuck::cast(EmitterRow {
                center: s.center.into(),
                radius: s.radius,
                power: light.photon_power.into(),
                sphere: light.sphere
                    | if light.inside { INWARDS } else { 0 }
                    | if is_far(index) { IS_FAR } else { 0 },
            })
        };
        Self {
            rows: still.lights.entries.iter().enumerate().map(row).collect(),
            scale: (!aim.is_empty()).then(|| aim.scale()),
            guide: aim.guide.clone().map(GuideTables::new),
            departures: aim.departures.clone(),
            aim: AimTables::new(aim),
            low_digits: Box::new(std::array::from_fn(low_digits)),
        }
    }

    /// What multiplies powers before they are rounded to units, if photons are aimed or guided.
    pub(crate) fn scale(&self) -> Option<f32> {
        self.scale
    }

    /// The lights with these numbers, and what each photon of theirs carries.
    #[inline(always)]
    fn gather<L: Lanes>(&self, numbers: &[u32]) -> (LampLanes<L>, V3<L>) {
        let [cx, cy, cz, radius, r, g, b, sphere] = rows::gather::<L>(&self.rows, numbers);
        let sphere = L::bits(sphere);
        let lamp = LampLanes {
            center: V3::new(cx, cy, cz),
            radius,
            sphere: sphere & L::u(!(INWARDS | IS_FAR)),
            shines_inwards: L::eq(sphere & L::u(INWARDS), L::u(INWARDS)),
            is_far: L::eq(sphere & L::u(IS_FAR), L::u(IS_FAR)),
        };
        (lamp, V3::new(r, g, b))
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
    pub(super) still: &'a Still<'a>,
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

    /// True if photons of neighbouring indices leave the same lamp in similar directions.
    pub(super) fn are_close(&self) -> bool {
        self.emitters.departures.is_some() && self.emitters.rows.len() == 1
    }

    /// How photons are aimed, if they are.
    pub(super) fn aim(&self) -> Option<&AimTables> {
        self.emitters.aim.as_ref()
    }

    /// How surfaces guide photons, if they do.
    pub(super) fn guide(&self) -> Option<&GuideTables> {
        self.emitters.guide.as_ref()
    }

    /// See [`Emitters::scale`].
    pub(super) fn scale(&self) -> Option<f32> {
        self.emitters.scale()
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
            let (packet, is_free) = match (&self.emitters.departures, self.aim()) {
                (Some(departures), _) => self.guided::<L>(&departures.cell(start), &points, start),
                (None, Some(aim)) => self.aimed::<L>(aim, &points, start),
                (None, None) => self.unaimed::<L>(&points, start),
            };
            let free = L::first(count - at) & is_free;
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

    /// The photons from index `start` on, which leave all lamps alike; and which of them start in free space.
    #[inline(always)]
    fn unaimed<L: Lanes>(&self, points: &StratifiedPoints, start: u32) -> (Packet<L>, L::M) {
        let lights = self.choose::<L>(points, start);
        let (lamp, power) = self.emitters.gather::<L>(&lights);
        let (origin, direction) = uniform(points, start, &lamp);
        let ray = Departures { origin, direction, leaves: lamp.sphere };
        (self.packet(start, &ray, power), self.is_free(origin, &lights))
    }

    /// The photons from index `start` on, all of one cell of directions; and which of them start in free space. As
    /// `reference::emission::guided`.
    #[inline(always)]
    fn guided<L: Lanes>(&self, cell: &Cell, points: &StratifiedPoints, start: u32) -> (Packet<L>, L::M) {
        let lights = self.choose::<L>(points, start);
        let (lamp, power) = self.emitters.gather::<L>(&lights);
        let [u, v] = [0, 1].map(|k| {
            let number = points.at::<L>(start, dimension::DIRECTION[k]);
            (L::f(cell.corner[k]) + number) * L::f(1.0 / SIDE as f32)
        });
        let direction = uniform_sphere::<L>(u, v);
        let [u, v] = dimension::POSITION.map(|d| points.at::<L>(start, d));
        let normal = cosine_hemisphere(direction, u, v);
        let outward = V3::select(lamp.shines_inwards, -normal, normal);
        let origin = lamp.center + outward.scale(lamp.radius);
        let ray = Departures { origin, direction, leaves: lamp.sphere };
        (self.packet(start, &ray, power.scale(L::f(cell.weight))), self.is_free(origin, &lights))
    }

    /// The photons from index `start` on, all of one component; and which of them are not dropped.
    #[inline(always)]
    fn aimed<L: Lanes>(&self, aim: &AimTables, points: &StratifiedPoints, start: u32) -> (Packet<L>, L::M) {
        let component = aim.component(start);
        let (lights, rows) = match component {
            0 => (self.choose::<L>(points, start), [0; MOST_LANES]),
            k => aim.choose::<L>(k - 1, points.at::<L>(start, dimension::LIGHT)),
        };
        let (lamp, power) = self.emitters.gather::<L>(&lights);
        let (origin, direction, point, crosses) = if component == 0 {
            let (origin, direction) = uniform(points, start, &lamp);
            (origin, direction, origin, L::first(L::N))
        } else {
            let [on_disk, direction] = [dimension::POSITION, dimension::DIRECTION]
                .map(|pair| pair.map(|d| points.at::<L>(start, d)));
            aim.lines(&rows, &lamp, on_disk, direction)
        };
        let ray = aim.depart(&self.still.grounds, &lamp, (origin, direction, point));
        let (weight, is_of_component) = aim.weigh(component, &ray);
        let is_free = crosses & is_of_component & self.is_free(origin, &lights);
        (self.packet(start, &ray, power.scale(weight)), is_free)
    }

    /// The lights of photons that leave all lamps alike.
    #[inline(always)]
    fn choose<L: Lanes>(&self, points: &StratifiedPoints, start: u32) -> [u32; MOST_LANES] {
        let mut lights = [0; MOST_LANES];
        L::store_u(self.lights.choose::<L>(points.at::<L>(start, dimension::LIGHT)), &mut lights);
        lights
    }

    #[inline(always)]
    fn packet<L: Lanes>(&self, start: u32, ray: &Departures<L>, power: V3<L>) -> Packet<L> {
        Packet {
            origin: ray.origin,
            direction: ray.direction,
            weight: power,
            leaves: ray.leaves,
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
            !self.still.is_hidden(&self.still.lights.entries[lights[lane] as usize], point)
        };
        L::mask_from_bits((0..L::N).map(|lane| u32::from(is_free(lane)) << lane).sum())
    }
}

/// Uniform points of lamps, and directions by the cosine.
#[inline(always)]
fn uniform<L: Lanes>(points: &StratifiedPoints, start: u32, lamp: &LampLanes<L>) -> (V3<L>, V3<L>) {
    let [u, v] = dimension::POSITION;
    let outward = uniform_sphere::<L>(points.at::<L>(start, u), points.at::<L>(start, v));
    let normal = V3::select(lamp.shines_inwards, -outward, outward);
    let [u, v] = dimension::DIRECTION;
    let direction = cosine_hemisphere(normal, points.at::<L>(start, u), points.at::<L>(start, v));
    (lamp.center + outward.scale(lamp.radius), direction)
}
