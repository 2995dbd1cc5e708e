//! Noise and work of a render as functions of its photons and iterations, and the choice of both.
//!
//! In one iteration of `L` photons the variance is `camera + photons / L`. After `n` iterations that of the camera is an n-th.
//! That of photons, as radii shrink, is `3/4 n^(-2/3)` of it (Knaus and Zwicker 2011, section 5, with alpha = 2/3); and with
//! more photons the best radius is smaller, by `L^(-1/6)`, so it goes as the number of all photons:
//!
//! ```text
//! noise^2 = camera / n + 3/4 photons L_0^(-1/3) (n L)^(-2/3)      radii are those for L_0 photons
//! ```

use super::pilot::{SEEDS, Variance};
use scene::Stats;

/// The least number of photons that is chosen.
const FEWEST_PHOTONS: u32 = 1 << 12;
/// The least number of iterations that is chosen: the estimate of noise is of few images, and radii need some to shrink.
const FEWEST_ITERATIONS: u32 = 8;
/// See above.
const SHRINKING: f64 = 0.75;

/// Work in units of a ray segment.
mod work {
    /// A pixel's share besides its rays.
    pub(super) const PIXEL: f64 = 0.5;
    /// A photon that lands: kept, sorted.
    pub(super) const DEPOSIT: f64 = 1.5;
    /// A photon that counts at a visible point.
    pub(super) const CONTRIBUTION: f64 = 0.07;
}

/// Noise and work of an iteration, as functions of its photons.
#[derive(Debug)]
pub(super) struct Account {
    /// The variance that more photons do not lower.
    camera: Variance,
    /// The variance of one photon; that of `n` photons is an n-th of it.
    photons: Variance,
    /// The photons of an iteration for which the radius is meant.
    usual: f64,
    /// The work of the camera's paths.
    camera_work: f64,
    /// The work of a photon.
    photon_work: f64,
    spheres: usize,
}

impl Account {
    /// From `variances` with so many `photons` each, the `stats` of the pilot with more of them, and how many pixels the
    /// image has for each of the pilot.
    pub(super) fn new(photons: [u32; 2], variances: [Variance; 2], stats: &Stats, scale: f64) -> Self {
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
        Self {
            // A block of the image has more pixels than one of the pilot, and each has its own paths.
            camera: Variance { pixel: pixel.0, block: block.0 / scale },
            photons: Variance { pixel: pixel.1, block: block.1 },
            usual: few * scale,
            camera_work: scale * camera_work(stats) / seeds,
            photon_work: photon_work(stats, scale) / (many * seeds),
            spheres: 0,
        }
    }

    /// Of path tracing, from the variance with so many paths in each pixel and the `stats` of the pilot; its photons are none, and
    /// cost nothing.
    pub(super) fn of_paths(paths: u32, variance: Variance, stats: &Stats, scale: f64) -> Self {
        let paths = f64::from(paths);
        // A path asks for light at most once for each of its segments.
        let rays = 2.0 * stats.camera_segments as f64;
        Self {
            camera: Variance { pixel: paths * variance.pixel, block: paths * variance.block / scale },
            photons: Variance { pixel: 0.0, block: 0.0 },
            usual: 1.0,
            camera_work: scale * rays / (paths * SEEDS as f64),
            photon_work: 0.0,
            spheres: 0,
        }
    }

    /// The same, for an image of so many pixels, among so many spheres.
    pub(super) fn of(self, pixels: usize, spheres: usize) -> Self {
        Self { camera_work: self.camera_work + work::PIXEL * pixels as f64, spheres, ..self }
    }

    /// The squared noise of so many iterations of so many photons.
    fn noise(&self, photons: f64, iterations: f64) -> Variance {
        let (root, usual) = (cube_root(iterations * photons), cube_root(self.usual));
        let settled = SHRINKING / (usual * root * root);
        let of = |camera: f64, photon: f64| camera / iterations + settled * photon;
        Variance {
            pixel: of(self.camera.pixel, self.photons.pixel),
            block: of(self.camera.block, self.photons.block),
        }
    }

    /// The work of an iteration of so many photons.
    fn work(&self, photons: f64) -> f64 {
        (self.camera_work + self.photon_work * photons) * segment_work(self.spheres)
    }

    /// The number of photons by which the noise is least after so much `work`. Powers of two and the numbers half-way between
    /// are tried, up to `most`.
    pub(super) fn photons(&self, most: u32, work: f64) -> u32 {
        let best = numbers(most)
            .min_by(|&a, &b| self.noise_after(work, a.into()).total_cmp(&self.noise_after(work, b.into())));
        best.unwrap_or(most)
    }

    /// The noise with the number of photons by which it is least.
    pub(super) fn least_noise(&self, most: u32, work: f64) -> f64 {
        self.noise_after(work, self.photons(most, work).into())
    }

