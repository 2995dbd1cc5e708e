//! Runs both engines side by side and finds their first difference.

use crate::cases;
use crate::difference::Outcome;
use fast::{LaneKind, Parameters};
use proptest::test_runner::{Config, RngAlgorithm};
use rayon::{ThreadPool, ThreadPoolBuilder};
use scene::aim::Targets;
use scene::{Engine, Film, RadiusSchedule, Scene, Settings, Stats};
use std::sync::OnceLock;

/// The largest number of threads in the tests.
pub(crate) const MOST_THREADS: usize = 5;

/// A configuration of the fast engine.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Way {
    pub(crate) lanes: LaneKind,
    pub(crate) threads: usize,
    /// As `fast::Sppm::deposits_at_once`.
    pub(crate) deposits_at_once: Option<u32>,
    /// The free parameters.
    pub(crate) parameters: Parameters,
}

/// Every kind of lanes, on `threads` threads. Lanes that the processor does not support are emulated.
pub(crate) fn all_lanes(threads: usize) -> Vec<Way> {
    let parameters = Parameters::default();
    LaneKind::ALL
        .into_iter()
        .map(|lanes| Way { lanes, threads, deposits_at_once: None, parameters })
        .collect()
}

/// The kinds of lanes that the processor has and, if `number` is even, one of those that are emulated in turn, on `threads`
/// threads. Emulated lanes take five times as long (docs/benchmarks.md). The kernels are the same code on all lanes, and `kernels::operations` shows
/// the operations equal, so random scenes need not meet every kind.
pub(crate) fn lanes_in_turn(threads: usize, number: u64) -> Vec<Way> {
    let is_emulated = |way: &Way| way.lanes == LaneKind::Emulated || !way.lanes.is_available();
    let (emulated, mut ways): (Vec<_>, Vec<_>) = all_lanes(threads).into_iter().partition(is_emulated);
    if number.is_multiple_of(2) {
        ways.push(emulated[number as usize / 2 % emulated.len()]);
    }
    ways
}

/// The configuration of property tests with `cases` cases, scaled by `SPPM_EQUALITY_EFFORT`.
pub(crate) fn effort(cases: u32) -> Config {
    Config {
        cases: scaled(cases),
        failure_persistence: None,
        // Each alternative of `prop_oneof!` draws a seed of its own, which took a sixth of the time with ChaCha.
        rng_algorithm: RngAlgorithm::XorShift,
        max_local_rejects: u32::MAX,
        max_shrink_time: 20_000,
        ..Config::default()
    }
}

/// `cases` scaled by `SPPM_EQUALITY_EFFORT`; at least one.
pub(crate) fn scaled(cases: u32) -> u32 {
    const NAME: &str = "SPPM_EQUALITY_EFFORT";
    let parse = |text: String| {
        let effort = text.parse().ok().filter(|effort| (0.0..=1e6).contains(effort));
        effort.unwrap_or_else(|| panic!("{NAME}: {text:?} is not a number from 0 to 1e6"))
    };
    let effort = std::env::var(NAME).map_or(1.0, parse);
    ((f64::from(cases) * effort) as u32).max(1)
}

/// Reports how many renders were compared.
pub(crate) fn tell(count: usize, what: &str) {
    cases::tell("equality", count, &format!("renders of {what} equal the reference"));
}

/// Expects equality, and returns the number of renders that were compared with the reference.
pub(crate) fn assert_equal(scene: &Scene, settings: &Settings, ways: &[Way]) -> usize {
    match compare(scene, settings, ways) {
        Ok(_) => ways.len(),
        Err(difference) => panic!("{}, {settings:?}: {difference}", scene.name),
    }
}

/// As [`assert_equal`], by the path tracers.
pub(crate) fn assert_equal_paths(scene: &Scene, settings: &Settings, ways: &[Way]) -> usize {
    match compare_paths(scene, settings, ways) {
        Ok(_) => ways.len(),
        Err(difference) => panic!("{}, {settings:?}, paths: {difference}", scene.name),
    }
}

/// Runs the reference and all `ways`, and compares them after each iteration. Returns the reference's statistics, or
/// describes the first difference.
pub(crate) fn compare(scene: &Scene, settings: &Settings, ways: &[Way]) -> Result<Stats, String> {
    Ok(*compared(scene, settings, ways)?.stats())
}

/// The same, and compares what photons are aimed at. Returns the reference.
pub(crate) fn compared<'a>(
    scene: &'a Scene,
    settings: &Settings,
    ways: &[Way],
) -> Result<reference::Sppm<'a>, String> {
    let mut others: Vec<_> = ways.iter().map(|way| (*way, start(scene, settings, *way))).collect();
    let reference = run_side_by_side(reference::Sppm::new(scene, settings), &mut others)?;
    for (way, engine) in others {
        let (found, expected) = (engine.targets(), reference.targets());
        if found != expected {
            return Err(format!("{way:?} aims at {found:?}, not at {expected:?}"));
        }
    }
    Ok(reference)
}

/// The same with photons that are aimed at `targets`, whatever a survey would find. Returns the reference's statistics.
pub(crate) fn compare_aimed_at(
    scene: &Scene,
    settings: &Settings,
    ways: &[Way],
    targets: &Targets,
) -> Result<Stats, String> {
    let aimed = |way: &Way| start(scene, settings, *way).aimed_at(targets.clone());
    let mut others: Vec<_> = ways.iter().map(|way| (*way, aimed(way))).collect();
    let reference = reference::Sppm::new(scene, settings).aimed_at(targets.clone());
    Ok(*run_side_by_side(reference, &mut others)?.stats())
}

