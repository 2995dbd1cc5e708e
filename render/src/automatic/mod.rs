//! Chooses settings that a scene leaves open, from the scene and the work counted in a small render, the pilot.
//!
//! Nothing depends on a clock, on the processor or on threads, so the image stays a function of scene, settings and seed.
//! docs/quality.md has the reasons, and what was measured.
//!
//! ```text
//! radius      LARGEST_RADIUS footprints of a pixel, from which pilots choose down for each pixel, or clearance if there are
//!             few iterations
//! depth       the least of DEPTHS that hardly darkens the pilot
//! photons     the number by which the noise is least for so much work, from a pilot with few and one with many
//! iterations  until the noise is that of the quality, but for so much work at most
//! ```
//!
//! Of these a render by path tracing has depth and iterations. By how much a depth darkens an image, photon mapping tells for
//! both; noise and work are those of a pilot by path tracing.

mod account;
mod bias;
mod footprint;
mod pilot;
mod pilots;

use crate::memory::{bytes_of_scene, lamps};
use crate::names::MethodName;
use account::{Account, camera_work, photon_work};
pub(crate) use bias::{Bias, first_bias};
use fast::{DEPOSITS_OF_PILOTS, LaneKind, Parameters, PathTracer, Sppm};
use footprint::footprint;
use pilot::{SEEDS, loss};
use pilots::{PILOT_PHOTONS, Pilots, large_pilot_settings};
use scene::settings::{MAX_DEPOSITS, MAX_PHOTONS, RADIUS_RANGE, RADIUS_RATIO};
use scene::{Automatic, Quality, RadiusSchedule, Scene, Settings, Stop};

/// The first radius in footprints of a pixel, if the render does not end by its quality. Of eleven scenes, the radii by
/// which the error of pixels and of blocks was least lay from 1.2 to 6.9 and from 0.6 to 5.3; see docs/quality.md.
const RADIUS: f32 = 4.0;
/// The largest of the first radii, in footprints, where each pixel has its own; and the share of it that most pixels take,
/// by which photons are chosen.
const LARGEST_RADIUS: f32 = 12.0;
const TYPICAL_SHARE: f32 = 0.6;
/// Iterations of the render for each of a pilot that chooses radii, of which there are eight renders of fewer pixels; and the
/// most of a pilot. More of them choose better, but hardly so: see docs/quality.md.
const ITERATIONS_PER_PILOT: u32 = 64;
const MOST_PILOTS: u32 = 4;
/// In a render of fewer iterations than ask for a pilot, first radii are limited by clearance instead, by this factor: pilots
/// would take longer than they are worth. See docs/quality.md.
const CLEARANCE: f32 = 0.7;
/// The numbers of rays through a pixel that sees a lamp, or a mirror or glass, from which one is chosen, each with a share: the most
/// whose work is not more than this share of what an iteration takes without them. Up to 8 rays gain what they cost in most scenes;
/// more of them gain little, and are sent where they hardly cost. See docs/quality.md.
const GLINT_SAMPLES: [(u32, f64); 5] = [(32, 0.25), (16, 0.25), (8, 1.25), (4, 1.25), (2, 1.25)];
/// The rays of the pilot that counts their work.
const GLINTS_OF_PILOT: u32 = 8;
/// The first of global radii over the first of radii per pixel: the root of alpha. With light that is even around a pixel, the
/// squared radii per pixel are those of the iteration before times alpha, `r_i^2 (i - 1 + alpha) / i`, and global ones
/// `r_i^2 (i + alpha) / (i + 1)`; so from this first radius both become the same (docs/farm.md).
const GLOBAL: f32 = 0.816_496_6;
/// What the allocator may keep of the lamps' tables of one pilot while another thread makes those of the next, per lamp: of
/// 100,000 lamps 20 bytes were seen beyond what is counted, on a busy machine. The rest is reserve.
const KEPT_PER_LAMP: u64 = 160;
/// Paths in each pixel of the pilot by path tracing. With fewer, light that few paths find is missed in most pixels.
const PATHS: u32 = 4;
/// The depths from which one is chosen. The last is as good as all light.
const DEPTHS: [u32; 4] = [8, 16, 32, 64];
/// Pixels along the side of a block, as images are compared by blocks of 8 x 8.
const BLOCK: f64 = 8.0;

/// The noise to reach, and the work that may be spent on it.
struct Goal {
    /// Root of the relative mean square error of pixels.
    noise: f64,
    /// In units of a ray segment among few spheres.
    work: f64,
    /// The share of light that may be lost by a finite depth.
    loss: f64,
    /// The first radius, in footprints of a pixel. With a 64th of the work, the best radius is twice as large: bias grows
    /// as its fourth power, noise falls as its square.
    radius: f32,
}

