//! Whole iterations: what is held, how long passes take, and what is left from one render to the next. Not unit tests, as the
//! kernels of all lanes would be built once more for these.

use fast::{LaneKind, Parameters, Parts, PathTracer, Sppm};
use scene::film::tile_of;
use scene::{Engine, Filter, RadiusSchedule, Resumable as _, Scene, Settings, Stats, Stop};
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

/// However many photons there are and however deep they go: 51 bytes for each deposit, a thread's bins with room in advance and for a
/// bin that is sorted, starts of 2^16 buckets and a bit for each, and pixels with their sums.
#[test]
fn rounds_hold_no_more_deposits_than_are_wanted_at_once() {
    let scene = files::builtin::scene("cornell").unwrap();
    let settings = Settings {
        width: 16,
        height: 16,
        photons_per_iteration: 40_000,
        max_depth: 9,
        initial_radius: 30.0,
        ..scene.settings
    };
    let others = 2 * 170 * 256 * 48 + 33 * (1 << 16) / 8 + 16 * 16 * 88 + 16 * BYTES_OF_SUMS;
    for most in [50_000, 100_000] {
        for (_, bytes) in iterations(Sppm::new(&scene, &settings).deposits_at_once(most), 2) {
            assert!(bytes < 51 * u64::from(most) + others, "{bytes} bytes of {most} deposits");
        }
    }
}

/// The pairs tested and the bytes held in a first iteration, in rounds of so many deposits, and the deposits kept in the last
/// round.
fn first_iteration(lanes: LaneKind, parameters: &Parameters, at_once: u32) -> [u64; 3] {
    let scene = files::builtin::scene("cornell").unwrap();
    let settings = Settings {
        width: 32,
        height: 24,
        photons_per_iteration: 8000,
        initial_radius: 2.0,
        max_depth: 6,
        ..Settings::default()
    };
    let mut engine = Sppm::with_parameters(&scene, &settings, lanes, parameters).deposits_at_once(at_once);
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    one_thread.install(|| engine.iterate());
    [engine.stats().candidates, engine.stats().bytes, engine.kept() as u64]
}

/// In the pairs tested, the bytes held, or the deposits kept; the others show in time alone.
#[test]
fn free_parameters_show() {
    let at = |name, value, at_once| {
        let parameters = Parameters::default().with(name, value).unwrap();
        first_iteration(LaneKind::Avx2, &parameters, at_once)
    };
    let pairs = |name, value| at(name, value, u32::MAX)[0];
    let bytes = |name, value| at(name, value, u32::MAX)[1];
    let kept = |name, value| at(name, value, u32::MAX)[2];
    assert!(pairs("cell_size", 2.0) < pairs("cell_size", 12.0));
    assert!(pairs("neighbours_at_first", 64.0) < pairs("neighbours_at_first", 0.25));
    // Four bytes and a bit for each bucket.
    let [some, more] = [1.0, 4.0].map(|buckets| bytes("buckets_per_photon", buckets));
    assert_eq!(more - some, 33 * (32_768 - 8192) / 8);
    // Coarse cells, and those that share a bit with others, keep photons that nothing can reach.
    assert!(kept("occupancy_cell_size", 0.5) < kept("occupancy_cell_size", 8.0));
    assert!(kept("occupancy_bits", 2_097_152.0) < kept("occupancy_bits", 32_768.0));
    // A round has the photons of a work item at least.
    assert!(at("photons_per_job", 256.0, 1)[2] < at("photons_per_job", 32_768.0, 1)[2]);
}

