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
//! method      photon mapping, or path tracing with photons for caustics: the one by which the noise is less for so much work
//! ```
//!
//! A render by path tracing has no radius and no photons. By how much a depth darkens an image, photon mapping tells for all
//! methods; noise and work are those of pilots by the method itself.

mod account;
mod bias;
mod footprint;
mod goal;
mod method;
mod pilot;
mod pilots;

use crate::memory::{bytes_of_scene, lamps};
use crate::names::MethodName;
pub(crate) use bias::{Bias, first_bias};
use fast::{DEPOSITS_OF_PILOTS, LaneKind, Parameters, PathTracer, Sppm};
use footprint::footprint;
use goal::Goal;
use method::plan;
use pilot::loss;
use pilots::{PILOT_PHOTONS, Pilots, large_pilot_settings};
use scene::settings::{RADIUS_RANGE, RADIUS_RATIO};
use scene::{Automatic, RadiusSchedule, Scene, Settings, Stop};

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
/// The first of global radii over the first of radii per pixel: the root of alpha. With light that is even around a pixel, the
/// squared radii per pixel are those of the iteration before times alpha, `r_i^2 (i - 1 + alpha) / i`, and global ones
/// `r_i^2 (i + alpha) / (i + 1)`; so from this first radius both become the same (docs/farm.md).
const GLOBAL: f32 = 0.816_496_6;
/// What the allocator may keep of the lamps' tables of one pilot while another thread makes those of the next, per lamp: of
/// 100,000 lamps 20 bytes were seen beyond what is counted, on a busy machine. The rest is reserve.
const KEPT_PER_LAMP: u64 = 160;
/// The depths from which one is chosen. The last is as good as all light.
const DEPTHS: [u32; 4] = [8, 16, 32, 64];
/// Pixels along the side of a block, as images are compared by blocks of 8 x 8.
const BLOCK: f64 = 8.0;

/// The method of the render, `method` if it is not chosen, and the settings of `scene` with those that are `automatic` chosen
/// for it; `None` if stopped.
///
/// Takes at most [`bytes_at_most`].
pub(crate) fn choose(
    scene: &Scene,
    automatic: Automatic,
    (method, lanes): (MethodName, LaneKind),
    stop: &Stop,
) -> Option<(MethodName, Settings)> {
    let goal = Goal::of(automatic.quality);
    let are_own = are_own(&scene.settings, automatic);
    let side = footprint(lanes, scene, &scene.settings);
    let mut settings = scene.settings;
    if let Some(side) = side.filter(|_| automatic.initial_radius) {
        settings.initial_radius =
            first_radius(side * footprints(&goal, are_own, automatic), settings.radius_schedule);
    }
    // The photons of pilots need a radius that suits the scene. Paths have none, so nobody has stated one.
    let radius = match side.filter(|_| !method.has_photons()) {
        Some(side) => TYPICAL_SHARE * first_radius(side * LARGEST_RADIUS, RadiusSchedule::PerPixel),
        None => settings.initial_radius * if are_own { TYPICAL_SHARE } else { 1.0 },
    };
    let pilots = Pilots::new(scene, &Settings { initial_radius: radius, ..settings }, lanes, stop);
    if automatic.max_depth {
        settings.max_depth = pilots.depth(&goal)?;
    }
    let plan = plan(&pilots, &settings, (automatic, method), &goal)?;
    plan.apply(&mut settings, automatic, &goal);
    if !plan.method.has_photons() {
        settings.initial_radius = scene.settings.initial_radius;
    } else if are_own {
        choose_first_radii(&mut settings, automatic);
    }
    Some((plan.method, settings))
}

/// Whether each pixel has a first radius of its own.
fn are_own(settings: &Settings, automatic: Automatic) -> bool {
    let are_chosen = automatic.radius_pilots || automatic.radius_clearance;
    are_chosen && settings.radius_schedule == RadiusSchedule::PerPixel
        || settings.radius_pilots > 0
        || settings.radius_clearance > 0.0
}

/// The first radius, or the largest of them, in footprints of a pixel.
fn footprints(goal: &Goal, are_own: bool, automatic: Automatic) -> f32 {
    match (are_own, automatic.iterations) {
        (true, _) => LARGEST_RADIUS,
        (false, true) => goal.radius,
        (false, false) => RADIUS,
    }
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

    /// The side of a block in pixels of the pilot, for an image of so many pixels.
    fn block(&self, settings: &Settings) -> usize {
        let scale = (self.settings.pixels() as f64 / settings.pixels() as f64).sqrt();
        ((BLOCK * scale + 0.5) as usize).max(1)
    }
}

/// `value` with two significant digits.
fn rounded(value: f32) -> f32 {
    format!("{value:.1e}").parse().unwrap_or(value)
}

#[cfg(test)]
mod tests;
