//! When a render ends: its iterations, its time, or an estimate of its error.

use scene::settings::MAX_ITERATIONS;
use std::time::{Duration, Instant};

/// What a render is to reach; it ends with the first of these, or when all iterations are done.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Goals {
    /// Time from the start of the render.
    pub time: Option<Duration>,
    /// Estimated relative error.
    pub error: Option<f64>,
}

impl Goals {
    /// The iterations of a render: those `asked` for if given, else those that the scene states as its `own`; without
    /// end if there is another goal.
    pub fn iterations(&self, asked: Option<u32>, own: u32) -> u32 {
        let is_open = self.time.is_some() || self.error.is_some();
        asked.unwrap_or(if is_open { MAX_ITERATIONS } else { own })
    }
}

/// The clock of a goal.
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

    /// Time since then.
    pub(crate) fn elapsed(&self) -> Duration {
        self.began.elapsed()
    }

    /// Time that is left, if there is an end to it.
    pub(crate) fn left(&self) -> Option<Duration> {
        self.goal.map(|goal| goal.saturating_sub(self.elapsed()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_another_goal_the_scene_tells_the_iterations() {
        let timed = Goals { time: Some(Duration::from_secs(1)), error: None };
        assert_eq!(Goals::default().iterations(None, 6), 6);
        assert_eq!(Goals::default().iterations(Some(9), 6), 9);
        assert_eq!(timed.iterations(None, 6), MAX_ITERATIONS);
        assert_eq!(timed.iterations(Some(9), 6), 9);
    }
}