/// Nothing of an iteration's work is left out or counted twice, in whatever parts it is done.
#[test]
fn an_iteration_counts_all_of_its_work_once() {
    let scene = files::builtin::scene("cornell").unwrap();
    for (width, height, photons_per_iteration) in [(40, 30, 5000), (1, 1, 1), (65, 9, 1025)] {
        let settings = Settings { width, height, photons_per_iteration, ..scene.settings };
        let photons = || Sppm::new(&scene, &settings);
        let engines: [Box<dyn Engine>; 5] = [
            Box::new(photons()),
            Box::new(photons().deposits_at_once(500)),
            Box::new(photons().long_join(0)),
            Box::new(photons().of_caustics()),
            Box::new(PathTracer::new(&scene, &settings)),
        ];
        for (number, mut engine) in engines.into_iter().enumerate() {
            let stop = Stop::new();
            for iteration in 0..2 {
                assert!(engine.iterate_unless(&stop));
                let all = stop.meter().share();
                // One unit less: the count wraps around.
                stop.meter().advance(u64::MAX);
                let less = stop.meter().share();
                assert!(
                    less < 1.0 && all == 1.0,
                    "engine {number}, {iteration}: {all}, and {less} without one"
                );
            }
        }
    }
}

/// Sixteen points gather together on sixteen lanes and on two vectors of eight (AVX2), eight on eight emulated lanes.
#[test]
fn lanes_are_those_that_are_asked_for() {
    let pairs = |lanes| first_iteration(lanes, &Parameters::default(), u32::MAX)[0];
    let [emulated, avx2, sixteen] = LaneKind::ALL.map(pairs);
    let of_two_vectors = if LaneKind::Avx2.is_available() { sixteen } else { emulated };
    assert!(emulated < sixteen && avx2 == of_two_vectors, "{emulated}, {avx2} and {sixteen} pairs");
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

/// Where photons go and what counts, without seconds and bytes.
fn work(stats: &Stats) -> [u64; 8] {
    let Stats { camera_segments, shadow_rays, visible_points, photons, .. } = *stats;
    let Stats { photon_segments, deposits, candidates, contributions, .. } = *stats;
    [
        camera_segments,
        shadow_rays,
        visible_points,
        photons,
        photon_segments,
        deposits,
        candidates,
        contributions,
    ]
}

/// Settings of which buffers keep something change from render to render, and are again what they were; so do lanes and the
/// light that photons carry.
#[test]
fn an_image_does_not_depend_on_the_settings_of_renders_before() {
    // One batch, so that what is left of a render is of the same pixels.
    let usual = Settings {
        width: 16,
        height: 16,
        photons_per_iteration: 600,
        initial_radius: 9.0,
        ..Settings::default()
    };
    // Scene, settings, and whether photons carry caustics alone.
    let renders = [
        ("cornell", usual, false),
        (
            "cornell",
            Settings { light_samples: 4, glint_samples: 5, filter: Filter::Mitchell, ..usual },
            false,
        ),
        ("cornell", usual, false),
        // As many tiles, the last of which are of fewer pixels.
        ("cornell", Settings { width: 12, height: 10, ..usual }, false),
        ("cornell", usual, true),
        ("random", Settings { radius_schedule: RadiusSchedule::Global, ..usual }, false),
        ("motion", Settings { glint_samples: 3, ..usual }, false),
        ("random", usual, false),
        ("cornell", Settings { radius_pilots: 1, radius_clearance: 0.7, ..usual }, false),
        ("cornell", Settings { max_depth: 9, ..usual }, true),
        ("cornell", Settings { max_depth: 2, ..usual }, false),
    ];
    let mut parts = Parts::default();
    for (number, (name, settings, carries_caustics)) in renders.into_iter().enumerate() {
        let scene = files::builtin::scene(name).unwrap();
        let lanes = [LaneKind::best(), LaneKind::Avx2][number % 2];
        let render = |parts| {
            let engine = Sppm::with_parts(&scene, &settings, lanes, &Parameters::default(), parts);
            let mut engine = if carries_caustics { engine.of_caustics() } else { engine };
            engine.iterate();
            engine.iterate();
            let told = (engine.develop(), engine.radius(), engine.count(), work(engine.stats()));
            (told, engine.into_parts())
        };
        let (fresh, _) = render(Parts::default());
        let (warm, used) = render(parts);
        assert!(warm == fresh, "render {number}, {name} with {settings:?}, caustics: {carries_caustics}");
        parts = used;
    }
}

/// The next iteration reckons with the radii that the last has left, but not if others were loaded since: photons at the rim of a
/// ball would be taken to arrive on the visible side of all points within a radius that is too small.
#[test]
fn what_was_loaded_is_gathered_by_its_own_radii() {
    let mut scene = files::builtin::scene("cornell").unwrap();
    // A ball of the walls' material fills the image, so that all of its pixels count photons.
    let white = scene.spheres[2].material;
    let balls = scene.spheres.iter_mut().filter(|s| s.radius == 16.5);
    balls.for_each(|ball| ball.material = white);
    let ball = scene.spheres.iter().find(|s| s.radius == 16.5).unwrap();
    scene.camera.direction = ball.center - scene.camera.eye;
    scene.camera.vertical_fov_degrees = 4.0;
    let settings = Settings {
        width: 16,
        height: 16,
        photons_per_iteration: 50_000,
        initial_radius: 14.0,
        max_depth: 6,
        ..scene.settings
    };
    let after = |count| {
        let mut engine = Sppm::new(&scene, &settings);
        (0..count).for_each(|_| engine.iterate());
        engine
    };
    let (saved, mut other) = (after(1), after(30));
    let largest = |engine: &Sppm| engine.radius().unwrap().values.into_iter().fold(0.0, f32::max);
    assert!(largest(&other) < 0.8 * largest(&saved));
    let mut words = vec![0; settings.width as usize * saved.sums().words()];
    for y in 0..settings.height {
        saved.save_row(y, &mut words);
        other.load_row(y, &words);
    }
    other.go_on_after(1, *saved.stats());
    other.iterate();
    assert!(other.develop() == after(2).develop());
}

/// Whatever their corner, and before the first iteration as well.
#[test]
fn tiles_are_of_the_pixels_that_are_given_one_by_one() {
    let scene = files::builtin::scene("cornell").unwrap();
    for radius_schedule in [RadiusSchedule::PerPixel, RadiusSchedule::Global] {
        let settings = Settings {
            width: 27,
            height: 18,
            photons_per_iteration: 2000,
            radius_schedule,
            ..scene.settings
        };
        let mut engine = Sppm::new(&scene, &settings);
        for _ in 0..2 {
            for (left, top) in [(0, 0), (8, 8), (16, 0), (4, 8), (8, 5), (19, 10)] {
                let expected = tile_of(left, top, |x, y| engine.radiance(x, y));
                assert_eq!(engine.radiance_of_tile(left, top), expected);
            }
            let places: Vec<_> = (0..60).map(|k| (k * 7 % 27, k * 5 % 18)).collect();
            let each = places.iter().map(|(x, y)| engine.radiance(*x, *y));
            assert!(engine.radiance_of_each(&places).into_iter().eq(each));
            engine.iterate();
        }
    }
}

/// Of each pixel 80 bytes more, in whole tiles.
#[test]
fn global_radii_hold_exact_sums_as_well() {
    let scene = files::builtin::scene("cornell").unwrap();
    let bytes = |radius_schedule| {
        let settings =
            Settings { width: 20, height: 9, photons_per_iteration: 2000, radius_schedule, ..scene.settings };
        iterations(Sppm::new(&scene, &settings), 1)[0].1
    };
    assert_eq!(bytes(RadiusSchedule::Global) - bytes(RadiusSchedule::PerPixel), 24 * 16 * 80);
}

/// Paths from the eye are the camera pass, and there is no other.
#[test]
fn seconds_of_paths_are_those_of_the_camera_pass() {
    let scene = files::builtin::scene("cornell").unwrap();
    let settings = Settings { width: 40, height: 30, ..scene.settings };
    let mut engine = PathTracer::new(&scene, &settings);
    let (began, mut before) = (Instant::now(), 0.0);
    for _ in 0..3 {
        engine.iterate();
        let all = began.elapsed().as_secs_f64();
        let Stats { camera_seconds, build_grid_seconds, photon_seconds, consolidate_seconds, .. } =
            *engine.stats();
        assert!(before < camera_seconds && camera_seconds <= all, "{camera_seconds} after {before} in {all}");
        assert_eq!([build_grid_seconds, photon_seconds, consolidate_seconds], [0.0; 3]);
        before = camera_seconds;
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
