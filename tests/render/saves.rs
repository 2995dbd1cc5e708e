//! When checkpoints are written, and what the other files show then.

use crate::{path_tracer, small};
use files::image_file;
use render::{End, Every, Goals, Job, Notice, Observer, Outputs, Save, Step};
use scene::{Film, Plane, Resumable, Rgb, Settings, Stop};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// Notes after which iterations a checkpoint was written, and expects each image to show that iteration.
#[derive(Clone, Default)]
struct Saves {
    folder: PathBuf,
    after: Arc<Mutex<Vec<u32>>>,
}

impl Observer for Saves {
    fn after(&mut self, step: &Step, engine: &dyn Resumable) {
        if !step.saved {
            return;
        }
        self.after.lock().unwrap().push(step.iteration);
        let read = |name: &str| image_file::read(&self.folder.join(name)).unwrap();
        let grey = |plane: Plane| {
            let pixels = plane.values.into_iter().map(Rgb::splat).collect();
            Film { width: plane.width, height: plane.height, pixels }
        };
        assert!(read("a.pfm") == engine.develop(), "the image after {}", step.iteration);
        assert!(read("radius.pfm") == grey(engine.radius().unwrap()), "radii after {}", step.iteration);
        assert!(read("count.pfm") == grey(engine.count().unwrap()), "counts after {}", step.iteration);
    }
}

/// Runs a job with a checkpoint every so many iterations. Returns after which there was one.
fn saves(mut job: Job, folder: &Path, iterations: u32, every: u32) -> Vec<u32> {
    let saves = Saves { folder: folder.into(), ..Saves::default() };
    let there = |name: &str| Some(folder.join(name));
    job.scene.settings = Settings { iterations, ..job.scene.settings };
    job.save = Some(Save { path: folder.join("a.sppm"), every: Every::Iterations(every), keep: true });
    job.outputs = Outputs {
        image: there("a.pfm"),
        radius_image: there("radius.pfm"),
        count_image: there("count.pfm"),
        ..Outputs::default()
    };
    job.start(saves.clone()).unwrap().wait().unwrap();
    let after = saves.after.lock().unwrap();
    after.clone()
}

/// Every so many iterations, counted from the last checkpoint, and none where the render ends anyway.
#[test]
fn checkpoints_are_written_every_so_many_iterations_from_the_last_one_on() {
    for (first, every, then, next) in [(4, 1, 6, 1), (4, 2, 11, 3), (5, 7, 20, 6), (3, 2, 12, 8)] {
        let folder = tempfile::tempdir().unwrap();
        let job = Job::new(small(first));
        let expected: Vec<u32> = (1..first).filter(|n| n.is_multiple_of(every)).collect();
        assert_eq!(saves(job, folder.path(), first, every), expected, "{first} iterations, every {every}");
        let job = Job::resume(&folder.path().join("a.sppm")).unwrap();
        let expected: Vec<u32> = (first + 1..then).filter(|n| (n - first).is_multiple_of(next)).collect();
        assert_eq!(saves(job, folder.path(), then, next), expected, "{then} after {first}, every {next}");
    }
}

/// Puts a folder in the place of the image after the first iteration, and notes what is told of checkpoints and images.
#[derive(Clone, Default)]
struct Obstacle {
    image: PathBuf,
    told: Arc<Mutex<Vec<String>>>,
}

impl Observer for Obstacle {
    fn after(&mut self, step: &Step, engine: &dyn Resumable) {
        if step.iteration == 1 {
            std::fs::create_dir(&self.image).unwrap();
        }
        if step.saved {
            let radii = image_file::read(&self.image.with_file_name("radius.pfm")).unwrap();
            assert_eq!(radii.pixels[0], Rgb::splat(engine.probe(0, 0).radius), "the other image is there");
        }
    }

    fn notice(&mut self, notice: &Notice) {
        let line = match notice {
            Notice::Saved { iterations } => format!("{iterations} saved"),
            Notice::NotRefreshed(error) => {
                format!("{} not refreshed", error.path.file_name().unwrap().display())
            }
            _ => return,
        };
        self.told.lock().unwrap().push(line);
    }
}

/// With a checkpoint all images are written that can be, and which cannot is told. No work is lost at the end either.
#[test]
fn an_image_that_cannot_be_refreshed_is_told_and_holds_up_no_other() {
    let folder = tempfile::tempdir().unwrap();
    let [image, radius, path] = ["a.pfm", "radius.pfm", "a.sppm"].map(|name| folder.path().join(name));
    let obstacle = Obstacle { image: image.clone(), ..Obstacle::default() };
    let mut job = Job::new(small(3));
    job.save = Some(Save { path: path.clone(), every: Every::Iterations(2), keep: false });
    job.outputs =
        Outputs { image: Some(image.clone()), radius_image: Some(radius.clone()), ..Outputs::default() };
    let outcome = job.start(obstacle.clone()).unwrap().wait().unwrap();
    assert_eq!(*obstacle.told.lock().unwrap(), ["2 saved", "a.pfm not refreshed"]);
    assert_eq!(outcome.written, [radius]);
    let [failed] = outcome.failed.as_slice() else { panic!("{:?}", outcome.failed) };
    assert_eq!((&failed.error.path, failed.refuge.as_ref().unwrap().is_file()), (&image, true));
    // The checkpoint stays, with all iterations, although it was to be removed.
    assert_eq!(outcome.saved.map(|saved| (saved.path, saved.iterations)), Some((path, 3)));
    assert!(folder.path().join("a.sppm").is_file());
}