    /// The noise after so much `work` with so many photons in an iteration. Noise of pixels and of blocks counts both, that of
    /// blocks twice: noise of neighbours that is alike is easier to see.
    fn noise_after(&self, work: f64, photons: f64) -> f64 {
        let iterations = (work / self.work(photons)).max(FEWEST_ITERATIONS.into());
        let noise = self.noise(photons, iterations);
        // The fewest iterations may be more work than there is, which counts as so much more noise.
        let spent = iterations * self.work(photons);
        noise.pixel * noise.block * noise.block * spent * spent * spent
    }

    /// The iterations after which the root of the squared noise of pixels is `noise`, or so much `work` is done.
    pub(super) fn iterations(&self, photons: u32, noise: f64, work: f64) -> u32 {
        let photons = f64::from(photons);
        // The conversion saturates, and makes 0 of what is not a number.
        let most = (work / self.work(photons) + 0.5) as u32;
        let is_enough = |iterations: u32| self.noise(photons, iterations.into()).pixel <= noise * noise;
        let (mut low, mut high) = (FEWEST_ITERATIONS, most.max(FEWEST_ITERATIONS));
        while low < high {
            let middle = low.midpoint(high);
            if is_enough(middle) {
                high = middle;
            } else {
                low = middle + 1;
            }
        }
        low
    }
}

/// The work of the camera's paths.
pub(super) fn camera_work(stats: &Stats) -> f64 {
    (stats.camera_segments + stats.shadow_rays) as f64
}

/// The work of photons, for an image that has so many pixels for each of the pilot.
pub(super) fn photon_work(stats: &Stats, scale: f64) -> f64 {
    let landed = work::DEPOSIT * stats.deposits as f64 + stats.photon_segments as f64;
    landed + work::CONTRIBUTION * scale * stats.contributions as f64
}

/// The numbers of photons that are tried, up to `most`.
fn numbers(most: u32) -> impl Iterator<Item = u32> {
    let powers = (FEWEST_PHOTONS.ilog2()..31).map(|power| 1_u32 << power);
    powers.flat_map(|power| [power, power / 2 * 3]).take_while(move |&photons| photons <= most)
}

/// The cube root of a number from 1 on, by Newton's method: with operations that every processor rounds alike.
fn cube_root(x: f64) -> f64 {
    // From above, each step comes nearer by a third at least.
    (0..100).fold(x, |root, _| (2.0 * root + x / (root * root)) / 3.0)
}

