//! The main loop of a render, from the first iteration to the last output file, on the render's own thread.
//!
//! A stop request or the time limit abandons the current iteration instead of waiting for it. The engine then holds the
//! state after the last complete iteration.

use crate::automatic::{Bias, first_bias};
use crate::backdrop::{Backdrop, scene_behind};
use crate::error::{Error, Field};
use crate::estimate::{Estimate, is_checked};
use crate::goals::Clock;
use crate::image::Image;
use crate::job::{Job, Repeats};
use crate::keeper::Keeper;
use crate::memory;
use crate::metadata::Metadata;
use crate::noise::{Noise, mean_square_radius};
use crate::observer::{Notice, Observer};
use crate::outcome::{End, Outcome, Unwritten};
use crate::prepare::Ready;
use crate::report::Report;
use crate::snapshot::{Snapshot, Window};
use crate::step::Step;
use crate::writer::{Shown, Writer};
use fast::Parts;
use files::atomic_file::FileError;
use files::checkpoint::{Loaded, Past};
use files::lock::Lock;
use scene::{Iterations, Resumable, Scene, Spheres, Stop, TRANSPORT};
use std::mem::{replace, take};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread;
use std::time::{Duration, Instant};

/// The mean of the squared radii of all iterations, over that of the last: they fall as `i^(-1/3)`, whose mean is 3/2 of the
/// last. The bias of the image is that of their mean.
const AVERAGE_OF_SQUARES: f64 = 1.5;

/// Runs a prepared job on its thread pool.
pub(crate) fn run(ready: Ready, observer: &mut dyn Observer, window: &Window) -> Result<Outcome, Error> {
    let Ready { mut job, pool, need, digest, locks, keeper, from } = ready;
    // The engine borrows the scene. Move it out of the job, which is returned to the caller.
    let nothing = Scene {
        spheres: Spheres::default(),
        materials: Vec::new(),
        name: String::new(),
        imports: Vec::new(),
        ..job.scene
    };
    let scene = replace(&mut job.scene, nothing);
    let behind = scene_behind(&scene);
    let (threads, mut parts) = (pool.current_num_threads(), take(&mut job.warm.parts));
    let ended = pool.install(|| {
        let mut session = Session {
            clock: Clock::start(&job.goals),
            writer: Writer::new(job.outputs.clone()),
            job: &job,
            scene: &scene,
            backdrop: behind.as_ref().map(|behind| Backdrop::new(behind, scene.background, job.engine)),
            threads,
            bytes_at_most: need.bytes,
            digest,
            keeper,
            estimate: Estimate::default(),
            bias: None,
            blur: 1.0,
            noise: Noise::default(),
            resumed_after: 0,
            done: Iterations::default(),
            observer,
            window,
        };
        session.render(need.deposits, from, &locks, &mut parts)
    });
    drop(locks);
    job.scene = scene;
    // Started again, it begins anew: the checkpoint is not an input any more.
    job.inputs.retain(|(field, _)| *field != Field::Resumed);
    job.warm.keep_pool(job.threads, pool);
    (job.warm.parts, job.stop) = (parts, Stop::new());
    let Ended { end, report, noise, writing, unsaved, keeper, written, failed } = ended?;
    let saved = keeper.and_then(|keeper| keeper.saved());
    let last = window.snapshot();
    Ok(Outcome { end, report, noise, writing, saved, unsaved, written, failed, last, job })
}

/// The results of a session.
struct Ended {
    end: End,
    report: Report,
    noise: Option<f64>,
    writing: Duration,
    unsaved: Option<FileError>,
    keeper: Option<Keeper>,
    written: Vec<PathBuf>,
    failed: Vec<Unwritten>,
}

