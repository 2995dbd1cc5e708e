//! Saved state: any engine can resume what another one saved, and an abandoned iteration changes nothing.

use crate::cases::tell;
use fast::LaneKind;
use rayon::{ThreadPool, ThreadPoolBuilder};
use scene::RadiusSchedule::{Global, PerPixel};
use scene::state::transfer;
use scene::{Film, Probe, Resumable, Rgb, Scene, Settings, Stop};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::thread;
use std::time::Duration;

/// An engine with its options and threads.
#[derive(Clone, Copy, Debug)]
enum Way {
    Reference,
    Fast { lanes: LaneKind, threads: usize, deposits_at_once: u32, long_join: u64 },
    ReferencePaths { threads: usize },
    FastPaths { lanes: LaneKind, threads: usize },
}

impl Way {
    fn start<'a>(self, scene: &'a Scene, settings: &Settings) -> Box<dyn Resumable + 'a> {
        match self {
            Self::Reference => Box::new(reference::Sppm::new(scene, settings)),
            Self::Fast { lanes, deposits_at_once, long_join, .. } => {
                let engine = fast::Sppm::with_lanes(scene, settings, lanes);
                Box::new(engine.deposits_at_once(deposits_at_once).long_join(long_join))
            }
            Self::ReferencePaths { .. } => Box::new(reference::PathTracer::new(scene, settings)),
            Self::FastPaths { lanes, .. } => Box::new(fast::PathTracer::with_lanes(scene, settings, lanes)),
        }
    }

    fn pool(self) -> ThreadPool {
        let threads = match self {
            Self::Reference => 1,
            Self::Fast { threads, .. }
            | Self::ReferencePaths { threads }
            | Self::FastPaths { threads, .. } => threads,
        };
        ThreadPoolBuilder::new().num_threads(threads).build().unwrap()
    }
}

/// Photon mapping in all ways: by the reference and by fast, in one or several rounds, on one to three threads, with
/// short and long joins.
fn photon_ways() -> Vec<Way> {
    let lanes = LaneKind::ALL.into_iter().filter(|lanes| lanes.is_available());
    let ways = [(1, u32::MAX, u64::MAX), (3, 300, u64::MAX), (2, 1000, 0)];
    let fast = lanes.flat_map(|lanes| {
        ways.map(|(threads, deposits_at_once, long_join)| Way::Fast {
            lanes,
            threads,
            deposits_at_once,
            long_join,
        })
    });
    [Way::Reference].into_iter().chain(fast).collect()
}

/// Path tracing by the reference and by fast, on one to three threads.
fn path_ways() -> Vec<Way> {
    let lanes = LaneKind::ALL.into_iter().filter(|lanes| lanes.is_available());
    let fast = lanes.flat_map(|lanes| [1, 2].map(|threads| Way::FastPaths { lanes, threads }));
    [1, 3].map(|threads| Way::ReferencePaths { threads }).into_iter().chain(fast).collect()
}

fn scenes() -> Vec<(Scene, Settings)> {
    let tiny = |name| {
        let scene = files::builtin::scene(name).unwrap();
        let settings = Settings {
            width: 21,
            height: 13,
            iterations: 5,
            photons_per_iteration: 700,
            initial_radius: 12.0,
            ..scene.settings
        };
        (scene, settings)
    };
    ["cornell", "motion", "random", "focus"].map(tiny).to_vec()
}

/// The number of iterations, and the words of all rows: what one engine hands over to another, but for work and seconds,
/// which are added to and read by nothing that renders.
type State = (u32, Vec<u32>);

fn state(engine: &dyn Resumable) -> State {
    let Settings { width, height, .. } = *engine.settings();
    let mut row = vec![0; width as usize * engine.sums().words()];
    let rows = (0..height).flat_map(|y| {
        engine.save_row(y, &mut row);
        row.clone()
    });
    (engine.iterations(), rows.collect())
}