/// The work of a ray segment among so many spheres, in units of one among few: measured, it grows by about as much for
/// every time that there are twice as many.
fn segment_work(spheres: usize) -> f64 {
    const FEW: usize = 64;
    let doublings = (spheres / FEW).max(1).ilog2();
    1.0 + 1.5 * f64::from(doublings)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Variances that follow the law are split into its parts.
    fn account(camera: f64, photons: f64, camera_work: f64, photon_work: f64) -> Account {
        let variance = |of: f64| {
            let all = camera + photons / of;
            Variance { pixel: all, block: all }
        };
        let account =
            Account::new([1000, 4000], [variance(1000.0), variance(4000.0)], &Stats::default(), 1.0);
        Account { camera_work, photon_work, ..account }
    }

    #[test]
    fn variances_are_split_into_those_of_camera_and_photons() {
        const ROUNDING: f64 = 1e-9;
        let account = account(0.3, 500.0, 1.0, 1.0);
        for (found, exact) in [(account.camera.pixel, 0.3), (account.photons.block, 500.0)] {
            assert!((found / exact - 1.0).abs() < ROUNDING, "{found} for {exact}");
        }
    }

    /// Of a pilot as large as the image, an iteration with its photons takes the work that was counted, once for each seed; of a
    /// smaller one, the camera's part and what counts at visible points grow with the pixels.
    #[test]
    fn work_is_what_the_pilots_have_counted() {
        let stats = Stats {
            camera_segments: 7000,
            shadow_rays: 5000,
            photon_segments: 90_000,
            deposits: 40_000,
            contributions: 300_000,
            ..Stats::default()
        };
        let none = Variance { pixel: 0.0, block: 0.0 };
        let seeds = SEEDS as f64;
        for scale in [1.0, 16.0] {
            let account = Account::new([1000, 4000], [none; 2], &stats, scale).of(600, 9);
            let camera = scale * 12_000.0 / seeds + work::PIXEL * 600.0;
            let counted = work::CONTRIBUTION * scale * 300_000.0;
            let photons = (90_000.0 + work::DEPOSIT * 40_000.0 + counted) / seeds;
            let found = [account.work(0.0), account.work(4000.0), account.work(8000.0)];
            for (found, exact) in found.into_iter().zip([camera, camera + photons, camera + 2.0 * photons]) {
                assert!((found / exact - 1.0).abs() < 1e-12, "{found} for {exact}, {scale}");
            }
        }
    }

    /// An image with 16 pixels for each of the pilot: a block of it has 16 times the paths, and its photons are as usual if there
    /// are 16 times those of the pilot.
    #[test]
    fn noise_of_a_larger_image_is_that_of_its_own_blocks_and_photons() {
        let at = |photons: f64| Variance { pixel: 0.3 + 500.0 / photons, block: 0.2 + 400.0 / photons };
        let account = Account::new([1000, 4000], [at(1000.0), at(4000.0)], &Stats::default(), 16.0);
        // After one iteration of the usual photons.
        let found = account.noise(16_000.0, 1.0);
        let (pixel, block) = (0.3 + SHRINKING * 500.0 / 16_000.0, 0.2 / 16.0 + SHRINKING * 400.0 / 16_000.0);
        assert!((found.pixel / pixel - 1.0).abs() < 1e-9, "{found:?} for {pixel}");
        assert!((found.block / block - 1.0).abs() < 1e-9, "{found:?} for {block}");
    }

    /// Four images of two paths in each of 100 pixels, which an image of 1600 is made of by its variance and its work.
    #[test]
    fn paths_have_the_variance_of_one_and_its_work() {
        let stats = Stats { camera_segments: 4 * 2 * 100 * 3, ..Stats::default() };
        let variance = Variance { pixel: 0.5, block: 0.04 };
        let account = Account::of_paths(2, variance, &stats, 16.0).of(1600, 9);
        let found = account.noise(1.0, 10.0);
        assert!((found.pixel / (2.0 * 0.5 / 10.0) - 1.0).abs() < 1e-12, "{found:?}");
        assert!((found.block / (2.0 * 0.04 / 16.0 / 10.0) - 1.0).abs() < 1e-12, "{found:?}");
        // Three segments, and a shadow ray for each.
        let exact = 1600.0 * (6.0 + work::PIXEL);
        assert!((account.work(1.0) / exact - 1.0).abs() < 1e-12, "{} for {exact}", account.work(1.0));
        assert_eq!(account.iterations(1, 0.1, 1e9), 100);
        assert_eq!(account.iterations(1, 0.1, 50.0 * exact), 50);
    }

    #[test]
    fn cube_roots_are_exact_to_rounding() {
        for x in [1.0, 2.0, 8.0, 1e3, 123_456.7, 1e9] {
            assert!((cube_root(x) / f64::cbrt(x) - 1.0).abs() < 1e-14, "{x}");
        }
    }

    /// Where photons alone make noise, it falls with the number of all photons, so each iteration has as many as there can
    /// be; where they make none, there are few.
    #[test]
    fn photons_are_as_many_as_noise_asks_for() {
        const WORK: f64 = 1e9;
        assert!(account(0.0, 5e3, 1e4, 10.0).photons(1 << 28, WORK) >= 1 << 16);
        assert_eq!(account(0.3, 0.0, 1e6, 10.0).photons(1 << 28, WORK), FEWEST_PHOTONS);
        assert_eq!(account(0.3, 5e9, 1e6, 10.0).photons(100_000, WORK), 98_304);
        assert_eq!(account(0.3, 5e9, 1e6, 10.0).photons(1000, WORK), 1000);
    }

    #[test]
    fn numbers_of_photons_are_powers_of_two_and_half_way_between() {
        let of = |most| numbers(most).collect::<Vec<_>>();
        assert_eq!(of(24_575), [4096, 6144, 8192, 12_288, 16_384]);
        assert_eq!((of(6144), of(4095)), (vec![4096, 6144], vec![]));
        assert_eq!(of(u32::MAX).last(), Some(&(3 << 29)));
    }

    /// No other number has less noise for the same work, by a finer search.
    #[test]
    fn the_number_of_photons_is_next_to_the_best() {
        const WORK: f64 = 5e8;
        for (c, p, w, v) in [(0.3_f64, 5e3, 1e6, 10.0), (0.01, 5e2, 1e6, 3.0), (1.0, 1e4, 1e6, 20.0)] {
            let account = account(c, p, w, v);
            let noise = |photons: f64| account.noise(photons, WORK / account.work(photons)).pixel;
            let found = noise(account.photons(1 << 28, WORK).into());
            let best = (0..2000).map(|k| noise(4096.0 * 1.005_f64.powi(k))).fold(f64::INFINITY, f64::min);
            // Candidates are at most 1.5 times apart, where the optimum is flat.
            assert!(found < 1.03 * best, "{found}, not {best}");
        }
    }

    #[test]
    fn iterations_end_with_the_noise_or_the_work() {
        // The camera's variance alone is 1 in an iteration, and 0.01 is to be reached.
        assert_eq!(account(1.0, 0.0, 1e6, 1.0).iterations(10_000, 0.1, 1e9), 100);
        // That of photons falls as the power of 2/3: 3/4 to 0.01 takes 75^(3/2), with as many photons as are usual.
        assert_eq!(account(0.0, 1000.0, 1e6, 1.0).iterations(1000, 0.1, 1e9), 650);
        assert_eq!(account(1.0, 5000.0, 1e8, 1.0).iterations(10_000, 0.1, 1e9), 10);
        assert_eq!(account(0.0, 0.0, 1.0, 1.0).iterations(10_000, 0.1, 1e9), FEWEST_ITERATIONS);
    }

    /// One work unit among few spheres, 1.5 more for each doubling.
    #[test]
    fn segments_take_longer_among_many_spheres() {
        let found = [0, 1, 64, 127, 128, 255, 256, 65_536].map(segment_work);
        assert_eq!(found, [1.0, 1.0, 1.0, 1.0, 2.5, 2.5, 4.0, 16.0]);
        let account = account(0.3, 500.0, 7.0, 2.0).of(0, 128);
        assert_eq!((account.work(0.0), account.work(10.0)), (17.5, 67.5));
    }

    /// Noise may turn what pilots say around: no part of a variance is negative.
    #[test]
    fn variances_are_never_negative() {
        let of = |few: f64, many: f64| {
            let variance = |of| Variance { pixel: of, block: of };
            let account = Account::new([1000, 4000], [variance(few), variance(many)], &Stats::default(), 1.0);
            (account.camera.pixel, account.photons.pixel)
        };
        // More photons, more noise: that of photons is none.
        assert_eq!(of(0.1, 0.2), (0.2, 0.0));
        // All of it goes with the photons, and more than all.
        let (camera, photons) = of(10.0, 1.0);
        assert!(camera == 0.0 && (photons - 9.0 / (1e-3 - 2.5e-4)).abs() < 1e-6, "{camera} and {photons}");
    }

    /// Work is rounded to whole iterations, and never to fewer than the least.
    #[test]
    fn iterations_are_as_many_as_the_work_allows() {
        let noisy = account(1e9, 0.0, 10.0, 0.0);
        let of = |work| noisy.iterations(1000, 1e-9, work);
        assert_eq!([of(0.0), of(84.0), of(94.9), of(95.1), of(1234.0)], [8, 8, 9, 10, 123]);
    }

    /// The first number of iterations by which the noise is low enough, one after another, and at most what the work allows.
    #[test]
    fn iterations_are_the_fewest() {
        for (camera, photons, noise, work) in [
            (1.0, 0.0, 0.1_f64, 1e9),
            (0.3, 5000.0, 0.05, 1e9),
            (0.0, 70_000.0, 0.03, 1e9),
            (0.3, 5000.0, 0.05, 3e8),
            (2.0, 1e5, 1e-3, 5e7),
        ] {
            let account = account(camera, photons, 1e6, 3.0);
            let most = ((work / account.work(20_000.0)).round() as u32).max(8);
            let is_enough = |n: u32| account.noise(20_000.0, n.into()).pixel <= noise.powi(2);
            let expected = (8..most).find(|n| is_enough(*n)).unwrap_or(most);
            assert_eq!(account.iterations(20_000, noise, work), expected, "{camera}, {photons}, {noise}");
        }
    }

    /// With little work too, where more photons than there is work for cost as much more noise.
    #[test]
    fn photons_are_those_of_the_least_cost() {
        for (c, p, w, v, work) in [
            (0.3_f64, 5e3, 1e6, 10.0, 5e8),
            (0.01, 5e4, 1e5, 3.0, 1e6),
            (0.5, 5e5, 1e4, 20.0, 3e6),
            (0.2, 1e3, 1e3, 1.0, 1e5),
        ] {
            // Pixels and blocks have noise of their own.
            let mut account = account(c, p, w, v);
            (account.camera.block, account.photons.block) = (c / 50.0, p / 3.0);
            let cost = |photons: u32| {
                let each = account.work(photons.into());
                let iterations = (work / each).max(8.0);
                let Variance { pixel, block } = account.noise(photons.into(), iterations);
                pixel * block.powi(2) * (iterations * each / work).max(1.0).powi(3)
            };
            let all = (12..28).flat_map(|power| [1_u32 << power, 3 << (power - 1)]);
            let expected = all.clone().min_by(|a, b| cost(*a).total_cmp(&cost(*b))).unwrap();
            assert_eq!(account.photons(1 << 28, work), expected, "{c}, {p}");
            let fewer = all.filter(|n| *n <= 50_000).min_by(|a, b| cost(*a).total_cmp(&cost(*b))).unwrap();
            assert_eq!(account.photons(50_000, work), fewer, "{c}, {p}");
        }
    }
}
