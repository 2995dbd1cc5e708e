//! From iteration to iteration, until a goal is reached or somebody asks to end.
//!
//! A request to end, or the end of the time, stops the iteration in progress, so nobody waits for it; what the engine
//! holds is then the render after the last whole iteration.

use crate::budget::{Clock, Goals};
use crate::error::Error;
use crate::interrupt::{Requests, Signal};
use scene::{Resumable, Stop};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread;
use std::time::{Duration, Instant};

/// What ended a session.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum End {
    /// All iterations are done.
    Iterations,
    /// Time is up.
    Time,
    /// The estimated error is small enough.
    Error,
    /// Somebody asked for it.
    Signal(Signal),
}

impl End {
    /// For accounts.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Iterations => "iterations",
            Self::Time => "time",
            Self::Error => "error",
            Self::Signal(signal) => signal.name(),
        }
    }
}

/// Iterates until the end. After each iteration `watch` is told how long it took, and gives the estimate of the error,
/// if there is one.
pub(crate) fn run(
    engine: &mut dyn Resumable,
    goals: &Goals,
    clock: &Clock,
    requests: &Requests,
    mut watch: impl FnMut(&dyn Resumable, Duration) -> Result<Option<f64>, Error>,
) -> Result<End, Error> {
    let (mut alarm, mut error) = (None, None);
    loop {
        if let Some(signal) = requests.pending() {
            return Ok(End::Signal(signal));
        }
        if engine.iterations() >= engine.settings().iterations {
            return Ok(End::Iterations);
        }
        if engine.iterations() > 0 {
            if goals.error.zip(error).is_some_and(|(goal, error)| error <= goal) {
                return Ok(End::Error);
            }
            match clock.left() {
                Some(Duration::ZERO) => return Ok(End::Time),
                Some(left) if alarm.is_none() => alarm = Some(ring(left, requests.stop().clone())),
                _ => {}
            }
        }
        let began = Instant::now();
        let iterated = catch_unwind(AssertUnwindSafe(|| engine.iterate_unless(requests.stop())));
        let is_whole = iterated.map_err(|_| {
            Error::Failed("the engine broke down; this is a fault of sppm, please report it".into())
        })?;
        if is_whole {
            error = watch(engine, began.elapsed())?;
        }
    }
}

/// Requests to stop once `left` has passed, unless what it gives is dropped before.
fn ring(left: Duration, stop: Stop) -> Sender<()> {
    let (alarm, off) = channel();
    thread::spawn(move || {
        if off.recv_timeout(left) == Err(RecvTimeoutError::Timeout) {
            stop.request();
        }
    });
    alarm
}
