//! Camera pass, photon pass and direct light, with their results before the join.

use super::join::{Cells, Occupancy, Photon, sorted_photons};
use crate::camera_pass::{CameraBatch, CameraJob, CameraPass};
use crate::direct_light::{LightTable, Receivers, ShadowNumbers, ShadowRays};
use crate::eye::Eye;
use crate::hierarchy::SearchBuffers;
use crate::join::{Binned, Slabs, Sorted};
use crate::light_choice::LightChoice;
use crate::parameters::Parameters;
use crate::paths::{BATCH, ROOM, Vectors, Words};
use crate::photon_pass::{Emission, Emitters, PhotonBatch, PhotonCounts, PhotonJob, PhotonPass, Rounding};
use crate::pixels::{GROUP, Pixel, Seen, slot_of};
use crate::prepared::Prepared;
use crate::tables::Tables;
use lanes::{Kernel, LaneKind, Lanes, MOST_LANES, dispatch};
use scene::aim::{Aim, Targets};
use scene::ray::{NO_SPHERE, SphereId};
use scene::still::Carried;
use scene::{Rgb, Scene, Settings, Still, Vec3};
use std::ops::Range;
use std::sync::Arc;

/// The result of a camera path: as `reference::camera_pass::CameraSample`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraSample {
    /// Direct light, including lamps that the path meets.
    pub direct: Rgb,
    /// The visible point (point, normal, sphere, beta), if there is one.
    pub visible: Option<(Vec3, Vec3, SphereId, Rgb)>,
}

/// The slot in which the engine keeps pixel (x, y) of an image of that width.
pub fn pixel_slot(width: u32, x: u32, y: u32) -> usize {
    slot_of(width, x, y)
}

/// The camera pass of one iteration: the result of each pixel, row by row, and the numbers of segments and of visible
/// points.
pub fn camera_pass(
    scene: &Scene,
    still: &Still,
    settings: &Settings,
    iteration: u32,
    lanes: LaneKind,
) -> (Vec<CameraSample>, u64, u64) {
    let mut seen = Seen::new(None, settings);
    let pass = CameraPass {
        still,
        tables: &Tables::new(still),
        lights: &LightTable::new(still),
        eye: &Eye::new(scene, settings),
        settings,
        iteration,
        clearance: None,
    };
    let Seen { rows, columns } = &mut seen;
    let pixels = vec![Pixel::new(1.0); rows.len()];
    let (batch, occupancy) = (&mut CameraBatch::new(), &mut Occupancy::new(1.0).0);
    let (pass, pixels) = (&pass, &pixels[..]);
    let job = CameraJob { pass, batch, at_once: BATCH, first: 0, rows, columns, pixels, occupancy };
    let counts = dispatch(lanes, job);
    let sample = |x, y| {
        let slot = slot_of(settings.width, x, y);
        let (row, columns, k) = (&seen.rows[slot], &seen.columns[slot / GROUP], slot % GROUP);
        let visible = row.visible().map(|point| (point, columns.normal(k), row.sphere, row.beta.into()));
        CameraSample { direct: columns.direct_light(k), visible }
    };
    let pixels = (0..settings.height).flat_map(|y| (0..settings.width).map(move |x| (x, y)));
    (pixels.map(|(x, y)| sample(x, y)).collect(), counts.segments, counts.visible_points)
}

/// What photons are to be aimed at.
pub fn survey(scene: &Scene, settings: &Settings, lanes: LaneKind) -> Targets {
    survey_for(scene, settings, Carried::All, lanes)
}

/// The same for photons that carry this light.
pub fn survey_for(scene: &Scene, settings: &Settings, carried: Carried, lanes: LaneKind) -> Targets {
    let first = scene.at_for(scene.camera.shutter_time(settings.seed, 0), carried);
    let prepared = Prepared::new(first, &Parameters::default(), None);
    crate::survey::survey(scene, settings, &prepared, lanes)
}

/// The result of a photon pass.
#[derive(Clone, Debug)]
pub struct PhotonRun {
    /// The deposits that visible points may reach, each with its bucket, in order of buckets.
    pub photons: Vec<(Photon, u32)>,
    /// Segments traced.
    pub segments: u64,
    /// Photons that arrived at diffuse surfaces from bounce 1 on.
    pub deposits: u64,
}

/// The photon pass of one iteration over a range of photons, whose start is a multiple of 16. Keeps the deposits that are
/// `wanted`; photons are safe for visible points within `reach`.
pub fn photon_pass(
    (still, aim): (&Still, &Aim),
    settings: &Settings,
    iteration: u32,
    photons: Range<u32>,
    (wanted, cells, reach): (&Occupancy, Cells, f32),
    lanes: LaneKind,
) -> PhotonRun {
    let (emitters, lights) = (Emitters::new(still, aim.clone()), LightChoice::new(&still.lights.cumulative));
    let pass = PhotonPass {
        emission: Emission::new(still, &emitters, &lights, (settings.seed, iteration)),
        tables: &Tables::new(still),
        max_depth: settings.max_depth,
        carried: still.carried,
        cells: cells.0,
        occupancy: &wanted.0,
        reach,
        rounding: Rounding::of(still),
        at_once: BATCH,
    };
    let pool = Arc::new(Slabs::new());
    let mut out = Binned::new(&pool);
    let job = PhotonJob { pass: &pass, batch: &mut PhotonBatch::new(), photons, out: &mut out };
    let PhotonCounts { segments, deposits } = dispatch(lanes, job);
    let mut sorted = Sorted::new();
    sorted.fill(&mut [&mut out], &pool, cells.0);
    PhotonRun { photons: sorted_photons(&sorted), segments, deposits }
}

