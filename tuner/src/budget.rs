//! The budget of a search: numbers of points and renders, and a time limit.

use std::time::Duration;

/// The budget of a search.
#[derive(Clone, Copy, Debug)]
pub struct Budget {
    /// Points to try, including the defaults; at least 2.
    pub evaluations: u32,
    /// Pairs of renders per point, one with the defaults and one with the point; at least 1.
    pub pairs: u32,
    /// Pairs of renders in the final measurement of the best point; at least 1.
    pub final_pairs: u32,
    /// The time after which no further point is tried.
    pub time: Option<Duration>,
}

impl Budget {
    /// The number of points spread over the space before the model proposes any.
    pub(crate) fn initial(&self) -> u32 {
        (self.evaluations / 4).clamp(2, 12)
    }
}
