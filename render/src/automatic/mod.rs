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
/// The numbers of rays through a pixel that sees a lamp, or a mirror or glass, from which one is chosen: the most whose work is
/// not more than this share of what an iteration takes without them. See docs/quality.md.
const GLINT_SAMPLES: [u32; 3] = [8, 4, 2];
const GLINT_WORK: f64 = 1.0;
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
            Quality::Good | Quality::Paper => Self { noise: 0.02, work: 2.5e8, loss: 0.005, radius: 4.8 },
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
        let most = GLINT_SAMPLES[0];
        let of = |glint_samples| {
            self.run(1, |pilot| (pilot.max_depth, pilot.glint_samples) = (max_depth, glint_samples))
        };
        let (one, several) = (of(1)?.stats, of(most)?.stats);
        let each = (camera_work(&several) - camera_work(&one)) / f64::from(most - 1);
        let room = GLINT_WORK * (camera_work(&one) + photon_work(&one, 1.0));
        let is_cheap = |samples: &u32| f64::from(samples - 1) * each <= room;
        Some(GLINT_SAMPLES.into_iter().find(is_cheap).unwrap_or(1))
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
mod tests {
    use super::*;
    use rayon::ThreadPoolBuilder;
    use scene::Rgb;

    fn cornell() -> Scene {
        let scene = files::builtin::scene("cornell").unwrap();
        Scene { settings: Settings { width: 64, height: 48, ..scene.settings }, ..scene }
    }

