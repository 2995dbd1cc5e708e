//! A search that is over.

use super::subject::Subject;
use crate::candidate::Candidate;
use crate::found::Found;

/// A search that is over, with all that its files and its text tell.
pub(crate) struct Outcome {
    pub(crate) subject: Subject,
    pub(crate) defaults: Candidate,
    pub(crate) found: Found,
    /// The library and its version.
    pub(crate) optimiser: String,
    pub(crate) seed: u32,
    pub(crate) pairs: u32,
}

impl Outcome {
    /// What to render by: the best, unless its final measurement says that it is no gain.
    pub(crate) fn chosen(&self) -> Candidate {
        let Found { best, is_confirmed, .. } = &self.found;
        if *is_confirmed && !self.found.is_gain() { self.defaults } else { best.candidate }
    }
}
