//! Goes on with renders from their checkpoints: in the same file or in another, which may be that of another render.

use crate::{image, path_tracer, small};
use render::{End, Error, Every, Field, Job, Made, Metadata, Notice, Observer, Save, Saved};
use scene::text::counted;
use scene::{RadiusSchedule, Scene, Settings};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Sender, channel};
use std::time::Duration;
use tempfile::TempDir;

/// A render that takes no time.
fn tiny(iterations: u32) -> Scene {
    let scene = small(iterations);
    let settings = Settings { width: 8, height: 6, photons_per_iteration: 100, ..scene.settings };
    Scene { settings, ..scene }
}

/// A job of `scene` whose checkpoint is kept at `file`.
fn kept(scene: Scene, file: &Path) -> Job {
    let mut job = Job::new(scene);
    job.save = Some(Save { path: file.to_owned(), every: Every::Iterations(1), keep: true });
    job
}

/// Runs a job to its end.
fn run(job: Job) -> render::Outcome {
    job.start(()).unwrap().wait().unwrap()
}

/// A folder with the checkpoint of a tiny render of so many iterations; its path, and that of another.
fn begun(iterations: u32) -> (TempDir, PathBuf, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let [file, other] = ["a.sppm", "other.sppm"].map(|name| folder.path().join(name));
    run(kept(tiny(iterations), &file));
    (folder, file, other)
}

/// The render of the checkpoint `file`, with so many iterations, and with its checkpoint at `save`.
fn resumed(file: &Path, iterations: u32, save: &Path) -> Job {
    let mut job = Job::resume(file).unwrap();
    job.scene.settings.iterations = iterations;
    save.clone_into(&mut job.save.as_mut().unwrap().path);
    job
}

/// Why a job is refused, by a problem of its checkpoint.
fn refused(job: Job) -> String {
    match job.start(()).map(drop) {
        Err(Error::Input { field: Field::Checkpoint, problem }) => problem.to_string(),
        other => panic!("{other:?}"),
    }
}

/// Iterations in the checkpoint that would be resumed.
fn iterations_in(file: &Path) -> u32 {
    Job::resume(file).unwrap().resumed_after().unwrap()
}

/// Unless something else is asked for: in the same place, as often, and kept.
#[test]
fn checkpoints_of_a_resumed_render_are_written_as_before() {
    let folder = tempfile::tempdir().unwrap();
    for (name, every) in [("a.sppm", Every::Iterations(5)), ("b.sppm", Every::Time(Duration::from_secs(7)))] {
        let save = Save { path: folder.path().join(name), every, keep: true };
        let mut job = Job::new(tiny(1));
        job.save = Some(save.clone());
        run(job);
        assert_eq!(Job::resume(&save.path).unwrap().save, Some(save));
    }
}

/// Neither of another scene, seed or method, nor of more iterations than are asked for; nor what is no checkpoint at all.
#[test]
fn a_resumed_job_overwrites_no_checkpoint_of_another_render() {
    type Change = fn(&mut Job);
    let (_folder, file, other) = begun(2);
    let changes: [(Change, &str); 4] = [
        (|job| job.scene.camera.eye.x += 1.0, "of another scene, Cornell Box"),
        (|job| job.scene.settings.seed += 1, "of other settings"),
        (|job| job.engine = path_tracer(), "of path tracing"),
        (|job| job.scene.settings.iterations = 5, "of this render, more than 3"),
    ];
    for (change, what) in changes {
        let mut job = kept(tiny(1), &other);
        change(&mut job);
        let done = job.scene.settings.iterations;
        run(job);
        let before = std::fs::read(&other).unwrap();
        // Whether or not it would be removed in the end.
        for keep in [true, false] {
            let mut job = resumed(&file, 3, &other);
            job.save.as_mut().unwrap().keep = keep;
            let told = refused(job);
            let shown = other.display();
            let done = counted(done, "iteration");
            assert!(told.starts_with(&format!("{shown} holds {done} {what}; ")), "{told}");
            assert!(std::fs::read(&other).unwrap() == before, "{what}");
        }
        std::fs::remove_file(&other).unwrap();
    }
    let (_folder, file, other) = begun(2);
    std::fs::write(&other, "a letter").unwrap();
    let told = refused(resumed(&file, 3, &other));
    assert!(told.contains("is no checkpoint of sppm"), "{told}");
    assert_eq!(std::fs::read(&other).unwrap(), b"a letter");
}

