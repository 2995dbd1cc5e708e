//! Writes the checkpoints of a running render.

use crate::outcome::Saved;
use crate::save::{Every, Note, Save};
use files::atomic_file::{self, FileError, rescue};
use files::checkpoint::{self, Contents, Loaded, Past, Store};
use files::paths;
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
    /// Iterations in the newest checkpoint of the store, or of its refuge.
    saved: Option<u32>,
    /// Whether that asks for as many iterations as this render, so that it goes on to these.
    is_current: bool,
    /// The path of the newest checkpoint, if it had to be written elsewhere.
    refuge: Option<PathBuf>,
    next: u32,
}

impl Keeper {
    /// The keeper of a render of a scene with this digest, of which so many iterations are `asked` for, and which resumes the
    /// checkpoint `from`, if there is one. The files of the checkpoint are locked.
    pub(crate) fn new(save: Save, digest: &str, asked: u32, note: &Note, from: Option<&Loaded>) -> Self {
        let saved = from.map(|from| from.checkpoint.account.iterations);
        let store = Store::new(save.path);
        let from = from.filter(|from| is_in(&store, from));
        let falls_back = from.is_some_and(|from| !is_same(&from.path, store.path()));
        let is_here = from.is_some();
        let is_current = from.is_some_and(|from| from.checkpoint.scene.settings.iterations == asked);
        let note = serde_json::to_string(note).unwrap_or_default(); // cannot fail: noted paths are Unicode
        let mut keeper = Self {
            store,
            every: save.every,
            keep: save.keep,
            falls_back,
            digest: digest.into(),
            note,
            last: Instant::now(),
            // What was resumed from elsewhere is not saved here yet.
            saved: saved.filter(|_| is_here),
            is_current,
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

    /// The most bytes that its files take: two generations, and a third while it is being written.
    pub(crate) fn room(&self, scene: &Scene, sums: Sums, has_past: bool) -> u64 {
        3 * checkpoint::length(scene, &self.note, sums, has_past)
    }

    /// Whether it is time for the next checkpoint.
    pub(crate) fn is_due(&self, iterations: u32) -> bool {
        match self.every {
            Every::Time(interval) => self.last.elapsed() >= interval,
            Every::Iterations(_) => iterations >= self.next,
        }
    }

    /// Writes a checkpoint, unless there is one of this iteration already that asks for as many. `done` are the iterations in
    /// the engine's sums.
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
        if self.is_current && self.saved == Some(iterations) {
            return Ok(());
        }
        let contents = self.contents(scene, done, past);
        self.store.save(|out| checkpoint::write(out, engine, &contents))?;
        (self.saved, self.is_current) = (Some(iterations), true);
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
            self.is_current |= self.refuge.is_some();
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

    /// After the end of the render: writes the last checkpoint if checkpoints are kept, elsewhere if it must, else removes them.
    pub(crate) fn finish(
        &mut self,
        scene: &Scene,
        (engine, done): (&dyn Resumable, &Iterations),
        past: Option<&Past>,
    ) -> Result<(), FileError> {
        if self.keep {
            return self.save_somewhere(scene, (engine, done), past);
        }
        self.store.remove()
    }
}

/// Whether `loaded` is what `store` holds: its newest generation, or the older one in place of a newest that cannot be used.
pub(crate) fn is_in(store: &Store, loaded: &Loaded) -> bool {
    is_same(&loaded.path, store.path())
        || loaded.fallback.is_some() && is_same(&loaded.path, &store.previous())
}

/// Whether both paths lead to the same file.
fn is_same(a: &Path, b: &Path) -> bool {
    paths::identity(a) == paths::identity(b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use scene::Engine as _;
    use std::time::Duration;

    fn keeper(path: &Path, every: Every, keep: bool) -> Keeper {
        Keeper::new(Save { path: path.into(), every, keep }, "a digest", 6, &Note::default(), None)
    }

    /// Of each generation no more than a third, and nearly that.
    #[test]
    fn there_is_room_for_three_generations() {
        let mut scene = files::builtin::scene("cornell").unwrap();
        (scene.settings.width, scene.settings.height) = (64, 48);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.sppm");
        let mut keeper = keeper(&path, Every::Iterations(1), true);
        let mut engine = fast::Sppm::new(&scene, &scene.settings);
        engine.iterate();
        let done = Iterations::from(0..1);
        keeper.save(&scene, (&engine, &done), None).unwrap();
        let (room, length) = (keeper.room(&scene, engine.sums(), false), path.metadata().unwrap().len());
        assert!((3 * length..4 * length).contains(&room), "{room} for {length}");
    }

    /// With an error goal, the earlier image that it is compared with is in each of them.
    #[test]
    fn there_is_room_for_the_earlier_image() {
        let mut scene = files::builtin::scene("cornell").unwrap();
        (scene.settings.width, scene.settings.height) = (64, 48);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.sppm");
        let mut keeper = keeper(&path, Every::Iterations(1), true);
        let engine = fast::Sppm::new(&scene, &scene.settings);
        let past = Past { iterations: 1, film: engine.develop() };
        keeper.save(&scene, (&engine, &Iterations::default()), Some(&past)).unwrap();
        let (room, length) = (keeper.room(&scene, engine.sums(), true), path.metadata().unwrap().len());
        assert!((3 * length..4 * length).contains(&room), "{room} for {length}");
    }

    /// One that cannot be written is tried again when the next is due, not after each iteration, and is not taken for written.
    #[test]
    fn a_checkpoint_that_fails_is_tried_again_when_the_next_is_due() {
        let mut scene = files::builtin::scene("cornell").unwrap();
        scene.settings = scene::Settings { width: 4, height: 3, photons_per_iteration: 10, ..scene.settings };
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("none/a.sppm");
        let mut keeper = keeper(&path, Every::Iterations(2), true);
        let mut engine = fast::Sppm::new(&scene, &scene.settings);
        (0..2).for_each(|_| engine.iterate());
        assert!(keeper.is_due(2));
        assert!(keeper.save(&scene, (&engine, &(0..2).into()), None).is_err());
        assert_eq!([2, 3, 4].map(|done| keeper.is_due(done)), [false, false, true]);
        assert_eq!(keeper.saved(), None);
        // The same iteration, as it is not there yet.
        std::fs::create_dir(folder.path().join("none")).unwrap();
        keeper.save(&scene, (&engine, &(0..2).into()), None).unwrap();
        assert_eq!(keeper.saved(), Some(Saved { path: path.clone(), iterations: 2 }));
        assert!(path.is_file());
    }

    /// The last one as well, of a render that is done: of a part it is all that there is.
    #[test]
    fn a_kept_checkpoint_is_written_elsewhere_if_it_must() {
        let mut scene = files::builtin::scene("cornell").unwrap();
        scene.settings = scene::Settings { width: 4, height: 3, photons_per_iteration: 10, ..scene.settings };
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("none/a.sppm");
        let mut engine = fast::Sppm::new(&scene, &scene.settings);
        engine.iterate();
        let mut keeper = keeper(&path, Every::Iterations(2), true);
        assert!(keeper.finish(&scene, (&engine, &(0..1).into()), None).is_err());
        let saved = keeper.saved().unwrap();
        assert!(saved.iterations == 1 && saved.path.metadata().unwrap().len() > 0, "{saved:?}");
        std::fs::remove_file(saved.path).unwrap();
    }

    /// From the last one on, not from the start.
    #[test]
    fn the_time_to_the_next_checkpoint_is_counted_from_the_last_one() {
        const INTERVAL: Duration = Duration::from_secs(10);
        let mut keeper = keeper(Path::new("a.sppm"), Every::Time(INTERVAL), true);
        assert!(!keeper.is_due(1));
        keeper.last = keeper.last.checked_sub(INTERVAL).unwrap();
        assert!(keeper.is_due(1));
        keeper.schedule(1);
        assert!(!keeper.is_due(2));
    }

    #[test]
    fn checkpoints_are_due_after_their_time_or_their_iterations() {
        let path = Path::new("a.sppm");
        let mut counted = keeper(path, Every::Iterations(3), true);
        assert_eq!([0, 2, 3, 4].map(|done| counted.is_due(done)), [false, false, true, true]);
        counted.schedule(4);
        assert_eq!([6, 7].map(|done| counted.is_due(done)), [false, true]);
        counted.schedule(u32::MAX);
        assert!(counted.is_due(u32::MAX) && !counted.is_due(u32::MAX - 1));
        let timed = |time| keeper(path, Every::Time(time), true).is_due(u32::MAX);
        assert_eq!([Duration::ZERO, Duration::from_hours(1)].map(timed), [true, false]);
    }
}
