//! Shares the latest image and progress of a render with other threads.

use crate::step::Step;
use scene::Film;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The image after a complete iteration.
#[derive(Clone, Debug, PartialEq)]
pub struct Snapshot {
    /// Iterations in the image.
    pub iterations: u32,
    /// The image.
    pub film: Film,
}

/// The latest state of a render, written by its thread and read by others.
#[derive(Debug, Default)]
pub(crate) struct Window {
    shown: Mutex<Shown>,
}

#[derive(Debug, Default)]
struct Shown {
    snapshot: Option<Arc<Snapshot>>,
    step: Option<Step>,
}

impl Window {
    pub(crate) fn snapshot(&self) -> Option<Arc<Snapshot>> {
        self.lock().snapshot.clone()
    }

    pub(crate) fn step(&self) -> Option<Step> {
        self.lock().step
    }

    /// Publishes an image. It was developed before, so that readers do not wait for that.
    pub(crate) fn show_snapshot(&self, snapshot: Snapshot) {
        let snapshot = Some(Arc::new(snapshot));
        // Frees the old image after the lock is released.
        let _old = std::mem::replace(&mut self.lock().snapshot, snapshot);
    }

    pub(crate) fn show_step(&self, step: Step) {
        self.lock().step = Some(step);
    }

    fn lock(&self) -> MutexGuard<'_, Shown> {
        self.shown.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_latest_is_shown() {
        let window = Window::default();
        assert!(window.snapshot().is_none() && window.step().is_none());
        for iterations in [1, 2] {
            window.show_snapshot(Snapshot { iterations, film: Film::new(1, 1) });
            window.show_step(Step { iteration: iterations, ..Step::default() });
            assert_eq!(window.snapshot().map(|shown| shown.iterations), Some(iterations));
            assert_eq!(window.step().map(|step| step.iteration), Some(iterations));
        }
    }
}