/// The whole, or another part, are other iterations, though of the same image.
#[test]
fn a_resumed_part_overwrites_no_other_part() {
    let folder = tempfile::tempdir().unwrap();
    let part = |name: &str, range| {
        let (scene, path) = (tiny(6), folder.path().join(name));
        let settings = Settings { radius_schedule: RadiusSchedule::Global, ..scene.settings };
        let mut job = kept(Scene { settings, ..scene }, &path);
        job.range = range;
        run(job);
        path
    };
    let file = part("first.sppm", Some(0..2));
    for (name, range, told) in [
        ("second.sppm", Some(2..5), "holds 3 iterations of this render's 2..5, another part; "),
        ("whole.sppm", None, "holds 6 iterations of this render's 0..6, another part; "),
    ] {
        let other = part(name, range);
        let before = std::fs::read(&other).unwrap();
        let said = refused(resumed(&file, 6, &other));
        assert!(said.contains(told), "{said}");
        assert!(std::fs::read(&other).unwrap() == before, "{name}");
    }
    // By another name it is the same file, in which all is saved already.
    let older = folder.path().join("first.sppm.1");
    let before = std::fs::read(&older).unwrap();
    let same = folder.path().join(".").join("first.sppm");
    assert_eq!(run(resumed(&file, 6, &same)).report.resumed_after, 2);
    assert!(std::fs::read(&older).unwrap() == before);
}

/// So it is not taken for one of the first iterations, nor repeated as if it were.
#[test]
fn an_image_of_a_part_says_which_iterations_it_has() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let scene = tiny(6);
    let settings = Settings { radius_schedule: RadiusSchedule::Global, ..scene.settings };
    let mut job = Job::new(Scene { settings, ..scene });
    (job.range, job.outputs.image) = (Some(2..5), Some(path.clone()));
    let report = run(job).report;
    assert_eq!((report.iterations, report.settings.iterations, report.stats.photons), (3, 6, 300));
    let Ok(Made::Image(made)) = Made::read(&path) else { panic!("no image") };
    assert_eq!((made.which, made.settings.iterations, made.photons), (Some((2..5).into()), 3, 300));
    let said = Job::like(&path, None).unwrap_err().to_string();
    assert!(said.contains("a.exr: it holds the iterations 2..5 of a render"), "{said}");
}

/// It may be about to be replaced by the other render.
#[test]
fn a_checkpoint_that_is_in_use_is_not_looked_at() {
    let (_folder, file, _) = begun(1);
    let other = || {
        let mut scene = tiny(1);
        scene.settings.seed += 1;
        refused(kept(scene, &file))
    };
    let lock = files::lock::Lock::take(&file).unwrap();
    let said = other();
    assert!(said.starts_with("checkpoint: ") && said.contains("a.sppm: is in use by another"), "{said}");
    drop(lock);
    assert!(other().contains("a.sppm holds 1 iteration of other settings; continue it by Job::resume, "));
}

/// Even if no iteration is left: what was resumed is not in another file before it is written there. Where it was, it stays.
#[test]
fn a_resumed_job_may_have_its_checkpoint_elsewhere() {
    for iterations in [2, 3] {
        let (_folder, file, other) = begun(2);
        let before = std::fs::read(&file).unwrap();
        let outcome = run(resumed(&file, iterations, &other));
        assert_eq!(outcome.saved, Some(Saved { path: other.clone(), iterations }));
        assert_eq!(iterations_in(&other), iterations);
        assert!(std::fs::read(&file).unwrap() == before);
        // What comes back begins anew: the file is no input any more.
        assert!(outcome.job.inputs.is_empty());
        // Of the same render it is replaced, and what was named is resumed, not what is there.
        let outcome = run(resumed(&file, 4, &other));
        assert_eq!((outcome.report.resumed_after, iterations_in(&other)), (2, 4));
        assert_eq!(outcome.last.unwrap().film, image(&tiny(4)));
        // One that is not to be kept goes in the end, and goes alone.
        let mut job = resumed(&file, 5, &other);
        job.save.as_mut().unwrap().keep = false;
        run(job);
        assert!(!other.exists() && std::fs::read(&file).unwrap() == before);
    }
}

/// As that of any other job: it is neither an output nor an input.
#[test]
fn the_checkpoint_of_a_resumed_job_is_a_file_of_its_own() {
    let (folder, file, other) = begun(2);
    let mut job = resumed(&file, 3, &other);
    job.outputs.stats = Some(other.clone());
    let shown = other.display();
    assert_eq!(refused(job), format!("checkpoint: {shown} is also stats; name another file"));
    let mut job = resumed(&file, 3, &other);
    job.inputs.push((Field::Scene, folder.path().join("other.sppm")));
    assert_eq!(refused(job), format!("checkpoint: {shown} is also scene; name another file"));
    assert!(!other.exists());
}

/// The older generation, from which the render has gone on, stays the older one: the damaged one is what is replaced.
#[test]
fn a_damaged_generation_does_not_become_the_older_one() {
    // Whether or not there is another iteration.
    for is_stopped in [false, true] {
        let (_folder, file, _) = begun(3);
        let older = file.with_file_name("a.sppm.1");
        let good = std::fs::read(&older).unwrap();
        std::fs::write(&file, "damaged").unwrap();
        assert_eq!(iterations_in(&file), 2);
        let job = resumed(&file, 3, &file);
        if is_stopped {
            job.stop.request();
        }
        assert_eq!(run(job).report.resumed_after, 2);
        let found = [&file, &older].map(|path| std::fs::read(path).ok());
        if is_stopped {
            assert!(found == [Some(good), None]);
            continue;
        }
        assert!(found[1].as_ref() == Some(&good) && iterations_in(&file) == 3);
        // The newest may also be missing.
        std::fs::remove_file(&file).unwrap();
        assert_eq!(iterations_in(&file), 2);
        let Ok(Made::Checkpoint(made)) = Made::read(&file) else { panic!("not found") };
        assert_eq!((made.checkpoint.account.iterations, made.fallback.is_some()), (2, true));
    }
}

