//! Says what takes long before there is progress to be shown: reading a large scene, for example.

use super::bar::Bar;
use super::logs;
use std::io::{self, IsTerminal as _};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::{self, JoinHandle};
use std::time::Duration;

/// What takes less time than this is not mentioned.
const PATIENCE: Duration = Duration::from_millis(300);

/// Shows what the command is busy with, on standard error if that is a terminal, until it is dropped.
pub(crate) struct Busy {
    shown: Option<(Sender<()>, JoinHandle<()>)>,
}

impl Busy {
    /// Busy with `what`.
    pub(crate) fn with(what: impl Into<String>) -> Self {
        let what = what.into();
        let is_shown = io::stderr().is_terminal() && logs::has_bars();
        Self { shown: is_shown.then(|| show(what)) }
    }
}

fn show(what: String) -> (Sender<()>, JoinHandle<()>) {
    let (over, is_over) = channel();
    let thread = thread::spawn(move || {
        if is_over.recv_timeout(PATIENCE) == Err(RecvTimeoutError::Timeout) {
            let bar = Bar::wait(what);
            let _ = is_over.recv(); // ends when the sender is dropped
            bar.clear();
        }
    });
    (over, thread)
}

impl Drop for Busy {
    fn drop(&mut self) {
        if let Some((over, thread)) = self.shown.take() {
            drop(over);
            let _ = thread.join(); // it only draws
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;
    use std::sync::atomic::{AtomicBool, Ordering};

    /// What comes next on the terminal must not be cleared by what was shown before.
    #[test]
    fn nothing_is_drawn_any_more_when_it_is_over() {
        let (over, is_over) = channel();
        let is_cleared = Arc::new(AtomicBool::new(false));
        let cleared = Arc::clone(&is_cleared);
        let thread = thread::spawn(move || {
            let ended = is_over.recv();
            thread::sleep(Duration::from_millis(50));
            cleared.store(ended.is_err(), Ordering::Relaxed);
        });
        let busy = Busy { shown: Some((over, thread)) };
        assert!(!is_cleared.load(Ordering::Relaxed));
        drop(busy);
        assert!(is_cleared.load(Ordering::Relaxed));
    }
}
