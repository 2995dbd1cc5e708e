//! A flag by which other threads or signal handlers ask a render to stop.

use crate::meter::Meter;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A request, from another thread or a signal handler, to abandon the iteration in progress. It also carries the meter
/// on which the engine shows how far that iteration is.
///
/// Clones share one flag and one meter.
#[derive(Clone, Debug, Default)]
pub struct Stop {
    flag: Arc<AtomicBool>,
    /// The parent: if it is requested, so is this one.
    outer: Option<Arc<Stop>>,
    meter: Meter,
}

impl Stop {
    /// A flag that is not set yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// A new flag that also counts as set once this one is. It can stop a part of the work without stopping the whole.
    /// The meter is shared.
    #[must_use]
    pub fn child(&self) -> Self {
        Self { flag: Arc::default(), outer: Some(Arc::new(self.clone())), meter: self.meter.clone() }
    }

    /// How far the iteration in progress is.
    #[inline]
    pub fn meter(&self) -> &Meter {
        &self.meter
    }

    /// The flag itself, for signal handlers: setting it makes the request.
    pub fn shared(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.flag)
    }

    /// Makes the request.
    pub fn request(&self) {
        self.flag.store(true, Ordering::Relaxed);
    }

    /// Whether the request was made, here or at a parent.
    #[inline]
    pub fn is_requested(&self) -> bool {
        self.flag.load(Ordering::Relaxed) || self.outer.as_ref().is_some_and(|outer| outer.is_requested())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_child_follows_its_parent_and_not_the_other_way_round() {
        let parent = Stop::new();
        let (first, second) = (parent.child(), parent.child());
        first.request();
        assert!(first.is_requested() && !second.is_requested() && !parent.is_requested());
        parent.clone().request();
        assert!(parent.is_requested() && second.is_requested() && second.child().is_requested());
    }
}
