//! The interface through which a caller follows the progress of a measurement.

/// Called as the work progresses. The work consists of stages, one after the other.
pub trait Progress {
    /// A stage begins, of `count` steps called `noun`.
    fn begin(&mut self, count: u32, noun: &'static str);
    /// `done` steps of the stage are over, and `what` is running.
    fn step(&mut self, done: u32, what: &str);
    /// The stage is over.
    fn end(&mut self);
}

/// Ignores progress.
impl Progress for () {
    fn begin(&mut self, _: u32, _: &'static str) {}
    fn step(&mut self, _: u32, _: &str) {}
    fn end(&mut self) {}
}
