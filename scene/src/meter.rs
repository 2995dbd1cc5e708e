//! Measures how far the iteration in progress is, for whoever waits for it.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// How much of an iteration's work is done, in units that the engine chooses. Clones share one count.
///
/// An engine counts whole work items, so that counting costs nothing; other threads read at any time.
#[derive(Clone, Debug, Default)]
pub struct Meter {
    work: Arc<Work>,
}

#[derive(Debug, Default)]
struct Work {
    done: AtomicU64,
    all: AtomicU64,
    /// Whether the work comes before the first iteration.
    is_preparation: AtomicBool,
}

impl Meter {
    /// Begins to count `all` units of an iteration; 0 if nothing is in progress.
    pub fn begin(&self, all: u64) {
        self.count(all, false);
    }

    /// Begins to count `all` units of what comes before the first iteration.
    pub fn prepare(&self, all: u64) {
        self.count(all, true);
    }

    fn count(&self, all: u64, is_preparation: bool) {
        self.work.is_preparation.store(is_preparation, Ordering::Relaxed);
        self.work.done.store(0, Ordering::Relaxed);
        self.work.all.store(all, Ordering::Relaxed);
    }

    /// Counts `units` more as done.
    #[inline]
    pub fn advance(&self, units: u64) {
        self.work.done.fetch_add(units, Ordering::Relaxed);
    }

    /// The share of the iteration that is done, from 0 to 1; 0 if none is in progress.
    pub fn share(&self) -> f64 {
        if self.is_preparing() { 0.0 } else { self.share_of_work() }
    }

    /// The share of the preparation that is done, from 0 to 1; `None` if it is over, or there is none.
    pub fn preparation(&self) -> Option<f64> {
        self.is_preparing().then(|| self.share_of_work())
    }

    fn is_preparing(&self) -> bool {
        self.work.is_preparation.load(Ordering::Relaxed)
    }

    fn share_of_work(&self) -> f64 {
        let [done, all] = [&self.work.done, &self.work.all].map(|count| count.load(Ordering::Relaxed));
        if all == 0 { 0.0 } else { (done as f64 / all as f64).min(1.0) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_share_goes_from_0_to_1() {
        let meter = Meter::default();
        assert_eq!(meter.share(), 0.0);
        meter.begin(8);
        assert_eq!(meter.share(), 0.0);
        meter.clone().advance(2);
        assert_eq!(meter.share(), 0.25);
        meter.advance(100);
        assert_eq!(meter.share(), 1.0);
        meter.begin(0);
        assert_eq!(meter.share(), 0.0);
    }

    /// What comes before the first iteration is no share of it.
    #[test]
    fn preparation_is_counted_by_itself() {
        let meter = Meter::default();
        assert_eq!(meter.preparation(), None);
        meter.prepare(4);
        meter.advance(1);
        assert_eq!((meter.preparation(), meter.share()), (Some(0.25), 0.0));
        meter.begin(2);
        meter.advance(1);
        assert_eq!((meter.preparation(), meter.share()), (None, 0.5));
    }
}
