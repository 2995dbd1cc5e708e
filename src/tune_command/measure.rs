//! Renders in turns with the defaults, and what their times say.

use super::space::Candidate;
use crate::terminal::error::Error;
use rayon::ThreadPool;
use scene::{Engine, Film, Rgb, Scene, Settings, Stop};
use std::time::Instant;

/// How sure an interval is.
const CONFIDENCE: f64 = 0.95;

/// What is rendered, and where.
pub(super) struct Bench<'a> {
    scene: &'a Scene,
    settings: &'a Settings,
    pool: ThreadPool,
    usual: Candidate,
    /// What the defaults make of it, and so must all.
    image: Film,
    stop: &'a Stop,
}

/// Ratios of a candidate's times to those of the defaults.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Ratios {
    /// From the least to the greatest.
    sorted: Vec<f64>,
}

impl<'a> Bench<'a> {
    /// Renders once by the defaults, `usual`; `None` if stopped meanwhile.
    pub(super) fn new(
        scene: &'a Scene,
        settings: &'a Settings,
        pool: ThreadPool,
        usual: Candidate,
        stop: &'a Stop,
    ) -> Option<Self> {
        let mut bench = Self { scene, settings, pool, usual, image: Film::new(0, 0), stop };
        bench.image = bench.render(usual)?.1;
        Some(bench)
    }

    /// Whether somebody asked to stop.
    pub(super) fn is_stopped(&self) -> bool {
        self.stop.is_requested()
    }

    /// Seconds from the start to the developed image, and this; `None` if stopped.
    fn render(&self, candidate: Candidate) -> Option<(f64, Film)> {
        let Candidate { lanes, parameters } = candidate;
        self.pool.install(|| {
            let began = Instant::now();
            let mut engine = fast::Sppm::with_parameters(self.scene, self.settings, lanes, &parameters);
            for _ in 0..self.settings.iterations {
                if !engine.iterate_unless(self.stop) {
                    return None;
                }
            }
            let image = engine.develop();
            Some((began.elapsed().as_secs_f64(), image))
        })
    }

    /// The same, if the image is the defaults' in every bit.
    fn seconds(&self, candidate: Candidate) -> Result<Option<f64>, Error> {
        let Some((seconds, image)) = self.render(candidate) else { return Ok(None) };
        if is_equal(&image, &self.image) {
            return Ok(Some(seconds));
        }
        let profile = candidate.profile().to_text().replace('\n', ", ");
        Err(Error::Failed(format!("another image by other free parameters, a fault of sppm: {profile}")))
    }

    /// The ratios of `pairs` pairs, of which every other begins with the defaults; `None` if stopped.
    pub(super) fn ratios(&self, candidate: Candidate, pairs: u32) -> Result<Option<Ratios>, Error> {
        let mut ratios = Vec::new();
        for pair in 0..pairs {
            let order = if pair % 2 == 0 { [self.usual, candidate] } else { [candidate, self.usual] };
            let (Some(first), Some(second)) = (self.seconds(order[0])?, self.seconds(order[1])?) else {
                return Ok(None);
            };
            ratios.push(if pair % 2 == 0 { second / first } else { first / second });
        }
        Ok(Some(Ratios::new(ratios)))
    }
}

fn is_equal(a: &Film, b: &Film) -> bool {
    let bits = |pixel: &Rgb| pixel.to_array().map(f32::to_bits);
    a.pixels.len() == b.pixels.len() && a.pixels.iter().zip(&b.pixels).all(|(a, b)| bits(a) == bits(b))
}

impl Ratios {
    /// Of at least one pair.
    pub(super) fn new(mut ratios: Vec<f64>) -> Self {
        ratios.sort_by(f64::total_cmp);
        Self { sorted: ratios }
    }

    /// Those of both.
    pub(super) fn and(self, other: Self) -> Self {
        Self::new([self.sorted, other.sorted].concat())
    }

    /// The median; of an even number, the geometric mean of the two in the middle.
    pub(super) fn median(&self) -> f64 {
        let n = self.sorted.len();
        (self.sorted[(n - 1) / 2] * self.sorted[n / 2]).sqrt()
    }

    /// Where the median of many more pairs would be, in 95 of 100 cases: whatever the distribution, it lies between
    /// the k-th least and the k-th greatest ratio but in twice the cases in which a fair coin falls on heads fewer
    /// than k times. From the least to the greatest of all where they are too few to be so sure. For at most 1000.
    pub(super) fn interval(&self) -> [f64; 2] {
        let n = self.sorted.len();
        let (mut below, mut probability, mut k) = (0.0, 0.5_f64.powi(n as i32), 0);
        // Heads come k times with this probability.
        while below + probability <= (1.0 - CONFIDENCE) / 2.0 {
            below += probability;
            probability *= (n - k) as f64 / (k + 1) as f64;
            k += 1;
        }
        let k = k.max(1);
        [self.sorted[k - 1], self.sorted[n - k]]
    }

    /// The least and the greatest.
    pub(super) fn ends(&self) -> [f64; 2] {
        [self.sorted[0], self.sorted[self.sorted.len() - 1]]
    }

    /// How many pairs there are.
    pub(super) fn count(&self) -> usize {
        self.sorted.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fast::{LaneKind, Parameters};
    use render::pool;

    fn ratios(values: impl IntoIterator<Item = u32>) -> Ratios {
        Ratios::new(values.into_iter().map(f64::from).collect())
    }

    #[test]
    fn medians() {
        assert_eq!(ratios([3, 1, 2]).median(), 2.0);
        assert_eq!(ratios([4, 1]).median(), 2.0);
        assert_eq!(ratios([5]).and(ratios([7, 6])), ratios([5, 6, 7]));
        assert_eq!(ratios([1, 2, 3, 4]).count(), 4);
    }

    /// As in tables of the sign test's interval for the median.
    #[test]
    fn intervals_are_those_of_the_sign_test() {
        for (n, k) in
            [(6, 1), (8, 1), (9, 2), (11, 2), (12, 3), (15, 4), (20, 6), (21, 6), (25, 8), (1000, 469)]
        {
            assert_eq!(ratios(1..=n).interval(), [f64::from(k), f64::from(n + 1 - k)], "{n}");
        }
        assert_eq!(ratios([2, 1]).interval(), [1.0, 2.0]);
    }

    #[test]
    fn renders_are_in_turns_and_alike() {
        let scene = files::builtin::scene("cornell").unwrap();
        let settings =
            Settings { width: 16, height: 12, iterations: 1, photons_per_iteration: 200, ..scene.settings };
        let usual = Candidate { lanes: LaneKind::best(), parameters: Parameters::default() };
        let stop = Stop::new();
        let bench = Bench::new(&scene, &settings, pool(Some(1)).unwrap(), usual, &stop).unwrap();
        let other = Candidate { parameters: usual.parameters.with("cell_size", 4.0).unwrap(), ..usual };
        let ratios = bench.ratios(other, 3).unwrap().unwrap();
        assert!(ratios.count() == 3 && ratios.median() > 0.0);
        stop.request();
        assert_eq!(bench.ratios(other, 3).unwrap(), None);
        assert!(!is_equal(&bench.image, &Film::new(16, 12)));
    }
}
