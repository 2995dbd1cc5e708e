//! Tests of the library `render` through its public interface.

mod alpha;
#[path = "../shared/cases.rs"]
mod cases;
mod changes;
mod error_goal;
mod errors;
mod images;
mod lives;
mod merge;
mod progress;
mod resumes;
mod saves;
mod trace;

use render::{EngineChoice, Job, MethodName};
use scene::{Engine, Film, Scene, Settings};

/// The scene `cornell` at a small size, with the given number of iterations.
fn small(iterations: u32) -> Scene {
    let scene = files::builtin::scene("cornell").unwrap();
    let settings =
        Settings { width: 40, height: 30, iterations, photons_per_iteration: 5000, ..scene.settings };
    Scene { settings, ..scene }
}

/// The image of `scene` by the fast engine itself, without the library.
fn image(scene: &Scene) -> Film {
    let mut engine = fast::Sppm::new(scene, &scene.settings);
    for _ in 0..scene.settings.iterations {
        engine.iterate();
    }
    engine.develop()
}

/// A job whose render takes much longer than a test.
fn endless() -> Job {
    let mut job = Job::new(small(1 << 30));
    job.threads = Some(1);
    job
}

/// The path tracer.
fn path_tracer() -> EngineChoice {
    EngineChoice::new(MethodName::Path, None).unwrap()
}
