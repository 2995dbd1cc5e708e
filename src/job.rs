//! A render from its first iteration here to its last file.

use crate::args::MessageArgs;
use crate::budget::{Clock, Estimate, Goals, photons};
use crate::checkpoints::{Keeper, Note, Plan};
use crate::engines::{Chosen, LanesName};
use crate::error::Error;
use crate::interrupt::Requests;
use crate::memory::{self, Need, mebibytes};
use crate::metadata::{self, Metadata};
use crate::outputs::{Outputs, Shown};
use crate::progress::{self, Lines, Progress, Step};
use crate::report::Report;
use crate::session::{self, End};
use crate::text::{counted, duration};
use crate::threads;
use files::checkpoint::Loaded;
use files::scene_file;
use scene::settings::MAX_ITERATIONS;
use scene::{Resumable, Scene, Settings, Stats};
use std::time::Duration;
use tracing::{debug, info, warn};

/// What is to be rendered, and where to.
pub(crate) struct Job {
    /// The scene, whose settings are those of the render.
    pub scene: Scene,
    pub engine: Chosen,
    pub threads: Option<usize>,
    pub memory_limit: Option<u64>,
    pub outputs: Outputs,
    pub goals: Goals,
    /// Where it is saved, if it is.
    pub plan: Option<Plan>,
    /// Where it goes on from, if it does.
    pub from: Option<Loaded>,
}

impl Job {
    /// Renders, and writes the files that were asked for. Everything that can be refused is refused before.
    pub(crate) fn run(mut self, messages: &MessageArgs) -> Result<(), Error> {
        let requests = Requests::listen()?;
        let threads = threads::start(self.threads)?;
        let has_past = self.goals.error.is_some();
        let need = Need::new(self.engine, &self.scene, threads, has_past, self.memory_limit)?;
        self.outputs.check_room(self.scene.settings.pixels() as u64)?;
        introduce(&self.scene, self.engine, threads, need);
        let digest = scene_file::digest(&self.scene);
        let resumed_after = self.from.as_ref().map_or(0, |from| from.checkpoint.account.iterations);
        let keeper = self.keeper(&digest)?;
        let mut engine = self.engine.start(&self.scene, &self.scene.settings, need.deposits);
        let mut estimate = Estimate::default();
        if let Some(from) = &mut self.from {
            from.restore(&mut *engine).map_err(|error| Error::BadInput(error.to_string()))?;
            estimate = Estimate::after(from.checkpoint.past.take().filter(|_| has_past));
            tell_where(from, &self.scene.settings);
        }
        let clock = Clock::start(&self.goals);
        let mut watch = Watch {
            job: &self,
            digest,
            keeper,
            estimate,
            progress: Progress::new(self.scene.settings.iterations, messages.quiet || is_json(messages)),
            lines: is_json(messages).then(Lines::default),
            clock: &clock,
        };
        let ended = session::run(&mut *engine, &self.goals, &clock, &requests, |engine, time| {
            watch.after_iteration(engine, time)
        });
        watch.progress.clear();
        let conclusion = Conclusion { end: ended?, threads, need, resumed_after };
        watch.conclude(&*engine, &conclusion)
    }

    /// Who saves the render, if somebody does.
    fn keeper(&mut self, digest: &str) -> Result<Option<Keeper>, Error> {
        let Some(plan) = self.plan.take() else { return Ok(None) };
        let mut note = Note {
            engine: Some(self.engine.name()),
            until_error: self.goals.error,
            every: plan.every,
            keep: plan.keep,
            ..Note::default()
        };
        self.outputs.note(plan.store.path(), &mut note);
        let saved = self.from.as_ref().map(|from| from.checkpoint.account.iterations);
        let keeper = Keeper::new(plan, &self.scene, digest, &note, saved);
        if let Some(path) = keeper.asked_for() {
            // Two generations, and a third on its way.
            let sums = self.engine.name().sums();
            let bytes = 3 * keeper.bytes(&self.scene.settings, sums, self.goals.error.is_some());
            let room = files::atomic_file::check_room(path, bytes);
            room.map_err(|error| Error::BadInput(format!("--checkpoint: {error}")))?;
        }
        Ok(Some(keeper))
    }
}

fn is_json(messages: &MessageArgs) -> bool {
    messages.progress == progress::Shown::Json
}

/// How a session ended, and what it began with.
struct Conclusion {
    end: End,
    threads: usize,
    need: Need,
    resumed_after: u32,
}