/// For each iteration, renders up to it with `first` and resumes with `second`. Expects the states in `whole` of `first`, and
/// of `second` after every further iteration.
fn check(scene: &Scene, settings: &Settings, [first, second]: [Way; 2], whole: &[State]) {
    let pools = [first.pool(), second.pool()];
    let mut begun = first.start(scene, settings);
    for done in 0..settings.iterations {
        let mut other = second.start(scene, settings);
        assert!(state(&*begun) == whole[done as usize], "{}: {first:?} after {done}", scene.name);
        transfer(&*begun, &mut *other);
        assert_eq!(other.stats(), begun.stats());
        for (_, expected) in whole.iter().enumerate().skip(done as usize + 1) {
            pools[1].install(|| other.iterate());
            assert!(
                state(&*other) == *expected,
                "{}: {first:?} {done} iterations, then {second:?}",
                scene.name
            );
        }
        pools[0].install(|| begun.iterate());
    }
    let film = begun.develop();
    let mut developed = second.start(scene, settings);
    transfer(&*begun, &mut *developed);
    assert_eq!(developed.develop(), film, "{}: {second:?} develops another image", scene.name);
    assert_eq!((developed.radius(), developed.count()), (begun.radius(), begun.count()));
    assert_eq!(developed.direct(), begun.direct());
    check_probes(&*developed, &film);
}

/// Expects the probe of each pixel to have the same values as the whole images.
fn check_probes(engine: &dyn Resumable, film: &Film) {
    let [radius, count] = [engine.radius(), engine.count()].map(|plane| plane.map(|plane| plane.values));
    let direct = engine.direct().map(|film| film.pixels);
    let of = |values: &Option<Vec<f32>>, i: usize| values.as_ref().map_or(0.0, |values| values[i]);
    for (i, &radiance) in film.pixels.iter().enumerate() {
        let probe = engine.probe(i as u32 % film.width, i as u32 / film.width);
        assert_eq!(
            probe,
            Probe {
                radiance,
                direct: direct.as_ref().map_or(Rgb::ZERO, |direct| direct[i]),
                radius: of(&radius, i),
                count: of(&count, i)
            }
        );
    }
}

/// The states of an uninterrupted render, before the first and after each iteration.
fn whole(way: Way, scene: &Scene, settings: &Settings) -> Vec<State> {
    let mut engine = way.start(scene, settings);
    let mut all = vec![state(&*engine)];
    for _ in 0..settings.iterations {
        engine.iterate();
        all.push(state(&*engine));
    }
    all
}

/// Expects each of the `ways` to resume what any other has begun, with radii as in `own`; returns the number of pairs.
///
/// After each iteration the state that is handed over is the same of all ways, which is expected here. So it does not matter
/// which way has begun, and each has to resume from one other alone.
fn check_all(ways: &[Way], own: Settings) -> usize {
    let Settings { radius_schedule, radius_pilots, radius_clearance, glint_samples, .. } = own;
    let mut pairs = 0;
    for (scene, settings) in scenes() {
        let settings =
            Settings { radius_schedule, radius_pilots, radius_clearance, glint_samples, ..settings };
        let expected = whole(ways[0], &scene, &settings);
        for (i, &first) in ways.iter().enumerate() {
            check(&scene, &settings, [first, ways[(i + 1) % ways.len()]], &expected);
            pairs += settings.iterations as usize;
        }
    }
    pairs
}

#[test]
fn any_engine_resumes_from_any_other() {
    tell(
        "equality",
        check_all(&photon_ways(), Settings::default()),
        "renders begun by one engine and ended by another",
    );
}

#[test]
fn any_engine_resumes_from_any_other_with_global_radii() {
    tell(
        "equality",
        check_all(&photon_ways(), Settings { radius_schedule: Global, ..Settings::default() }),
        "renders with global radii begun by one engine and ended by another",
    );
}

#[test]
fn any_engine_resumes_from_any_other_with_radii_of_pilots() {
    tell(
        "equality",
        check_all(&photon_ways(), Settings { radius_pilots: 1, ..Settings::default() }),
        "renders with first radii by pilots begun by one engine and ended by another",
    );
}

#[test]
fn any_engine_resumes_from_any_other_with_radii_by_clearance() {
    tell(
        "equality",
        check_all(&photon_ways(), Settings { radius_clearance: 0.7, ..Settings::default() }),
        "renders with first radii by clearance begun by one engine and ended by another",
    );
}

#[test]
fn any_path_tracer_resumes_from_any_other() {
    tell(
        "equality",
        check_all(&path_ways(), Settings::default()),
        "renders begun by one path tracer and ended by another",
    );
}

