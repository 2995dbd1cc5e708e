//! The studio: a scene that is edited and rendered again after every change, on a thread of its own.
//!
//! After a change a small picture is rendered at once. When the camera rests the whole image follows, and converges until
//! the next change. A whole image is abandoned when a change comes; a small picture is finished first, so that pictures
//! keep coming while the camera turns. Pictures are published by one render at a time, so none of an older camera follows
//! one of a newer.

use crate::display::Display;
use crate::easel::{Desk, Easel, History, LAYERS};
use crate::hub::{Asked, Hub, show};
use crate::kept::{Kept, Subject};
use crate::message::{Answer, CameraParts, Request};
use crate::model::{self, Change, Model, State};
use crate::pace::Divisor;
use crate::pick::pick;
use render::{EngineChoice, Job, Running};
use scene::settings::MAX_ITERATIONS;
use scene::{Scene, Settings, Sphere, Stop};
use serde_json::{Value, json};
use std::cmp::Reverse;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::time::{Duration, Instant};

/// How often the studio looks whether it is to end.
const TICK: Duration = Duration::from_millis(50);
/// The camera counts as resting when it was not moved for so long, also if the page says that it moves.
const REST: Duration = Duration::from_millis(250);
/// A render that nobody watches is held after this time.
const ABSENCE: Duration = Duration::from_millis(400);
/// At the start somebody may take longer to open the page.
const FIRST_ABSENCE: Duration = Duration::from_secs(5);
/// How long the end waits for the image to be kept.
const LAST_WAIT: Duration = Duration::from_secs(20);
/// More spheres are not listed in the page; they can still be picked in the image, or by their number.
const MOST_LISTED: usize = 2000;
/// Memory per sphere of a scene that is searched for what is picked: the sphere at one instant, if anything moves, its role, and
/// its place in the search tree (see "Memory" in ARCHITECTURE.md), with some reserve.
const BYTES_PER_SEARCHED: usize = 2 * size_of::<Sphere>();
/// More styles are not listed.
const MOST_STYLES: usize = 100;

/// What a studio is made of.
#[derive(Debug)]
pub struct Project {
    /// The scene, with its settings.
    pub scene: Scene,
    /// The text of its file.
    pub text: Option<String>,
    /// The name for files, without extension.
    pub stem: String,
    /// The engine.
    pub engine: EngineChoice,
    /// Number of threads; one per core if not given.
    pub threads: Option<usize>,
    /// Limit on the memory of a render, in bytes.
    pub memory_limit: Option<u64>,
    /// Iterations after which the image is taken to be done.
    pub limit: Option<u32>,
}

/// The most bytes of memory that a studio of `scene` takes, besides those of a render and of the text: the edited scene with the
/// steps that can be taken back; a copy that is checked, rendered next, or searched for what is picked; names.
pub fn bytes_at_most(scene: &Scene) -> u64 {
    let copy = size_of_val(&scene.spheres[..]) + size_of_val(&scene.materials[..]);
    let per_sphere = BYTES_PER_SEARCHED + size_of::<Option<String>>();
    (model::bytes_at_most(scene) + copy + per_sphere * scene.spheres.len()) as u64
}

/// What became of a project when its studio ended.
#[derive(Debug)]
pub struct Legacy {
    /// The last image, unless not one iteration was done.
    pub kept: Option<Arc<Kept>>,
    /// Whether the scene was changed and then not saved.
    pub is_unsaved: bool,
}

/// What the render in progress is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    /// There is none.
    Nothing,
    /// One of reduced size.
    Small,
    /// The whole image.
    Whole,
}

pub(crate) struct Studio {
    hub: Arc<Hub>,
    desk: Arc<Desk>,
    display: Option<Arc<Display>>,
    model: Model,
    text: Option<Arc<str>>,
    /// The names of spheres in the text.
    names: Vec<Option<String>>,
    stem: String,
    threads: Option<usize>,
    memory_limit: Option<u64>,
    /// The job between two renders, which keeps threads and buffers.
    job: Option<Job>,
    running: Option<Running>,
    is_over: Arc<AtomicBool>,
    stage: Stage,
    began: Instant,
    divisor: Divisor,
    /// Counts changes of what is rendered.
    version: u32,
    /// The version of the last render that was started.
    rendered: u32,
    numbers: Arc<AtomicU32>,
    is_moving: bool,
    /// Whether the list of balls has changed since it was shown.
    owes_scene: bool,
    changed: Instant,
    /// When somebody last watched; none until somebody does.
    watched: Option<Instant>,
    opened: Instant,
    /// Who waits for the image to be kept.
    keepers: Vec<Asked>,
    is_unsaved: bool,
}

