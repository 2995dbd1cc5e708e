//! The progress bar of a render or a verification.

use crate::session::Snapshot;
use crate::text::scaled;
use indicatif::{ProgressBar, ProgressStyle};
use std::time::Duration;

const TEMPLATE: &str = "{wide_bar} {pos}/{len} {prefix}  {msg}  {elapsed} elapsed, {eta} left";

/// A bar on standard error; draws nothing if that is no terminal.
pub(crate) struct Progress {
    bar: ProgressBar,
}

impl Progress {
    /// A bar for `iterations` iterations; a hidden one if `quiet`.
    pub(crate) fn new(iterations: u32, quiet: bool) -> Self {
        if quiet {
            return Self { bar: ProgressBar::hidden() };
        }
        Self::of(iterations, "iterations")
    }

    /// A bar for `count` things called `noun`.
    pub(crate) fn of(count: u32, noun: &'static str) -> Self {
        let style =
            ProgressStyle::with_template(TEMPLATE).expect("the template is valid: a test makes a bar");
        let bar = ProgressBar::new(count.into()).with_style(style).with_prefix(noun);
        // The clock goes on while an iteration takes its time.
        bar.enable_steady_tick(Duration::from_millis(250));
        Self { bar }
    }

    /// Shows where the render is.
    pub(crate) fn show(&self, snapshot: &Snapshot) {
        self.bar.set_message(message(snapshot, self.bar.elapsed().as_secs_f64()));
        self.bar.set_position(snapshot.iterations.into());
    }

    /// Shows that `done` iterations are over and that `what` is at work.
    pub(crate) fn step(&self, done: u32, what: &str) {
        self.bar.set_message(what.to_owned());
        self.bar.set_position(done.into());
    }

    /// Takes the bar away.
    pub(crate) fn clear(&self) {
        self.bar.finish_and_clear();
    }
}

/// Speed and, where there are photons, the mean radius.
fn message(snapshot: &Snapshot, seconds: f64) -> String {
    let per_second = |count: u64| scaled(count as f64 / seconds.max(f64::MIN_POSITIVE));
    match &snapshot.radius {
        Some(plane) => {
            let sum: f64 = plane.values.iter().map(|&r| f64::from(r)).sum();
            let mean = sum / plane.values.len() as f64;
            format!("{} photons/s  mean radius {mean:.4}", per_second(snapshot.stats.photons))
        }
        None => format!("{} segments/s", per_second(snapshot.stats.camera_segments)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scene::{Film, Plane, Stats};

    fn snapshot(radius: Option<Vec<f32>>) -> Snapshot {
        Snapshot {
            film: Film::new(2, 1),
            radius: radius.map(|values| Plane { width: 2, height: 1, values }),
            count: None,
            stats: Stats { photons: 3_000_000, camera_segments: 500, ..Stats::default() },
            iterations: 3,
            develop: Duration::ZERO,
        }
    }

    #[test]
    fn photons_and_mean_radius_are_shown() {
        let message = message(&snapshot(Some(vec![1.0, 2.0])), 2.0);
        assert_eq!(message, "1.50M photons/s  mean radius 1.5000");
    }

    #[test]
    fn a_path_tracer_has_no_radius() {
        assert_eq!(message(&snapshot(None), 2.0), "250 segments/s");
    }

    #[test]
    fn the_bar_follows_the_iterations() {
        let progress = Progress::new(10, false);
        progress.show(&snapshot(None));
        assert_eq!(progress.bar.position(), 3);
        progress.clear();
        assert!(progress.bar.is_finished());
    }
}
