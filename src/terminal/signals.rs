//! Handles the signals that ask the process to end: Ctrl-C (SIGINT), SIGTERM and SIGHUP.
//!
//! The first signal stops the iteration in progress, and the render then ends normally. The second ends the process
//! immediately. A signal that is ignored when the process starts stays ignored. No file is left half written, as each is renamed into place only when it is complete.

use files::atomic_file::reason;
use scene::Stop;
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGXFSZ};
use signal_hook::flag;
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// A signal that asks the process to end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Signal(i32);

impl Signal {
    /// The exit code that a shell reports for a process ended by this signal: 130 for Ctrl-C, 143 for SIGTERM, 129 for
    /// SIGHUP.
    pub(crate) fn exit_code(self) -> u8 {
        128 + self.0 as u8
    }

    /// The name of the signal.
    pub(crate) fn name(self) -> &'static str {
        match self.0 {
            SIGINT => "SIGINT",
            SIGTERM => "SIGTERM",
            _ => "SIGHUP",
        }
    }
}

/// A signal, and whether it was received.
type Received = (i32, Arc<AtomicBool>);

/// Signal handlers could not be installed.
#[derive(Debug, thiserror::Error)]
#[error("cannot listen for signals: {}", reason(.0))]
pub(crate) struct SignalError(#[from] io::Error);

/// Signals received so far, and the stop request that they make.
#[derive(Clone)]
pub(crate) struct Requests {
    /// The number of the signal received; 0 for none.
    signal: Arc<AtomicUsize>,
    stop: Stop,
}

impl Requests {
    /// Installs the handlers: from now on the first signal makes a request instead of ending the process.
    pub(crate) fn listen() -> Result<Self, SignalError> {
        let requests = Self::deaf();
        // What the process was started to ignore stays ignored: SIGHUP under `nohup`, so that a render survives the end of
        // its terminal, and SIGINT where a shell starts it in the background.
        let heard = [SIGINT, SIGTERM, SIGHUP].into_iter().filter(|signal| !is_ignored(*signal));
        let received: Vec<Received> = heard.map(|signal| (signal, Arc::default())).collect();
        for (signal, _) in &received {
            requests.register(*signal, &received)?;
        }
        Ok(requests)
    }

    /// Requests that no signal makes.
    pub(crate) fn deaf() -> Self {
        Self { signal: Arc::new(AtomicUsize::new(0)), stop: Stop::default() }
    }

    /// Installs the handler of one signal, whose actions run in the order in which they are registered here.
    ///
    /// Two signals of different kinds may be handled at the same time, by two threads. Each handler marks its own signal as
    /// received before it looks for the marks of the others: so at least one of the two finds the other's mark, and ends the
    /// process.
    fn register(&self, signal: i32, received: &[Received]) -> io::Result<()> {
        let code = Signal(signal).exit_code().into();
        let (own, others): (Vec<_>, Vec<_>) = received.iter().partition(|(of, _)| *of == signal);
        for (_, mark) in own {
            flag::register_conditional_shutdown(signal, code, Arc::clone(mark))?;
            flag::register(signal, Arc::clone(mark))?;
        }
        for (_, mark) in others {
            flag::register_conditional_shutdown(signal, code, Arc::clone(mark))?;
        }
        flag::register_usize(signal, Arc::clone(&self.signal), signal as usize)?;
        flag::register(signal, self.stop.shared())?;
        Ok(())
    }

    /// The signal received, if any.
    pub(crate) fn pending(&self) -> Option<Signal> {
        match self.signal.load(Ordering::Relaxed) {
            0 => None,
            number => Some(Signal(number as i32)),
        }
    }

    /// The stop request for the engine. Signals make it; other code may make it too.
    pub(crate) fn stop(&self) -> &Stop {
        &self.stop
    }
}

/// Makes a write beyond the process's file size limit fail, instead of ending the process by SIGXFSZ.
pub(crate) fn outlive_limits() {
    let _ = flag::register(SIGXFSZ, Arc::default()); // best effort: on failure the default action stays
}

/// Whether the process was started with `signal` ignored; false where there is no /proc to tell.
fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok())
        .is_some_and(|mask| mask >> (signal - 1) & 1 == 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::terminal::error::Error;

    impl Requests {
        /// What there is once this signal has come, which must not come to a process that runs tests.
        pub(crate) fn after(signal: i32) -> Self {
            let requests = Self::deaf();
            requests.signal.store(signal as usize, Ordering::Relaxed);
            requests
        }
    }

    #[test]
    fn a_signal_is_told_as_a_shell_tells_it() {
        for (number, code, name) in
            [(SIGINT, 130, "SIGINT"), (SIGTERM, 143, "SIGTERM"), (SIGHUP, 129, "SIGHUP")]
        {
            let error = Error::Interrupted(Signal(number), "b".into());
            assert_eq!((error.code(), error.label(), error.signal()), (code, "interrupted", Some(name)));
            assert_eq!(error.to_string(), "b");
        }
    }

    #[test]
    fn no_signal_is_pending_before_one_came() {
        let requests = Requests::deaf();
        assert_eq!(requests.pending(), None);
        let requests = Requests::after(SIGTERM);
        assert_eq!(requests.pending(), Some(Signal(SIGTERM)));
        assert!(!requests.stop().is_requested());
    }
}
