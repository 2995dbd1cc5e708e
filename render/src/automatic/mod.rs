//! Chooses settings that a scene leaves open, from the scene and the work counted in a small render, the pilot.
//!
//! Nothing depends on a clock, on the processor or on threads, so the image stays a function of scene, settings and seed.
//! docs/quality.md has the reasons, and what was measured.
//!
//! ```text
//! radius      RADIUS footprints of a pixel
//! depth       the least of DEPTHS that hardly darkens the pilot
//! photons     the number by which a unit of work lowers the error most, for a pilot with few and one with many
//! iterations  until the noise is that of the quality, but for so much work at most
//! ```

mod bias;
mod footprint;
mod pilot;
mod pilots;

pub(crate) use bias::relative_bias;
use fast::{LaneKind, Parameters, Sppm};
use footprint::footprint;
use pilot::{DEPOSITS_AT_ONCE, SEEDS, Variance, loss};
use pilots::{PILOT_PHOTONS, Pilots, pilot_settings};
use scene::settings::{MAX_DEPOSITS, MAX_PHOTONS, RADIUS_RANGE};
use scene::{Automatic, Quality, RadiusSchedule, Scene, Settings, Stats, Stop};

/// The first radius in footprints of a pixel, if the render does not end by its quality. Of eleven scenes, the radii by
/// which the error of pixels and of blocks was least lay from 1.2 to 6.9 and from 0.6 to 5.3; see docs/quality.md.
const RADIUS: f32 = 4.0;
/// The first of global radii over the first of radii per pixel: the root of alpha. With light that is even around a pixel, the
/// squared radii per pixel are those of the iteration before times alpha, `r_i^2 (i - 1 + alpha) / i`, and global ones
/// `r_i^2 (i + alpha) / (i + 1)`; so from this first radius both become the same (docs/farm.md).
const GLOBAL: f32 = 0.816_496_6;
/// The depths from which one is chosen. The last is as good as all light.
const DEPTHS: [u32; 4] = [8, 16, 32, 64];
/// Pixels along the side of a block, as images are compared by blocks of 8 x 8.
const BLOCK: f64 = 8.0;
/// The least number of photons that is chosen.
const FEWEST_PHOTONS: u32 = 1 << 12;

/// Work in units of a ray segment.
mod work {
    /// A pixel's share besides its rays.
    pub(super) const PIXEL: f64 = 0.5;
    /// A photon that lands: kept, sorted.
    pub(super) const DEPOSIT: f64 = 1.5;
    /// A photon that counts at a visible point.
    pub(super) const CONTRIBUTION: f64 = 0.2;
}

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
            Quality::Draft => Self { noise: 0.08, work: 4e7, loss: 0.02, radius: 6.5 },
            Quality::Good | Quality::Paper => Self { noise: 0.02, work: 5e8, loss: 0.005, radius: 4.8 },
            Quality::Final => Self { noise: 0.007, work: 1e10, loss: 0.002, radius: 3.6 },
        }
    }
}

/// The settings of `scene` with those that are `automatic` chosen; `None` if stopped.
///
/// Takes at most [`bytes_at_most`].
pub(crate) fn choose(scene: &Scene, automatic: Automatic, lanes: LaneKind, stop: &Stop) -> Option<Settings> {
    let goal = Goal::of(automatic.quality);
    let mut settings = scene.settings;
    if automatic.initial_radius
        && let Some(side) = footprint(lanes, scene, &settings)
    {
        let [least, most] = RADIUS_RANGE;
        let footprints = if automatic.iterations { goal.radius } else { RADIUS };
        let share = match settings.radius_schedule {
            RadiusSchedule::PerPixel => 1.0,
            RadiusSchedule::Global => GLOBAL,
        };
        settings.initial_radius = rounded(share * footprints * side).clamp(least, most);
    }
    let pilot = Pilots::new(scene, &settings, lanes, stop);
    if automatic.max_depth {
        settings.max_depth = pilot.depth(&goal)?;
    }
    if automatic.photons_per_iteration || automatic.iterations {
        let account = pilot.account(&settings)?;
        if automatic.photons_per_iteration {
            let most = ((MAX_DEPOSITS - 1) / u64::from(settings.max_depth)).min(MAX_PHOTONS.into()) as u32;
            settings.photons_per_iteration = account.photons(most);
        }
        if automatic.iterations {
            settings.iterations = account.iterations(settings.photons_per_iteration, &goal);
        }
    }
    Some(settings)
}

