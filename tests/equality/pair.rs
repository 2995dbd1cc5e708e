//! Both engines in step, and where they first differ.

use crate::cases;
use crate::difference::Outcome;
use fast::{LaneKind, Parameters};
use proptest::test_runner::Config;
use rayon::{ThreadPool, ThreadPoolBuilder};
use scene::{Engine, Scene, Settings, Stats};
use std::sync::OnceLock;

/// The most threads that tests run on.
pub(crate) const MOST_THREADS: usize = 5;

/// A way to run the fast engine.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Way {
    pub(crate) lanes: LaneKind,
    pub(crate) threads: usize,
    /// As `fast::Sppm::deposits_at_once`.
    pub(crate) deposits_at_once: Option<u32>,
    /// The free parameters.
    pub(crate) parameters: Parameters,
}

/// Every kind of lanes, on `threads` threads; one that this processor lacks is emulated.
pub(crate) fn all_lanes(threads: usize) -> Vec<Way> {
    let parameters = Parameters::default();
    LaneKind::ALL
        .into_iter()
        .map(|lanes| Way { lanes, threads, deposits_at_once: None, parameters })
        .collect()
}

/// How properties are tried, on so many cases or as many times that as is asked for.
pub(crate) fn effort(cases: u32) -> Config {
    Config {
        cases: scaled(cases),
        failure_persistence: None,
        max_local_rejects: u32::MAX,
        max_shrink_time: 20_000,
        ..Config::default()
    }
}

/// So many cases, or as many times that as is asked for; at least one.
pub(crate) fn scaled(cases: u32) -> u32 {
    const NAME: &str = "SPPM_EQUALITY_EFFORT";
    let parse = |text: String| {
        let effort = text.parse().ok().filter(|effort| (0.0..=1e6).contains(effort));
        effort.unwrap_or_else(|| panic!("{NAME}: {text:?} is not a number from 0 to 1e6"))
    };
    let effort = std::env::var(NAME).map_or(1.0, parse);
    ((f64::from(cases) * effort) as u32).max(1)
}

/// Tells on standard error how many cases ran, past the capture of the test harness.
pub(crate) fn tell(count: usize, what: &str) {
    cases::tell("equality", count, &format!("renders of {what} equal the reference"));
}

/// Expects equality, and gives the number of renders that were compared with the reference.
pub(crate) fn assert_equal(scene: &Scene, settings: &Settings, ways: &[Way]) -> usize {
    match compare(scene, settings, ways) {
        Ok(_) => ways.len(),
        Err(difference) => panic!("{}, {settings:?}: {difference}", scene.name),
    }
}

/// Iterates all in step. Gives the reference's account, or describes the first difference from the reference.
pub(crate) fn compare(scene: &Scene, settings: &Settings, ways: &[Way]) -> Result<Stats, String> {
    settings.validate().unwrap();
    let mut reference = reference::Sppm::new(scene, settings);
    let mut others: Vec<(Way, fast::Sppm)> =
        ways.iter().map(|way| (*way, start(scene, settings, *way))).collect();
    for iteration in 0..settings.iterations {
        reference.iterate();
        let expected = Outcome::of(&reference);
        for (way, engine) in &mut others {
            let actual = pool(way.threads).install(|| {
                engine.iterate();
                Outcome::of(engine)
            });
            if let Some(difference) = expected.difference(&actual) {
                return Err(format!("{way:?} differs in iteration {iteration}: {difference}"));
            }
        }
    }
    Ok(*reference.stats())
}

fn start<'a>(scene: &'a Scene, settings: &Settings, way: Way) -> fast::Sppm<'a> {
    let engine = fast::Sppm::with_parameters(scene, settings, way.lanes, &way.parameters);
    match way.deposits_at_once {
        Some(most) => engine.deposits_at_once(most),
        None => engine,
    }
}

/// Pools of threads are dear, and cases many.
fn pool(threads: usize) -> &'static ThreadPool {
    static POOLS: [OnceLock<ThreadPool>; MOST_THREADS] = [const { OnceLock::new() }; MOST_THREADS];
    POOLS[threads - 1].get_or_init(|| ThreadPoolBuilder::new().num_threads(threads).build().unwrap())
}

/// That the comparison is not of a render with itself: another seed makes another image.
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
