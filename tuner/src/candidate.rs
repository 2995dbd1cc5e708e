//! A candidate: values of all tuned parameters, which can be rendered with and timed.

use fast::{LaneKind, Parameters};
use render::Profile;

/// A value of every free parameter, and the lanes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Candidate {
    pub(crate) lanes: LaneKind,
    pub(crate) parameters: Parameters,
}

impl Candidate {
    /// The candidate as a profile for renders.
    pub(crate) fn profile(self) -> Profile {
        Profile { parameters: self.parameters, lanes: Some(self.lanes.into()) }
    }
}
