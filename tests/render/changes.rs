//! Changes the job of a finished render and starts it again.

use crate::{endless, image, small};
use render::{End, Error, Every, Field, Job, Save};
use scene::{Automatic, Material, Quality, Rgb};
use std::time::Duration;

type Change = fn(&mut Job);

#[test]
fn camera_materials_and_settings_change_between_starts() {
    let mut job = Job::new(small(3));
    job.threads = Some(2);
    let changes: [Change; 5] = [
        |_| {},
        |job| job.scene.camera.eye.x += 3.0,
        |job| job.scene.materials[0] = Material::Diffuse { albedo: Rgb::new(0.2, 0.4, 0.6) },
        |job| (job.scene.settings.width, job.scene.settings.seed) = (33, 7),
        |job| job.threads = Some(1),
    ];
    for change in changes {
        change(&mut job);
        let expected = image(&job.scene);
        let outcome = job.start(()).unwrap().wait().unwrap();
        assert_eq!(outcome.last.unwrap().film, expected);
        assert_eq!(Some(outcome.report.threads), outcome.job.threads);
        job = outcome.job;
    }
}

#[test]
fn a_render_that_was_stopped_starts_again() {
    let running = endless().start(()).unwrap();
    std::thread::sleep(Duration::from_millis(20));
    running.stopper().request();
    let mut job = running.wait().unwrap().job;
    job.scene.settings.iterations = 2;
    let expected = image(&job.scene);
    let outcome = job.start(()).unwrap().wait().unwrap();
    assert_eq!((outcome.end, outcome.report.iterations), (End::Iterations, 2));
    assert_eq!(outcome.last.unwrap().film, expected);
}

#[test]
fn a_checkpoint_can_be_resumed_and_repeated() {
    let folder = tempfile::tempdir().unwrap();
    let mut job = Job::new(small(4));
    let image_file = folder.path().join("a.pfm");
    job.outputs.image = Some(image_file.clone());
    job.save = Some(Save { keep: true, ..Save::beside(&image_file) });
    let outcome = job.start(()).unwrap().wait().unwrap();
    let saved = outcome.saved.unwrap();
    assert_eq!((saved.iterations, saved.path.file_name().unwrap().to_str()), (4, Some("a.pfm.sppm")));
    assert_eq!(outcome.written, [image_file]);

    let mut resumed = Job::resume(&saved.path).unwrap();
    assert_eq!(resumed.resumed_after(), Some(4));
    resumed.scene.settings.iterations = 6;
    let outcome = resumed.start(()).unwrap().wait().unwrap();
    assert_eq!(outcome.report.resumed_after, 4);
    assert_eq!(outcome.last.unwrap().film, image(&small(6)));

    let again = outcome.job.start(()).unwrap().wait().unwrap();
    assert_eq!((again.report.resumed_after, again.report.iterations), (6, 6));

    let like = Job::like(&saved.path, None).unwrap();
    assert_eq!(like.scene.settings, small(6).settings);
}

/// It is the render that was begun: nothing is chosen anew, whatever is asked for.
#[test]
fn a_resumed_render_keeps_its_settings() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.sppm");
    let mut job = Job::new(small(2));
    job.save = Some(Save { path: file.clone(), every: Every::default(), keep: true });
    job.start(()).unwrap().wait().unwrap();
    let mut resumed = Job::resume(&file).unwrap().choosing(Automatic::all(Quality::Draft));
    resumed.scene.settings.iterations = 3;
    let outcome = resumed.start(()).unwrap().wait().unwrap();
    assert_eq!((outcome.report.resumed_after, outcome.report.settings), (2, small(3).settings));
    assert_eq!(outcome.last.unwrap().film, image(&small(3)));
}

/// The checkpoint that a stopped render leaves beside its image is gone on from, even if it is named as the render to repeat.
#[test]
fn a_checkpoint_beside_the_image_may_be_what_is_repeated() {
    let folder = tempfile::tempdir().unwrap();
    let image_file = folder.path().join("a.pfm");
    let mut job = Job::new(small(2));
    job.outputs.image = Some(image_file.clone());
    job.save = Some(Save { keep: true, ..Save::beside(&image_file) });
    let saved = job.start(()).unwrap().wait().unwrap().saved.unwrap();
    let like = |keep| {
        let mut job = Job::like(&saved.path, None).unwrap();
        job.outputs.image = Some(image_file.clone());
        job.save = Some(Save { keep, ..Save::beside(&image_file) });
        job.start(())
    };
    // Kept under this name it would be an output like others, that overwrites an input.
    let error = like(true).map(drop).unwrap_err();
    assert!(matches!(error, Error::Input { field: Field::Checkpoint, .. }), "{error:?}");
    let outcome = like(false).unwrap().wait().unwrap();
    assert_eq!((outcome.report.resumed_after, outcome.report.iterations), (2, 2));
    assert_eq!(outcome.last, None, "there was nothing left to be rendered");
    assert_eq!(files::image_file::read(&image_file).unwrap(), image(&small(2)));
}

/// The sums of a checkpoint are worth nothing to another scene or other settings.
#[test]
fn a_resumed_job_must_be_the_render_that_was_stopped() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.sppm");
    let mut job = Job::new(small(2));
    job.save = Some(Save { path: file.clone(), every: Every::default(), keep: true });
    job.start(()).unwrap().wait().unwrap();
    let kept = std::fs::read(&file).unwrap();

    let changes: [(Change, &str); 4] = [
        (|job| job.scene.camera.eye.x += 1.0, "another scene"),
        (|job| job.scene.materials[0] = Material::Diffuse { albedo: Rgb::splat(0.25) }, "another scene"),
        (|job| job.scene.settings.width += 1, "other settings"),
        (|job| job.scene.settings.seed += 1, "other settings"),
    ];
    for (change, what) in changes {
        let mut resumed = Job::resume(&file).unwrap();
        change(&mut resumed);
        let error = resumed.start(()).map(drop).expect_err(what);
        assert!(matches!(error, Error::Input { field: Field::Resumed, .. }), "{error:?}");
        assert!(error.to_string().contains(what), "{error}");
    }
    assert_eq!(std::fs::read(&file).unwrap(), kept);
}