/// The most bytes that choosing settings takes, or estimating the bias, on so many threads.
pub(crate) fn bytes_at_most(scene: &Scene, threads: usize) -> u64 {
    let settings = pilot_settings(&scene.settings);
    let (spheres, parameters) = (scene.spheres.len(), Parameters::default());
    // Those of the bias are twice as many as those of the second pilot.
    let photons_per_iteration = 2 * settings.photons_per_iteration * PILOT_PHOTONS.2;
    let deepest = Settings { photons_per_iteration, max_depth: DEPTHS[3], ..settings };
    let films = 16 * bias::FILMS * settings.pixels() as u64;
    // The variances of all channels are sorted.
    let terms = 3 * 8 * settings.pixels() as u64;
    Sppm::bytes_at_most(&deepest, spheres, threads, DEPOSITS_AT_ONCE, &parameters) + films + terms
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

    /// Noise and work of a render with `settings`.
    fn account(&self, settings: &Settings) -> Option<Account> {
        let few = self.settings.photons_per_iteration;
        let many = few * PILOT_PHOTONS.2;
        let of = |photons| {
            self.run(SEEDS, |pilot| {
                pilot.photons_per_iteration = photons;
                (pilot.max_depth, pilot.initial_radius) = (settings.max_depth, settings.initial_radius);
            })
        };
        let (first, second) = (of(few)?, of(many)?);
        let side = self.block(settings);
        let scale = settings.pixels() as f64 / self.settings.pixels() as f64;
        let variances = [first.variance(side), second.variance(side)];
        let mut account = Account::new([few, many], variances, &second.stats, scale);
        account.camera_work += work::PIXEL * settings.pixels() as f64;
        account.spheres = self.scene.spheres.len();
        Some(account)
    }
}

/// Noise and work of an iteration, as functions of its photons.
#[derive(Debug)]
struct Account {
    /// The variance that more photons do not lower.
    camera: Variance,
    /// The variance of one photon; that of `n` photons is an n-th of it.
    photons: Variance,
    /// The work of the camera's paths.
    camera_work: f64,
    /// The work of a photon.
    photon_work: f64,
    spheres: usize,
}

impl Account {
    /// From `variances` with so many `photons` each, the `stats` of the pilot with more of them, and how many pixels the
    /// image has for each of the pilot.
    fn new(photons: [u32; 2], variances: [Variance; 2], stats: &Stats, scale: f64) -> Self {
        let [few, many] = photons.map(f64::from);
        let split = |a: f64, b: f64| {
            // V(few) = c + p / few, V(many) = c + p / many. Noise of the variances may make either negative.
            let p = ((a - b) / (1.0 / few - 1.0 / many)).max(0.0);
            let c = (b - p / many).max(0.0);
            (c, p)
        };
        let [a, b] = variances;
        let (pixel, block) = (split(a.pixel, b.pixel), split(a.block, b.block));
        let seeds = SEEDS as f64;
        let paths = (stats.camera_segments + stats.shadow_rays) as f64;
        let landed = work::DEPOSIT * stats.deposits as f64 + stats.photon_segments as f64;
        let counted = work::CONTRIBUTION * scale * stats.contributions as f64;
        Self {
            // A block of the image has more pixels than one of the pilot, and each has its own paths.
            camera: Variance { pixel: pixel.0, block: block.0 / scale },
            photons: Variance { pixel: pixel.1, block: block.1 },
            camera_work: scale * paths / seeds,
            photon_work: (landed + counted) / (many * seeds),
            spheres: 0,
        }
    }

    /// The variance of one iteration with so many photons.
    fn variance(&self, photons: f64) -> Variance {
        Variance {
            pixel: self.camera.pixel + self.photons.pixel / photons,
            block: self.camera.block + self.photons.block / photons,
        }
    }

    fn work(&self, photons: f64) -> f64 {
        self.camera_work + self.photon_work * photons
    }

    /// The number of photons by which the work for a given error is least. Errors of pixels and of blocks count both, those
    /// of blocks twice: noise of neighbours that is alike is easier to see. Powers of two and the numbers half-way between are tried, up to `most`.
    fn photons(&self, most: u32) -> u32 {
        let cost = |photons: f64| {
            let (variance, work) = (self.variance(photons), self.work(photons));
            (variance.pixel * work) * (variance.block * work) * (variance.block * work)
        };
        let powers = (FEWEST_PHOTONS.ilog2()..31).map(|power| 1_u32 << power);
        let candidates =
            powers.flat_map(|power| [power, power / 2 * 3]).take_while(|&photons| photons <= most);
        let best = candidates.min_by(|&a, &b| cost(a.into()).total_cmp(&cost(b.into())));
        best.unwrap_or(most)
    }

