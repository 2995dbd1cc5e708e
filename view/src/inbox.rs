//! What threads leave for the one that works on it: requests of clients, of which only so many may wait.

use std::collections::VecDeque;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// A bounded queue, and a bell that may be rung without leaving anything.
#[derive(Debug)]
pub(crate) struct Inbox<T> {
    state: Mutex<State<T>>,
    changed: Condvar,
    most: usize,
}

#[derive(Debug)]
struct State<T> {
    queue: VecDeque<T>,
    has_rung: bool,
}

impl<T> Inbox<T> {
    /// An inbox in which at most `most` may wait.
    pub(crate) fn new(most: usize) -> Self {
        let state = State { queue: VecDeque::with_capacity(most), has_rung: false };
        Self { state: Mutex::new(state), changed: Condvar::new(), most }
    }

    /// Leaves something, or gives it back if the inbox is full.
    pub(crate) fn leave(&self, thing: T) -> Result<(), T> {
        let mut state = self.lock();
        if state.queue.len() >= self.most {
            return Err(thing);
        }
        state.queue.push_back(thing);
        self.changed.notify_one();
        Ok(())
    }

    /// Wakes who waits.
    pub(crate) fn ring(&self) {
        self.lock().has_rung = true;
        self.changed.notify_one();
    }

    /// Everything that was left, after it was waited for, at most so long.
    pub(crate) fn take(&self, most: Duration) -> Vec<T> {
        let state = self.lock();
        let is_quiet = |state: &mut State<T>| state.queue.is_empty() && !state.has_rung;
        let waited = self.changed.wait_timeout_while(state, most, is_quiet);
        let mut state = waited.unwrap_or_else(PoisonError::into_inner).0;
        state.has_rung = false;
        state.queue.drain(..).collect()
    }

    fn lock(&self) -> MutexGuard<'_, State<T>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_full_inbox_gives_back() {
        let inbox = Inbox::new(2);
        assert_eq!([inbox.leave(1), inbox.leave(2), inbox.leave(3)], [Ok(()), Ok(()), Err(3)]);
        assert_eq!(inbox.take(Duration::MAX), [1, 2]);
        inbox.ring();
        assert_eq!(inbox.take(Duration::MAX), [0; 0]);
        assert_eq!(inbox.take(Duration::ZERO), [0; 0]);
    }
}