impl Goal {
    fn of(quality: Quality) -> Self {
        match quality {
            Quality::Draft => Self { noise: 0.08, work: 2e7, loss: 0.02, radius: 6.5 },
            Quality::Good | Quality::Paper => Self { noise: 0.02, work: 2e8, loss: 0.005, radius: 4.8 },
            Quality::Final => Self { noise: 0.007, work: 5e9, loss: 0.002, radius: 3.6 },
        }
    }
}

/// The settings of `scene` with those that are `automatic` chosen for `method`; `None` if stopped.
///
/// Takes at most [`bytes_at_most`].
pub(crate) fn choose(
    scene: &Scene,
    automatic: Automatic,
    (method, lanes): (MethodName, LaneKind),
    stop: &Stop,
) -> Option<Settings> {
    match method {
        MethodName::Sppm | MethodName::Hybrid => choose_for_photons(scene, automatic, (method, lanes), stop),
        MethodName::Path => choose_for_paths(scene, automatic, lanes, stop),
    }
}

/// True if lamps may be seen in mirrors or glass.
fn shows_lamps_again(scene: &Scene) -> bool {
    let is_smooth = |material: u32| !scene.materials[material as usize].is_diffuse();
    scene.spheres.iter().any(|sphere| is_smooth(sphere.material)) && scene.at(0.0).has_lamps()
}

fn choose_for_paths(scene: &Scene, automatic: Automatic, lanes: LaneKind, stop: &Stop) -> Option<Settings> {
    let (goal, mut settings) = (Goal::of(automatic.quality), scene.settings);
    if automatic.max_depth {
        // The photons of pilots need a radius that suits the scene. Paths have none, so nobody has stated one.
        let radius = footprint(lanes, scene, &settings)
            .map(|side| first_radius(RADIUS * side, RadiusSchedule::PerPixel));
        let typical = Settings { initial_radius: radius.unwrap_or(settings.initial_radius), ..settings };
        settings.max_depth = Pilots::new(scene, &typical, lanes, stop).depth(&goal)?;
    }
    if automatic.iterations {
        let pilots = Pilots::new(scene, &settings, lanes, stop);
        let pilot = pilots.run_paths(SEEDS, PATHS, settings.max_depth)?;
        let scale = settings.pixels() as f64 / pilots.settings.pixels() as f64;
        let variance = pilot.variance(pilots.block(&settings));
        let account = Account::of_paths(PATHS, variance, &pilot.stats, scale)
            .of(settings.pixels(), scene.spheres.len());
        settings.iterations = account.iterations(1, goal.noise, goal.work);
    }
    Some(settings)
}

fn choose_for_photons(
    scene: &Scene,
    automatic: Automatic,
    (method, lanes): (MethodName, LaneKind),
    stop: &Stop,
) -> Option<Settings> {
    let goal = Goal::of(automatic.quality);
    let mut settings = scene.settings;
    let are_chosen = automatic.radius_pilots || automatic.radius_clearance;
    let are_own = are_chosen && settings.radius_schedule == RadiusSchedule::PerPixel
        || settings.radius_pilots > 0
        || settings.radius_clearance > 0.0;
    if automatic.initial_radius
        && let Some(side) = footprint(lanes, scene, &settings)
    {
        let footprints = match (are_own, automatic.iterations) {
            (true, _) => LARGEST_RADIUS,
            (false, true) => goal.radius,
            (false, false) => RADIUS,
        };
        settings.initial_radius = first_radius(footprints * side, settings.radius_schedule);
    }
    let share = if are_own { TYPICAL_SHARE } else { 1.0 };
    let typical = Settings { initial_radius: settings.initial_radius * share, ..settings };
    let pilot = Pilots::new(scene, &typical, lanes, stop).by(method);
    if automatic.max_depth {
        settings.max_depth = pilot.depth(&goal)?;
    }
    if automatic.glint_samples {
        let is_worthwhile = shows_lamps_again(scene);
        settings.glint_samples = if is_worthwhile { pilot.glint_samples(settings.max_depth)? } else { 1 };
    }
    if automatic.photons_per_iteration || automatic.iterations {
        let Settings { max_depth, glint_samples, .. } = settings;
        let account = pilot.account(&Settings { max_depth, glint_samples, ..typical })?;
        if automatic.photons_per_iteration {
            settings.photons_per_iteration = account.photons(most_photons(settings.max_depth), goal.work);
        }
        if automatic.iterations {
            settings.iterations = account.iterations(settings.photons_per_iteration, goal.noise, goal.work);
        }
    }
    if are_own {
        choose_first_radii(&mut settings, automatic);
    }
    Some(settings)
}

/// How each pixel comes to a first radius of its own: by pilots in renders of many iterations, else by clearance.
fn choose_first_radii(settings: &mut Settings, automatic: Automatic) {
    // A render that ends by time or by its error has the most iterations there can be.
    let pilots = (settings.iterations / ITERATIONS_PER_PILOT).min(MOST_PILOTS);
    if automatic.radius_pilots {
        let is_limited = !automatic.radius_clearance && settings.radius_clearance > 0.0;
        let least = u32::from(!automatic.radius_clearance);
        settings.radius_pilots = if is_limited { 0 } else { pilots.max(least) };
    }
    if automatic.radius_clearance {
        settings.radius_clearance = if settings.radius_pilots > 0 { 0.0 } else { CLEARANCE };
    }
}

