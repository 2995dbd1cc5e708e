//! The state of a render between two iterations, in a form that every engine can save and load.
//!
//! From one iteration to the next an engine keeps a few words per pixel: see [`Sums`]. They do not depend on engine,
//! lanes or threads. So one engine can resume a render that another began, and the image is the same as that of a
//! render without a pause.

use crate::color::Rgb;
use crate::engine::{Engine, Stats};
use crate::exact::{Exact, Scale};
use crate::settings::MAX_DEPOSITS;
use serde::{Deserialize, Serialize};
use std::fmt;

/// The version of the light transport, raised whenever a scene with its settings and seed gets another image. Iterations
/// of two versions are never added up.
///
/// 2: shadow rays choose their light by what it may send to the point. 3: photons are aimed. 4: the path
/// tracer's numbers are stratified up to the first bounce. 5: photons are scattered towards what they are aimed at. 6: of more
/// than a thousand lights those far from others are aimed by themselves. 7: the path tracer's paths meet glowing enclosures,
/// such as the sky, by themselves. 8: photons are guided where none are aimed. 9: opaque spheres
/// close to the eye are computed from an anchor. 10: rays that see lamps in place of a pixel's path choose at glass by roots.
/// 11: walls limit first radii to a third of the initial radius, no longer to an eighth. 12: aimed photons are scattered towards
/// the middle of the places where light arrives, which is a target too. 13: balls around the middle are targets, far lamps have
/// wider cores, and fluxes have finer units. 14: those cores have rims, and lamps that they would reach are near.
pub const TRANSPORT: u32 = 14;

/// The meaning of a pixel's words.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Sums {
    /// Photon mapping with radii per pixel: the eight words of [`PhotonSums`].
    Photons,
    /// Photon mapping with global radii: the words of [`ExactSums`]. Those of iterations that were rendered apart can be
    /// added up.
    Exact,
    /// Path tracing: the radiance of red, green and blue, each summed over all iterations, as the bits of three `f64`,
    /// lower word first.
    Paths,
    /// Path tracing with photons for caustics: the words of [`Sums::Paths`], then those of [`PhotonSums`].
    Hybrid,
}

/// Words per pixel of [`Sums::Paths`].
pub(crate) const PATH_WORDS: usize = 6;

impl Sums {
    /// Finds words that no engine could have written after so many `iterations`: an invalid count, a radius that is invalid
    /// or has grown, a sum that is too large. Returns the end of an error message.
    pub fn fault(self, words: &[u32], initial_radius: f32, iterations: u32) -> Option<&'static str> {
        let photons = |words: &[u32]| {
            words.try_into().ok().and_then(|words| PhotonSums::from_words(words).fault(initial_radius))
        };
        match self {
            Self::Photons => photons(words),
            Self::Hybrid => words.get(PATH_WORDS..).and_then(photons),
            Self::Exact => {
                words.try_into().ok().and_then(|words| ExactSums::from_words(words).fault(iterations))
            }
            Self::Paths => None,
        }
    }

    /// Words per pixel.
    pub fn words(self) -> usize {
        match self {
            Self::Photons => PhotonSums::WORDS,
            Self::Exact => ExactSums::WORDS,
            Self::Paths => PATH_WORDS,
            Self::Hybrid => PATH_WORDS + PhotonSums::WORDS,
        }
    }
}

/// The state of a pixel in photon mapping, from one iteration to the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhotonSums {
    /// Direct light, including that of visible lamps, summed over all iterations: radiance times iterations.
    pub direct: Rgb,
    /// `tau`, the flux gathered so far, scaled down as the radius shrinks.
    pub tau: Rgb,
    /// `N`, the photons counted so far, weighted by alpha.
    pub n: f32,
    /// The squared search radius, in square scene units.
    pub radius_squared: f32,
}

impl PhotonSums {
    /// Words per pixel.
    pub const WORDS: usize = 8;

    /// The bits of every number, in the order of the fields.
    pub fn to_words(self) -> [u32; Self::WORDS] {
        let ([dr, dg, db], [tr, tg, tb]) = (self.direct.to_array(), self.tau.to_array());
        [dr, dg, db, tr, tg, tb, self.n, self.radius_squared].map(f32::to_bits)
    }

    /// The inverse of [`Self::to_words`].
    pub fn from_words(words: [u32; Self::WORDS]) -> Self {
        let [dr, dg, db, tr, tg, tb, n, radius_squared] = words.map(f32::from_bits);
        Self { direct: Rgb::new(dr, dg, db), tau: Rgb::new(tr, tg, tb), n, radius_squared }
    }