/// Puts a folder in the place of the checkpoint after the first iteration, and notes what is told.
#[derive(Clone, Default)]
struct Blocked {
    path: PathBuf,
    told: Arc<Mutex<Vec<String>>>,
}

impl Observer for Blocked {
    fn after(&mut self, step: &Step, _: &dyn Resumable) {
        if step.iteration == 1 {
            std::fs::create_dir(&self.path).unwrap();
        }
        let what = if step.saved { "saved" } else { "done" };
        self.told.lock().unwrap().push(format!("{} {what}", step.iteration));
    }

    fn notice(&mut self, notice: &Notice) {
        if let Notice::NotSaved(error) = notice {
            let name = error.path.file_name().unwrap().display().to_string();
            self.told.lock().unwrap().push(format!("{name} not saved"));
        }
    }
}

/// No step says that it was, and nor does the end; that what is in the way cannot be removed is told there.
#[test]
fn a_checkpoint_that_cannot_be_written_is_not_said_to_be_there() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.sppm");
    let blocked = Blocked { path: path.clone(), ..Blocked::default() };
    let mut job = Job::new(small(5));
    job.save = Some(Save { path: path.clone(), every: Every::Iterations(2), keep: false });
    let outcome = job.start(blocked.clone()).unwrap().wait().unwrap();
    let expected = ["1 done", "a.sppm not saved", "2 done", "3 done", "a.sppm not saved", "4 done", "5 done"];
    assert_eq!(*blocked.told.lock().unwrap(), expected);
    assert_eq!(outcome.saved, None);
    assert_eq!(outcome.unsaved.map(|error| error.path), Some(path));
}

/// A goal completes a render as its iterations do: there is nothing to go on with, and what was asked for is kept.
#[test]
fn a_render_that_has_reached_its_goal_leaves_no_checkpoint() {
    for (time, error, end) in [(Some(Duration::ZERO), None, End::Time), (None, Some(1e9), End::Error)] {
        for keep in [false, true] {
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("a.sppm");
            let mut job = Job::new(small(1 << 20));
            (job.engine, job.goals) = (path_tracer(), Goals { time, error });
            job.save = Some(Save { path: path.clone(), every: Every::Iterations(1), keep });
            let outcome = job.start(()).unwrap().wait().unwrap();
            assert_eq!((outcome.end, outcome.report.interrupted), (end, false));
            assert_eq!((path.is_file(), folder.path().read_dir().unwrap().count() > 0), (keep, keep));
        }
    }
}

/// Puts folders in the place of the image and of the checkpoint after the first iteration, and stops the render.
struct Disaster {
    image: PathBuf,
    checkpoint: PathBuf,
    stop: Stop,
}

impl Observer for Disaster {
    fn after(&mut self, _: &Step, _: &dyn Resumable) {
        std::fs::create_dir(&self.image).unwrap();
        std::fs::create_dir(&self.checkpoint).unwrap();
        self.stop.request();
    }
}

/// Once, and told where: it is saved before the image is written, and again where that fails.
#[test]
fn a_stopped_render_that_can_be_written_nowhere_is_saved_beside() {
    let folder = tempfile::tempdir().unwrap();
    let [image, checkpoint] = ["a.pfm", "a.sppm"].map(|name| folder.path().join(name));
    let mut job = Job::new(small(1 << 20));
    job.outputs.image = Some(image.clone());
    job.save = Some(Save { path: checkpoint.clone(), every: Every::default(), keep: false });
    let stop = job.stop.clone();
    let disaster = Disaster { image: image.clone(), checkpoint: checkpoint.clone(), stop };
    let outcome = job.start(disaster).unwrap().wait().unwrap();
    let [failed] = outcome.failed.as_slice() else { panic!("{:?}", outcome.failed) };
    let refuge = failed.refuge.clone().unwrap();
    assert_eq!((&failed.error.path, image_file::read(&refuge).unwrap().pixels.len()), (&image, 40 * 30));
    assert_eq!(outcome.unsaved.map(|error| error.path).as_ref(), Some(&checkpoint));
    let saved = outcome.saved.unwrap();
    let of = |path: &Path| path.parent().map(Path::to_path_buf);
    assert_eq!([of(&saved.path), of(&refuge)], [of(&checkpoint), of(&image)]);
    assert_eq!(Job::resume(&saved.path).unwrap().resumed_after(), Some(1));
    // The two folders that are in the way, and one file in place of each.
    assert_eq!((saved.iterations, folder.path().read_dir().unwrap().count()), (1, 4));
}
