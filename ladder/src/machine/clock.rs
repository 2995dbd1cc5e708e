//! Counts processor cycles: by the hardware's counter if the system gives access, else from time and a measured clock.

use super::best::best_rate;
use serde::Serialize;
use std::hint::black_box;

/// The source of cycle counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum CycleSource {
    /// The hardware's counter.
    Counter,
    /// Time, multiplied by a clock measured with a chain of operations of known latency.
    Chain,
}

impl CycleSource {
    /// The text on the source in reports.
    pub fn about(self) -> &'static str {
        match self {
            Self::Counter => "cycles from the hardware counter",
            Self::Chain => {
                "no hardware counter here: cycles are time at the clock measured by a chain of dependent operations"
            }
        }
    }
}

/// The clock of the processor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clock {
    /// Cycles per second.
    pub hertz: f64,
    /// How it was measured.
    pub source: CycleSource,
}

/// Steps of a chain, which take about 2 ms.
const STEPS: u32 = 3_000_000;
/// Cycles of a step: an addition and an exclusive or, each of one cycle on all common x86-64 processors.
const CYCLES_PER_STEP: f64 = 2.0;

impl Clock {
    /// Times the chain, and counts its cycles if there is a counter.
    pub fn measure() -> Self {
        let cycles = f64::from(STEPS) * CYCLES_PER_STEP;
        let by_chain = best_rate(cycles, || {
            black_box(chain(STEPS));
        });
        let Some(mut counter) = CycleCounter::open() else {
            return Self { hertz: by_chain, source: CycleSource::Chain };
        };
        let mut counted = 0;
        let chains_a_second = best_rate(1.0, || {
            counter.start();
            black_box(chain(STEPS));
            counted = counter.stop().unwrap_or(0);
        });
        match counted {
            // A counter that stays at 0 does not work.
            0 => Self { hertz: by_chain, source: CycleSource::Chain },
            _ => Self { hertz: counted as f64 * chains_a_second, source: CycleSource::Counter },
        }
    }
}

/// Runs a chain in which each operation waits for the one before, and which a compiler cannot shorten.
#[inline(never)]
fn chain(steps: u32) -> u32 {
    let (a, b) = (black_box(0x9e37_79b9_u32), black_box(0x85eb_ca6b_u32));
    let mut x = black_box(1);
    for _ in 0..steps {
        x = b ^ a.wrapping_add(x);
    }
    x
}

/// The hardware's counter of this thread's cycles in user code.
#[derive(Debug)]
pub struct CycleCounter(#[cfg(target_os = "linux")] perf_event::Counter);

#[cfg(target_os = "linux")]
impl CycleCounter {
    /// Opens the counter of the calling thread. `None` if the machine or the system does not provide one.
    pub fn open() -> Option<Self> {
        perf_event::Builder::new().kind(perf_event::events::Hardware::CPU_CYCLES).build().ok().map(Self)
    }

    /// Starts counting from zero.
    pub fn start(&mut self) {
        // If this fails, nothing is counted, and `stop` returns `None`.
        let _ = self.0.reset().and_then(|()| self.0.enable());
    }

    /// Cycles since the start, if any have been counted.
    pub fn stop(&mut self) -> Option<u64> {
        self.0.disable().ok()?;
        self.0.read().ok().filter(|cycles| *cycles > 0)
    }
}

#[cfg(not(target_os = "linux"))]
impl CycleCounter {
    /// Always `None`: counters are supported on Linux only.
    pub fn open() -> Option<Self> {
        None
    }

    /// Does nothing.
    pub fn start(&mut self) {}

    /// Always `None`.
    pub fn stop(&mut self) -> Option<u64> {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_chain_computes_every_step() {
        let by_hand = (0..1000).fold(1_u32, |x, _| x.wrapping_add(0x9e37_79b9) ^ 0x85eb_ca6b);
        assert_eq!(chain(1000), by_hand);
    }
}
