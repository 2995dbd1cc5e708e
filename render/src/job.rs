//! The description of a render: its scene and everything that controls how it runs.

use crate::automatic;
use crate::choice::EngineChoice;
use crate::error::{Error, Field, Problem};
use crate::goals::Goals;
use crate::made::Repeated;
use crate::memory::{Need, check_limit};
use crate::names::MethodName;
use crate::outputs::Outputs;
use crate::save::{Note, Save};
use crate::warm::Warm;
use files::checkpoint::{Loaded, Store};
use files::lock::Lock;
use files::scene_file;
use scene::{Automatic, Scene, Stop, Sums};
use std::mem::take;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// The description of a render. [`Job::start`] validates it and starts the render.
#[derive(Debug)]
pub struct Job {
    /// The scene, with the settings of the render.
    pub scene: Scene,
    /// The settings that are chosen from the scene when the render starts, in place of its own.
    pub automatic: Automatic,
    /// The engine.
    pub engine: EngineChoice,
    /// Goals that can end the render before its last iteration.
    pub goals: Goals,
    /// Number of threads; one per core if not given.
    pub threads: Option<usize>,
    /// Limit on the memory of the render, in bytes.
    pub memory_limit: Option<u64>,
    /// Memory that was taken before the render, to read its scene, in bytes. The bound that is told covers it.
    pub bytes_before: u64,
    /// The iterations to render, counted from 0, if not all of the scene's settings: a part of a render, whose checkpoint is
    /// merged with others ([`crate::merge`]). Only with global radii.
    pub range: Option<Range<u32>>,
    /// Where and how often to write checkpoints, if at all.
    pub save: Option<Save>,
    /// The files to write.
    pub outputs: Outputs,
    /// Input files, which no output may overwrite.
    pub inputs: Vec<(Field, PathBuf)>,
    /// Whether [`crate::Running::latest`] is updated after every iteration, which costs developing the image each time.
    pub live: bool,
    /// Requests the render to stop. A front end may share it with signal handlers.
    pub stop: Stop,
    /// The checkpoint to resume.
    pub(crate) from: Option<Loaded>,
    /// The lock on the checkpoint to resume.
    pub(crate) lock: Option<Lock>,
    /// The render to repeat.
    pub(crate) repeats: Option<Repeats>,
    pub(crate) warm: Warm,
    /// The settings that were chosen.
    pub(crate) chosen: Automatic,
    /// Memory that choosing them took.
    pub(crate) bytes_of_choice: u64,
}

/// A file whose render is repeated.
#[derive(Clone, Debug)]
pub(crate) struct Repeats {
    pub(crate) path: PathBuf,
    /// The version of the light transport that made it.
    pub(crate) transport: u32,
}

impl Job {
    /// A render of `scene` with its own settings by the fast engine on all cores, without checkpoints and output files.
    pub fn new(scene: Scene) -> Self {
        Self {
            scene,
            automatic: Automatic::default(),
            engine: EngineChoice::default(),
            goals: Goals::default(),
            threads: None,
            memory_limit: None,
            bytes_before: 0,
            range: None,
            save: None,
            outputs: Outputs::default(),
            inputs: Vec::new(),
            live: true,
            stop: Stop::new(),
            from: None,
            lock: None,
            repeats: None,
            warm: Warm::default(),
            chosen: Automatic::default(),
            bytes_of_choice: 0,
        }
    }

    /// The same render with these settings chosen when it starts.
    #[must_use]
    pub fn choosing(self, automatic: Automatic) -> Self {
        Self { automatic, ..self }
    }

    /// Chooses the settings that are automatic, as [`Job::start`] would; after that, nothing is left to be chosen. If it is
    /// stopped, the settings stay as they are, and the render will not begin either.
    ///
    /// # Errors
    /// If the scene cannot be rendered, if the threads cannot be started, or if it takes more than the memory limit.
    pub fn choose_settings(&mut self) -> Result<(), Error> {
        let (mut automatic, method) = (take(&mut self.automatic), self.engine.method());
        // Who states another method than the usual one, repeats a render or asks for images of photons has chosen.
        automatic.method = automatic.leaves_method_open(self.scene.settings.radius_schedule)
            && method == MethodName::default()
            && self.repeats.is_none()
            && !self.outputs.show_photons();
        if !method.has_photons() {
            automatic = automatic.without_photons();
        }
        if !automatic.any() || self.from.is_some() {
            return Ok(());
        }
        self.scene.check().map_err(|flaw| Error::named(Field::Scene, flaw))?;
        let pool = self.warm.take_pool(self.threads)?;
        self.bytes_of_choice = automatic::bytes_at_most(&self.scene, pool.current_num_threads());
        check_limit(self.bytes_of_choice, self.memory_limit)?;
        // A child: what is done here is not progress of the render.
        let (scene, stop, lanes) = (&self.scene, self.stop.child(), self.engine.lane_kind());
        let chosen = pool.install(|| automatic::choose(scene, automatic, (method, lanes), &stop));
        stop.meter().begin(0);
        self.warm.keep_pool(self.threads, pool);
        if let Some((method, settings)) = chosen {
            self.engine = self.engine.by(method);
            self.scene.settings = settings;
            self.chosen = if method.has_photons() { automatic } else { automatic.without_photons() };
        }
        Ok(())
    }

