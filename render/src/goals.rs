//! The goals of a render besides its iterations: a time limit and an estimated error.

use scene::settings::MAX_ITERATIONS;
use std::time::{Duration, Instant};

/// Goals of a render. It ends when the first goal is reached, or when all iterations are done.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Goals {
    /// Time limit, from the start of the render.
    pub time: Option<Duration>,
    /// Estimated relative error to reach.
    pub error: Option<f64>,
}

impl Goals {
    /// Whether a goal ends the render, however many iterations it takes.
    pub fn are_open(&self) -> bool {
        self.time.is_some() || self.error.is_some()
    }

    /// The number of iterations: `asked` if given, else the maximum if there is a goal, else `own`, the scene's number.
    pub fn iterations(&self, asked: Option<u32>, own: u32) -> u32 {
        asked.unwrap_or(if self.are_open() { MAX_ITERATIONS } else { own })
    }
}

/// Measures the time of a render against its time limit.
#[derive(Debug)]
pub(crate) struct Clock {
    began: Instant,
    goal: Option<Duration>,
}

impl Clock {
    /// A clock that starts now.
    pub(crate) fn start(goals: &Goals) -> Self {
        Self { began: Instant::now(), goal: goals.time }
    }

    /// Time since the start.
    pub(crate) fn elapsed(&self) -> Duration {
        self.began.elapsed()
    }

    /// Time that is left, if there is a limit.
    pub(crate) fn left(&self) -> Option<Duration> {
        self.goal.map(|goal| goal.saturating_sub(self.elapsed()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_a_goal_the_scene_sets_the_iterations() {
        let timed = Goals { time: Some(Duration::from_secs(1)), error: None };
        assert_eq!(Goals::default().iterations(None, 6), 6);
        assert_eq!(Goals::default().iterations(Some(9), 6), 9);
        assert_eq!(timed.iterations(None, 6), MAX_ITERATIONS);
        assert_eq!(timed.iterations(Some(9), 6), 9);
    }

    #[test]
    fn either_goal_leaves_the_iterations_open() {
        let (time, error) = (Some(Duration::from_secs(1)), Some(0.1));
        let are_open = |time, error| Goals { time, error }.are_open();
        assert!(are_open(time, None) && are_open(None, error) && are_open(time, error));
        assert!(!are_open(None, None));
    }

    #[test]
    fn a_clock_tells_what_is_left_of_its_limit() {
        let hour = Duration::from_hours(1);
        let left = |time| Clock::start(&Goals { time, error: None }).left();
        assert_eq!((left(None), left(Some(Duration::ZERO))), (None, Some(Duration::ZERO)));
        let clock = Clock::start(&Goals { time: Some(hour), error: None });
        let (left, elapsed) = (clock.left().unwrap(), clock.elapsed());
        assert!(left < hour && left > hour / 2 && left + elapsed >= hour, "{left:?}");
    }
}
