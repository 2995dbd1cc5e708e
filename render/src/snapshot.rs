//! The newest image of a render, for other threads.

use crate::step::Step;
use scene::Film;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// A render after a whole iteration.
#[derive(Clone, Debug, PartialEq)]
pub struct Snapshot {
    /// Whole iterations that the image holds.
    pub iterations: u32,
    /// The image.
    pub film: Film,
}

/// What the thread of a render shows to others.
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

    /// Shows an image, which was developed before: nobody waits for that.
    pub(crate) fn show_snapshot(&self, snapshot: Snapshot) {
        let snapshot = Some(Arc::new(snapshot));
        // The old one is freed after the lock.
        let _old = std::mem::replace(&mut self.lock().snapshot, snapshot);
    }

    pub(crate) fn show_step(&self, step: Step) {
        self.lock().step = Some(step);
    }

    fn lock(&self) -> MutexGuard<'_, Shown> {
        self.shown.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