struct Session<'a> {
    job: &'a Job,
    scene: &'a Scene,
    /// If the background is transparent.
    backdrop: Option<Backdrop<'a>>,
    threads: usize,
    bytes_at_most: u64,
    digest: String,
    keeper: Option<Keeper>,
    writer: Writer,
    estimate: Estimate,
    /// The bias that the image would have if radii stayed as they are at first, if the error is estimated.
    bias: Option<Bias>,
    /// The share of it that is left, as radii have shrunk.
    blur: f64,
    noise: Noise,
    clock: Clock,
    resumed_after: u32,
    /// The iterations in the engine's sums.
    done: Iterations,
    observer: &'a mut dyn Observer,
    window: &'a Window,
}

impl Session<'_> {
    /// Renders with the reusable `parts` of an earlier render, and replaces them with those of this one.
    fn render(
        &mut self,
        deposits: u32,
        from: Option<Loaded>,
        locks: &[Lock],
        parts: &mut Parts,
    ) -> Result<Ended, Error> {
        self.introduce();
        // One is enough: the files of a render are mostly on one file system.
        if let Some(fault) = locks.iter().find_map(Lock::uncertain) {
            self.observer.notice(&Notice::NotLocked(fault.clone()));
        }
        if let Some(other) = self.job.repeats.as_ref().filter(|repeats| repeats.transport != TRANSPORT) {
            let Repeats { path, transport } = other.clone();
            self.observer.notice(&Notice::OtherTransport { path, transport });
        }
        self.bias = self.first_bias();
        let radii = self.bias.as_ref().map(|bias| bias.radii.clone());
        let mut started = self.job.engine.start(self.scene, deposits, take(parts), radii);
        let engine = started.engine();
        if let Some(from) = from {
            self.resume(from, engine)?;
        }
        self.clock = Clock::start(&self.job.goals);
        let end = self.iterate(engine)?;
        let ended = self.conclude(engine, end);
        *parts = started.into_parts();
        Ok(ended)
    }

    /// The bias by which the error is estimated, if there is an error goal and if there is a bias at all.
    fn first_bias(&self) -> Option<Bias> {
        let method = self.job.engine.method();
        if self.job.goals.error.is_none() || !method.has_photons() {
            return None;
        }
        let meter = self.job.stop.meter();
        meter.prepare(1);
        let bias =
            first_bias(self.scene, (method, self.job.engine.lane_kind()), &self.job.stop.child_aside());
        meter.begin(0);
        bias
    }

    /// The estimated relative error: noise and bias.
    fn error(&self) -> Option<f64> {
        let (noise, bias) =
            (self.estimate.error?, self.bias.as_ref().map_or(0.0, |bias| self.blur * bias.relative));
        Some((noise * noise + bias * bias).sqrt())
    }

    fn introduce(&mut self) {
        self.observer.notice(&Notice::Begun {
            scene: self.scene.name.clone(),
            settings: self.scene.settings,
            chosen: self.job.chosen,
            wanted: self.job.wanted().len() as u32,
            renderer: self.job.engine.renderer(),
            lanes: self.job.engine.lanes(),
            threads: self.threads,
            bytes_at_most: self.bytes_at_most,
        });
    }

    fn resume(&mut self, mut from: Loaded, engine: &mut dyn Resumable) -> Result<(), Error> {
        let bad = |error: FileError| Error::input(Field::Resumed, error.to_string());
        from.restore(engine).map_err(bad)?;
        let has_past = self.job.goals.error.is_some();
        self.estimate = Estimate::after(from.checkpoint.past.take().filter(|_| has_past));
        self.resumed_after = from.checkpoint.account.iterations;
        self.done = from.checkpoint.account.done();
        self.observer.notice(&Notice::Resumed {
            path: from.path,
            iterations: self.resumed_after,
            of: self.job.wanted().len() as u32,
            fallback: from.fallback,
        });
        Ok(())
    }

    /// Iterates until all iterations are done, a goal is reached or a stop is requested.
    fn iterate(&mut self, engine: &mut dyn Resumable) -> Result<End, Error> {
        let (job, goals) = (self.job, &self.job.goals);
        // A child of the job's stop: the time limit ends the iteration, but must not count as a stop request.
        let stop = job.stop.child();
        let mut alarm = None;
        loop {
            if job.stop.is_requested() {
                return Ok(End::Stopped);
            }
            let Some(next) = self.done.first_missing(&job.wanted()) else {
                return Ok(End::Iterations);
            };
            if next != engine.progress().next {
                engine.skip_to(next);
            }
            if engine.iterations() > 0 {
                if goals.error.zip(self.error()).is_some_and(|(goal, error)| error <= goal) {
                    return Ok(End::Error);
                }
                match self.clock.left() {
                    Some(Duration::ZERO) => return Ok(End::Time),
                    Some(left) => _ = alarm.get_or_insert_with(|| ring(left, stop.clone())),
                    None => {}
                }
            }
            let began = Instant::now();
            let iterated = catch_unwind(AssertUnwindSafe(|| engine.iterate_unless(&stop)));
            stop.meter().begin(0);
            let broken = "the engine broke down; this is a fault of sppm, please report it";
            if iterated.map_err(|_| Error::failed(broken))? {
                self.done = self.done.with(&(next..next + 1).into());
                self.after_iteration(engine, began.elapsed());
            }
        }
    }

    fn after_iteration(&mut self, engine: &dyn Resumable, time: Duration) {
        self.catch_up();
        let iterations = engine.iterations();
        if self.job.goals.error.is_some() {
            self.estimate.update(iterations, || engine.develop());
            if let Some(bias) = self.bias.as_ref().filter(|_| is_checked(iterations)) {
                self.blur = (AVERAGE_OF_SQUARES * mean_square_radius(engine, &bias.radii)).min(1.0);
            }
        }
        self.noise.update(engine);
        if let Err(error) = self.writer.snapshot(iterations, || self.shown(engine)) {
            self.observer.notice(&Notice::NoSnapshot(error));
        }
        let saved = self.save_if_due(engine);
        let follows = self.observer.follows();
        let step = Step {
            iterations: self.job.wanted().len() as u32,
            seconds: time.as_secs_f64(),
            elapsed_seconds: self.clock.elapsed().as_secs_f64(),
            estimated_error: self.error(),
            saved,
            ..if follows { Step::of(engine) } else { Step::brief(engine) }
        };
        self.window.show_step(step);
        if self.job.live {
            self.window.show_snapshot(Snapshot { iterations, film: engine.develop() });
        }
        if follows {
            self.observer.after(&step, engine);
        }
        self.offer_image(engine, false);
    }

    /// Brings what is seen of the background up to the image, if that has alpha.
    fn catch_up(&mut self) {
        if let Some(backdrop) = &mut self.backdrop {
            backdrop.catch_up(&self.done);
        }
    }

    /// Gives the image to the observer, if it wants it.
    fn offer_image(&mut self, engine: &dyn Resumable, is_last: bool) {
        if self.observer.wants_image(is_last) {
            let (film, radius, count) = (engine.develop(), engine.radius(), engine.count());
            let transparent = self.backdrop.as_ref().map(|backdrop| backdrop.pixels(&film));
            self.observer.image(Image { film, transparent, radius, count, metadata: self.metadata(engine) });
        }
    }

    /// Writes a checkpoint and the images, if it is time. If that fails, the render continues, as the next attempt may
    /// succeed. Returns whether a checkpoint was written.
    fn save_if_due(&mut self, engine: &dyn Resumable) -> bool {
        let iterations = engine.iterations();
        if self.done.first_missing(&self.job.wanted()).is_none()
            || !self.keeper.as_ref().is_some_and(|keeper| keeper.is_due(iterations))
        {
            return false;
        }
        let saved = self.save(engine, Keeper::save);
        let is_saved = saved.is_ok();
        self.observer.notice(&match saved {
            Ok(()) => Notice::Saved { iterations },
            Err(error) => Notice::NotSaved(error),
        });
        for error in self.writer.refresh(&self.shown(engine)) {
            self.observer.notice(&Notice::NotRefreshed(error));
        }
        is_saved
    }

    /// Calls one of the saving methods of [`Keeper`], if checkpoints are written at all.
    fn save(&mut self, engine: &dyn Resumable, way: Way) -> Result<(), FileError> {
        let Some(keeper) = &mut self.keeper else { return Ok(()) };
        way(keeper, self.scene, (engine, &self.done), self.estimate.past())
    }

    fn shown<'b>(&'b self, engine: &'b dyn Resumable) -> Shown<'b> {
        Shown { engine, backdrop: self.backdrop.as_ref(), metadata: self.metadata(engine) }
    }

    fn metadata(&self, engine: &dyn Resumable) -> Metadata {
        let outputs = self.writer.outputs();
        Metadata {
            which: Some(self.done.clone()).filter(|done| !done.are_first()),
            exposure: outputs.exposure,
            tone: outputs.shown_tone(),
            estimated_error: self.error(),
            ..Metadata::of(engine, self.scene, &self.digest, self.job.engine)
        }
    }

    /// Writes the final files. The checkpoint of a stopped render stays; that of a completed render is removed, unless
    /// it is to be kept.
    fn conclude(&mut self, engine: &dyn Resumable, end: End) -> Ended {
        let is_stopped = end == End::Stopped;
        let has_image = engine.iterations() > 0 || !is_stopped;
        self.catch_up();
        // The checkpoint first: the image can be made from it.
        let mut unsaved = None;
        if is_stopped && has_image {
            unsaved = self.save(engine, Keeper::save_somewhere).err();
        }
        if has_image {
            self.offer_image(engine, true);
        }
        let report = self.report(engine, end);
        let (mut written, mut failed) = (Vec::new(), Vec::new());
        if has_image {
            (written, failed) = self.writer.write(&self.shown(engine), &report);
        }
        if !failed.is_empty() {
            // If this fails too, the last checkpoint remains.
            let _ = self.save(engine, Keeper::save_somewhere);
        } else if !is_stopped {
            unsaved = self.save(engine, Keeper::finish).err();
        }
        let (writing, keeper) = (self.writer.writing(), self.keeper.take());
        let noise = self.noise.estimate();
        Ended { end, report, noise, writing, unsaved, keeper, written, failed }
    }

    fn report(&self, engine: &dyn Resumable, end: End) -> Report {
        let job = self.job;
        let ended_by = match end {
            End::Iterations => "iterations",
            End::Time => "time",
            End::Error => "error",
            End::Stopped => self.observer.stopped_by(),
        };
        Report {
            version: env!("CARGO_PKG_VERSION"),
            scene: self.scene.name.clone(),
            renderer: job.engine.renderer(),
            lanes: job.engine.lanes(),
            threads: self.threads,
            settings: *engine.settings(),
            iterations: engine.iterations(),
            interrupted: end == End::Stopped,
            ended_by,
            resumed_after: self.resumed_after,
            estimated_error: self.error(),
            wall_seconds: self.clock.elapsed().as_secs_f64(),
            write_seconds: self.writer.writing().as_secs_f64(),
            bytes_at_most: self.bytes_at_most,
            peak_bytes: memory::peak(),
            stats: *engine.stats(),
        }
    }
}

/// A saving method of [`Keeper`].
type Way = fn(&mut Keeper, &Scene, (&dyn Resumable, &Iterations), Option<&Past>) -> Result<(), FileError>;

/// Starts a timer that requests a stop after `left`. Dropping the returned sender cancels it.
fn ring(left: Duration, stop: Stop) -> Sender<()> {
    let (alarm, off) = channel();
    thread::spawn(move || {
        if off.recv_timeout(left) == Err(RecvTimeoutError::Timeout) {
            stop.request();
        }
    });
    alarm
}