    /// The iterations by which the noise of `goal` is reached, or its work is spent.
    fn iterations(&self, photons: u32, goal: &Goal) -> u32 {
        let photons = f64::from(photons);
        let needed = self.variance(photons).pixel / (goal.noise * goal.noise);
        let affordable = goal.work / (self.work(photons) * segment_work(self.spheres));
        let iterations = needed.min(affordable) + 0.5;
        // The conversion saturates, and makes 0 of what is not a number.
        (iterations as u32).max(FEWEST_ITERATIONS)
    }
}

/// The least number of iterations that is chosen: the estimate of noise is of few images, and radii need some to shrink.
const FEWEST_ITERATIONS: u32 = 8;

/// The work of a ray segment among so many spheres, in units of one among few: measured, it grows by about as much for
/// every time that there are twice as many.
fn segment_work(spheres: usize) -> f64 {
    const FEW: usize = 64;
    let doublings = (spheres / FEW).max(1).ilog2();
    1.0 + 1.5 * f64::from(doublings)
}

/// `value` with two significant digits.
fn rounded(value: f32) -> f32 {
    format!("{value:.1e}").parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rayon::ThreadPoolBuilder;

    fn cornell() -> Scene {
        let scene = files::builtin::scene("cornell").unwrap();
        Scene { settings: Settings { width: 64, height: 48, ..scene.settings }, ..scene }
    }

    fn chosen(scene: &Scene, automatic: Automatic, lanes: LaneKind, threads: usize) -> Settings {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| choose(scene, automatic, lanes, &Stop::new())).unwrap()
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

    #[test]
    fn only_what_is_automatic_is_chosen() {
        let scene = cornell();
        let none = Automatic::default();
        for one in [
            Automatic { iterations: true, ..none },
            Automatic { photons_per_iteration: true, ..none },
            Automatic { max_depth: true, ..none },
            Automatic { initial_radius: true, ..none },
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
        assert!(draft.initial_radius > good.initial_radius && good.initial_radius > last.initial_radius);
        assert!(draft.max_depth <= good.max_depth && good.max_depth <= last.max_depth);
    }

    #[test]
    fn a_stopped_choice_gives_nothing() {
        let stop = Stop::new();
        stop.request();
        assert_eq!(choose(&cornell(), Automatic::all(Quality::Good), LaneKind::best(), &stop), None);
    }

    /// Variances that follow the law are split into its parts.
    fn account(camera: f64, photons: f64, camera_work: f64, photon_work: f64) -> Account {
        let variance = |of: f64| {
            let all = camera + photons / of;
            Variance { pixel: all, block: all }
        };
        let account =
            Account::new([1000, 4000], [variance(1000.0), variance(4000.0)], &Stats::default(), 1.0);
        Account { camera_work, photon_work, spheres: 1, ..account }
    }

    #[test]
    fn variances_are_split_into_those_of_camera_and_photons() {
        const ROUNDING: f64 = 1e-9;
        let account = account(0.3, 500.0, 1.0, 1.0);
        for (found, exact) in [(account.camera.pixel, 0.3), (account.photons.block, 500.0)] {
            assert!((found / exact - 1.0).abs() < ROUNDING, "{found} for {exact}");
        }
    }

    /// The work for an error, (c + p / n) (w + v n), is least at n = sqrt(p w / (c v)).
    #[test]
    fn the_number_of_photons_is_next_to_the_best() {
        for (c, p, w, v) in [(0.3_f64, 5e3, 1e6, 10.0), (0.01, 5e4, 1e6, 3.0), (1.0, 1e4, 1e7, 20.0)] {
            let best: f64 = p * w / (c * v);
            let best = best.sqrt();
            let found = f64::from(account(c, p, w, v).photons(1 << 28));
            // Candidates are at most 1.5 times apart.
            assert!(found / best < 1.5 && best / found < 1.5, "{found} for {best}");
        }
        assert_eq!(account(0.3, 5e9, 1e6, 10.0).photons(100_000), 98_304);
        assert_eq!(account(0.3, 5e9, 1e6, 10.0).photons(1000), 1000);
        // Where photons do nothing, there are few.
        assert_eq!(account(0.3, 0.0, 1e6, 10.0).photons(1 << 28), FEWEST_PHOTONS);
    }

    #[test]
    fn iterations_end_with_the_noise_or_the_work() {
        let goal = Goal { noise: 0.1, work: 1e9, loss: 0.0, radius: 1.0 };
        // A variance of 1.5 in an iteration, and 0.01 to reach.
        assert_eq!(account(1.0, 5000.0, 1e6, 1.0).iterations(10_000, &goal), 150);
        assert_eq!(account(1.0, 5000.0, 1e8, 1.0).iterations(10_000, &goal), 10);
        assert_eq!(account(0.0, 0.0, 1.0, 1.0).iterations(10_000, &goal), FEWEST_ITERATIONS);
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
}