/// The same for the path tracers. Returns the reference's image.
pub(crate) fn compare_paths(scene: &Scene, settings: &Settings, ways: &[Way]) -> Result<Film, String> {
    let start = |way: &Way| fast::PathTracer::with_parameters(scene, settings, way.lanes, &way.parameters);
    let mut others: Vec<_> = ways.iter().map(|way| (*way, start(way))).collect();
    let reference = run_side_by_side(reference::PathTracer::new(scene, settings), &mut others)?;
    Ok(reference.develop())
}

/// The same by path tracing with photons for caustics. Returns the reference's statistics.
pub(crate) fn compare_hybrids(scene: &Scene, settings: &Settings, ways: &[Way]) -> Result<Stats, String> {
    let settings = &Settings { radius_schedule: RadiusSchedule::PerPixel, ..*settings };
    let hybrid = |way: &Way| {
        let paths = fast::PathTracer::with_parameters(scene, settings, way.lanes, &way.parameters);
        fast::hybrid(paths, start(scene, settings, *way))
    };
    let mut others: Vec<_> = ways.iter().map(|way| (*way, hybrid(way))).collect();
    let (paths, photons) =
        (reference::PathTracer::new(scene, settings), reference::Sppm::new(scene, settings));
    Ok(*run_side_by_side(reference::hybrid(paths, photons), &mut others)?.stats())
}

/// Expects equality by path tracing with photons for caustics, and returns the number of renders that were compared with the
/// reference, and the photons that counted in it.
pub(crate) fn assert_equal_hybrids(scene: &Scene, settings: &Settings, ways: &[Way]) -> (usize, u64) {
    match compare_hybrids(scene, settings, ways) {
        Ok(stats) => (ways.len(), stats.contributions),
        Err(difference) => panic!("{}, {settings:?}, hybrid: {difference}", scene.name),
    }
}

/// Runs all iterations of the reference and of the others, and compares them after each. Returns the reference, or
/// describes the first difference.
fn run_side_by_side<R: Engine, F: Engine + Send>(
    mut reference: R,
    others: &mut [(Way, F)],
) -> Result<R, String> {
    let settings = *reference.settings();
    settings.validate().unwrap();
    for iteration in 0..settings.iterations {
        reference.iterate();
        let expected = Outcome::of(&reference);
        for (way, engine) in &mut *others {
            let actual = pool(way.threads).install(|| {
                engine.iterate();
                Outcome::of(engine)
            });
            if let Some(difference) = expected.difference(&actual) {
                return Err(format!("{way:?} differs in iteration {iteration}: {difference}"));
            }
        }
    }
    Ok(reference)
}

fn start<'a>(scene: &'a Scene, settings: &Settings, way: Way) -> fast::Sppm<'a> {
    let engine = fast::Sppm::with_parameters(scene, settings, way.lanes, &way.parameters);
    match way.deposits_at_once {
        Some(most) => engine.deposits_at_once(most),
        None => engine,
    }
}

/// A pool of `threads` threads, kept for all cases, as starting one is expensive.
fn pool(threads: usize) -> &'static ThreadPool {
    static POOLS: [OnceLock<ThreadPool>; MOST_THREADS] = [const { OnceLock::new() }; MOST_THREADS];
    POOLS[threads - 1].get_or_init(|| ThreadPoolBuilder::new().num_threads(threads).build().unwrap())
}

/// Checks that the comparison can fail: a different seed must give a different image.
#[test]
fn another_seed_makes_a_difference() {
    let scene = files::builtin::scene("cornell").unwrap();
    let settings = Settings { width: 9, height: 8, photons_per_iteration: 50, ..scene.settings };
    let (mut one, mut other) = (
        reference::Sppm::new(&scene, &settings),
        fast::Sppm::new(&scene, &Settings { seed: settings.seed + 1, ..settings }),
    );
    one.iterate();
    other.iterate();
    assert!(Outcome::of(&one).difference(&Outcome::of(&other)).is_some());
}

/// The planes that are compared are those of the pixels: of either engine, with each value where it belongs.
#[test]
fn planes_are_what_pixels_tell() {
    let scene = files::builtin::scene("cornell").unwrap();
    let settings = Settings { width: 9, height: 8, photons_per_iteration: 5000, ..scene.settings };
    let mut engines: [Box<dyn Engine>; 2] =
        [Box::new(reference::Sppm::new(&scene, &settings)), Box::new(fast::Sppm::new(&scene, &settings))];
    for engine in &mut engines {
        engine.iterate();
        for plane in compare::planes(&**engine) {
            let places = (0..settings.height).flat_map(|y| (0..settings.width).map(move |x| (x, y)));
            let told: Vec<f32> = places
                .flat_map(|(x, y)| {
                    let probe = engine.probe(x, y);
                    match plane.kind {
                        compare::PlaneKind::DirectLight => probe.direct.to_array().to_vec(),
                        compare::PlaneKind::Count => vec![probe.count],
                        compare::PlaneKind::Radius => vec![probe.radius],
                        compare::PlaneKind::Image => probe.radiance.to_array().to_vec(),
                    }
                })
                .collect();
            assert_eq!(plane.values, told, "{:?}", plane.kind);
        }
    }
}