    fn chosen(scene: &Scene, automatic: Automatic, lanes: LaneKind, threads: usize) -> Settings {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| choose(scene, automatic, (MethodName::Sppm, lanes), &Stop::new())).unwrap()
    }

    #[test]
    fn the_choice_depends_on_neither_threads_nor_lanes() {
        let scene = cornell();
        let all = Automatic::all(Quality::Good);
        let one = chosen(&scene, all, LaneKind::best(), 1);
        for lanes in LaneKind::ALL.into_iter().filter(|lanes| lanes.is_available()) {
            for threads in [1, 2, 3] {
                assert_eq!(chosen(&scene, all, lanes, threads), one, "{lanes:?}, {threads} threads");
            }
        }
        one.validate().unwrap();
        assert!(one != scene.settings);
    }

    /// The noise of the render is that of the quality, within what pilots of few paths can tell.
    #[test]
    fn paths_are_as_many_as_their_noise_asks_for() {
        const FACTOR: f64 = 2.0;
        let mut scene = files::builtin::scene("terrace").unwrap();
        (scene.settings.width, scene.settings.height) = (96, 72);
        let automatic = Automatic::all(Quality::Draft).without_photons();
        let of =
            |automatic, lanes| choose(&scene, automatic, (MethodName::Path, lanes), &Stop::new()).unwrap();
        let found = of(automatic, LaneKind::best());
        assert_eq!(found, of(automatic, LaneKind::Emulated));
        let own = Settings { iterations: found.iterations, max_depth: found.max_depth, ..scene.settings };
        assert_eq!(found, own, "something else is chosen");
        let stop = Stop::new();
        let pilots = Pilots::new(&scene, &found, LaneKind::best(), &stop);
        let noise = pilots.run_paths(8, found.iterations, found.max_depth).unwrap().variance(8).pixel.sqrt();
        let goal = Goal::of(Quality::Draft).noise;
        assert!((goal / FACTOR..goal * FACTOR).contains(&noise), "{noise} for {goal}: {found:?}");
        let fixed = Automatic { iterations: false, ..automatic };
        assert_eq!(of(fixed, LaneKind::best()).iterations, scene.settings.iterations);
    }

    /// So many as do not take more work than the rest: few where mirrors fill the image, none where there is nothing to see in.
    #[test]
    fn rays_that_see_lamps_are_as_many_as_their_work_allows() {
        let of = |name: &str, change: fn(&mut Scene)| {
            let mut scene = files::builtin::scene(name).unwrap();
            (scene.settings.width, scene.settings.height) = (64, 48);
            change(&mut scene);
            let only = Automatic { glint_samples: true, ..Automatic::default() };
            chosen(&scene, only, LaneKind::best(), 1).glint_samples
        };
        assert_eq!(of("dusk", |_| {}), GLINT_SAMPLES[0]);
        assert!(of("mirror", |_| {}) < GLINT_SAMPLES[0]);
        let is_smooth = |scene: &Scene, material: u32| !scene.materials[material as usize].is_diffuse();
        let matte = |scene: &mut Scene| {
            let diffuse = (0..scene.materials.len() as u32).find(|m| !is_smooth(scene, *m)).unwrap();
            scene.spheres.iter_mut().for_each(|sphere| sphere.material = diffuse);
        };
        let mut scene = cornell();
        matte(&mut scene);
        let only = Automatic { glint_samples: true, ..Automatic::default() };
        assert_eq!(chosen(&scene, only, LaneKind::best(), 1).glint_samples, 1);
        let mut dark = cornell();
        dark.spheres.iter_mut().for_each(|sphere| sphere.emission = Rgb::ZERO);
        assert!(!shows_lamps_again(&dark) && shows_lamps_again(&cornell()));
    }

    #[test]
    fn only_what_is_automatic_is_chosen() {
        let scene = cornell();
        let none = Automatic::default();
        for one in [
            Automatic { iterations: true, ..none },
            Automatic { photons_per_iteration: true, ..none },
            Automatic { max_depth: true, ..none },
            Automatic { initial_radius: true, ..none },
            Automatic { radius_pilots: true, ..none },
            Automatic { radius_clearance: true, ..none },
            Automatic { glint_samples: true, ..none },
        ] {
            let (found, own) = (chosen(&scene, one, LaneKind::best(), 1), scene.settings);
            assert_eq!(found.iterations == own.iterations, !one.iterations, "{found:?}");
            assert_eq!(
                found.photons_per_iteration == own.photons_per_iteration,
                !one.photons_per_iteration,
                "{found:?}"
            );
            assert_eq!(found.max_depth == own.max_depth, !one.max_depth, "{found:?}");
            assert_eq!(found.initial_radius == own.initial_radius, !one.initial_radius, "{found:?}");
            assert_eq!(found.radius_pilots == own.radius_pilots, !one.radius_pilots, "{found:?}");
            assert_eq!(found.radius_clearance == own.radius_clearance, !one.radius_clearance, "{found:?}");
            assert_eq!(found.glint_samples == own.glint_samples, !one.glint_samples, "{found:?}");
        }
    }

    #[test]
    fn a_pilot_has_an_iteration_for_so_many_of_the_render() {
        let one = Automatic { radius_pilots: true, ..Automatic::default() };
        for (iterations, pilots) in [(1, 1), (64, 1), (128, 2), (250, 3), (256, 4), (100_000, 4)] {
            let mut scene = cornell();
            scene.settings.iterations = iterations;
            assert_eq!(
                chosen(&scene, one, LaneKind::best(), 1).radius_pilots,
                pilots,
                "{iterations} iterations"
            );
        }
    }

    /// By clearance in renders that are too short for a pilot, and by one of both alone, unless both are given.
    #[test]
    fn first_radii_are_by_clearance_or_by_pilots() {
        let none = Automatic::default();
        let [pilots, clearance] =
            [Automatic { radius_pilots: true, ..none }, Automatic { radius_clearance: true, ..none }];
        let both = Automatic { radius_pilots: true, radius_clearance: true, ..none };
        let own = |radius_pilots, radius_clearance| Settings {
            radius_pilots,
            radius_clearance,
            ..Settings::default()
        };
        for (automatic, iterations, given, expected) in [
            (both, 63, (0, 0.0), (0, CLEARANCE)),
            (both, 64, (9, 9.0), (1, 0.0)),
            (both, 1 << 30, (0, 0.0), (4, 0.0)),
            (pilots, 63, (9, 0.0), (1, 0.0)),
            (pilots, 500, (9, 2.0), (0, 2.0)),
            (clearance, 500, (0, 0.0), (0, CLEARANCE)),
            (clearance, 6, (2, 5.0), (2, 0.0)),
            (none, 6, (2, 5.0), (2, 5.0)),
        ] {
            let mut settings = Settings { iterations, ..own(given.0, given.1) };
            choose_first_radii(&mut settings, automatic);
            let found = (settings.radius_pilots, settings.radius_clearance);
            assert_eq!(found, expected, "{iterations} iterations, {automatic:?}, given {given:?}");
        }
    }

    /// A block shows the same part of the picture, whatever its size.
    #[test]
    fn blocks_are_to_the_image_as_those_of_the_pilot_are_to_it() {
        let (scene, stop) = (cornell(), Stop::new());
        let pilots = Pilots::new(&scene, &scene.settings, LaneKind::best(), &stop);
        let Settings { width, height, .. } = pilots.settings;
        assert_eq!(pilots.block(&pilots.settings), BLOCK as usize);
        for (times, block) in [(2, 4), (3, 3), (8, 1), (100, 1)] {
            let larger = Settings { width: width * times, height: height * times, ..scene.settings };
            assert_eq!(pilots.block(&larger), block, "{times} times");
        }
    }

    /// What is chosen follows from the scene, and not from what the scene has in its place.
    #[test]
    fn what_is_chosen_does_not_depend_on_what_stands_there() {
        let scene = cornell();
        let all = Automatic::all(Quality::Draft);
        let expected = chosen(&scene, all, LaneKind::best(), 1);
        let own = Settings {
            iterations: 77,
            photons_per_iteration: 1_000_000,
            max_depth: 2,
            initial_radius: 0.01,
            radius_pilots: 3,
            ..scene.settings
        };
        let found = chosen(&Scene { settings: own, ..scene }, all, LaneKind::best(), 1);
        assert_eq!(found, expected);
    }

    /// Where pixels have radii of their own, most of which are narrower than the largest.
    #[test]
    fn photons_are_chosen_for_the_radius_that_most_pixels_take() {
        let scene = cornell();
        let of = |initial_radius: f32, are_own: bool| {
            let settings = Settings { initial_radius, radius_pilots: 0, ..scene.settings };
            let automatic = Automatic {
                initial_radius: false,
                radius_pilots: are_own,
                radius_clearance: are_own,
                ..Automatic::all(Quality::Good)
            };
            chosen(&Scene { settings, ..scene.clone() }, automatic, LaneKind::best(), 1)
        };
        let (own, even) = (of(8.0, true), of(8.0 * TYPICAL_SHARE, false));
        assert!(own.radius_pilots > 0 && even.radius_pilots == 0);
        assert_eq!(
            (own.iterations, own.photons_per_iteration),
            (even.iterations, even.photons_per_iteration)
        );
        assert_ne!(own.iterations, of(8.0, false).iterations, "the radius is of no account here");
    }

    /// The scene, the engines of the largest pilot, all images that are held at once, and the terms of a variance of one image.
    #[test]
    fn bytes_are_those_of_the_largest_pilot_and_of_its_images() {
        /// In memory an image may be padded to so many bytes per pixel.
        const PADDED: u64 = 16;
        for (width, height, threads) in [(64, 48, 1), (1024, 768, 3)] {
            let mut scene = cornell();
            (scene.settings.width, scene.settings.height) = (width, height);
            let pilot = large_pilot_settings(&scene.settings);
            let largest =
                Settings { photons_per_iteration: pilot.photons_per_iteration * 8, max_depth: 64, ..pilot };
            let (spheres, parameters) = (scene.spheres.len(), Parameters::default());
            let engine = |settings: &Settings| {
                Sppm::bytes_at_most(settings, spheres, threads, DEPOSITS_OF_PILOTS, &parameters)
                    + PathTracer::bytes_at_most(settings, spheres, threads)
            };
            let of_scene = bytes_of_scene(&scene) + lamps(&scene) * KEPT_PER_LAMP;
            let images = bytes_at_most(&scene, threads) - engine(&largest) - of_scene;
            let pixels = pilot.pixels() as u64;
            let terms = size_of::<[f64; 3]>() as u64;
            assert!(PADDED >= size_of::<Rgb>() as u64);
            assert_eq!(images, (PADDED * bias::FILMS + terms) * pixels, "{pixels} pixels");
            // What makes it the largest.
            assert!(engine(&largest) > engine(&Settings { max_depth: 16, ..largest }));
            let fewer = Settings { photons_per_iteration: pilot.photons_per_iteration * 4, ..largest };
            assert!(engine(&largest) > engine(&fewer));
        }
    }

    /// Scenes of many lamps are small in pixels, and large in what is found out about their light.
    #[test]
    fn bytes_grow_with_spheres_and_lamps() {
        let base = cornell();
        let more = |is_lamp: bool| {
            let mut scene = base.clone();
            let sphere = *scene.spheres.iter().find(|sphere| sphere.is_emitter() == is_lamp).unwrap();
            scene.spheres.push(sphere);
            let of_engine = |scene: &Scene| {
                let pilot = large_pilot_settings(&scene.settings);
                let spheres = scene.spheres.len();
                Sppm::bytes_at_most(&pilot, spheres, 1, DEPOSITS_OF_PILOTS, &Parameters::default())
                    + PathTracer::bytes_at_most(&pilot, spheres, 1)
            };
            let more = bytes_at_most(&scene, 1) - bytes_at_most(&base, 1);
            more - (of_engine(&scene) - of_engine(&base))
        };
        let sphere = bytes_of_scene(&base) - {
            let mut fewer = base.clone();
            let dark = fewer.spheres.iter().position(|sphere| !sphere.is_emitter()).unwrap();
            fewer.spheres.remove(dark);
            bytes_of_scene(&fewer)
        };
        assert_eq!(more(false), sphere);
        assert!(more(true) >= sphere + size_of::<scene::still::Light>() as u64 + KEPT_PER_LAMP);
    }

    #[test]
    fn photons_are_as_many_as_their_depth_allows() {
        for depth in [1, 8, 16, 64, 1000] {
            let most = most_photons(depth);
            let is_valid = |photons: u32| {
                let settings =
                    Settings { photons_per_iteration: photons, max_depth: depth, ..Settings::default() };
                settings.validate().is_ok()
            };
            assert!(is_valid(most) && !is_valid(most + 1), "{most} at depth {depth}");
        }
    }

    /// Within the digits that radii are rounded to.
    #[test]
    fn global_radii_begin_smaller() {
        let scene = cornell();
        let one = Automatic { initial_radius: true, ..Automatic::default() };
        let of = |radius_schedule| {
            let settings = Settings { radius_schedule, ..scene.settings };
            let scene = Scene { settings, ..scene.clone() };
            chosen(&scene, one, LaneKind::best(), 1).initial_radius
        };
        let [per_pixel, global] = RadiusSchedule::ALL.map(of);
        let share = global / per_pixel;
        assert!((share.powi(2) - 2.0 / 3.0).abs() < 0.02, "{share}");
    }

    #[test]
    fn better_pictures_take_more_iterations() {
        let scene = cornell();
        let of = |quality| chosen(&scene, Automatic::all(quality), LaneKind::best(), 1);
        let [draft, good, last] = [Quality::Draft, Quality::Good, Quality::Final].map(of);
        assert!(draft.iterations < good.iterations && good.iterations < last.iterations);
        assert!(draft.max_depth <= good.max_depth && good.max_depth <= last.max_depth);
        assert!(draft.radius_pilots == 0 && draft.radius_clearance > 0.0);
        assert!(last.radius_pilots > 0 && last.radius_clearance == 0.0);
        assert_eq!(draft.initial_radius, last.initial_radius);
    }

    /// With the same radius for all pixels it is narrower than the largest of their own, and the narrower, the better the
    /// picture.
    #[test]
    fn one_radius_for_all_follows_the_quality() {
        let scene = cornell();
        let own = chosen(&scene, Automatic::all(Quality::Good), LaneKind::best(), 1);
        let settings = Settings { radius_schedule: RadiusSchedule::Global, ..scene.settings };
        let scene = Scene { settings, ..scene };
        let of = |quality| chosen(&scene, Automatic::all(quality), LaneKind::best(), 1);
        let [draft, good, last] = [Quality::Draft, Quality::Good, Quality::Final].map(of);
        assert!([draft, good, last].iter().all(|s| (s.radius_pilots, s.radius_clearance) == (0, 0.0)));
        assert!(draft.initial_radius > good.initial_radius && good.initial_radius > last.initial_radius);
        assert!(own.initial_radius > draft.initial_radius);
    }

    #[test]
    fn a_stopped_choice_gives_nothing() {
        let stop = Stop::new();
        stop.request();
        for method in MethodName::ALL {
            assert_eq!(
                choose(&cornell(), Automatic::all(Quality::Good), (method, LaneKind::best()), &stop),
                None
            );
        }
    }

    #[test]
    fn radii_have_two_digits() {
        assert_eq!(rounded(1.2345), 1.2);
        assert_eq!(rounded(0.009_87), 0.0099);
        assert_eq!(rounded(98_765.0), 99_000.0);
    }

    /// No picture is too small, and nothing that is seen may be missing.
    #[test]
    fn tiny_pictures_and_empty_views_have_settings_too() {
        let mut scene = cornell();
        for (width, height) in [(1, 1), (1, 300), (7, 3)] {
            (scene.settings.width, scene.settings.height) = (width, height);
            chosen(&scene, Automatic::all(Quality::Draft), LaneKind::best(), 1).validate().unwrap();
        }
    }

    /// Of half as many rows and columns, pixels are twice as large.
    #[test]
    fn radii_follow_the_size_of_pixels() {
        let one = Automatic { initial_radius: true, ..Automatic::default() };
        let of = |width, height, radius_pilots, radius_clearance| {
            let scene = cornell();
            let settings = Settings { width, height, radius_pilots, radius_clearance, ..scene.settings };
            chosen(&Scene { settings, ..scene }, one, LaneKind::best(), 1).initial_radius
        };
        let (coarse, fine) = (of(64, 48, 0, 0.0), of(128, 96, 0, 0.0));
        // Radii have two digits.
        assert!((coarse / fine - 2.0).abs() < 0.15, "{coarse}, {fine}");
        // With radii of their own, pixels have wider ones to choose from, whoever asks for them.
        let own = of(64, 48, 2, 0.0);
        assert_eq!(own, of(64, 48, 0, 0.5));
        assert!((own / coarse - LARGEST_RADIUS / RADIUS).abs() < 0.15, "{own}, {coarse}");
    }

    /// The least depth that loses no more than is allowed, or else the deepest.
    #[test]
    fn depths_are_the_least_that_are_good_enough() {
        let (scene, stop) = (cornell(), Stop::new());
        let pilots = Pilots::new(&scene, &scene.settings, LaneKind::best(), &stop);
        let of = |loss| pilots.depth(&Goal { loss, ..Goal::of(Quality::Good) }).unwrap();
        assert_eq!([of(f64::INFINITY), of(-1.0)], [DEPTHS[0], DEPTHS[3]]);
        let film = |depth| pilots.run(1, |settings| settings.max_depth = depth).unwrap().films.remove(0);
        let all = film(DEPTHS[3]);
        let lost = |depth| loss(&film(depth), &all, pilots.block(&pilots.settings));
        let (first, second) = (lost(DEPTHS[0]), lost(DEPTHS[1]));
        assert!(first > second && second > 0.0, "{first}, {second}");
        assert_eq!(
            [of(first), of(second), of(second * 1.01), of(second * 0.99)],
            [DEPTHS[0], DEPTHS[1], DEPTHS[1], DEPTHS[2]]
        );
    }

    /// One with few photons and one with four times as many tell noise and work, of which an image with four times the pixels has
    /// four times as much.
    #[test]
    fn photons_are_those_of_two_pilots_scaled_to_the_image() {
        let mut scene = cornell();
        (scene.settings.width, scene.settings.height) = (256, 192);
        let automatic = Automatic {
            quality: Quality::Final,
            iterations: true,
            photons_per_iteration: true,
            ..Automatic::default()
        };
        let found = chosen(&scene, automatic, LaneKind::best(), 2);
        let stop = Stop::new();
        let pilots = Pilots::new(&scene, &scene.settings, LaneKind::best(), &stop);
        assert_eq!(scene.settings.pixels(), 4 * pilots.settings.pixels());
        let few = pilots.settings.photons_per_iteration;
        let [first, second] = [few, 4 * few]
            .map(|photons| pilots.run(SEEDS, |settings| settings.photons_per_iteration = photons).unwrap());
        let variances = [&first, &second].map(|pilot| pilot.variance(BLOCK as usize / 2));
        let account = Account::new([few, 4 * few], variances, &second.stats, 4.0);
        let account = account.of(scene.settings.pixels(), scene.spheres.len());
        let goal = Goal::of(Quality::Final);
        let photons = account.photons(most_photons(scene.settings.max_depth), goal.work);
        let iterations = account.iterations(photons, goal.noise, goal.work);
        assert_eq!((found.photons_per_iteration, found.iterations), (photons, iterations));
        // Not the least, so that they tell something.
        assert!(photons > few && iterations > 8, "{photons}, {iterations}");
    }

    /// Paths gather no photons, so no radius has been stated, and the usual one may be wider than the scene.
    #[test]
    fn the_depth_of_paths_does_not_depend_on_a_search_radius() {
        let depth = Automatic { max_depth: true, quality: Quality::Final, ..Automatic::default() };
        let of = |initial_radius| {
            let scene = cornell();
            let settings = Settings { initial_radius, ..scene.settings };
            let method = (MethodName::Path, LaneKind::best());
            choose(&Scene { settings, ..scene }, depth, method, &Stop::new()).unwrap()
        };
        // By the first and the last no pilot would see that light is lost: none gathers a photon, or all gather the same.
        let radii = [0.01, 2.0, 1000.0];
        let found = radii.map(of);
        assert!(found.iter().all(|chosen| chosen.max_depth == 16), "{found:?}");
        assert_eq!(found.map(|chosen| chosen.initial_radius), radii);
    }

    /// Of an image that has four times the pixels of its pilot, by the noise and the work of each of them.
    #[test]
    fn iterations_of_paths_are_those_of_the_pilot_scaled_to_the_image() {
        let mut scene = files::builtin::scene("terrace").unwrap();
        (scene.settings.width, scene.settings.height) = (256, 192);
        let automatic = Automatic { quality: Quality::Draft, iterations: true, ..Automatic::default() };
        let (method, stop) = ((MethodName::Path, LaneKind::best()), Stop::new());
        let found = choose(&scene, automatic, method, &stop).unwrap().iterations;
        let pilots = Pilots::new(&scene, &scene.settings, LaneKind::best(), &stop);
        assert_eq!(scene.settings.pixels(), 4 * pilots.settings.pixels());
        let pilot = pilots.run_paths(SEEDS, PATHS, scene.settings.max_depth).unwrap();
        let variance = pilot.variance(BLOCK as usize / 2);
        let account = Account::of_paths(PATHS, variance, &pilot.stats, 4.0);
        let account = account.of(scene.settings.pixels(), scene.spheres.len());
        let goal = Goal::of(Quality::Draft);
        assert_eq!(found, account.iterations(1, goal.noise, goal.work));
        // Neither the least nor what the work alone would allow.
        assert!(found > 8 && found < account.iterations(1, 0.0, goal.work), "{found}");
    }
}