impl Studio {
    pub(crate) fn new(project: Project, hub: Arc<Hub>, display: Option<Arc<Display>>) -> Self {
        let Project { scene, text, stem, engine, threads, memory_limit, limit } = project;
        let desk = Desk::default();
        desk.change(|wishes| wishes.limit = limit.unwrap_or(u32::MAX));
        let now = Instant::now();
        Self {
            hub,
            desk: Arc::new(desk),
            display,
            model: Model::new(&scene, engine),
            names: text.as_deref().map(files::scene_file::revise::sphere_names).unwrap_or_default(),
            text: text.map(Arc::from),
            stem,
            threads,
            memory_limit,
            job: None,
            running: None,
            is_over: Arc::default(),
            stage: Stage::Nothing,
            began: now,
            divisor: Divisor::default(),
            version: 1,
            rendered: 0,
            numbers: Arc::default(),
            is_moving: false,
            owes_scene: false,
            changed: now,
            watched: None,
            opened: now,
            keepers: Vec::new(),
            is_unsaved: false,
        }
    }

    /// Works until `quit` is requested.
    pub(crate) fn run(mut self, quit: &Stop) -> Legacy {
        self.show_scene();
        self.show_setup();
        while !quit.is_requested() {
            self.mind_render();
            let asked = self.hub.requests.take(TICK);
            self.obey(asked);
            self.desk.wake();
            self.hand_out();
        }
        self.end()
    }

    /// Does what was asked. Of moves of the camera that waited together only the last is made.
    fn obey(&mut self, asked: Vec<Asked>) {
        let mut overtaken = Vec::new();
        let mut asked = asked.into_iter().peekable();
        while let Some(one) = asked.next() {
            let is_move = |asked: &Asked| matches!(asked.request, Request::Camera { .. });
            if is_move(&one) && asked.peek().is_some_and(is_move) {
                overtaken.push(one);
                continue;
            }
            self.obey_one(one);
            for one in overtaken.drain(..) {
                if let Request::Camera { id, .. } = one.request {
                    one.answer(Answer::Taken { id, version: self.version });
                }
            }
        }
    }

    fn obey_one(&mut self, asked: Asked) {
        let before = self.model.now().clone();
        let done = match asked.request.clone() {
            Request::Camera { camera, moving, .. } => self.change(Change::Camera(camera), moving),
            Request::Sphere { index, parts, styled, moving } => {
                let change = if styled { Change::Style } else { Change::Sphere };
                self.change(change(index, parts), moving)
            }
            Request::Settings(parts) => self.change(Change::Settings(parts), false),
            Request::Engine { method, engine } => self.choose(render::Renderer { method, engine }),
            Request::Undo => Ok(self.model.undo()),
            Request::Redo => Ok(self.model.redo()),
            Request::Reset => Ok(self.model.reset()),
            Request::Pause { paused } => {
                self.desk.change(|wishes| wishes.is_paused = paused);
                self.show_setup();
                return;
            }
            Request::Pick { id, x, y } => return asked.answer(pick(&self.model.now().scene(), id, [x, y])),
            Request::Describe { id, index } => {
                return asked.answer(Answer::Described { id, sphere: self.describe(index) });
            }
            Request::Keep { .. } => {
                // A render that goes on from before a change has nothing to answer.
                self.mind_render();
                self.desk.change(|wishes| wishes.wants_kept = true);
                return self.keepers.push(asked);
            }
            Request::Ack | Request::Layer { .. } => return,
        };
        match done {
            Ok(true) => self.begin_version(&before),
            Ok(false) => {}
            Err(problem) => {
                asked.answer(Answer::Refused { problem });
                // The page shows what it asked for; it learns what there is.
                self.show_setup();
            }
        }
        if let Request::Camera { id, .. } = asked.request {
            asked.answer(Answer::Taken { id, version: self.version });
        }
    }

    fn change(&mut self, change: Change, is_moving: bool) -> Result<bool, String> {
        let before = self.is_moving;
        self.is_moving = is_moving;
        let is_camera_at_rest = match &change {
            Change::Camera(parts) => *parts == CameraParts::of(&self.model.now().camera),
            _ => false,
        };
        // At the end of a drag the page repeats the camera, to say that it rests.
        if is_camera_at_rest && before {
            return Ok(false);
        }
        self.model.apply(change).map(|()| true)
    }

