//! Requests to stop, from other threads or signals.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A request, from another thread or a signal, to abandon the iteration in progress.
///
/// Clones are the same request.
#[derive(Clone, Debug, Default)]
pub struct Stop {
    flag: Arc<AtomicBool>,
    /// Another request that this one follows.
    outer: Option<Arc<Stop>>,
}

impl Stop {
    /// No request yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// A request of its own that is also made whenever this one is: for what may end earlier than the whole.
    #[must_use]
    pub fn child(&self) -> Self {
        Self { flag: Arc::default(), outer: Some(Arc::new(self.clone())) }
    }

    /// The flag itself, for handlers of signals: setting it makes the request.
    pub fn shared(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.flag)
    }

    /// Makes the request.
    pub fn request(&self) {
        self.flag.store(true, Ordering::Relaxed);
    }

    /// Whether it was made.
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
