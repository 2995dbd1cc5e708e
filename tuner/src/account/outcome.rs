//! The outcome of a search, from which its files and its summary are made.

use super::subject::Subject;
use crate::candidate::Candidate;
use crate::found::Found;

/// The outcome of a search.
pub(crate) struct Outcome {
    pub(crate) subject: Subject,
    pub(crate) defaults: Candidate,
    pub(crate) found: Found,
    /// The library of the optimiser and its version.
    pub(crate) optimiser: String,
    pub(crate) seed: u32,
    pub(crate) pairs: u32,
}

impl Outcome {
    /// The candidate for the profile.
    pub(crate) fn chosen(&self) -> Candidate {
        self.found.chosen().unwrap_or(self.defaults)
    }
}

#[cfg(test)]
impl Outcome {
    /// Three points were tried, and the second is the best, with these ratios in the end.
    pub(crate) fn example(best: Vec<f64>, is_confirmed: bool) -> Self {
        use crate::found::Tried;
        use crate::optimiser::Learnt;
        use crate::ratios::Ratios;
        let scene = files::builtin::scene("cornell").unwrap();
        let settings = scene::Settings { iterations: 9, ..scene.settings };
        let tried: Vec<Tried> =
            [(5.0, 1.01), (4.0, 0.9), (6.0, 1.2)].map(|(size, ratio)| Tried::example(size, ratio)).into();
        let best = Tried { ratios: Ratios::new(best), ..tried[1].clone() };
        let learnt = Learnt {
            order: vec![1, 0, 2],
            noise: Some(0.012_34),
            length_scales: [("cell_size".into(), 0.567_89)].into(),
        };
        Self {
            subject: Subject::new("box", &scene, settings, 2),
            defaults: tried[0].candidate,
            found: Found { tried, learnt: is_confirmed.then_some(learnt), best, is_confirmed },
            optimiser: "stub 1.0".into(),
            seed: 7,
            pairs: 3,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_profile_gets_the_best_point_or_the_defaults() {
        let [gain, loss] = [0.9, 1.1].map(|ratio| Outcome::example(vec![ratio; 6], true));
        assert_eq!(gain.chosen(), gain.found.best.candidate);
        assert_eq!(loss.chosen(), loss.defaults);
        assert_ne!(gain.chosen(), loss.chosen());
    }
}
