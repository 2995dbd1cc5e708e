//! What a search has found.

use crate::candidate::Candidate;
use crate::optimiser::Learnt;
use crate::ratios::Ratios;

/// A point that was measured.
#[derive(Clone, Debug)]
pub(crate) struct Tried {
    pub(crate) candidate: Candidate,
    pub(crate) ratios: Ratios,
}

/// The outcome of a search.
#[derive(Clone, Debug)]
pub(crate) struct Found {
    /// In the order of the proposals; the first are the defaults themselves.
    pub(crate) tried: Vec<Tried>,
    /// What the optimiser has learnt of them; `None` if the search was interrupted.
    pub(crate) learnt: Option<Learnt>,
    /// The best, with the ratios of its final measurement; if that was interrupted, with those of the search.
    pub(crate) best: Tried,
    /// Whether the final measurement is complete.
    pub(crate) is_confirmed: bool,
}

impl Found {
    /// Whether the best is faster than the defaults, beyond chance.
    pub(crate) fn is_gain(&self) -> bool {
        self.is_confirmed && self.best.ratios.interval()[1] < 1.0
    }

    /// The least ratio of those up to each point.
    pub(crate) fn best_so_far(&self) -> Vec<f64> {
        let ratios = self.tried.iter().map(|tried| tried.ratios.median());
        let lower = |best: &mut f64, ratio| {
            *best = best.min(ratio);
            Some(*best)
        };
        ratios.scan(f64::INFINITY, lower).collect()
    }
}

#[cfg(test)]
impl Tried {
    /// A candidate that differs from the defaults in its cells alone, measured once.
    pub(crate) fn example(cell_size: f64, ratio: f64) -> Self {
        let parameters = fast::Parameters::default().with("cell_size", cell_size).unwrap();
        let candidate = Candidate { lanes: fast::LaneKind::Emulated, parameters };
        Self { candidate, ratios: Ratios::new(vec![ratio]) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(best: Vec<f64>, is_confirmed: bool) -> Found {
        let all: Vec<Tried> =
            [(5.0, 1.01), (4.0, 0.9), (6.0, 1.2)].map(|(size, ratio)| Tried::example(size, ratio)).into();
        let best = Tried { ratios: Ratios::new(best), ..all[1].clone() };
        Found { tried: all, learnt: None, best, is_confirmed }
    }

    #[test]
    fn a_gain_is_beyond_chance_and_measured_anew() {
        let clear = vec![0.9, 0.91, 0.92, 0.93, 0.94, 0.95];
        let in_doubt = vec![0.9, 0.91, 0.92, 0.93, 0.94, 1.01];
        assert!(found(clear.clone(), true).is_gain());
        assert!(!found(clear, false).is_gain());
        assert!(!found(in_doubt, true).is_gain());
    }

    #[test]
    fn the_best_so_far_never_grows() {
        assert_eq!(found(vec![1.0], true).best_so_far(), [1.01, 0.9, 0.9]);
    }
}
