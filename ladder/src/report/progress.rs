//! How whoever waits is told what is done.

/// Told as work goes on. The work comes in stages, one after the other.
pub trait Progress {
    /// A stage begins, of `count` steps called `noun`.
    fn begin(&mut self, count: u32, noun: &'static str);
    /// `done` steps of the stage are over, and `what` is at work.
    fn step(&mut self, done: u32, what: &str);
    /// The stage is over.
    fn end(&mut self);
}

/// Nobody waits.
impl Progress for () {
    fn begin(&mut self, _: u32, _: &'static str) {}
    fn step(&mut self, _: u32, _: &str) {}
    fn end(&mut self) {}
}
