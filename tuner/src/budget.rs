//! How much is tried.

use std::time::Duration;

/// How much is to be done.
#[derive(Clone, Copy, Debug)]
pub struct Budget {
    /// Points to try, the defaults among them; at least 2.
    pub evaluations: u32,
    /// Pairs of renders per point, by the defaults and by the point; at least 1.
    pub pairs: u32,
    /// Pairs by which the best point is measured again; at least 1.
    pub final_pairs: u32,
    /// No point is tried after so much time.
    pub time: Option<Duration>,
}

impl Budget {
    /// Points spread over the space before the model proposes any.
    pub(crate) fn initial(&self) -> u32 {
        (self.evaluations / 4).clamp(2, 12)
    }
}