    fn choose(&mut self, renderer: render::Renderer) -> Result<bool, String> {
        let choice = EngineChoice::new(renderer, None).map_err(|error| error.to_string())?;
        self.is_moving = false;
        self.model.apply(Change::Engine(choice)).map(|()| true)
    }

    fn begin_version(&mut self, before: &State) {
        (self.version, self.changed, self.is_unsaved) = (self.version + 1, Instant::now(), true);
        self.owes_scene |= self.model.has_other_body(before);
        self.settle_scene();
        self.show_setup();
    }

    /// Shows the list of balls if it has changed, but not while one of them is dragged: it may be long.
    fn settle_scene(&mut self) {
        if self.owes_scene && !self.is_moving {
            self.show_scene();
            self.owes_scene = false;
        }
    }

    /// Starts, ends and holds renders as the model and the clients want it.
    fn mind_render(&mut self) {
        if self.stage != Stage::Nothing && self.is_over.load(Ordering::Acquire) {
            if self.stage == Stage::Small {
                self.divisor.learn(self.began.elapsed().max(self.hub.drawing_time()));
            }
            self.finish();
        }
        if self.rendered != self.version {
            match self.stage {
                Stage::Small => {}
                Stage::Whole => {
                    self.stop();
                    self.start(Stage::Small);
                }
                Stage::Nothing => self.start(Stage::Small),
            }
        } else if self.stage == Stage::Nothing && (!self.is_moving || self.changed.elapsed() >= REST) {
            self.is_moving = false;
            self.settle_scene();
            self.start(Stage::Whole);
        }
        self.hold();
    }

    /// Holds the render when nobody watches.
    fn hold(&mut self) {
        if self.hub.clients() > 0 {
            self.watched = Some(Instant::now());
        }
        if let Some(running) = &self.running {
            running.stopper().hold(self.is_abandoned());
        }
    }

    /// Whether no page has been open for a while, nor is there a viewer that images are sent to.
    fn is_abandoned(&self) -> bool {
        let absence = self.watched.map(|at| at.elapsed());
        let is_alone = absence.map_or(self.opened.elapsed() > FIRST_ABSENCE, |absence| absence > ABSENCE);
        is_alone && self.display.is_none()
    }

    fn start(&mut self, stage: Stage) {
        let state = self.model.now().clone();
        let mut scene = state.scene();
        let subject = Arc::new(Subject {
            scene: scene.clone(),
            engine: state.engine,
            text: self.text.clone(),
            stem: self.stem.clone(),
        });
        let whole = state.settings;
        scene.settings = match stage {
            Stage::Small => Settings { iterations: 1, ..self.divisor.reduce(&whole) },
            _ => Settings { iterations: MAX_ITERATIONS, ..whole },
        };
        let mut job = match self.job.take() {
            Some(job) => job,
            None => Job::new(scene.clone()),
        };
        job.scene = scene;
        (job.engine, job.live) = (state.engine, false);
        (job.threads, job.memory_limit) = (self.threads, self.memory_limit);
        self.is_over = Arc::default();
        let easel = Easel {
            hub: Arc::clone(&self.hub),
            desk: Arc::clone(&self.desk),
            display: self.display.clone(),
            stop: job.stop.clone(),
            subject,
            version: self.version,
            whole: [whole.width, whole.height],
            is_preview: stage == Stage::Small,
            numbers: Arc::clone(&self.numbers),
            is_over: Arc::clone(&self.is_over),
            history: History::default(),
        };
        self.began = Instant::now();
        self.rendered = self.version;
        match job.start(easel) {
            Ok(running) => (self.running, self.stage) = (Some(running), stage),
            Err(error) => self.complain(&error.to_string()),
        }
    }

    /// Stops the render in progress.
    fn stop(&mut self) {
        if let Some(running) = &self.running {
            let stopper = running.stopper();
            stopper.request();
            stopper.hold(false);
            self.desk.wake();
        }
        self.finish();
    }

    /// Waits for the end of the render in progress, and keeps its job.
    fn finish(&mut self) {
        let was_whole = self.stage == Stage::Whole;
        self.stage = Stage::Nothing;
        match self.running.take().map(Running::wait) {
            Some(Ok(outcome)) => self.job = Some(outcome.job),
            Some(Err(error)) => self.complain(&error.to_string()),
            None => {}
        }
        // A whole image ends by itself only if it cannot go on.
        if was_whole && self.rendered == self.version && self.job.is_none() {
            self.stage = Stage::Whole;
        }
    }

