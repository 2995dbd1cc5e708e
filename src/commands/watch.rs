//! Runs a render for `render` and `resume`: shows its progress, obeys signals, and reports the outcome.

use crate::args::messages::MessageArgs;
use crate::terminal::bar::{Bar, Lines, Progress};
use crate::terminal::busy::Busy;
use crate::terminal::error::Error;
use crate::terminal::line::Work;
use crate::terminal::logs;
use crate::terminal::signals::Requests;
use files::atomic_file::{FileError, reason};
use render::{End, Job, Notice, Observer, Outcome, Report, Step};
use scene::settings::MAX_ITERATIONS;
use scene::text::{counted, duration, list, mebibytes};
use scene::{Resumable, Settings, Stats};
use std::collections::HashMap;
use std::io;
use std::mem::take;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use tracing::{debug, info, warn};

/// Runs `job` to its end and reports what became of it.
pub(crate) fn run(mut job: Job, messages: &MessageArgs) -> Result<(), Error> {
    let is_json = messages.progress == Progress::Json;
    if is_json && job.outputs.stream.is_some() {
        let problem = "--progress json: standard output is taken by --output; write the image to a file";
        return Err(Error::BadInput(problem.into()));
    }
    let requests = Requests::listen()?;
    // The command does not show intermediate images.
    (job.live, job.stop) = (false, requests.stop().clone());
    let problem = Problem::default();
    let watch = Watch {
        busy: (!is_json).then(|| Busy::with("preparing the render")),
        bar: None,
        has_bar: !is_json && logs::has_bars(),
        limit: job.goals.time,
        told: Told::default(),
        lines: is_json.then(Lines::default),
        problem: problem.clone(),
        requests: requests.clone(),
    };
    let outcome = job.start(watch)?.wait()?;
    conclude(&outcome, &requests)?;
    // The image is written, but lines of progress were lost: fail, so that their reader does not miss it.
    match problem.lock().unwrap_or_else(PoisonError::into_inner).take() {
        Some(error) => Err(Error::Failed(format!("cannot write to standard output: {}", reason(&error)))),
        None => Ok(()),
    }
}

/// Why lines of progress could not be written.
type Problem = Arc<Mutex<Option<io::Error>>>;

/// The observer of the render; it is called on the render's thread.
struct Watch {
    /// Until the render begins.
    busy: Option<Busy>,
    /// From then on.
    bar: Option<Bar>,
    has_bar: bool,
    /// The time limit of the render.
    limit: Option<Duration>,
    told: Told,
    lines: Option<Lines>,
    problem: Problem,
    requests: Requests,
}

impl Observer for Watch {
    fn follows(&self) -> bool {
        self.lines.is_some() || self.bar.as_ref().is_some_and(|bar| !bar.is_hidden())
    }

    fn after(&mut self, step: &Step, _: &dyn Resumable) {
        if let Some(bar) = &self.bar {
            bar.show(step);
        }
        if let Some(lines) = &mut self.lines {
            lines.tell(step);
            if let Some(error) = lines.problem.take() {
                *self.problem.lock().unwrap_or_else(PoisonError::into_inner) = Some(error);
            }
        }
    }

    fn notice(&mut self, notice: &Notice) {
        match notice {
            Notice::Begun { settings, .. } => {
                self.busy = None;
                tell_beginning(notice);
                self.bar = self.has_bar.then(|| self.new_bar(settings));
            }
            Notice::Resumed { path, iterations, of, fallback } => {
                if let Some(fault) = fallback {
                    warn!("{fault}; going on from the older generation");
                }
                if let Some(bar) = &self.bar {
                    bar.go_on_after(*iterations);
                }
                let path = path.display();
                let of = if *of == MAX_ITERATIONS { String::new() } else { format!(" of {of}") };
                info!(iterations, "going on from {path} after {iterations}{of} iterations");
            }
            Notice::Saved { iterations } => {
                let after = counted(*iterations, "iteration");
                if self.told.is_mended() {
                    info!(iterations, "saved again, after {after}");
                } else {
                    debug!(iterations, "saved after {after}");
                }
            }
            Notice::NotSaved(error) if self.told.is_new(&error.path, error) => {
                self.told.is_unsaved = true;
                warn!("{error}; rendering goes on");
            }
            Notice::NotRefreshed(error) if self.told.is_new(&error.path, error) => {
                warn!("{error}; rendering goes on");
            }
            // Every snapshot is another file, and all of them fail alike.
            Notice::NoSnapshot(error) if self.told.is_new(Path::new("snapshots"), error) => {
                warn!("{error}; rendering goes on");
            }
            Notice::NotSaved(_) | Notice::NotRefreshed(_) | Notice::NoSnapshot(_) => {}
            Notice::NotLocked(error) => warn!("{error}; let no other render write it"),
        }
    }