/// Elsewhere nothing is damaged: no older generation is taken for the newest there.
#[test]
fn an_older_generation_is_resumed_to_another_file() {
    let (_folder, file, other) = begun(3);
    let older = file.with_file_name("a.sppm.1");
    std::fs::write(&file, "damaged").unwrap();
    let before = [&file, &older].map(|path| std::fs::read(path).unwrap());
    let outcome = run(resumed(&file, 2, &other));
    assert_eq!(outcome.saved, Some(Saved { path: other.clone(), iterations: 2 }));
    assert_eq!(iterations_in(&other), 2);
    assert!([&file, &older].map(|path| std::fs::read(path).unwrap()) == before);
    // The same render finds it there as well.
    assert_eq!(run(kept(tiny(3), &file)).report.resumed_after, 2);
    assert!(std::fs::read(&older).unwrap() == before[1]);
}

/// From when it is read, not only from when the render starts: until then another render could replace it.
#[test]
fn a_checkpoint_is_locked_as_long_as_it_is_to_be_resumed() {
    let (_folder, file, other) = begun(1);
    let first = Job::resume(&file).unwrap();
    let said = Job::resume(&file).unwrap_err().to_string();
    assert!(said.contains("a.sppm: is in use by another render, process "), "{said}");
    drop(first);
    // So it is in a render whose own checkpoint is elsewhere.
    let running = resumed(&file, 1 << 30, &other).start(()).unwrap();
    assert!(Job::resume(&file).is_err() && Job::resume(&other).is_err());
    drop(running);
    assert_eq!(iterations_in(&file), 1);
}

/// The image is of the iterations that were there, and the checkpoint stays: from now on with as many to go as are asked for.
#[test]
fn a_resumed_render_that_is_stopped_at_once_has_an_image() {
    let (folder, file, _) = begun(2);
    let path = folder.path().join("a.pfm");
    let mut job = resumed(&file, 5, &file);
    job.outputs.image = Some(path.clone());
    job.save.as_mut().unwrap().keep = false;
    job.stop.request();
    let outcome = run(job);
    assert_eq!((outcome.end, outcome.report.iterations, outcome.report.interrupted), (End::Stopped, 2, true));
    assert_eq!((outcome.written, outcome.failed), (vec![path.clone()], vec![]));
    assert_eq!(files::image_file::read(&path).unwrap(), image(&tiny(2)));
    assert_eq!(outcome.saved, Some(Saved { path: file.clone(), iterations: 2 }));
    let again = Job::resume(&file).unwrap();
    assert_eq!((again.resumed_after(), again.wanted()), (Some(2), 0..5));
}

/// Resumed or repeated, a render has all iterations that were asked for, not those that were done.
#[test]
fn what_was_asked_for_is_asked_for_again() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.sppm");
    let mut job = kept(tiny(5), &file);
    job.goals.time = Some(Duration::ZERO);
    let outcome = run(job);
    assert_eq!((outcome.end, outcome.report.iterations), (End::Time, 1));
    let job = Job::resume(&file).unwrap();
    assert_eq!((job.resumed_after(), job.wanted(), job.goals.time), (Some(1), 0..5, None));
    drop(job);
    assert_eq!(Job::like(&file, None).unwrap().scene.settings, tiny(5).settings);
}

/// Sends what is told of the light transport.
struct Transport(Sender<(PathBuf, u32)>);

impl Observer for Transport {
    fn notice(&mut self, notice: &Notice) {
        if let Notice::OtherTransport { path, transport } = notice {
            self.0.send((path.clone(), *transport)).unwrap();
        }
    }
}

/// Of an image as of a checkpoint, and only if it is another version that made it.
#[test]
fn repeating_an_image_of_another_light_transport_is_told() {
    use files::image_file::{Encoding, read, read_note, write};
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let mut job = Job::new(tiny(1));
    job.outputs.image = Some(path.clone());
    run(job);
    let told = || {
        let (sender, told) = channel();
        Job::like(&path, None).unwrap().start(Transport(sender)).unwrap().wait().unwrap();
        told.iter().collect::<Vec<_>>()
    };
    assert!(told().is_empty());
    let metadata = Metadata::from_note(&read_note(&path).unwrap().unwrap()).unwrap();
    let note = Metadata { transport: 3, ..metadata }.to_note();
    let encoding = Encoding { note: Some(&note), ..Encoding::default() };
    write(&path, &read(&path).unwrap(), &encoding).unwrap();
    assert_eq!(told(), [(path.clone(), 3)]);
}
