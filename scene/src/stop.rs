//! A flag by which other threads or signal handlers ask a render to stop.

use crate::meter::Meter;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

/// How often a render that is held looks whether it may go on.
const LOOK: Duration = Duration::from_millis(20);

/// A request, from another thread or a signal handler, to abandon the iteration in progress. It also carries the meter
/// on which the engine shows how far that iteration is, and a hold that makes the engine wait.
///
/// Clones share one flag, one meter and one hold.
#[derive(Clone, Debug, Default)]
pub struct Stop {
    flag: Arc<AtomicBool>,
    /// The parent: if it is requested, so is this one.
    outer: Option<Arc<Stop>>,
    meter: Meter,
    is_held: Arc<AtomicBool>,
}

impl Stop {
    /// A flag that is not set yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// A new flag that also counts as set once this one is. It can stop a part of the work without stopping the whole.
    /// The meter and the hold are shared.
    #[must_use]
    pub fn child(&self) -> Self {
        let (meter, is_held) = (self.meter.clone(), Arc::clone(&self.is_held));
        Self { flag: Arc::default(), outer: Some(Arc::new(self.clone())), meter, is_held }
    }

    /// As [`Self::child`], but with a meter of its own: what is done with it is no progress of the iteration.
    #[must_use]
    pub fn child_aside(&self) -> Self {
        Self { meter: Meter::default(), ..self.child() }
    }

    /// Holds the render, or lets it go on. A held render waits, within an iteration too, and takes next to no processor
    /// time. The image does not depend on it. A request to stop ends the wait.
    pub fn hold(&self, is_held: bool) {
        self.is_held.store(is_held, Ordering::Relaxed);
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

    /// Whether the request was made, here or at a parent. As long as the render is held, this waits for it.
    #[inline]
    pub fn is_requested(&self) -> bool {
        while self.is_held.load(Ordering::Relaxed) && !self.is_made() {
            thread::sleep(LOOK);
        }
        self.is_made()
    }

    /// Whether the request was made. This never waits.
    fn is_made(&self) -> bool {
        self.flag.load(Ordering::Relaxed) || self.outer.as_ref().is_some_and(|outer| outer.is_made())
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

    #[test]
    fn a_held_render_waits_until_it_is_let_go_or_stopped() {
        for lets_go in [true, false] {
            let stop = Stop::new();
            stop.hold(true);
            let child = stop.child();
            let waits = thread::spawn(move || child.is_requested());
            thread::sleep(4 * LOOK);
            assert!(!waits.is_finished());
            if lets_go {
                stop.hold(false);
            } else {
                stop.request();
            }
            assert_eq!(waits.join().ok(), Some(!lets_go));
        }
    }

    /// Work aside has a meter of its own; a hold of any is one of all, and a request of the whole is one of its parts.
    #[test]
    fn children_share_the_hold_and_all_but_those_aside_the_meter() {
        let stop = Stop::new();
        let (child, aside) = (stop.child(), stop.child_aside());
        stop.meter().begin(4);
        child.meter().advance(1);
        aside.meter().begin(2);
        aside.meter().advance(2);
        assert_eq!([&stop, &child, &aside].map(|stop| stop.meter().share()), [0.25, 0.25, 1.0]);
        let all = [&stop, &child, &aside];
        for one in all {
            one.hold(true);
            assert!(all.iter().all(|other| other.is_held.load(Ordering::Relaxed)));
            one.hold(false);
        }
        // As a handler of signals makes the request.
        aside.shared().store(true, Ordering::Relaxed);
        assert!(aside.is_requested() && !child.is_requested() && !stop.is_requested());
        stop.shared().store(true, Ordering::Relaxed);
        assert!(stop.is_requested() && child.is_requested());
    }
}