    fn fault(&self, initial_radius: f32) -> Option<&'static str> {
        if !(self.n >= 0.0 && self.n.is_finite()) {
            return Some("has a pixel whose count of photons is none");
        }
        let is_radius = self.radius_squared > 0.0 && self.radius_squared <= initial_radius * initial_radius;
        (!is_radius).then_some("has a pixel whose radius is none, or larger than the first")
    }
}

/// The state of a pixel in photon mapping with global radii: sums of integers, so those of any iterations can be added in any
/// order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ExactSums {
    /// The estimate of radiance in red, green and blue, summed over the iterations, in units of [`Scale`].
    pub radiance: [Exact; 3],
    /// The photons counted.
    pub photons: u64,
}

impl ExactSums {
    /// Words per pixel.
    pub const WORDS: usize = 20;

    /// Adds what a pixel gains in one iteration, where `m` photons counted.
    #[inline]
    pub fn gain(&mut self, scale: Scale, radiance: Rgb, m: u32) {
        for (sum, gain) in self.radiance.iter_mut().zip(radiance.to_array()) {
            *sum += scale.quantise(gain);
        }
        self.photons += u64::from(m);
    }

    /// Adds the sums of other iterations, of which no more than [`crate::settings::MAX_ITERATIONS`] are added in all.
    #[inline]
    pub fn add(&mut self, other: &Self) {
        for (sum, more) in self.radiance.iter_mut().zip(other.radiance) {
            *sum += more;
        }
        self.photons = self.photons.wrapping_add(other.photons);
    }

    /// Radiance, if the sums are of so many iterations.
    pub fn develop(&self, scale: Scale, iterations: u32) -> Rgb {
        Rgb::from_array(self.radiance.map(|sum| scale.mean(sum, iterations)))
    }

    /// All numbers as words, the lower word of each first, in the order of the fields.
    #[inline]
    pub fn to_words(self) -> [u32; Self::WORDS] {
        let [red, green, blue] = self.radiance.map(|sum| sum.0);
        let mut words = [0; Self::WORDS];
        let numbers = red.into_iter().chain(green).chain(blue).chain([self.photons]);
        for (words, number) in words.as_chunks_mut::<2>().0.iter_mut().zip(numbers) {
            *words = [number as u32, (number >> 32) as u32];
        }
        words
    }

    /// The inverse of [`Self::to_words`].
    #[inline]
    pub fn from_words(words: [u32; Self::WORDS]) -> Self {
        // A loop over pairs, as merging reads billions of them: closures are not always inlined.
        let mut numbers = [0; Self::WORDS / 2];
        for (number, [low, high]) in numbers.iter_mut().zip(words.as_chunks().0) {
            *number = u64::from(*low) | u64::from(*high) << 32;
        }
        let [a, b, c, d, e, f, g, h, i, photons] = numbers;
        Self { radiance: [Exact([a, b, c]), Exact([d, e, f]), Exact([g, h, i])], photons }
    }

    fn fault(&self, iterations: u32) -> Option<&'static str> {
        if !self.radiance.iter().all(|sum| sum.is_sum_of(iterations)) {
            return Some("has a pixel whose sum is too large for its iterations");
        }
        let most = u64::from(iterations) * MAX_DEPOSITS;
        (self.photons > most).then_some("has a pixel whose count of photons is too large for its iterations")
    }
}

impl fmt::Display for Sums {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Photons => "photon mapping",
            Self::Exact => "photon mapping with global radii",
            Self::Paths => "path tracing",
            Self::Hybrid => "path tracing with photons for caustics",
        })
    }
}

/// An engine whose render can be saved and resumed.
pub trait Resumable: Engine + Send + Sync {
    /// The kind of words that it keeps per pixel.
    fn sums(&self) -> Sums;

    /// Copies the words of row `y`, pixel by pixel from the left, into `words`.
    ///
    /// # Panics
    /// If there is no such row, or `words` is not as long as a row.
    fn save_row(&self, y: u32, words: &mut [u32]);

    /// Loads words that [`Self::save_row`] copied.
    ///
    /// # Panics
    /// As [`Self::save_row`].
    fn load_row(&mut self, y: u32, words: &[u32]);

    /// Sets the number of iterations done and their statistics, after the sums have been loaded by [`Self::load_row`].
    fn go_on_after(&mut self, iterations: u32, stats: Stats);