    /// The most bytes that the render takes, from which its checkpoint and what it writes are left out.
    ///
    /// # Errors
    /// If it is more than the memory limit.
    pub fn bytes_at_most(&self) -> Result<u64, Error> {
        Ok(self.need(self.threads.unwrap_or_else(rayon::current_num_threads))?.bytes)
    }

    /// The memory that the render needs on so many threads, with what was taken before it.
    ///
    /// # Errors
    /// If it is more than the memory limit, or if the system cannot provide it.
    pub(crate) fn need(&self, threads: usize) -> Result<Need, Error> {
        let has_error_goal = self.goals.error.is_some();
        let need = Need::new(self.engine, &self.scene, threads, has_error_goal, self.memory_limit)?;
        // The bias, which is a part of the error, is estimated from pilots, as settings are chosen.
        let of_bias = if has_error_goal { automatic::bytes_at_most(&self.scene, threads) } else { 0 };
        check_limit(of_bias, self.memory_limit)?;
        Ok(need.after(self.bytes_before.max(self.bytes_of_choice).max(of_bias)))
    }

    /// Checks that parts of the render, some of its iterations, can be merged. `field` is the one that asks for a part.
    ///
    /// # Errors
    /// If iterations depend on those before.
    pub fn check_parts(&self, field: Field) -> Result<(), Error> {
        if self.engine.method().sums(&self.scene.settings) == Sums::Exact {
            return Ok(());
        }
        let why = ": iterations are independent of each other only in photon mapping with ";
        let schedule = Field::Setting("radius_schedule");
        Err(Error::input(field, Problem::of(field).text(why).field(schedule).text(" global")))
    }

    /// Resumes the render that wrote the checkpoint `file`, with its scene, settings, engine, error goal and output
    /// files. If `file` is damaged, the older generation is resumed.
    ///
    /// # Errors
    /// If the checkpoint does not exist, has no valid generation, or is locked by another render.
    pub fn resume(file: &Path) -> Result<Self, Error> {
        let bad = |problem: String| Error::input(Field::Resumed, problem);
        let store = Store::new(file);
        let missing = || bad(format!("{}: there is no such file", file.display()));
        if !store.exists() {
            return Err(missing());
        }
        let lock = Lock::take(file).map_err(|error| bad(error.to_string()))?;
        let loaded = store.load().map_err(|error| bad(error.to_string()))?.ok_or_else(missing)?;
        let note = Note::of(&loaded);
        let scene = loaded.checkpoint.scene.clone();
        Ok(Self {
            engine: EngineChoice::new(note.renderer_of(loaded.checkpoint.account.sums), None)?,
            goals: Goals { time: None, error: note.until_error },
            range: note.part(),
            save: Some(Save { path: file.to_owned(), every: note.every, keep: note.keep }),
            outputs: Outputs::noted(&note, file),
            inputs: vec![(Field::Resumed, file.to_owned())],
            lock: Some(lock),
            from: Some(loaded),
            ..Self::new(scene)
        })
    }

    /// Repeats the render that wrote `file`, an image or a checkpoint, with its scene, settings, engine, exposure
    /// and tone.
    ///
    /// If `scene` is given, it must be the same scene. It must be given if its text is longer than a mebibyte, because
    /// images do not contain larger scenes.
    ///
    /// # Errors
    /// If `file` has no metadata, or if the scene is a different one or is needed and not given.
    pub fn like(file: &Path, scene: Option<Scene>) -> Result<Self, Error> {
        Self::like_in(file, scene, None)
    }

    /// As [`Self::like`]; files of particles that the scene needs are also searched in `folder`.
    ///
    /// # Errors
    /// As [`Self::like`], or if a file of particles is missing or has changed.
    pub fn like_in(file: &Path, scene: Option<Scene>, folder: Option<&Path>) -> Result<Self, Error> {
        let bad = |what: &str| Err(Error::named(Field::Like, format_args!("{}: {what}", file.display())));
        let Repeated { scene: own, digest, settings, renderer, exposure, tone, transport } =
            Repeated::read(file, folder)?;
        let Some(scene) = scene.or(own) else {
            return bad("its scene is too large to stand in it; name the scene too");
        };
        if !scene_file::is_digest_of(&digest, &scene) {
            return bad("the scene is another than the one that made it");
        }
        Ok(Self {
            engine: EngineChoice::new(renderer, None)?,
            outputs: Outputs { exposure, tone, ..Outputs::default() },
            inputs: vec![(Field::Like, file.to_owned())],
            repeats: Some(Repeats { path: file.to_owned(), transport }),
            ..Self::new(Scene { settings, ..scene })
        })
    }

    /// The iterations that are asked for: all, or those of a part.
    pub fn wanted(&self) -> Range<u32> {
        self.range.clone().unwrap_or(0..self.scene.settings.iterations)
    }

    /// Iterations in the checkpoint to resume; `None` if the render starts from scratch.
    pub fn resumed_after(&self) -> Option<u32> {
        self.from.as_ref().map(|from| from.checkpoint.account.iterations)
    }
}
