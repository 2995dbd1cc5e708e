//! Shows the progress of a render: a bar on standard error, or lines of JSON on standard output.

use super::logs;
use clap::ValueEnum;
use indicatif::{ProgressBar, ProgressStyle};
use render::Step;
use scene::text::scaled;
use std::io::{self, ErrorKind, Write};
use std::time::Duration;

/// How progress is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum Progress {
    /// A bar on standard error, if that is a terminal
    #[default]
    Bar,
    /// A JSON object per iteration on standard output
    Json,
}

const TEMPLATE: &str = "{wide_bar} {pos}/{len} {prefix}  {msg}  {elapsed} elapsed, {eta} left";

/// A bar on standard error; draws nothing if standard error is not a terminal.
pub(crate) struct Bar {
    bar: ProgressBar,
}

/// Lines of JSON on standard output, until the reader closes the pipe.
#[derive(Debug, Default)]
pub(crate) struct Lines {
    /// Set after the first failed write; nothing more is written.
    is_over: bool,
    /// The error of that write, unless the reader just closed the pipe.
    pub(crate) problem: Option<io::Error>,
}

impl Lines {
    /// Writes a line. A closed pipe is not an error.
    pub(crate) fn tell(&mut self, step: &Step) {
        if self.is_over {
            return;
        }
        let line = serde_json::to_string(step).unwrap_or_default(); // cannot fail: a step is all numbers
        let mut out = io::stdout().lock();
        if let Err(error) = writeln!(out, "{line}").and_then(|()| out.flush()) {
            self.is_over = true;
            self.problem = (error.kind() != ErrorKind::BrokenPipe).then_some(error);
        }
    }
}

impl Bar {
    /// A bar for `iterations` iterations, hidden if `quiet`.
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
        // Keeps the clock running during a long iteration.
        bar.enable_steady_tick(Duration::from_millis(250));
        logs::make_room(Some(bar.clone()));
        Self { bar }
    }

    /// Whether the bar draws nothing.
    pub(crate) fn is_hidden(&self) -> bool {
        self.bar.is_hidden()
    }

    /// Shows the state of the render after an iteration.
    pub(crate) fn show(&self, step: &Step) {
        self.bar.set_message(message(step, self.bar.elapsed().as_secs_f64()));
        self.bar.set_position(step.iteration.into());
    }

    /// Shows that `done` steps are over and that `what` is running.
    pub(crate) fn step(&self, done: u32, what: &str) {
        self.bar.set_message(what.to_owned());
        self.bar.set_position(done.into());
    }

    /// Removes the bar from the terminal.
    pub(crate) fn clear(&self) {
        logs::make_room(None);
        self.bar.finish_and_clear();
    }
}

/// The speed, the mean radius if the engine traces photons, and the estimated error if known.
fn message(step: &Step, seconds: f64) -> String {
    let per_second = |count: u64| scaled(count as f64 / seconds.max(f64::MIN_POSITIVE));
    let error = step.estimated_error.map_or(String::new(), |error| format!("  error {error:.4}"));
    match step.mean_radius {
        Some(mean) => format!("{} photons/s  mean radius {mean:.4}{error}", per_second(step.photons)),
        None => format!("{} segments/s{error}", per_second(step.camera_segments)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn step(mean_radius: Option<f64>) -> Step {
        Step { iteration: 3, photons: 3_000_000, camera_segments: 500, mean_radius, ..Step::default() }
    }

    #[test]
    fn photons_and_mean_radius_are_shown() {
        let message = message(&step(Some(1.5)), 2.0);
        assert_eq!(message, "1.50M photons/s  mean radius 1.5000");
    }

    #[test]
    fn a_path_tracer_has_no_radius() {
        let step = Step { estimated_error: Some(0.25), ..step(None) };
        assert_eq!(message(&step, 2.0), "250 segments/s  error 0.2500");
    }

    #[test]
    fn the_bar_follows_the_iterations() {
        let progress = Bar::new(10, false);
        progress.show(&step(None));
        assert_eq!(progress.bar.position(), 3);
        progress.clear();
        assert!(progress.bar.is_finished());
    }
}