    fn stopped_by(&self) -> &'static str {
        self.requests.pending().map_or("stop", |signal| signal.name())
    }
}

impl Watch {
    fn new_bar(&self, settings: &Settings) -> Bar {
        let all = (settings.iterations != MAX_ITERATIONS).then_some(settings.iterations);
        let work = Work { noun: "iterations", all, limit: self.limit, ..Work::default() };
        Bar::new(work, self.requests.stop().meter().clone())
    }
}

/// The warnings that were given, so that what fails again and again, as on a full disk, is told once.
#[derive(Default)]
struct Told {
    problems: HashMap<PathBuf, String>,
    /// Whether the last checkpoint could not be written.
    is_unsaved: bool,
}

impl Told {
    /// Whether `error` is another than the last one of the same `subject`.
    fn is_new(&mut self, subject: &Path, error: &FileError) -> bool {
        let last = self.problems.insert(subject.to_owned(), error.problem.clone());
        last.is_none_or(|last| last != error.problem)
    }

    /// Whether a checkpoint was written after one that could not be. What fails after that is told anew.
    fn is_mended(&mut self) -> bool {
        let is_mended = take(&mut self.is_unsaved);
        if is_mended {
            self.problems.clear();
        }
        is_mended
    }
}

impl Drop for Watch {
    /// Clears the bar when the render is over.
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.clear();
        }
    }
}

fn tell_beginning(notice: &Notice) {
    let Notice::Begun { scene, settings, engine, lanes, threads, bytes_at_most } = notice else { return };
    let Settings { width, height, iterations, photons_per_iteration, max_depth, initial_radius, seed } =
        settings;
    let lanes = lanes.map_or(String::new(), |lanes| format!(" on {} lanes", lanes.name()));
    let iterations = match *iterations {
        MAX_ITERATIONS => "iterations without end".into(),
        n => counted(n, "iteration"),
    };
    debug!(
        bytes_at_most,
        "{scene}: {width} x {height} pixels, {iterations}, {} each, depth {max_depth}, radius {initial_radius}, seed \
         {seed}; engine {}{lanes}, {}; up to {}",
        counted(*photons_per_iteration, "photon"),
        engine.name(),
        counted(*threads as u64, "thread"),
        mebibytes(*bytes_at_most),
    );
}

/// Reports what the render wrote and why it ended.
fn conclude(outcome: &Outcome, requests: &Requests) -> Result<(), Error> {
    let Outcome { end, report, unsaved, written, failed, .. } = outcome;
    let signal = requests.pending().filter(|_| *end == End::Stopped);
    let done = report.iterations;
    if let (Some(signal), 0) = (signal, done) {
        let what = "not one iteration was over, so nothing is written";
        return Err(Error::Interrupted(signal, what.into()));
    }
    let written = list(&written.iter().map(|path| path.display()).collect::<Vec<_>>());
    if !failed.is_empty() {
        return Err(lament(outcome, &written));
    }
    account(report, outcome.writing);
    let (iterations, seconds) = (counted(done, "iteration"), duration(report.wall_seconds));
    if let Some(signal) = signal {
        let all = match report.settings.iterations {
            MAX_ITERATIONS => iterations,
            all => format!("{done} of {}", counted(all, "iteration")),
        };
        let unsaved = unsaved.as_ref().map_or(String::new(), |error| format!("; {error}"));
        let next = how_to_go_on(outcome).unwrap_or_default();
        let text = format!("wrote {written} after {all} in {seconds}{unsaved}{next}");
        return Err(Error::Interrupted(signal, text));
    }
    if let Some(error) = unsaved {
        return Err(Error::Failed(format!("the image is written, but not its checkpoint: {error}")));
    }
    let why = match (end, report.estimated_error) {
        (End::Time, _) => "; time is up".into(),
        (End::Error, Some(error)) => format!("; the estimated error is {error:.3e}"),
        _ => String::new(),
    };
    info!(
        iterations = done,
        wall_seconds = report.wall_seconds,
        ended_by = report.ended_by,
        "wrote {written}: {iterations} in {seconds}{why}{}",
        hint(outcome),
    );
    Ok(())
}

