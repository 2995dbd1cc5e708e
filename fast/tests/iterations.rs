//! Whole iterations: what is held, how long passes take, and what is left from one render to the next. Not unit tests, as the
//! kernels of all lanes would be built once more for these.

use fast::{LaneKind, Parameters, Parts, PathTracer, Sppm};
use scene::{Engine, Scene, Settings, Stats};
use std::time::Instant;

/// What the sums of a join take for 16 pixels: four bytes of each for a count and 24 for the flux, and a pointer.
const BYTES_OF_SUMS: u64 = 16 * 28 + 8;

/// Per iteration, on one thread: the pairs tested and the bytes held.
fn iterations(mut engine: Sppm, count: u32) -> Vec<(u64, u64)> {
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let iteration = |_| {
        let before = engine.stats().candidates;
        one_thread.install(|| engine.iterate());
        (engine.stats().candidates - before, engine.stats().bytes)
    };
    (0..count).map(iteration).collect()
}

/// Sums of all pixels are held if the last join was long.
#[test]
fn a_join_is_long_after_one_that_tested_many_pairs() {
    let scene = files::builtin::scene("cornell").unwrap();
    let settings = Settings { width: 64, height: 48, photons_per_iteration: 20_000, ..scene.settings };
    let engine = || Sppm::new(&scene, &settings);
    let short = iterations(engine(), 3);
    let most = short.iter().map(|iteration| iteration.0).max().unwrap();
    assert_eq!(iterations(engine().long_join(most + 1), 3), short);
    let sums = BYTES_OF_SUMS * 64 * 48 / 16;
    let from_the_second = iterations(engine().long_join(1), 3);
    let always = iterations(engine().long_join(0), 3);
    for (number, iteration) in short.iter().enumerate() {
        let (pairs, bytes) = *iteration;
        let held = if number > 0 { bytes + sums } else { bytes };
        assert_eq!(from_the_second[number], (pairs, held));
        assert_eq!(always[number], (pairs, bytes + sums));
    }
}

/// The first join is long if there are many deposits.
#[test]
fn a_first_join_is_long_where_there_are_many_deposits() {
    let scene = files::builtin::scene("cornell").unwrap();
    let bytes = |photons, long_join: Option<u64>| {
        let settings = Settings {
            width: 16,
            height: 16,
            photons_per_iteration: photons,
            initial_radius: 20.0,
            ..scene.settings
        };
        let engine = Sppm::new(&scene, &settings);
        iterations(if let Some(pairs) = long_join { engine.long_join(pairs) } else { engine }, 1)[0].1
    };
    assert!(bytes(10_000, None) < bytes(10_000, Some(0)));
    assert_eq!(bytes(1 << 20, None), bytes(1 << 20, Some(0)));
}

#[test]
fn seconds_of_passes_add_up_to_no_more_than_all() {
    let scene = files::builtin::scene("cornell").unwrap();
    let settings = Settings { width: 40, height: 30, photons_per_iteration: 5000, ..scene.settings };
    let began = Instant::now();
    let mut engine = Sppm::new(&scene, &settings);
    for _ in 0..3 {
        engine.iterate();
        let all = began.elapsed().as_secs_f64();
        let Stats { camera_seconds, build_grid_seconds, photon_seconds, consolidate_seconds, .. } =
            *engine.stats();
        let passes = [camera_seconds, build_grid_seconds, photon_seconds, consolidate_seconds];
        assert!(passes.iter().all(|&seconds| seconds > 0.0), "{passes:?}");
        assert!(passes.iter().sum::<f64>() <= all, "{passes:?} in {all}");
    }
}

/// Camera, materials, sizes, spheres and photons change from render to render; the parts go on.
#[test]
fn an_image_does_not_depend_on_the_parts_of_renders_before() {
    let small = Settings { width: 24, height: 17, photons_per_iteration: 3000, ..Settings::default() };
    let mut scene = files::builtin::scene("random").unwrap();
    let mut parts = Parts::default();
    let changes: [fn(&mut Scene, &mut Settings); 10] = [
        |_, _| {},
        |scene, _| scene.camera.eye.x += 1.0,
        |scene, _| scene.materials.rotate_left(1),
        |_, settings| settings.width = 40,
        |scene, _| scene.spheres.swap(7, 8),
        |scene, settings| (scene.spheres[9].radius, settings.height) = (scene.spheres[9].radius * 0.5, 9),
        |_, settings| settings.photons_per_iteration = 60_000,
        // Tables as wide as those before would be read beyond what these few photons fill.
        |_, settings| settings.photons_per_iteration = 2000,
        |_, settings| (settings.photons_per_iteration, settings.initial_radius) = (500, 20.0),
        |_, settings| settings.photons_per_iteration = 150,
    ];
    let mut settings = small;
    for (number, change) in changes.into_iter().enumerate() {
        change(&mut scene, &mut settings);
        let image = |parts| {
            let (lanes, parameters) = (LaneKind::best(), Parameters::default());
            let mut engine = Sppm::with_parts(&scene, &settings, lanes, &parameters, parts);
            engine.iterate();
            engine.iterate();
            (engine.develop(), engine.into_parts())
        };
        let (fresh, _) = image(Parts::default());
        let (warm, used) = image(parts);
        assert_eq!(warm, fresh, "after change {number}");
        parts = used;
    }
}

/// Per pixel 36 bytes; the image is rendered in tiles of 8x8.
#[test]
fn path_tracing_holds_whole_tiles() {
    let scene = files::builtin::scene("cornell").unwrap();
    let settings = Settings { width: 20, height: 9, max_depth: 1, ..scene.settings };
    let mut engine = PathTracer::new(&scene, &settings);
    engine.iterate();
    assert_eq!(engine.stats().bytes, 24 * 16 * 36);
}
