//! What is to be rendered, and how.

use crate::choice::EngineChoice;
use crate::error::{Error, Field};
use crate::goals::Goals;
use crate::made::Repeated;
use crate::names::EngineName;
use crate::outputs::Outputs;
use crate::save::{Note, Save};
use crate::warm::Warm;
use files::checkpoint::{Loaded, Lock, Store};
use files::scene_file;
use scene::{Scene, Stop};
use std::path::{Path, PathBuf};

/// A render to be done: a scene and everything that can be said of how. [`Job::start`] checks all of it and begins.
#[derive(Debug)]
pub struct Job {
    /// The scene. Its settings are those of the render.
    pub scene: Scene,
    /// What renders.
    pub engine: EngineChoice,
    /// When it ends, beside its iterations.
    pub goals: Goals,
    /// Threads that work; one per core if not given.
    pub threads: Option<usize>,
    /// The most bytes of memory that it may take.
    pub memory_limit: Option<u64>,
    /// How it is saved, if it is.
    pub save: Option<Save>,
    /// The files that it writes.
    pub outputs: Outputs,
    /// Files that no output may be, and what they are.
    pub inputs: Vec<(Field, PathBuf)>,
    /// Whether [`crate::Running::latest`] shows the image after every iteration; that costs a development each.
    pub live: bool,
    /// What stops it. A front end may share it with handlers of signals.
    pub stop: Stop,
    /// What it is resumed from.
    pub(crate) from: Option<Loaded>,
    /// On the checkpoint that it is resumed from.
    pub(crate) lock: Option<Lock>,
    pub(crate) warm: Warm,
}

impl Job {
    /// Renders `scene` by its own settings with the fast engine on all cores, saves nothing and writes no files.
    pub fn new(scene: Scene) -> Self {
        Self {
            scene,
            engine: EngineChoice::default(),
            goals: Goals::default(),
            threads: None,
            memory_limit: None,
            save: None,
            outputs: Outputs::default(),
            inputs: Vec::new(),
            live: true,
            stop: Stop::new(),
            from: None,
            lock: None,
            warm: Warm::default(),
        }
    }

    /// Resumes the render that wrote the checkpoint `file`: its scene, settings, engine, goals and files. Where `file` is
    /// damaged, the generation before is resumed.
    ///
    /// # Errors
    /// If there is no such checkpoint, none that is whole, or another render has it.
    pub fn resume(file: &Path) -> Result<Self, Error> {
        let bad = |problem: String| Error::input(Field::Resumed, problem);
        let store = Store::new(file);
        let missing = || bad(format!("{}: there is no such file", file.display()));
        if !store.exists() {
            return Err(missing());
        }
        let lock = store.lock().map_err(|error| bad(error.to_string()))?;
        let loaded = store.load().map_err(|error| bad(error.to_string()))?.ok_or_else(missing)?;
        let note = Note::of(&loaded);
        let sums = loaded.checkpoint.account.sums;
        let usual = note.engine.filter(|engine| engine.sums() == sums).unwrap_or(EngineName::of(sums));
        let scene = loaded.checkpoint.scene.clone();
        Ok(Self {
            engine: EngineChoice::new(usual, None)?,
            goals: Goals { time: None, error: note.until_error },
            save: Some(Save { path: file.to_owned(), every: note.every, keep: note.keep }),
            outputs: Outputs::noted(&note, file),
            inputs: vec![(Field::Resumed, file.to_owned())],
            lock: Some(lock),
            from: Some(loaded),
            ..Self::new(scene)
        })
    }

    /// Repeats the render that wrote `file`, an image or a checkpoint: its scene, settings, engine and exposure.
    ///
    /// `scene`, if given, is checked to be the same; a scene of more than a mebibyte is not in an image and must be
    /// given.
    ///
    /// # Errors
    /// If `file` does not say what made it, or `scene` is another or missing.
    pub fn like(file: &Path, scene: Option<Scene>) -> Result<Self, Error> {
        let bad = |what: &str| Err(Error::named(Field::Like, format_args!("{}: {what}", file.display())));
        let Repeated { scene: own, digest, settings, engine, exposure } = Repeated::read(file)?;
        let Some(scene) = scene.or(own) else {
            return bad("its scene is too large to stand in it; name the scene too");
        };
        if scene_file::digest(&scene) != digest {
            return bad("the scene is another than the one that made it");
        }
        Ok(Self {
            engine: EngineChoice::new(engine, None)?,
            outputs: Outputs { exposure, ..Outputs::default() },
            inputs: vec![(Field::Like, file.to_owned())],
            ..Self::new(Scene { settings, ..scene })
        })
    }

    /// Iterations that the checkpoint holds which it is resumed from; `None` if it begins anew.
    pub fn resumed_after(&self) -> Option<u32> {
        self.from.as_ref().map(|from| from.checkpoint.account.iterations)
    }
}
