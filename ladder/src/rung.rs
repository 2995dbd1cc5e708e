//! The trait of the ladder's renders: an engine that may count its operations.

use crate::counted::Operations;
use scene::Engine;

/// A render by one row of the ladder.
pub trait Rung: Engine {
    /// The operations of the camera pass, the building of the index, the photon pass and the consolidation. `None` if
    /// counting was not requested ([`crate::Options::counts_operations`]) or is not supported by the row.
    fn operations(&self) -> Option<[Operations; 4]>;
}
