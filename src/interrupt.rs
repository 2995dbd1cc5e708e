//! Requests to end: Ctrl-C (SIGINT) and SIGTERM.
//!
//! SIGHUP is left alone, so that a render under `nohup` outlives its terminal.

use crate::error::Error;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// A signal that asks to end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Signal(i32);

impl Signal {
    /// What a shell reports for a process that the signal ended: 130 for Ctrl-C, 143 for SIGTERM.
    pub(crate) fn exit_code(self) -> u8 {
        128 + self.0 as u8
    }
}

/// Remembers the first request to end. A second one ends the process on the spot; as files are renamed into place
/// when whole, none is torn.
pub(crate) struct Requests {
    /// The signal's number, 0 for none.
    signal: Arc<AtomicUsize>,
}

impl Requests {
    /// From here on requests are remembered and do not end the process.
    pub(crate) fn listen() -> Result<Self, Error> {
        let requests = Self { signal: Arc::new(AtomicUsize::new(0)) };
        let asked = Arc::new(AtomicBool::new(false));
        for signal in [SIGINT, SIGTERM] {
            requests
                .register(signal, &asked)
                .map_err(|error| Error::Failed(format!("cannot listen for Ctrl-C: {error}")))?;
        }
        Ok(requests)
    }

    fn register(&self, signal: i32, asked: &Arc<AtomicBool>) -> io::Result<()> {
        // Actions run in the order of registration: the first request finds `asked` unset and sets it.
        flag::register_conditional_shutdown(signal, Signal(signal).exit_code().into(), Arc::clone(asked))?;
        flag::register(signal, Arc::clone(asked))?;
        flag::register_usize(signal, Arc::clone(&self.signal), signal as usize)?;
        Ok(())
    }

    /// The request that waits for an answer.
    pub(crate) fn pending(&self) -> Option<Signal> {
        match self.signal.load(Ordering::Relaxed) {
            0 => None,
            number => Some(Signal(number as i32)),
        }
    }
}
