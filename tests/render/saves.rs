//! When checkpoints are written, and what the other files show then.

use crate::small;
use files::image_file;
use render::{Every, Job, Notice, Observer, Outputs, Save, Step};
use scene::{Film, Plane, Resumable, Rgb, Settings};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

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
