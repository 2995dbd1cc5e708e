//! Runs a render for `render` and `resume`: shows its progress, obeys signals, and reports the outcome.

use crate::args::messages::MessageArgs;
use crate::terminal::bar::{Bar, Lines, Progress};
use crate::terminal::error::Error;
use crate::terminal::signals::Requests;
use render::{End, Job, Notice, Observer, Outcome, Report, Step};
use scene::settings::MAX_ITERATIONS;
use scene::text::{counted, duration, list, mebibytes};
use scene::{Resumable, Settings, Stats};
use std::io;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use tracing::{debug, info, warn};

/// Runs `job` to its end and reports what became of it.
pub(crate) fn run(mut job: Job, messages: &MessageArgs) -> Result<(), Error> {
    let requests = Requests::listen()?;
    // The command does not show intermediate images.
    (job.live, job.stop) = (false, requests.stop().clone());
    let is_json = messages.progress == Progress::Json;
    let problem = Problem::default();
    let watch = Watch {
        bar: None,
        has_bar: !(messages.quiet || is_json),
        lines: is_json.then(Lines::default),
        problem: problem.clone(),
        requests: requests.clone(),
    };
    let outcome = job.start(watch)?.wait()?;
    conclude(&outcome, &requests)?;
    // The image is written, but lines of progress were lost: fail, so that their reader does not miss it.
    match problem.lock().unwrap_or_else(PoisonError::into_inner).take() {
        Some(error) => Err(Error::Failed(format!("cannot write to standard output: {error}"))),
        None => Ok(()),
    }
}

/// Why lines of progress could not be written.
type Problem = Arc<Mutex<Option<io::Error>>>;

/// The observer of the render; it is called on the render's thread.
struct Watch {
    /// Set when the render begins.
    bar: Option<Bar>,
    has_bar: bool,
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
                tell_beginning(notice);
                self.bar = self.has_bar.then(|| Bar::new(settings.iterations, false));
            }
            Notice::Resumed { path, iterations, of, fallback } => {
                if let Some(fault) = fallback {
                    warn!("{fault}; going on from the older generation");
                }
                let path = path.display();
                let of = if *of == MAX_ITERATIONS { String::new() } else { format!(" of {of}") };
                info!(iterations, "going on from {path} after {iterations}{of} iterations");
            }
            Notice::Saved { iterations } => {
                debug!(iterations, "saved after {}", counted(*iterations, "iteration"));
            }
            Notice::NotSaved(error) | Notice::NotRefreshed(error) => warn!("{error}; rendering goes on"),
            Notice::NotLocked(error) => warn!("{error}; let no other render write it"),
            Notice::NoSnapshot(error) => warn!("{error}"),
        }
    }

    fn stopped_by(&self) -> &'static str {
        self.requests.pending().map_or("stop", |signal| signal.name())
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
        "wrote {written}: {iterations} in {seconds}{why}"
    );
    Ok(())
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
