//! Estimates the relative error of a render.

use files::checkpoint::Past;
use scene::film::RELATIVE_MSE_EPSILON;
use scene::{Film, Rgb};

/// At most this many estimates are made from one power of two of iterations to the next.
const CHECKS_PER_OCTAVE: u32 = 16;

/// Estimates the relative error of a render by comparing its image with that of an earlier iteration.
///
/// Assume that the iterations have independent noise of equal variance `s^2`. Then the images after m and after n > m
/// iterations differ with a variance of `s^2 (n - m) / (m n)`, and the later image has a variance of `s^2 / n`. So the
/// mean square of their difference, times `m / (n - m)`, estimates the mean square error. The square is taken relative,
/// `d^2 / (L^2 + 0.01)`, over all pixels and channels, as in the relative MSE of `sppm compare`; its root is the
/// estimate. In photon mapping, noise falls more slowly and there is a bias that shrinks. The difference includes the
/// noise fully and the bias in part.
///
/// The estimate depends only on the number of iterations and their images, so a resumed render stops at the same
/// iteration as one that was never interrupted.
#[derive(Debug, Default)]
pub struct Estimate {
    past: Option<Past>,
    /// The last estimate.
    pub error: Option<f64>,
}

impl Estimate {
    /// Continues the estimate of a resumed render from the earlier image `past`.
    pub fn after(past: Option<Past>) -> Self {
        Self { past, error: None }
    }

    /// The earlier image, which a checkpoint must keep.
    pub fn past(&self) -> Option<&Past> {
        self.past.as_ref()
    }

    /// Updates the estimate after iteration `n`. Only some iterations are used; `develop` is called for those.
    pub fn update(&mut self, n: u32, develop: impl FnOnce() -> Film) {
        if !is_checked(n) {
            return;
        }
        let film = develop();
        if let Some(past) = self.past.as_ref().filter(|past| past.iterations < n) {
            let (m, n) = (f64::from(past.iterations), f64::from(n));
            self.error = Some((relative_square(&film.pixels, &past.film.pixels) * m / (n - m)).sqrt());
        }
        if n.is_power_of_two() {
            self.past = Some(Past { iterations: n, film });
        }
    }
}

/// Whether an estimate is made after iteration `n`.
pub(crate) fn is_checked(n: u32) -> bool {
    let octave = 1_u32 << n.ilog2();
    n.is_multiple_of((octave / CHECKS_PER_OCTAVE).max(1))
}

/// The mean of `(a - b)^2 / (a^2 + epsilon)` over all channels of all pixels, leaving out terms that are not finite.
pub(crate) fn relative_square(a: &[Rgb], b: &[Rgb]) -> f64 {
    let (mut sum, mut count) = (0.0, 0_u64);
    for (a, b) in a.iter().zip(b) {
        for (a, b) in a.to_array().into_iter().zip(b.to_array()) {
            let (a, b) = (f64::from(a), f64::from(b));
            let term = (a - b) * (a - b) / (a * a + RELATIVE_MSE_EPSILON);
            if term.is_finite() {
                (sum, count) = (sum + term, count + 1);
            }
        }
    }
    sum / count.max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A grey image of value 3 with noise of variance 1: the image after n iterations is the mean of n samples.
    struct Noise {
        sums: Vec<f64>,
        state: u64,
        n: u32,
    }

    impl Noise {
        fn new() -> Self {
            Self { sums: vec![0.0; 3 * 4000], state: 1, n: 0 }
        }

        fn iterate(&mut self) {
            self.n += 1;
            for sum in &mut self.sums {
                self.state = self.state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                let uniform = (self.state >> 11) as f64 / (1_u64 << 53) as f64;
                *sum += 3.0 + (uniform - 0.5) * 12_f64.sqrt();
            }
        }

        fn film(&self) -> Film {
            let mean = |c: &f64| (c / f64::from(self.n)) as f32;
            let pixels =
                self.sums.chunks(3).map(|c| Rgb::new(mean(&c[0]), mean(&c[1]), mean(&c[2]))).collect();
            Film { width: 4000, height: 1, pixels }
        }
    }

    #[test]
    fn the_error_of_independent_noise_is_estimated() {
        let (mut noise, mut estimate) = (Noise::new(), Estimate::default());
        for n in 1..=300 {
            noise.iterate();
            estimate.update(n, || noise.film());
            let truth = (1.0 / (9.0 + RELATIVE_MSE_EPSILON) / f64::from(n)).sqrt();
            // 12000 samples are accurate to 1 %. Between updates the estimate is up to n / 16 iterations old, and after
            // few iterations L^2 is noisy.
            if n > 8 {
                let error = estimate.error.unwrap();
                assert!((0.95..1.1).contains(&(error / truth)), "iteration {n}: {error}, not {truth}");
            }
        }
    }

    /// The closer the images, the less of the noise that both share; the farther, the less of the bias. So the earlier one is
    /// at most half as far, and at least a power of two.
    #[test]
    fn the_earlier_image_is_of_the_last_power_of_two() {
        let (mut noise, mut estimate) = (Noise::new(), Estimate::default());
        for n in 1..=40_u32 {
            noise.iterate();
            estimate.update(n, || noise.film());
            assert_eq!(estimate.past().unwrap().iterations, 1 << n.ilog2());
        }
    }

    #[test]
    fn the_estimate_of_a_resumed_render_is_the_same() {
        let (mut noise, mut whole, mut broken) = (Noise::new(), Estimate::default(), Estimate::default());
        for n in 1..=100 {
            noise.iterate();
            whole.update(n, || noise.film());
            broken.update(n, || noise.film());
            if n > 1 {
                let again = Estimate::after(broken.past().cloned());
                assert_eq!(again.past(), whole.past());
                let is_looked_at = n < 32 || n % 2 == 0 && n < 64 || n % 4 == 0;
                assert!(!is_looked_at || broken.error == whole.error);
                broken = again;
            }
        }
    }

    /// Each to the power of two of iterations, and 16 times on the way to the next.
    #[test]
    fn estimates_are_made_at_most_so_often() {
        assert!((1..=32).all(is_checked));
        let of = |from: u32| (from + 1..=2 * from).filter(|n| is_checked(*n)).count();
        assert_eq!([of(16), of(32), of(64), of(1024)], [16; 4]);
        assert!(is_checked(34) && !is_checked(33) && is_checked(1024 + 64) && !is_checked(1024 + 32));
    }

    #[test]
    fn squares_are_relative_and_of_what_is_finite() {
        let (a, b) = (Rgb::new(2.0, 0.0, f32::INFINITY), Rgb::new(1.0, 1.0, 1.0));
        let exact = f64::midpoint(1.0 / (4.0 + RELATIVE_MSE_EPSILON), 1.0 / RELATIVE_MSE_EPSILON);
        assert!((relative_square(&[a], &[b]) / exact - 1.0).abs() < 1e-12);
        assert_eq!(relative_square(&[a], &[Rgb::splat(f32::NAN)]), 0.0);
        assert_eq!(relative_square(&[], &[]), 0.0);
    }

    /// An image compared with itself would tell nothing.
    #[test]
    fn an_image_is_compared_with_earlier_ones_alone() {
        let mut estimate = Estimate::default();
        let film = || Film::from_fn(2, 2, |_, _| Rgb::ONE);
        estimate.update(2, film);
        estimate.update(2, film);
        assert_eq!(estimate.error, None);
        estimate.update(3, film);
        assert_eq!(estimate.error, Some(0.0));
    }
}
