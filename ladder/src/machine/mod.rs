//! Measures the peaks of one thread (floating-point operations and memory bandwidth), and counts cycles.

mod bandwidth;
mod best;
mod clock;
mod flops;
mod peaks;

pub use bandwidth::{Bandwidth, Level};
pub(crate) use best::best_seconds;
pub use clock::{Clock, CycleCounter, CycleSource};
pub use peaks::Peaks;
