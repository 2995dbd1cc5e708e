//! Errors of invalid jobs name the field at fault, and leave no files behind.

use crate::{path_tracer, small};
use files::image_file::Tone;
use render::{EngineChoice, EngineName, Error, Field, Job, LanesName};
use scene::{RadiusSchedule, Rgb, Scene};
use std::path::PathBuf;

/// The field at fault and the message for a job that `change` makes invalid.
fn refused(change: impl FnOnce(&mut Job)) -> (Field, String) {
    let mut job = Job::new(small(1));
    change(&mut job);
    match job.start(()).map(drop) {
        Err(Error::Input { field, problem }) => (field, problem.to_string()),
        other => panic!("not refused: {other:?}"),
    }
}

#[test]
fn the_field_at_fault_is_named() {
    let width = refused(|job| job.scene.settings.width = 0);
    assert_eq!(width, (Field::Setting("width"), "width is 0; it must be at least 1".into()));

    let radius = refused(|job| {
        job.engine = path_tracer();
        job.outputs.radius_image = Some("r.exr".into());
    });
    let said = "radius_image: method path has no photons; leave out one of the two";
    assert_eq!(radius, (Field::RadiusImage, said.into()));

    let exposure = refused(|job| {
        job.outputs.image = Some("a.exr".into());
        job.outputs.exposure = Some(1.0);
    });
    assert_eq!(exposure.0, Field::Exposure);

    for white in [0.0, -1.0, f32::INFINITY, f32::NAN] {
        let tone = refused(|job| {
            job.outputs.image = Some("a.png".into());
            job.outputs.tone = Some(Tone::Reinhard { white });
        });
        assert_eq!(tone.0, Field::Tone, "{white}");
    }

    let twice = refused(|job| {
        job.outputs.image = Some("a.exr".into());
        job.outputs.radius_image = Some("./a.exr".into());
    });
    assert_eq!(twice, (Field::RadiusImage, "radius_image: ./a.exr is also image; name another file".into()));

    // A snapshot would overwrite the image that is repeated, though nobody has named its file as an output.
    let snapshot = refused(|job| {
        job.inputs.push((Field::Like, "a-0001.pfm".into()));
        (job.outputs.image, job.outputs.snapshots) = (Some("a.pfm".into()), true);
    });
    assert_eq!(snapshot.0, Field::Snapshots);
    assert!(snapshot.1.starts_with("snapshots: a-0001.pfm is also "), "{}", snapshot.1);

    let memory = refused(|job| job.memory_limit = Some(1));
    assert_eq!(memory.0, Field::MemoryLimit);

    let (field, _) = refused(|job| job.outputs.image = Some("no/such/folder/a.png".into()));
    assert_eq!(field, Field::Image);
}

/// From code as from options: of a part there are some iterations, and none beyond those of the render.
#[test]
fn a_range_is_of_iterations_that_there_are() {
    for (start, end) in [(2, 2), (3, 2), (0, 5), (4, 5)] {
        let told = refused(|job| {
            let settings = &mut job.scene.settings;
            (settings.iterations, settings.radius_schedule) = (4, RadiusSchedule::Global);
            job.range = Some(start..end);
        });
        let why = "they are counted from 0 to before 4, and the second is left out";
        let said = format!("range {start}..{end}: there are no such iterations; {why}");
        assert_eq!(told, (Field::Range, said));
    }
}

/// A scene built in code has passed no check yet.
#[test]
fn a_scene_that_cannot_be_rendered_is_refused() {
    type Change = fn(&mut Scene);
    let changes: [(Change, &str); 7] = [
        (|scene| scene.camera.eye.x = f32::NAN, "eye of the camera must be finite numbers"),
        (|scene| scene.camera.vertical_fov_degrees = 0.0, "vertical_fov_degrees of the camera is outside"),
        (|scene| scene.materials.clear(), "material of sphere 1 is index 2 of 0 materials"),
        (|scene| scene.spheres[0].radius = -1.0, "radius of sphere 1 must be above 0"),
        (|scene| scene.spheres[1].emission.x = f32::INFINITY, "emission of sphere 2 is outside"),
        (|scene| scene.background = Rgb::ONE, "background of the scene is no light yet"),
        (|scene| scene.spheres.clear(), "there is no light"),
    ];
    for (change, problem) in changes {
        let (field, said) = refused(|job| change(&mut job.scene));
        assert_eq!(field, Field::Scene, "{said}");
        assert!(said.starts_with(&format!("scene: {problem}")), "{said}");
    }
}

#[test]
fn missing_lanes_and_files_are_reported() {
    let lanes = EngineChoice::new(EngineName::Reference, Some(LanesName::Emulated)).unwrap_err();
    assert_eq!(
        lanes.to_string(),
        "lanes: engine reference has no lanes, only fast has; leave out one of the two"
    );
    let dashed = lanes.problem().say(|field| format!("--{}", field.name()));
    assert!(dashed.starts_with("--lanes: --engine reference has no lanes"), "{dashed}");

    let missing = PathBuf::from("no such.sppm");
    for error in [Job::resume(&missing).unwrap_err(), Job::like(&missing, None).unwrap_err()] {
        assert_eq!(error.to_string(), "no such.sppm: there is no such file");
    }
    // Whatever its name promises; nor does a checkpoint that is looked for leave a lock.
    let folder = tempfile::tempdir().unwrap();
    for name in ["none.png", "none.txt", "none"] {
        let path = folder.path().join(name);
        let told = format!("{}: there is no such file", path.display());
        assert_eq!(Job::like(&path, None).unwrap_err().to_string(), told);
        assert_eq!(Job::resume(&path).unwrap_err().to_string(), told);
    }
    assert_eq!(folder.path().read_dir().unwrap().count(), 0);
}

/// A rejected job writes no output, checkpoint or lock file.
#[test]
fn a_rejected_job_leaves_no_files() {
    let folder = tempfile::tempdir().unwrap();
    let image = folder.path().join("a.png");
    refused(|job| {
        job.outputs.image = Some(image.clone());
        job.save = Some(render::Save { keep: true, ..render::Save::beside(&image) });
        job.memory_limit = Some(1);
    });
    assert_eq!(folder.path().read_dir().unwrap().count(), 0);
}
