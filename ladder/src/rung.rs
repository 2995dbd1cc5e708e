//! A render in progress, as the ladder needs it: an engine that may count its operations.

use crate::counted::Operations;
use scene::Engine;

/// A render by one row of the ladder.
pub trait Rung: Engine {
    /// What has been counted in the camera pass, the building of the index, the photon pass and the consolidation, if
    /// it was asked for ([`crate::Options::counts_operations`]) and can be had.
    fn operations(&self) -> Option<[Operations; 4]>;
}
