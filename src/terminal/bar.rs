//! Shows the progress of a render: a bar on standard error, or lines of JSON on standard output.

use super::line::Work;
use super::logs;
use clap::ValueEnum;
use indicatif::style::ProgressTracker;
use indicatif::{ProgressBar, ProgressState, ProgressStyle};
use render::Step;
use scene::Meter;
use scene::text::scaled;
use std::fmt;
use std::io::{self, ErrorKind, Write};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use terminal_size::{Width, terminal_size_of};

/// How progress is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum Progress {
    /// A bar on standard error, if that is a terminal
    #[default]
    Bar,
    /// A JSON object per iteration on standard output
    Json,
}

/// How often the bar is drawn anew, as time goes on and within a long iteration.
const TICK: Duration = Duration::from_millis(200);
/// The columns of a terminal that does not tell how many it has.
const USUAL_COLUMNS: usize = 80;

/// A bar on standard error; draws nothing if standard error is not a terminal.
pub(crate) struct Bar {
    shown: ProgressBar,
    work: Arc<Mutex<Work>>,
    began: Instant,
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
    /// A bar for `work`, whose current step is measured by `meter`.
    pub(crate) fn new(work: Work, meter: Meter) -> Self {
        let (work, began) = (Arc::new(Mutex::new(work)), Instant::now());
        let line = Line { work: Arc::clone(&work), meter, began };
        let style =
            ProgressStyle::with_template("{line}").expect("the template is valid: a test makes a bar");
        let bar = ProgressBar::new(1).with_style(style.with_key("line", line));
        logs::make_room(Some(bar.clone()));
        bar.enable_steady_tick(TICK);
        Self { shown: bar, work, began }
    }

    /// A bar for `count` things called `noun`.
    pub(crate) fn of(count: u32, noun: &'static str) -> Self {
        Self::new(Work { noun, all: Some(count), ..Work::default() }, Meter::default())
    }

    /// A bar for something that takes long, of which no more is known than `what` it is.
    pub(crate) fn wait(what: String) -> Self {
        Self::new(Work { facts: vec![what], ..Work::default() }, Meter::default())
    }

    /// Whether the bar draws nothing.
    pub(crate) fn is_hidden(&self) -> bool {
        self.shown.is_hidden()
    }

    /// Shows that a render goes on after `done` iterations.
    pub(crate) fn go_on_after(&self, done: u32) {
        let mut work = lock(&self.work);
        (work.done, work.began_at) = (done, done);
    }

    /// Shows the state of the render after an iteration.
    pub(crate) fn show(&self, step: &Step) {
        let mut work = lock(&self.work);
        let seconds = self.began.elapsed().saturating_sub(work.prepared).as_secs_f64();
        (work.done, work.facts) = (step.iteration, facts(step, work.began_at, seconds));
        drop(work);
        self.shown.tick();
    }

    /// Shows that `done` steps are over and that `what` is running.
    pub(crate) fn step(&self, done: u32, what: &str) {
        let mut work = lock(&self.work);
        (work.done, work.facts) = (done, vec![what.to_owned()]);
        drop(work);
        self.shown.tick();
    }

    /// What it tells, but for what its meter measures.
    #[cfg(test)]
    pub(crate) fn line(&self) -> String {
        lock(&self.work).line(200)
    }

    /// Removes the bar from the terminal.
    pub(crate) fn clear(&self) {
        logs::make_room(None);
        self.shown.finish_and_clear();
    }
}

/// The text of the bar, made anew whenever it is drawn.
#[derive(Clone)]
struct Line {
    work: Arc<Mutex<Work>>,
    meter: Meter,
    began: Instant,
}

impl Line {
    /// What is shown now, on a terminal of `columns` columns.
    fn text(&self, columns: usize) -> String {
        let (within, elapsed) = (self.meter.share(), self.began.elapsed());
        let mut work = Work { within, elapsed, ..lock(&self.work).clone() };
        if let Some(share) = self.meter.preparation() {
            work = work.preparing(share);
            lock(&self.work).prepared = elapsed;
        }
        work.line(columns)
    }
}

impl ProgressTracker for Line {
    fn clone_box(&self) -> Box<dyn ProgressTracker> {
        Box::new(self.clone())
    }

    fn tick(&mut self, _: &ProgressState, _: Instant) {}

    fn reset(&mut self, _: &ProgressState, _: Instant) {}

    fn write(&self, _: &ProgressState, out: &mut dyn fmt::Write) {
        let columns =
            terminal_size_of(io::stderr()).map_or(USUAL_COLUMNS, |(Width(columns), _)| columns.into());
        let _ = out.write_str(&self.text(columns)); // writing to a String cannot fail
    }
}