/// The most photons of an iteration of paths that have at most `max_depth` segments.
fn most_photons(max_depth: u32) -> u32 {
    ((MAX_DEPOSITS - 1) / u64::from(max_depth)).min(MAX_PHOTONS.into()) as u32
}

/// The initial radius, in scene units, by which radii per pixel would begin with `radius`.
fn first_radius(radius: f32, schedule: RadiusSchedule) -> f32 {
    let share = match schedule {
        RadiusSchedule::PerPixel => 1.0,
        RadiusSchedule::Global => GLOBAL,
    };
    let [least, most] = [RADIUS_RANGE[0] * RADIUS_RATIO, RADIUS_RANGE[1]];
    rounded(share * radius).clamp(least, most)
}

/// The most bytes that choosing settings takes, or estimating the bias, on so many threads.
pub(crate) fn bytes_at_most(scene: &Scene, threads: usize) -> u64 {
    let settings = large_pilot_settings(&scene.settings);
    let (spheres, parameters) = (scene.spheres.len(), Parameters::default());
    // Those of the bias are twice as many as those of the second pilot.
    let photons_per_iteration = 2 * settings.photons_per_iteration * PILOT_PHOTONS.2;
    let deepest = Settings { photons_per_iteration, max_depth: DEPTHS[3], ..settings };
    let films = 16 * bias::FILMS * settings.pixels() as u64;
    // The variances of all channels are sorted.
    let terms = 3 * 8 * settings.pixels() as u64;
    let of_photons = Sppm::bytes_at_most(&deepest, spheres, threads, DEPOSITS_OF_PILOTS, &parameters);
    // Path tracing with photons for caustics has both.
    let of_engine = of_photons + PathTracer::bytes_at_most(&deepest, spheres, threads);
    of_engine + bytes_of_scene(scene) + lamps(scene) * KEPT_PER_LAMP + films + terms
}

impl Pilots<'_> {
    /// The least depth of [`DEPTHS`] by which no more light is lost than `goal` allows. The images that are compared have
    /// the same random numbers, so they differ by what is lost alone.
    fn depth(&self, goal: &Goal) -> Option<u32> {
        let [shallow @ .., deepest] = DEPTHS;
        let all = self.run(1, |settings| settings.max_depth = deepest)?;
        for depth in shallow {
            let less = self.run(1, |settings| settings.max_depth = depth)?;
            if loss(&less.films[0], &all.films[0], self.block(&self.settings)) <= goal.loss {
                return Some(depth);
            }
        }
        Some(deepest)
    }

    /// The rays through a pixel that sees a lamp, or a mirror or glass, in paths of so many segments.
    fn glint_samples(&self, max_depth: u32) -> Option<u32> {
        let of = |glint_samples| {
            self.run(1, |pilot| (pilot.max_depth, pilot.glint_samples) = (max_depth, glint_samples))
        };
        let (one, several) = (of(1)?.stats, of(GLINTS_OF_PILOT)?.stats);
        let each = (camera_work(&several) - camera_work(&one)) / f64::from(GLINTS_OF_PILOT);
        let rest = camera_work(&one) + photon_work(&one, 1.0);
        let is_cheap = |&&(samples, share): &&(u32, f64)| f64::from(samples) * each <= share * rest;
        Some(GLINT_SAMPLES.iter().find(is_cheap).map_or(1, |(samples, _)| *samples))
    }

    /// The side of a block in pixels of the pilot, for an image of so many pixels.
    fn block(&self, settings: &Settings) -> usize {
        let scale = (self.settings.pixels() as f64 / settings.pixels() as f64).sqrt();
        ((BLOCK * scale + 0.5) as usize).max(1)
    }

    /// Noise and work of a render with `settings`.
    fn account(&self, settings: &Settings) -> Option<Account> {
        let few = self.settings.photons_per_iteration;
        let many = few * PILOT_PHOTONS.2;
        let of = |photons| {
            self.run(SEEDS, |pilot| {
                pilot.photons_per_iteration = photons;
                (pilot.max_depth, pilot.initial_radius) = (settings.max_depth, settings.initial_radius);
                pilot.glint_samples = settings.glint_samples;
            })
        };
        let (first, second) = (of(few)?, of(many)?);
        let side = self.block(settings);
        let scale = settings.pixels() as f64 / self.settings.pixels() as f64;
        let variances = [first.variance(side), second.variance(side)];
        Some(
            Account::new([few, many], variances, &second.stats, scale)
                .of(settings.pixels(), self.scene.spheres.len()),
        )
    }
}

/// `value` with two significant digits.
fn rounded(value: f32) -> f32 {
    format!("{value:.1e}").parse().unwrap_or(value)
}

#[cfg(test)]
mod tests;
