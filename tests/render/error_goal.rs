//! The error that a render estimates for a goal: noise, and the bias of photon mapping.

use crate::small;
use fast::{PathTracer, Sppm};
use files::image_file::read_note;
use render::{
    EngineChoice, EngineName, Estimate, Job, Metadata, MethodName, Notice, Observer, Renderer, Step,
};
use scene::radius_schedule::Shrinking;
use scene::{Engine, RadiusSchedule, Resumable, Scene, Settings};
use std::sync::mpsc::{Sender, channel};

/// The error that is told of a render of so many iterations.
fn told(scene: &Scene, iterations: u32) -> f64 {
    let mut job = Job::new(Scene { settings: Settings { iterations, ..scene.settings }, ..scene.clone() });
    job.goals.error = Some(1e-9);
    job.start(()).unwrap().wait().unwrap().report.estimated_error.unwrap()
}

/// What is told beside noise is the same bias at all times, which falls as the mean of the squared radii does: by global radii
/// that is known.
#[test]
fn the_error_is_of_noise_and_of_a_bias_that_falls_with_the_radius() {
    /// Differences of squares lose digits, and radii are read as `f32`.
    const ROUNDING: f64 = 1e-4;
    let scene = small(32);
    let radius_schedule = RadiusSchedule::Global;
    let (width, height, max_depth, initial_radius) = (64, 48, 16, 16.0);
    let settings = Settings { width, height, max_depth, initial_radius, radius_schedule, ..scene.settings };
    let scene = Scene { settings, ..scene };
    let (mut engine, mut noise) = (Sppm::new(&scene, &scene.settings), Estimate::default());
    let mut biases = Vec::new();
    for n in 1..=scene.settings.iterations {
        engine.iterate();
        noise.update(n, || engine.develop());
        if matches!(n, 2 | 4 | 8 | 32) {
            let noise = noise.error.unwrap();
            // The mean of `i^(-1/3)` up to n is 3/2 of the last; in no pixel is light blurred more than at first.
            let share = 1.5 * f64::from(Shrinking::default().radius_squared(1.0, n));
            biases.push((told(&scene, n).powi(2) - noise * noise).sqrt() / share.min(1.0));
        }
    }
    assert!(biases[0] > 0.0, "{biases:?}");
    for bias in &biases {
        assert!((bias / biases[0] - 1.0).abs() < ROUNDING, "{biases:?}");
    }
}

/// Paths gather no photons, so nothing is blurred: the error of path tracing is its noise alone.
#[test]
fn the_error_of_paths_is_of_noise_alone() {
    let scene = small(4);
    let mut job = Job::new(scene.clone());
    job.engine = EngineChoice::new(MethodName::Path, None).unwrap();
    job.goals.error = Some(1e-9);
    let found = job.start(()).unwrap().wait().unwrap().report.estimated_error;
    let (mut engine, mut noise) = (PathTracer::new(&scene, &scene.settings), Estimate::default());
    for n in 1..=4 {
        engine.iterate();
        noise.update(n, || engine.develop());
    }
    let (found, noise) = (found.unwrap(), noise.error.unwrap());
    // The root of its square.
    assert!((found / noise - 1.0).abs() < 1e-12, "{found}, not {noise}");
}

/// A goal ends a render, and is of no account for its image. The estimate finds the first radii of the pixels before.
#[test]
fn an_image_is_the_same_with_a_goal() {
    let (per_pixel, global) = (RadiusSchedule::PerPixel, RadiusSchedule::Global);
    let cases = [
        (MethodName::Sppm, 0, per_pixel),
        (MethodName::Sppm, 1, per_pixel),
        (MethodName::Sppm, 0, global),
        (MethodName::Hybrid, 1, per_pixel),
    ];
    for (method, radius_pilots, radius_schedule) in cases {
        let scene = small(3);
        let settings = Settings { radius_pilots, radius_schedule, initial_radius: 8.0, ..scene.settings };
        let scene = Scene { settings, ..scene };
        for engine in EngineName::ALL {
            let film = |goal: Option<f64>| {
                let mut job = Job::new(scene.clone());
                job.engine = EngineChoice::new(Renderer { method, engine }, None).unwrap();
                job.goals.error = goal;
                job.start(()).unwrap().wait().unwrap().last.unwrap().film.clone()
            };
            let case = format!("{radius_pilots} pilots, {radius_schedule}, {method:?} by {engine:?}");
            assert_eq!(film(Some(1e-9)), film(None), "{case}");
        }
    }
}

/// Keeps the memory that a render tells at its start.
struct Memory(Sender<u64>);

impl Observer for Memory {
    fn notice(&mut self, notice: &Notice) {
        if let Notice::Begun { bytes_at_most, .. } = notice {
            self.0.send(*bytes_at_most).unwrap();
        }
    }
}

/// They are renders of the fast engine by themselves, of many photons, whatever engine renders the image.
#[test]
fn the_pilots_of_the_bias_count_as_memory() {
    let told = |goal: Option<f64>| {
        let (sender, told) = channel();
        let scene = small(1);
        let settings = Settings { width: 4, height: 3, photons_per_iteration: 10, ..scene.settings };
        let mut job = Job::new(Scene { settings, ..scene });
        job.engine = EngineChoice::new(EngineName::Reference, None).unwrap();
        job.goals.error = goal;
        job.start(Memory(sender)).unwrap().wait().unwrap();
        told.recv().unwrap()
    };
    let (without, with) = (told(None), told(Some(1e9)));
    assert!(with > without + (1 << 20), "{with} and {without} bytes");
}

/// With every step once it is known, and in the image.
#[test]
fn the_error_is_told_with_steps_and_in_the_image() {
    struct Steps(Sender<Option<f64>>);

    impl Observer for Steps {
        fn after(&mut self, step: &Step, _: &dyn Resumable) {
            let _ = self.0.send(step.estimated_error);
        }
    }

    let folder = tempfile::tempdir().unwrap();
    let image = folder.path().join("a.exr");
    let (told, steps) = channel();
    let mut job = Job::new(small(4));
    job.goals.error = Some(1e-9);
    job.outputs.image = Some(image.clone());
    let report = job.start(Steps(told)).unwrap().wait().unwrap().report;
    let told: Vec<Option<f64>> = steps.iter().collect();
    assert_eq!((told.len(), told[0].is_none(), told[1].is_some()), (4, true, true));
    let metadata = Metadata::from_note(&read_note(&image).unwrap().unwrap()).unwrap();
    assert_eq!([told[3], metadata.estimated_error], [report.estimated_error; 2]);
    assert!(report.estimated_error.is_some());
}
