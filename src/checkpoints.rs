//! When a render is saved, where, and what is noted beside its sums.

use crate::args::CheckpointArgs;
use crate::engines::EngineName;
use crate::error::Error;
use crate::outputs::rescue;
use files::atomic_file::{self, FileError};
use files::checkpoint::{self, Contents, Loaded, Lock, Past, Store};
use files::scene_file;
use scene::{Resumable, Scene, Settings, Sums};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// The interval between two checkpoints.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Every {
    /// At the end of the first iteration after so much time.
    Time(Duration),
    /// After so many iterations.
    Iterations(u32),
}

impl Default for Every {
    fn default() -> Self {
        Self::Time(Duration::from_mins(1))
    }
}

/// Where the files of a render go, as its checkpoint notes it. Names of files in the checkpoint's own folder are
/// noted without the folder, so that all of it can be moved; others from the root.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Note {
    /// The engine that rendered last.
    pub engine: Option<EngineName>,
    /// The image.
    pub image: Option<PathBuf>,
    /// In stops.
    pub exposure: Option<f32>,
    /// Whether there are images of iterations 1, 2, 4, 8, ...
    pub snapshots: bool,
    /// The image of radii.
    pub radius_image: Option<PathBuf>,
    /// The image of counts.
    pub count_image: Option<PathBuf>,
    /// The account in JSON.
    pub stats: Option<PathBuf>,
    /// The estimated error at which the render is to end.
    pub until_error: Option<f64>,
    /// How often it is saved.
    pub every: Every,
    /// Whether the checkpoint stays when all is done.
    pub keep: bool,
}

impl Note {
    /// What a checkpoint notes; nothing if it was written by another program.
    pub(crate) fn of(loaded: &Loaded) -> Self {
        serde_json::from_str(&loaded.checkpoint.note).unwrap_or_default()
    }
}

/// `path` as a checkpoint at `store` notes it; `None` if it is not Unicode.
pub(crate) fn noted(path: &Path, store: &Path) -> Option<PathBuf> {
    let whole = std::path::absolute(path).ok()?;
    let folder = std::path::absolute(store).ok()?.parent()?.to_owned();
    let noted = whole.strip_prefix(folder).ok().filter(|rest| rest.components().count() == 1);
    let noted = noted.map_or_else(|| whole.clone(), Path::to_path_buf);
    noted.to_str().is_some().then_some(noted)
}

/// The reverse of [`noted`].
pub(crate) fn resolved(noted: &Path, store: &Path) -> PathBuf {
    match store.parent() {
        Some(folder) if noted.is_relative() => folder.join(noted),
        _ => noted.to_owned(),
    }
}

/// Where a render is saved, and how it is gone on with.
#[derive(Debug)]
pub(crate) struct Plan {
    pub store: Store,
    pub every: Every,
    /// Whether the checkpoint stays when all is done: it was asked for by its name.
    pub keep: bool,
    /// Held from the start if the checkpoint was asked for, or is there; else from the first time it is written.
    pub lock: Option<Lock>,
}

impl Plan {
    /// What `args` ask for a render whose image is `image`; `None` if that is nothing.
    pub(crate) fn new(args: &CheckpointArgs, image: &Path) -> Result<Option<Self>, Error> {
        if args.no_checkpoint {
            return Ok(None);
        }
        let path = args.checkpoint.clone().unwrap_or_else(|| beside(image));
        let keep = args.checkpoint.is_some();
        let mut plan =
            Self { store: Store::new(path), every: args.every.unwrap_or_default(), keep, lock: None };
        if keep {
            let checked = atomic_file::check(plan.store.path());
            checked.map_err(|error| Error::BadInput(format!("--checkpoint: {error}")))?;
        }
        if keep || plan.store.exists() {
            plan.lock()?;
        }
        Ok(Some(plan))
    }

    /// Takes the checkpoint for this process.
    pub(crate) fn lock(&mut self) -> Result<(), Error> {
        self.lock = Some(self.store.lock().map_err(|error| Error::BadInput(format!("checkpoint: {error}")))?);
        Ok(())
    }
}

/// The checkpoint of a render that was not asked for one.
fn beside(image: &Path) -> PathBuf {
    let mut name = image.as_os_str().to_owned();
    name.push(".sppm");
    name.into()
}

/// Saves a render.
#[derive(Debug)]
pub(crate) struct Keeper {
    plan: Plan,
    scene: String,
    digest: String,
    note: String,
    last: Instant,
    /// The iterations that the newest checkpoint holds.
    saved: Option<u32>,
    /// Where that is, if it could not be where it should be.
    refuge: Option<PathBuf>,
    next: u32,
}

