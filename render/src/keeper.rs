//! Saves a render as it goes.

use crate::outcome::Saved;
use crate::save::{Every, Note, Save};
use files::atomic_file::{self, FileError, rescue};
use files::checkpoint::{self, Contents, Lock, Past, Store};
use files::scene_file;
use scene::{Resumable, Scene, Settings, Sums};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Saves a render.
#[derive(Debug)]
pub(crate) struct Keeper {
    store: Store,
    every: Every,
    keep: bool,
    lock: Option<Lock>,
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
    /// The keeper of a render of `scene`, of which a checkpoint holds `saved` iterations, if there is one.
    pub(crate) fn new(
        save: Save,
        lock: Option<Lock>,
        scene: &Scene,
        digest: &str,
        note: &Note,
        saved: Option<u32>,
    ) -> Self {
        let note = serde_json::to_string(note).unwrap_or_default(); // never fails: paths are Unicode
        let text = scene_file::to_text(scene, &scene.settings);
        let mut keeper = Self {
            store: Store::new(save.path),
            every: save.every,
            keep: save.keep,
            lock,
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
        if let Every::Iterations(n) = self.every {
            self.next = iterations.saturating_add(n);
        }
    }

    /// Bytes of a checkpoint.
    pub(crate) fn bytes(&self, settings: &Settings, sums: Sums, has_past: bool) -> u64 {
        checkpoint::length(&self.scene, &self.note, settings, sums, has_past)
    }

    /// Whether it is time.
    pub(crate) fn is_due(&self, iterations: u32) -> bool {
        match self.every {
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
        if self.lock.is_none() {
            self.lock = Some(self.store.lock()?);
        }
        let contents = self.contents(past);
        self.store.save(|out| checkpoint::write(out, engine, &contents))?;
        self.saved = Some(iterations);
        Ok(())
    }

    /// Saves the render for the last time: where that fails, beside its place or in the folder for temporary files, and
    /// gives the error.
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
            self.refuge = rescue(self.store.path(), write);
            self.saved = self.refuge.as_ref().map(|_| engine.iterations()).or(self.saved);
        }
        saved
    }

    fn contents<'a>(&'a self, past: Option<&'a Past>) -> Contents<'a> {
        let (scene, digest, note) = (&self.scene, &self.digest, &self.note);
        Contents { scene, digest, version: env!("CARGO_PKG_VERSION"), note, past }
    }

    /// The checkpoint that is there.
    pub(crate) fn saved(&self) -> Option<Saved> {
        let path = self.refuge.as_deref().unwrap_or(self.store.path()).to_owned();
        self.saved.map(|iterations| Saved { path, iterations })
    }

    /// All is done: the checkpoint goes, unless it is to stay.
    pub(crate) fn finish(&mut self, engine: &dyn Resumable, past: Option<&Past>) -> Result<(), FileError> {
        if self.keep {
            return self.save(engine, past);
        }
        if self.lock.is_some() {
            self.store.remove()?;
        }
        Ok(())
    }
}