/// What happens beside the iterations.
struct Watch<'a> {
    job: &'a Job,
    digest: String,
    keeper: Option<Keeper>,
    estimate: Estimate,
    progress: Progress,
    lines: Option<Lines>,
    clock: &'a Clock,
}

impl Watch<'_> {
    fn after_iteration(&mut self, engine: &dyn Resumable, time: Duration) -> Result<Option<f64>, Error> {
        let iterations = engine.iterations();
        if self.job.goals.error.is_some() {
            self.estimate.update(iterations, || engine.develop());
        }
        if let Err(error) = self.job.outputs.snapshot(iterations, || self.shown(engine)) {
            warn!("{}", error.text());
        }
        let saved = self.save_if_due(engine)?;
        if self.lines.is_some() || !self.progress.is_hidden() {
            let step = Step {
                iterations: engine.settings().iterations,
                seconds: time.as_secs_f64(),
                elapsed_seconds: self.clock.elapsed().as_secs_f64(),
                estimated_error: self.estimate.error,
                saved,
                ..Step::of(engine)
            };
            self.progress.show(&step);
            if let Some(lines) = &mut self.lines {
                lines.tell(&step);
            }
        }
        Ok(self.estimate.error)
    }

    /// Saves the render and refreshes its images, if it is time. What cannot be written is no reason to stop: another
    /// time it may work.
    fn save_if_due(&mut self, engine: &dyn Resumable) -> Result<bool, Error> {
        let iterations = engine.iterations();
        if iterations >= engine.settings().iterations
            || !self.keeper.as_ref().is_some_and(|k| k.is_due(iterations))
        {
            return Ok(false);
        }
        let is_saved = self.save(engine).map_err(|error| warn!("{error}; rendering goes on")).is_ok();
        if is_saved {
            debug!(iterations, "saved after {}", counted(iterations, "iteration"));
        }
        let shown = self.shown(engine)?;
        for error in self.job.outputs.refresh(&shown) {
            warn!("{error}; rendering goes on");
        }
        Ok(is_saved)
    }

    /// Saves the render if it is to be saved at all.
    fn save(&mut self, engine: &dyn Resumable) -> Result<(), files::atomic_file::FileError> {
        let Some(keeper) = &mut self.keeper else { return Ok(()) };
        keeper.save(engine, self.estimate.past())
    }

    /// The same for the last time, where there is room for it.
    fn save_somewhere(&mut self, engine: &dyn Resumable) -> Result<(), files::atomic_file::FileError> {
        let Some(keeper) = &mut self.keeper else { return Ok(()) };
        keeper.save_somewhere(engine, self.estimate.past())
    }

    fn metadata(&self, engine: &dyn Resumable) -> Metadata {
        let (job, done) = (self.job, engine.iterations());
        // An image is what so many iterations make, whatever was asked for.
        let settings = Settings { iterations: done.max(1), ..*engine.settings() };
        Metadata {
            version: env!("CARGO_PKG_VERSION").into(),
            scene: job.scene.name.clone(),
            scene_digest: self.digest.clone(),
            settings,
            photons: if job.engine.name().has_photons() { photons(&settings, done) } else { 0 },
            engine: job.engine.name(),
            lanes: job.engine.lanes(),
            exposure: job.outputs.exposure(),
            estimated_error: self.estimate.error,
            scene_file: metadata::scene_file(&job.scene, &settings),
        }
    }

    fn shown<'a>(&self, engine: &'a dyn Resumable) -> Result<Shown<'a>, Error> {
        Shown::of(engine, &self.metadata(engine))
    }

    /// Writes what there is to write in the end, and says so.
    fn conclude(&mut self, engine: &dyn Resumable, conclusion: &Conclusion) -> Result<(), Error> {
        let signal = match conclusion.end {
            End::Signal(signal) => Some(signal),
            _ => None,
        };
        let done = engine.iterations();
        if let (Some(signal), 0) = (signal, done) {
            let what = "not one iteration was over, so nothing is written";
            return Err(Error::Interrupted(signal, what.into()));
        }
        // The checkpoint first: the image follows from it.
        let unsaved = signal.and_then(|_| self.save_somewhere(engine).err());
        let shown = self.shown(engine)?;
        let report = self.report(engine, conclusion);
        let written = self.job.outputs.write(&shown, &report).map_err(|error| self.lament(engine, error))?;
        account(&report, self.job.outputs.writing());
        let (iterations, seconds) = (counted(done, "iteration"), duration(report.wall_seconds));
        if let Some(signal) = signal {
            let all = match engine.settings().iterations {
                MAX_ITERATIONS => iterations,
                all => format!("{done} of {}", counted(all, "iteration")),
            };
            let unsaved = unsaved.map_or(String::new(), |error| format!("; {error}"));
            let next = unsaved + &self.how_to_go_on().unwrap_or_default();
            return Err(Error::Interrupted(
                signal,
                format!("wrote {written} after {all} in {seconds}{next}"),
            ));
        }
        self.finish(engine)?;
        let why = match (conclusion.end, self.estimate.error) {
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
        self.check_lines()
    }

    /// Everything is written, so the checkpoint has served.
    fn finish(&mut self, engine: &dyn Resumable) -> Result<(), Error> {
        let Some(keeper) = &mut self.keeper else { return Ok(()) };
        let failed = |error| Error::Failed(format!("the image is written, but not its checkpoint: {error}"));
        keeper.finish(engine, self.estimate.past()).map_err(failed)
    }

    /// What to say when a file could not be written: what is left of the render, and how to go on.
    fn lament(&mut self, engine: &dyn Resumable, error: Error) -> Error {
        let Error::Failed(problem) = error else { return error };
        // Where neither can be written, the last checkpoint is what is left.
        let _ = self.save_somewhere(engine);
        let elsewhere =
            self.how_to_go_on().map_or(String::new(), |how| format!("{how}, by -o to another image"));
        Error::Failed(format!("{problem}{elsewhere}"))
    }

    fn how_to_go_on(&self) -> Option<String> {
        let (path, iterations) = self.keeper.as_ref()?.saved()?;
        let done = counted(iterations, "iteration");
        Some(format!("; `sppm resume {}` goes on after {done}", path.display()))
    }

    /// The image is written, but those who follow the progress were not told.
    fn check_lines(&mut self) -> Result<(), Error> {
        match self.lines.as_mut().and_then(|lines| lines.problem.take()) {
            Some(error) => Err(Error::Failed(format!("cannot write to standard output: {error}"))),
            None => Ok(()),
        }
    }

    fn report(&self, engine: &dyn Resumable, conclusion: &Conclusion) -> Report {
        let job = self.job;
        Report {
            version: env!("CARGO_PKG_VERSION"),
            scene: job.scene.name.clone(),
            engine: job.engine.name(),
            lanes: job.engine.lanes(),
            threads: conclusion.threads,
            settings: *engine.settings(),
            iterations: engine.iterations(),
            interrupted: matches!(conclusion.end, End::Signal(_)),
            ended_by: conclusion.end.name(),
            resumed_after: conclusion.resumed_after,
            estimated_error: self.estimate.error,
            wall_seconds: self.clock.elapsed().as_secs_f64(),
            write_seconds: self.job.outputs.writing().as_secs_f64(),
            bytes_at_most: conclusion.need.bytes,
            peak_bytes: memory::peak(),
            stats: *engine.stats(),
        }
    }
}