    /// Sets the number of the next iteration, counted from 0: those before it are left to be rendered elsewhere.
    ///
    /// # Panics
    /// If the sums are not [`Sums::Exact`], as then an iteration depends on those before it.
    fn skip_to(&mut self, next: u32) {
        panic!("iteration {next} depends on those before it");
    }
}

/// Copies the state of a render from one engine to another of the same kind and size.
///
/// # Panics
/// If they are not of the same kind and size.
pub fn transfer(from: &dyn Resumable, to: &mut dyn Resumable) {
    let (width, height) = size(from);
    assert!(from.sums() == to.sums() && size(to) == (width, height), "engines of different renders");
    let mut words = vec![0; width as usize * from.sums().words()];
    for y in 0..height {
        from.save_row(y, &mut words);
        to.load_row(y, &words);
    }
    to.go_on_after(from.iterations(), *from.stats());
    if from.sums() == Sums::Exact {
        to.skip_to(from.progress().next);
    }
}

fn size(engine: &dyn Resumable) -> (u32, u32) {
    let settings = engine.settings();
    (settings.width, settings.height)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::{Probe, Progress};
    use crate::settings::Settings;
    use crate::stop::Stop;

    #[test]
    fn words_are_the_numbers_of_a_pixel_in_their_order() {
        let sums = PhotonSums {
            direct: Rgb::new(1.0, 2.0, 3.0),
            tau: Rgb::new(4.0, 5.0, 6.0),
            n: 7.0,
            radius_squared: 8.0,
        };
        let words = sums.to_words();
        assert_eq!(words, [1, 2, 3, 4, 5, 6, 7, 8].map(|n: u8| f32::from(n).to_bits()));
        assert_eq!(PhotonSums::from_words(words), sums);
        let part = |k: u64| Exact([k, k + 1 + (9 << 32), k + 2]);
        let sums = ExactSums { radiance: [part(10), part(20), part(30)], photons: 5 << 32 | 6 };
        let words = sums.to_words();
        assert_eq!((words[..4].to_vec(), words[18..].to_vec()), (vec![10, 0, 11, 9], vec![6, 5]));
        assert_eq!(ExactSums::from_words(words), sums);
        let all = [Sums::Photons, Sums::Exact, Sums::Paths, Sums::Hybrid];
        assert_eq!(all.map(Sums::words), [8, 20, 6, 14]);
    }

    /// What is gained in whichever order and grouping is the same sum, and its mean is that of the gains.
    #[test]
    fn exact_sums_are_of_all_gains() {
        let scene = crate::test_scenes::balls(&[(glam::Vec3::ZERO, 1.0, 1.0)]);
        let scale = Scale::of(&scene);
        let gains = [Rgb::new(0.5, 0.25, 0.0), Rgb::new(1.5, 0.0, 0.125), Rgb::new(0.0, 1.0, 3.0)];
        let sum_of = |gains: &[Rgb]| {
            let mut sums = ExactSums::default();
            for gain in gains {
                sums.gain(scale, *gain, 2);
            }
            sums
        };
        let all = sum_of(&gains);
        let mut apart = sum_of(&gains[2..]);
        apart.add(&sum_of(&gains[..2]));
        assert_eq!((all, all.photons), (apart, 6));
        assert_eq!(sum_of(&[gains[2], gains[0], gains[1]]), all);
        let mean = gains.iter().sum::<Rgb>() / 3.0;
        assert!((all.develop(scale, 3) - mean).abs().max_element() < 1e-6, "{}", all.develop(scale, 3));
    }

    #[test]
    fn sums_that_no_engine_writes_are_found() {
        let sums = PhotonSums { direct: Rgb::ZERO, tau: Rgb::ZERO, n: 0.0, radius_squared: 4.0 };
        let fault = |sums: PhotonSums| Sums::Photons.fault(&sums.to_words(), 2.0, 1);
        assert_eq!([fault(sums), fault(PhotonSums { n: 1e9, radius_squared: 1e-9, ..sums })], [None, None]);
        for n in [-1.0, f32::NAN, f32::INFINITY] {
            assert_eq!(fault(PhotonSums { n, ..sums }), Some("has a pixel whose count of photons is none"));
        }
        for radius_squared in [0.0, -1.0, 4.000_001, f32::NAN, f32::INFINITY] {
            let told = Some("has a pixel whose radius is none, or larger than the first");
            assert_eq!(fault(PhotonSums { radius_squared, ..sums }), told, "{radius_squared}");
        }
        let exact = ExactSums { photons: 3 * MAX_DEPOSITS, ..ExactSums::default() };
        let fault = |sums: ExactSums| Sums::Exact.fault(&sums.to_words(), 2.0, 3);
        assert_eq!(fault(exact), None);
        let told = Some("has a pixel whose count of photons is too large for its iterations");
        assert_eq!(fault(ExactSums { photons: exact.photons + 1, ..exact }), told);
        let told = Some("has a pixel whose sum is too large for its iterations");
        for channel in 0..3 {
            let mut large = exact;
            large.radiance[channel] = Exact([0, 0, u64::MAX >> 1]);
            assert_eq!(fault(large), told, "{channel}");
        }
        assert_eq!(Sums::Paths.fault(&[u32::MAX; 6], 2.0, 1), None);
        // Of both, the photons' words are checked.
        let both = |sums: PhotonSums| {
            let words: Vec<u32> = [u32::MAX; 6].into_iter().chain(sums.to_words()).collect();
            Sums::Hybrid.fault(&words, 2.0, 1)
        };
        let sums = PhotonSums { direct: Rgb::ZERO, tau: Rgb::ZERO, n: 1.0, radius_squared: 1.0 };
        assert_eq!(both(sums), None);
        assert!(both(PhotonSums { n: -1.0, ..sums }).is_some_and(|fault| fault.contains("count")));
        assert!(
            both(PhotonSums { radius_squared: 5.0, ..sums }).is_some_and(|fault| fault.contains("radius"))
        );
    }

    #[test]
    fn sums_are_told_by_their_method() {
        let all = [Sums::Photons, Sums::Exact, Sums::Paths, Sums::Hybrid].map(|sums| sums.to_string());
        let told = [
            "photon mapping",
            "photon mapping with global radii",
            "path tracing",
            "path tracing with photons for caustics",
        ];
        assert_eq!(all, told);
    }

    /// An engine of which nothing but its state matters.
    struct Fake {
        progress: Progress,
        sums: Sums,
        words: Vec<u32>,
    }

    impl Fake {
        fn new(sums: Sums, first: u32) -> Self {
            let settings = Settings { width: 3, height: 2, ..Settings::default() };
            let words = (first..).take(3 * 2 * sums.words()).collect();
            Self { progress: Progress::new(&settings), sums, words }
        }

        fn row(&mut self, y: u32) -> &mut [u32] {
            let length = 3 * self.sums.words();
            &mut self.words[y as usize * length..][..length]
        }
    }

    impl Engine for Fake {
        fn progress(&self) -> &Progress {
            &self.progress
        }

        fn iterate_unless(&mut self, _: &Stop) -> bool {
            true
        }

        fn probe(&self, _: u32, _: u32) -> Probe {
            Probe::default()
        }
    }

    impl Resumable for Fake {
        fn sums(&self) -> Sums {
            self.sums
        }

        fn save_row(&self, y: u32, words: &mut [u32]) {
            words.copy_from_slice(&self.words[y as usize * words.len()..][..words.len()]);
        }

        fn load_row(&mut self, y: u32, words: &[u32]) {
            self.row(y).copy_from_slice(words);
        }

        fn go_on_after(&mut self, iterations: u32, stats: Stats) {
            self.progress.go_on_after(iterations, stats);
        }

        fn skip_to(&mut self, next: u32) {
            assert_eq!(self.sums, Sums::Exact, "an iteration depends on those before it");
            self.progress.next = next;
        }
    }

    /// Sums, iterations and work; and of global radii the number of the next iteration, which may be beyond others that are
    /// rendered elsewhere.
    #[test]
    fn a_render_goes_on_in_another_engine_as_it_was() {
        let stats = Stats { photons: 9, camera_seconds: 0.5, bytes: 7, ..Stats::default() };
        for (sums, next) in [(Sums::Exact, 20), (Sums::Photons, 4), (Sums::Paths, 4), (Sums::Hybrid, 4)] {
            let (mut from, mut to) = (Fake::new(sums, 100), Fake::new(sums, 5000));
            from.progress = Progress { iterations: 4, next, stats, ..from.progress };
            transfer(&from, &mut to);
            assert_eq!(to.words, from.words, "{sums}");
            assert_eq!((to.progress.iterations, to.progress.next, to.progress.stats), (4, next, stats));
        }
    }

    #[test]
    #[should_panic(expected = "engines of different renders")]
    fn a_render_does_not_go_on_in_an_engine_of_another_kind() {
        transfer(&Fake::new(Sums::Photons, 0), &mut Fake::new(Sums::Paths, 0));
    }
}
