//! The results of a search.

use crate::candidate::Candidate;
use crate::optimiser::Learnt;
use crate::ratios::Ratios;

/// A measured point.
#[derive(Clone, Debug)]
pub(crate) struct Tried {
    pub(crate) candidate: Candidate,
    pub(crate) ratios: Ratios,
}

/// The results of a search.
#[derive(Clone, Debug)]
pub(crate) struct Found {
    /// All measured points, in the order of the proposals. The first is the defaults.
    pub(crate) tried: Vec<Tried>,
    /// What the optimiser's model has learnt; `None` if the search was interrupted.
    pub(crate) learnt: Option<Learnt>,
    /// The best point, with the ratios of its final measurement, or those of the search if that was interrupted.
    pub(crate) best: Tried,
    /// Whether the final measurement is complete.
    pub(crate) is_confirmed: bool,
}

impl Found {
    /// Whether the best point is significantly faster than the defaults.
    pub(crate) fn is_gain(&self) -> bool {
        self.is_confirmed && self.best.ratios.interval()[1] < 1.0
    }

    /// The best point; `None` if its final measurement shows no gain. A search that was interrupted has no such measurement, and
    /// its best point stands.
    pub(crate) fn chosen(&self) -> Option<Candidate> {
        (self.is_gain() || !self.is_confirmed).then_some(self.best.candidate)
    }

    /// For each point, the least ratio up to that point.
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
    /// A candidate that differs from the defaults only in its cell size, measured once.
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

    /// An interrupted search has not measured its best point anew, and keeps it all the same.
    #[test]
    fn the_best_point_is_chosen_unless_it_is_measured_to_be_none() {
        let (gain, loss) = (vec![0.9; 6], vec![1.1; 6]);
        let best = Some(Tried::example(4.0, 0.9).candidate);
        assert_eq!(found(gain.clone(), true).chosen(), best);
        assert_eq!(found(loss.clone(), true).chosen(), None);
        assert_eq!((found(gain, false).chosen(), found(loss, false).chosen()), (best, best));
    }

    #[test]
    fn the_best_so_far_never_grows() {
        assert_eq!(found(vec![1.0], true).best_so_far(), [1.01, 0.9, 0.9]);
    }
}