#[test]
fn any_engine_resumes_from_any_other_with_several_rays_that_see_lamps() {
    let several = Settings { glint_samples: 3, ..Settings::default() };
    tell(
        "equality",
        check_all(&photon_ways(), several) + check_all(&path_ways(), several),
        "renders with several rays that see lamps begun by one engine and ended by another",
    );
}

#[test]
fn before_the_first_iteration_images_are_black() {
    let (scene, settings) = scenes().swap_remove(0);
    let photons = photon_ways().into_iter().flat_map(|way| [(way, PerPixel), (way, Global)]);
    for (way, radius_schedule) in photons.chain(path_ways().into_iter().map(|way| (way, PerPixel))) {
        let settings = Settings { radius_schedule, ..settings };
        let engine = way.start(&scene, &settings);
        let film = engine.develop();
        assert!(film.pixels.iter().all(|pixel| *pixel == Rgb::ZERO), "{way:?}, {radius_schedule:?}");
        check_probes(&*engine, &film);
    }
}

/// Not those of another pixel, whose values stand next to theirs.
#[test]
fn pixels_outside_of_the_image_have_no_values() {
    let (scene, settings) = scenes().swap_remove(0);
    let photons = photon_ways().into_iter().flat_map(|way| [(way, PerPixel), (way, Global)]);
    for (way, radius_schedule) in photons.chain(path_ways().into_iter().map(|way| (way, PerPixel))) {
        let engine = way.start(&scene, &Settings { radius_schedule, ..settings });
        for (x, y) in [(settings.width, 0), (0, settings.height)] {
            let probe = AssertUnwindSafe(|| engine.probe(x, y));
            assert!(catch_unwind(probe).is_err(), "{way:?}, {radius_schedule:?}: pixel ({x}, {y})");
        }
    }
}

/// Stops each iteration after longer and longer times, from its first microseconds on, until it completes.
#[test]
fn an_abandoned_iteration_changes_nothing() {
    let (scene, settings) = (files::builtin::scene("cornell").unwrap(), Settings::default());
    let settings =
        Settings { width: 96, height: 64, photons_per_iteration: 20_000, iterations: 2, ..settings };
    let global = Settings { radius_schedule: Global, ..settings };
    let own = Settings { radius_pilots: 1, radius_clearance: 0.7, glint_samples: 2, ..settings };
    let photons = photon_ways().into_iter().flat_map(|way| [(way, settings), (way, global), (way, own)]);
    // The states of all ways are equal, and the last, on the widest lanes, is the quickest.
    let [by_photons, by_paths] = [photon_ways(), path_ways()].map(|mut ways| ways.pop().unwrap());
    for (way, settings) in photons.chain(path_ways().into_iter().map(|way| (way, settings))) {
        let quickest = match way {
            Way::Reference | Way::Fast { .. } => by_photons,
            Way::ReferencePaths { .. } | Way::FastPaths { .. } => by_paths,
        };
        let expected = whole(quickest, &scene, &settings);
        let mut engine = way.start(&scene, &settings);
        let pool = way.pool();
        let (mut abandoned, mut wait) = (0, Duration::from_micros(30));
        for iteration in 1..=settings.iterations {
            let before = (state(&*engine), *engine.stats());
            loop {
                let stop = Stop::new();
                if abandoned == 0 {
                    stop.request();
                }
                let is_whole = thread::scope(|scope| {
                    scope.spawn(|| {
                        thread::sleep(wait);
                        stop.request();
                    });
                    pool.install(|| engine.iterate_unless(&stop))
                });
                if is_whole {
                    break;
                }
                assert!((state(&*engine), *engine.stats()) == before, "{way:?} left a trace after {wait:?}");
                abandoned += 1;
                wait = wait.mul_f64(1.5);
            }
            assert!(state(&*engine) == expected[iteration as usize], "{way:?} went astray in {iteration}");
            wait = Duration::from_micros(100);
        }
        assert!(abandoned > 0, "{way:?} was never stopped");
        assert_eq!(engine.stats().photons, photons_of(way, &settings));
    }
}

fn photons_of(way: Way, settings: &Settings) -> u64 {
    match way {
        Way::ReferencePaths { .. } | Way::FastPaths { .. } => 0,
        Way::Reference | Way::Fast { .. } => {
            u64::from(settings.iterations) * u64::from(settings.photons_per_iteration)
        }
    }
}
