//! What the machine can do at most, measured: floating-point operations and memory traffic of one thread, and cycles.

mod bandwidth;
mod best;
mod clock;
mod flops;
mod peaks;

pub use bandwidth::{Bandwidth, Level};
pub(crate) use best::best_seconds;
pub use clock::{Clock, CycleCounter, CycleSource};
pub use peaks::Peaks;