fn tell_where(from: &Loaded, settings: &Settings) {
    if let Some(fault) = &from.fallback {
        warn!("{fault}; going on from the older generation");
    }
    let (path, done) = (from.path.display(), from.checkpoint.account.iterations);
    let all = if settings.iterations == MAX_ITERATIONS {
        String::new()
    } else {
        format!(" of {}", settings.iterations)
    };
    info!(iterations = done, "going on from {path} after {done}{all} iterations");
}

fn introduce(scene: &Scene, engine: Chosen, threads: usize, need: Need) {
    let Settings { width, height, iterations, photons_per_iteration, max_depth, initial_radius, seed } =
        scene.settings;
    let lanes =
        engine.lanes().map_or(String::new(), |lanes: LanesName| format!(" on {} lanes", lanes.name()));
    let iterations = match iterations {
        MAX_ITERATIONS => "iterations without end".into(),
        n => counted(n, "iteration"),
    };
    debug!(
        bytes_at_most = need.bytes,
        "{}: {width} x {height} pixels, {iterations}, {} each, depth {max_depth}, radius {initial_radius}, seed {seed}; \
         engine {}{lanes}, {}; up to {}",
        scene.name,
        counted(photons_per_iteration, "photon"),
        engine.name().name(),
        counted(threads as u64, "thread"),
        mebibytes(need.bytes),
    );
}

/// Where time and memory went.
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
