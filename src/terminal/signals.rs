//! Requests to end: Ctrl-C (SIGINT), SIGTERM and SIGHUP.
//!
//! The first stops the iteration in progress; the render then ends in order. The second ends the process on the spot.
//! As files are renamed into place when whole, none is torn.

use scene::Stop;
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGXFSZ};
use signal_hook::flag;
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// A signal that asks to end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Signal(i32);

impl Signal {
    /// What a shell reports for a process that the signal ended: 130 for Ctrl-C, 143 for SIGTERM, 129 for SIGHUP.
    pub(crate) fn exit_code(self) -> u8 {
        128 + self.0 as u8
    }

    /// Its name.
    pub(crate) fn name(self) -> &'static str {
        match self.0 {
            SIGINT => "SIGINT",
            SIGTERM => "SIGTERM",
            _ => "SIGHUP",
        }
    }
}

/// The system does not let the process listen for signals.
#[derive(Debug, thiserror::Error)]
#[error("cannot listen for signals: {0}")]
pub(crate) struct SignalError(#[from] io::Error);

/// Remembers the first request to end.
#[derive(Clone)]
pub(crate) struct Requests {
    /// The signal's number, 0 for none.
    signal: Arc<AtomicUsize>,
    stop: Stop,
}

impl Requests {
    /// From here on requests are remembered and do not end the process.
    pub(crate) fn listen() -> Result<Self, SignalError> {
        let requests = Self { signal: Arc::new(AtomicUsize::new(0)), stop: Stop::default() };
        let asked = Arc::new(AtomicBool::new(false));
        // What `nohup` has the process ignore stays ignored, so that the render outlives its terminal.
        let hang_up = (!is_ignored(SIGHUP)).then_some(SIGHUP);
        for signal in [SIGINT, SIGTERM].into_iter().chain(hang_up) {
            requests.register(signal, &asked)?;
        }
        Ok(requests)
    }

    fn register(&self, signal: i32, asked: &Arc<AtomicBool>) -> io::Result<()> {
        // Actions run in the order of registration: the first request finds `asked` unset and sets it.
        flag::register_conditional_shutdown(signal, Signal(signal).exit_code().into(), Arc::clone(asked))?;
        flag::register(signal, Arc::clone(asked))?;
        flag::register_usize(signal, Arc::clone(&self.signal), signal as usize)?;
        flag::register(signal, self.stop.shared())?;
        Ok(())
    }

    /// The request that waits for an answer.
    pub(crate) fn pending(&self) -> Option<Signal> {
        match self.signal.load(Ordering::Relaxed) {
            0 => None,
            number => Some(Signal(number as i32)),
        }
    }

    /// What a request, or who else has a reason, asks the engine for.
    pub(crate) fn stop(&self) -> &Stop {
        &self.stop
    }
}

/// From here on a file beyond the limit of the process is an error of writing, and not the end of the process.
pub(crate) fn outlive_limits() {
    let _ = flag::register(SIGXFSZ, Arc::default()); // without it all is as before
}

/// Whether the process was started with `signal` ignored, as far as the system tells.
fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok())
        .is_some_and(|mask| mask >> (signal - 1) & 1 == 1)
}
