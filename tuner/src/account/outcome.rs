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
