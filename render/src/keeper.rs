//! Writes the checkpoints of a running render.

use crate::outcome::Saved;
use crate::save::{Every, Note, Save};
use files::atomic_file::{self, FileError, rescue};
use files::checkpoint::{self, Contents, Loaded, Past, Store};
use scene::{Iterations, Resumable, Scene, Sums};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Writes the checkpoints of a render.
#[derive(Debug)]
pub(crate) struct Keeper {
    store: Store,
    every: Every,
    keep: bool,
    /// Whether the newest generation is damaged or missing and the older one was resumed.
    falls_back: bool,
    digest: String,
    note: String,
    last: Instant,
    /// Iterations in the newest checkpoint.
    saved: Option<u32>,
    /// The path of the newest checkpoint, if it had to be written elsewhere.
    refuge: Option<PathBuf>,
    next: u32,
}

impl Keeper {
    /// The keeper of a render of a scene with this digest, which resumes the checkpoint `from`, if there is one. The files
    /// of the checkpoint are locked.
    pub(crate) fn new(save: Save, digest: &str, note: &Note, from: Option<&Loaded>) -> Self {
        let saved = from.map(|from| from.checkpoint.account.iterations);
        let store = Store::new(save.path);
        let falls_back = from.is_some_and(|from| from.fallback.is_some() && from.path == store.previous());
        let note = serde_json::to_string(note).unwrap_or_default(); // cannot fail: noted paths are Unicode
        let mut keeper = Self {
            store,
            every: save.every,
            keep: save.keep,
            falls_back,
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
        if let Every::Iterations(n) = self.every {
            self.next = iterations.saturating_add(n);
        }
    }

    /// An upper bound of a checkpoint's bytes.
    pub(crate) fn bytes(&self, scene: &Scene, sums: Sums, has_past: bool) -> u64 {
        checkpoint::length(scene, &self.note, sums, has_past)
    }

    /// Whether it is time for the next checkpoint.
    pub(crate) fn is_due(&self, iterations: u32) -> bool {
        match self.every {
            Every::Time(interval) => self.last.elapsed() >= interval,
            Every::Iterations(_) => iterations >= self.next,
        }
    }

    /// Writes a checkpoint, unless there is one of this iteration already. `done` are the iterations in the engine's sums.
    pub(crate) fn save(
        &mut self,
        scene: &Scene,
        (engine, done): (&dyn Resumable, &Iterations),
        past: Option<&Past>,
    ) -> Result<(), FileError> {
        let iterations = engine.iterations();
        self.schedule(iterations);
        if self.falls_back {
            self.store.fall_back()?;
            self.falls_back = false;
        }
        if self.saved == Some(iterations) {
            return Ok(());
        }
        let contents = self.contents(scene, done, past);
        self.store.save(|out| checkpoint::write(out, engine, &contents))?;
        self.saved = Some(iterations);
        Ok(())
    }

    /// Writes the last checkpoint. If that fails, writes it under another name, in the same folder or in the temporary
    /// folder, and still returns the error.
    pub(crate) fn save_somewhere(
        &mut self,
        scene: &Scene,
        (engine, done): (&dyn Resumable, &Iterations),
        past: Option<&Past>,
    ) -> Result<(), FileError> {
        let saved = self.save(scene, (engine, done), past);
        if saved.is_err() {
            let contents = self.contents(scene, done, past);
            let write =
                |path: &Path| atomic_file::replace(path, |out| checkpoint::write(out, engine, &contents));
            self.refuge = rescue(self.store.path(), write);
            self.saved = self.refuge.as_ref().map(|_| engine.iterations()).or(self.saved);
        }
        saved
    }

    fn contents<'a>(
        &'a self,
        scene: &'a Scene,
        done: &'a Iterations,
        past: Option<&'a Past>,
    ) -> Contents<'a> {
        let (digest, note) = (&self.digest, &self.note);
        let which = Some(done).filter(|done| !done.are_first());
        Contents { scene, digest, version: env!("CARGO_PKG_VERSION"), note, which, past }
    }

    /// The newest checkpoint, if there is one.
    pub(crate) fn saved(&self) -> Option<Saved> {
        let path = self.refuge.as_deref().unwrap_or(self.store.path()).to_owned();
        self.saved.map(|iterations| Saved { path, iterations })
    }

    /// After the end of the render: writes the last checkpoint if checkpoints are kept, else removes them.
    pub(crate) fn finish(
        &mut self,
        scene: &Scene,
        (engine, done): (&dyn Resumable, &Iterations),
        past: Option<&Past>,
    ) -> Result<(), FileError> {
        if self.keep {
            return self.save(scene, (engine, done), past);
        }
        self.store.remove()
    }
}