/// A point to be lit; as `reference::light_choice::Receiver`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Receiver {
    /// Where.
    pub point: Vec3,
    /// The normal of the side to be lit.
    pub normal: Vec3,
    /// On which sphere.
    pub sphere: SphereId,
}

/// The irradiance that each receiver gets straight from the lights; per receiver, a number to choose the light and
/// two for the direction. There must be a light.
pub fn direct_light(
    still: &Still,
    receivers: &[Receiver],
    numbers: [&[f32]; 3],
    lanes: LaneKind,
) -> Vec<Rgb> {
    let (tables, lights) = (Tables::new(still), LightTable::new(still));
    dispatch(lanes, Light { tables: &tables, lights: &lights, receivers, numbers })
}

/// The light that each receiver chooses by its number, with its probability; `None` where no light can arrive. There
/// must be a light.
pub fn choose_for_points(
    still: &Still,
    receivers: &[Receiver],
    choice: &[f32],
    lanes: LaneKind,
) -> Vec<Option<(u32, f32)>> {
    dispatch(lanes, ChooseForPoints { lights: &LightTable::new(still), receivers, choice })
}

struct ChooseForPoints<'a> {
    lights: &'a LightTable,
    receivers: &'a [Receiver],
    choice: &'a [f32],
}

impl Kernel for ChooseForPoints<'_> {
    type Output = Vec<Option<(u32, f32)>>;
    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        let mut all = Vec::with_capacity(self.receivers.len());
        for first in (0..self.receivers.len()).step_by(L::N) {
            let count = L::N.min(self.receivers.len() - first);
            let (points, normals, spheres) = arrays(&self.receivers[first..first + count]);
            let receivers = Receivers::<L> {
                live: L::first(count),
                point: points.load(0),
                normal: normals.load(0),
                sphere: L::load_u(&spheres),
            };
            let choice = L::load(&padded(&self.choice[first..first + count]));
            let chosen = self.lights.choose::<L>(&receivers, choice);
            let (mut lights, mut probabilities) = ([0; MOST_LANES], [0.0; MOST_LANES]);
            L::store_u(L::add_where(chosen.is_around, chosen.light, L::u(1)), &mut lights);
            L::store(chosen.probability, &mut probabilities);
            let found = L::mask_bits(chosen.found);
            for lane in 0..count {
                all.push((found >> lane & 1 == 1).then_some((lights[lane], probabilities[lane])));
            }
        }
        all
    }
}

struct Light<'a> {
    tables: &'a Tables,
    lights: &'a LightTable,
    receivers: &'a [Receiver],
    numbers: [&'a [f32]; 3],
}

impl Kernel for Light<'_> {
    type Output = Vec<Rgb>;
    #[inline(always)]
    fn run<L: Lanes>(self) -> Vec<Rgb> {
        let (mut shadows, mut search) = (Box::new(ShadowRays::new()), SearchBuffers::new());
        let mut all = Vec::with_capacity(self.receivers.len());
        for first in (0..self.receivers.len()).step_by(BATCH) {
            let count = BATCH.min(self.receivers.len() - first);
            let (points, normals, spheres) = arrays(&self.receivers[first..first + count]);
            let numbers = self.numbers.map(|numbers| padded(&numbers[first..first + count]));
            for at in (0..count).step_by(L::N) {
                let receivers = Receivers::<L> {
                    live: L::first(count - at),
                    point: points.load(at),
                    normal: normals.load(at),
                    sphere: L::load_u(&spheres[at..]),
                };
                let numbers = ShadowNumbers {
                    choice: L::load(&numbers[0][at..]),
                    u: L::load(&numbers[1][at..]),
                    v: L::load(&numbers[2][at..]),
                };
                shadows.aim(at, self.lights, &receivers, &numbers);
            }
            shadows.follow::<L>(self.tables, &points, &spheres, &mut search, count, true);
            let mut found: Vectors = Vectors::ZERO;
            for at in (0..count).step_by(L::N) {
                found.store::<L>(at, shadows.irradiance(at));
            }
            all.extend((0..count).map(|k| Rgb::new(found.x[k], found.y[k], found.z[k])));
        }
        all
    }
}

fn arrays(receivers: &[Receiver]) -> (Vectors, Vectors, Words) {
    let (mut points, mut normals, mut spheres) = (Vectors::ZERO, Vectors::ZERO, [NO_SPHERE; ROOM]);
    for (k, receiver) in receivers.iter().enumerate() {
        (points.x[k], points.y[k], points.z[k]) = receiver.point.into();
        (normals.x[k], normals.y[k], normals.z[k]) = receiver.normal.into();
        spheres[k] = receiver.sphere;
    }
    (points, normals, spheres)
}

fn padded(numbers: &[f32]) -> [f32; ROOM] {
    let mut padded = [0.0; ROOM];
    padded[..numbers.len()].copy_from_slice(numbers);
    padded
}