impl Keeper {
    /// The keeper of a render of `scene` that has done `iterations`, some of them kept if it `is_resumed`.
    pub(crate) fn new(plan: Plan, scene: &Scene, digest: &str, note: &Note, saved: Option<u32>) -> Self {
        let note = serde_json::to_string(note).unwrap_or_default(); // never fails: paths are Unicode
        let text = scene_file::to_text(scene, &scene.settings);
        let mut keeper = Self {
            plan,
            scene: text,
            digest: digest.into(),
            note,
            last: Instant::now(),
            saved,
            refuge: None,
            next: 0,
        };
        keeper.schedule(saved.unwrap_or(0));
        keeper
    }

    fn schedule(&mut self, iterations: u32) {
        self.last = Instant::now();
        if let Every::Iterations(n) = self.plan.every {
            self.next = iterations.saturating_add(n);
        }
    }

    /// Bytes of a checkpoint.
    pub(crate) fn bytes(&self, settings: &Settings, sums: Sums, has_past: bool) -> u64 {
        checkpoint::length(&self.scene, &self.note, settings, sums, has_past)
    }

    /// The file, if it was asked for by name.
    pub(crate) fn asked_for(&self) -> Option<&Path> {
        self.plan.keep.then(|| self.plan.store.path())
    }

    /// Whether it is time.
    pub(crate) fn is_due(&self, iterations: u32) -> bool {
        match self.plan.every {
            Every::Time(interval) => self.last.elapsed() >= interval,
            Every::Iterations(_) => iterations >= self.next,
        }
    }

    /// Saves the render as it stands, unless that is saved already.
    pub(crate) fn save(&mut self, engine: &dyn Resumable, past: Option<&Past>) -> Result<(), FileError> {
        let iterations = engine.iterations();
        self.schedule(iterations);
        if self.saved == Some(iterations) {
            return Ok(());
        }
        if self.plan.lock.is_none() {
            self.plan.lock = Some(self.plan.store.lock()?);
        }
        let contents = self.contents(past);
        self.plan.store.save(|out| checkpoint::write(out, engine, &contents))?;
        self.saved = Some(iterations);
        Ok(())
    }

    /// Saves the render for the last time: where that fails, beside it or in the folder for temporary files. Then
    /// the error is why.
    pub(crate) fn save_somewhere(
        &mut self,
        engine: &dyn Resumable,
        past: Option<&Past>,
    ) -> Result<(), FileError> {
        let saved = self.save(engine, past);
        if saved.is_err() {
            let contents = self.contents(past);
            let write =
                |path: &Path| atomic_file::replace(path, |out| checkpoint::write(out, engine, &contents));
            self.refuge = rescue(self.plan.store.path(), write);
            self.saved = self.refuge.as_ref().map(|_| engine.iterations()).or(self.saved);
        }
        saved
    }

    fn contents<'a>(&'a self, past: Option<&'a Past>) -> Contents<'a> {
        let (scene, digest, note) = (&self.scene, &self.digest, &self.note);
        Contents { scene, digest, version: env!("CARGO_PKG_VERSION"), note, past }
    }

    /// The checkpoint that is there, and the iterations it holds.
    pub(crate) fn saved(&self) -> Option<(&Path, u32)> {
        let path = self.refuge.as_deref().unwrap_or(self.plan.store.path());
        self.saved.map(|iterations| (path, iterations))
    }

    /// All is done: the checkpoint goes, unless it was asked for.
    pub(crate) fn finish(&mut self, engine: &dyn Resumable, past: Option<&Past>) -> Result<(), FileError> {
        if self.plan.keep {
            return self.save(engine, past);
        }
        if self.plan.lock.is_some() {
            self.plan.store.remove()?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_move_with_their_checkpoint() {
        let there = Path::new("/a/b/x.sppm");
        for (path, as_noted, elsewhere) in [
            ("/a/b/x.png", "x.png", "/c/x.png"),
            ("/a/b/c/x.png", "/a/b/c/x.png", "/a/b/c/x.png"),
            ("/a/x.png", "/a/x.png", "/a/x.png"),
        ] {
            let note = noted(Path::new(path), there).unwrap();
            assert_eq!(note, Path::new(as_noted));
            assert_eq!(resolved(&note, there), Path::new(path));
            assert_eq!(resolved(&note, Path::new("/c/x.sppm")), Path::new(elsewhere));
        }
        assert_eq!(resolved(Path::new("x.png"), Path::new("x.sppm")), Path::new("x.png"));
    }
}