    /// Tells all clients of a problem, and returns to what was before.
    fn complain(&mut self, problem: &str) {
        show(&self.hub.status, &json!({ "type": "problem", "problem": problem }));
        // What remains without a job is not tried again until the next change.
        (self.job, self.stage) = (None, Stage::Whole);
        self.is_over = Arc::default();
        if self.model.undo() {
            self.version += 1;
            (self.stage, self.changed) = (Stage::Nothing, Instant::now());
            self.show_scene();
            self.show_setup();
        }
    }

    /// Gives a kept image to those who asked for it.
    fn hand_out(&mut self) {
        let Some(kept) = self.desk.change(|wishes| wishes.kept.take()) else { return };
        if let Ok(kept) = &kept {
            self.hub.keep(Arc::clone(kept));
            self.is_unsaved = false;
        }
        for asked in self.keepers.drain(..) {
            let Request::Keep { id } = asked.request else { continue };
            asked.answer(match &kept {
                Ok(kept) => Answer::Kept {
                    id,
                    number: kept.number,
                    iterations: kept.iterations,
                    stem: kept.stem().into(),
                },
                Err(problem) => Answer::Refused { problem: problem.clone() },
            });
        }
    }

    /// Keeps the last image and ends.
    fn end(mut self) -> Legacy {
        let is_unsaved = self.is_unsaved && self.model.steps()[2];
        self.desk.change(|wishes| (wishes.wants_kept, wishes.kept) = (true, None));
        let (until, mut kept) = (Instant::now() + LAST_WAIT, None);
        while kept.is_none() && Instant::now() < until && self.running.is_some() {
            // An iteration that nobody watched is finished for its image.
            self.watched = Some(Instant::now());
            self.mind_render();
            self.hub.requests.take(TICK);
            kept = self.desk.change(|wishes| wishes.kept.take());
        }
        self.stop();
        Legacy { kept: kept.and_then(Result::ok), is_unsaved }
    }

    fn show_setup(&self) {
        let State { camera, settings, engine, .. } = self.model.now();
        let [can_undo, can_redo, is_changed] = self.model.steps();
        let renderer = engine.renderer();
        show(
            &self.hub.setup,
            &json!({
                "type": "setup",
                "version": self.version,
                "camera": CameraParts::of(camera),
                "settings": {
                    "width": settings.width,
                    "height": settings.height,
                    "photons_per_iteration": settings.photons_per_iteration,
                    "max_depth": settings.max_depth,
                    "initial_radius": settings.initial_radius,
                    "seed": settings.seed.to_string(),
                },
                "method": renderer.method,
                "engine": renderer.engine,
                "paused": self.desk.change(|wishes| wishes.is_paused),
                "can_undo": can_undo,
                "can_redo": can_redo,
                "changed": is_changed,
            }),
        );
    }

    fn show_scene(&self) {
        let count = self.model.spheres().len();
        let listed = (0..count.min(MOST_LISTED)).filter_map(|i| self.describe(i));
        show(
            &self.hub.scene,
            &json!({
                "type": "scene",
                "mode": "studio",
                "name": self.model.name(),
                "version": self.version,
                "spheres": listed.collect::<Vec<_>>(),
                "total": count,
                "styles": self.styles(),
                "layers": LAYERS,
                "others": self.hub.others.iter().map(|(name, _)| name).collect::<Vec<_>>(),
            }),
        );
    }

    /// What the page knows of a sphere.
    fn describe(&self, index: usize) -> Option<Value> {
        let sphere = self.model.spheres().get(index)?;
        Some(json!({
            "name": self.names.get(index).cloned().flatten(),
            "center": sphere.center.to_array(),
            "radius": sphere.radius,
            "emission": sphere.emission.to_array(),
            "material": self.model.materials()[sphere.material as usize],
            "style": sphere.material,
        }))
    }

    /// The styles: materials that several spheres have. Each with the first of the spheres, and their number; the one of most
    /// spheres first.
    fn styles(&self) -> Vec<Value> {
        let mut styles: Vec<(usize, usize)> = vec![(0, 0); self.model.materials().len()];
        for (i, sphere) in self.model.spheres().iter().enumerate() {
            let (first, count) = &mut styles[sphere.material as usize];
            *first = if *count == 0 { i } else { *first };
            *count += 1;
        }
        let mut shared: Vec<_> = styles.iter().enumerate().filter(|(_, (_, count))| *count > 1).collect();
        shared.sort_by_key(|(style, (_, count))| (Reverse(*count), *style));
        let told = |(style, (first, count)): (usize, &(usize, usize))| json!({ "style": style, "first": first, "count": count, "material": self.model.materials()[style] });
        shared.into_iter().take(MOST_STYLES).map(told).collect()
    }
}

#[cfg(test)]
mod tests;