/// What to do about an image with visible noise.
fn hint(outcome: &Outcome) -> String {
    /// From this relative error on, noise is seen at once.
    const NOISY: f64 = 0.1;
    /// At this one, it is hardly seen.
    const SMOOTH: f64 = 0.05;
    /// The error falls about as this power of the time (docs/lasting.md).
    const RATE: f64 = 0.4;
    let is_asked_for = outcome.end == End::Error;
    let Some(noise) = outcome.noise.filter(|noise| *noise > NOISY && !is_asked_for) else {
        return String::new();
    };
    let seconds = outcome.report.wall_seconds * (noise / SMOOTH).powf(1.0 / RATE);
    format!(
        "; it is noisy, with an error of about {noise:.2}: `--time {}` gives a smoother one",
        at_least(seconds)
    )
}

/// The next round time, with its unit as `--time` takes it.
fn at_least(seconds: f64) -> String {
    const TIMES: [(f64, &str); 15] = [
        (1.0, "1s"),
        (2.0, "2s"),
        (5.0, "5s"),
        (10.0, "10s"),
        (20.0, "20s"),
        (30.0, "30s"),
        (60.0, "1m"),
        (120.0, "2m"),
        (300.0, "5m"),
        (600.0, "10m"),
        (1200.0, "20m"),
        (1800.0, "30m"),
        (3600.0, "1h"),
        (7200.0, "2h"),
        (18000.0, "5h"),
    ];
    match TIMES.iter().find(|(time, _)| *time >= seconds) {
        Some((_, text)) => (*text).into(),
        None => format!("{:.0}h", (seconds / 3600.0).ceil()),
    }
}

/// The error for files that could not be written: what was saved instead, and how to resume.
fn lament(outcome: &Outcome, written: &str) -> Error {
    let problems = outcome.failed.iter().map(|unwritten| match &unwritten.refuge {
        Some(refuge) => format!("{}; it is in {} instead", unwritten.error, refuge.display()),
        None => unwritten.error.to_string(),
    });
    let problems = problems.collect::<Vec<_>>().join("; ");
    let rest = if written.is_empty() { String::new() } else { format!("; wrote {written}") };
    let elsewhere =
        how_to_go_on(outcome).map_or(String::new(), |how| format!("{how}, by -o to another image"));
    Error::Failed(format!("{problems}{rest}{elsewhere}"))
}

fn how_to_go_on(outcome: &Outcome) -> Option<String> {
    let saved = outcome.saved.as_ref()?;
    let done = counted(saved.iterations, "iteration");
    Some(format!("; `sppm resume {}` goes on after {done}", saved.path.display()))
}

/// Logs the time of each pass and the memory used.
fn account(report: &Report, writing: Duration) {
    let Stats { camera_seconds, build_grid_seconds, photon_seconds, consolidate_seconds, bytes, .. } =
        report.stats;
    let passes = [
        ("camera pass", camera_seconds),
        ("grid", build_grid_seconds),
        ("photon pass", photon_seconds),
        ("consolidation", consolidate_seconds),
        ("developing and writing", writing.as_secs_f64()),
    ];
    let times: Vec<String> =
        passes.iter().map(|(name, seconds)| format!("{name} {}", duration(*seconds))).collect();
    debug!(bytes, peak_bytes = report.peak_bytes, "{}; {}", times.join(", "), mebibytes(bytes));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn round_times_are_no_shorter() {
        for (seconds, text) in [(0.1, "1s"), (13.4, "20s"), (20.0, "20s"), (61.0, "2m"), (1e5, "28h")] {
            assert_eq!(at_least(seconds), text);
        }
    }

    #[test]
    fn a_warning_is_given_once_until_something_changes() {
        let mut told = Told::default();
        let (path, error) = (Path::new("a"), |problem: &str| FileError::new(Path::new("a"), problem));
        assert!(told.is_new(path, &error("full")) && !told.is_new(path, &error("full")));
        assert!(told.is_new(Path::new("b"), &error("full")));
        assert!(told.is_new(path, &error("gone")) && told.is_new(path, &error("full")));
        assert!(!told.is_mended() && !told.is_new(path, &error("full")));
        told.is_unsaved = true;
        assert!(told.is_mended() && !told.is_mended() && told.is_new(path, &error("full")));
    }
}