fn lock(work: &Mutex<Work>) -> MutexGuard<'_, Work> {
    work.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The speed, the estimated error if known, and the mean radius if the engine traces photons. `seconds` are those of this
/// session, which began after `began_at` iterations: the work of earlier ones took none of them.
fn facts(step: &Step, began_at: u32, seconds: f64) -> Vec<String> {
    let here = step.iteration.saturating_sub(began_at);
    let share = f64::from(here) / f64::from(step.iteration.max(1));
    let per_second = |count: u64| scaled(share * count as f64 / seconds.max(f64::MIN_POSITIVE));
    let speed = match step.mean_radius {
        Some(_) => format!("{} photons/s", per_second(step.photons)),
        None => format!("{} segments/s", per_second(step.camera_segments)),
    };
    let error = step.estimated_error.map(|error| format!("error {error:.4}"));
    let radius = step.mean_radius.map(|mean| format!("mean radius {mean:.4}"));
    error.into_iter().chain([speed]).chain(radius).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn step(mean_radius: Option<f64>) -> Step {
        Step { iteration: 3, photons: 3_000_000, camera_segments: 500, mean_radius, ..Step::default() }
    }

    #[test]
    fn photons_and_mean_radius_are_shown() {
        assert_eq!(facts(&step(Some(1.5)), 0, 2.0), ["1.50M photons/s", "mean radius 1.5000"]);
    }

    /// Of three iterations, two were done before.
    #[test]
    fn the_photons_of_earlier_sessions_do_not_count_as_speed() {
        assert_eq!(facts(&step(Some(1.5)), 2, 2.0)[0], "500k photons/s");
        assert_eq!(facts(&step(None), 2, 2.0), ["83.3 segments/s"]);
        assert_eq!(facts(&step(Some(1.5)), 3, 2.0)[0], "0.00 photons/s");
    }

    #[test]
    fn a_path_tracer_has_no_radius() {
        let step = Step { estimated_error: Some(0.25), ..step(None) };
        assert_eq!(facts(&step, 0, 2.0), ["error 0.2500", "250 segments/s"]);
    }

    /// Where standard error is no terminal, nothing is drawn and nobody follows the render for it.
    #[test]
    fn a_bar_is_for_terminals() {
        use std::io::IsTerminal as _;
        assert_eq!(Bar::of(10, "iterations").is_hidden(), !io::stderr().is_terminal());
    }

    #[test]
    fn the_bar_follows_the_iterations() {
        let bar = Bar::of(10, "iterations");
        bar.go_on_after(2);
        bar.show(&step(None));
        let work = lock(&bar.work).clone();
        assert_eq!((work.done, work.began_at, work.all), (3, 2, Some(10)));
        // If all of the time so far was preparation, the iteration took none of it.
        lock(&bar.work).prepared = Duration::from_secs(1_000_000);
        bar.show(&step(None));
        assert_eq!(lock(&bar.work).facts, facts(&step(None), 2, 0.0));
        bar.clear();
        assert!(bar.shown.is_finished());
    }

    #[test]
    fn a_bar_tells_what_runs_and_how_much_is_done() {
        let bar = Bar::of(4, "points");
        let work = || lock(&bar.work).clone();
        assert_eq!((work().noun, work().all, work().done), ("points", Some(4), 0));
        bar.step(3, "the last");
        assert_eq!((work().done, work().facts), (3, vec!["the last".to_owned()]));
        assert!(!bar.shown.is_finished());
        bar.clear();
        let waiting = Bar::wait("reading a.toml".into());
        let work = lock(&waiting.work).clone();
        assert_eq!((work.noun, work.all, work.facts), ("", None, vec!["reading a.toml".to_owned()]));
        waiting.clear();
    }

    /// Iterations begin when the preparation ends: its time is not theirs.
    #[test]
    fn the_text_follows_the_meter() {
        let meter = Meter::default();
        let work = Arc::new(Mutex::new(Work { noun: "iterations", all: Some(4), ..Work::default() }));
        let line = Line { work: Arc::clone(&work), meter: meter.clone(), began: Instant::now() };
        assert!(line.text(60).contains(" 0/4 iterations  "), "{}", line.text(60));
        meter.prepare(8);
        meter.advance(2);
        assert!(line.text(60).starts_with("preparing, 25 %"), "{}", line.text(60));
        let prepared = lock(&work).prepared;
        assert!(prepared > Duration::ZERO);
        meter.begin(4);
        meter.advance(2);
        lock(&work).done = 1;
        assert!(line.text(80).starts_with("[########") && line.text(80).contains(" 1/4 iterations  "));
        assert_eq!(lock(&work).prepared, prepared);
    }
}
