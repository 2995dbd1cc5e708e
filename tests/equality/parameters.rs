//! The free parameters of the fast engine: the image must be the same for all of their values.

use crate::draft::{Case, case};
use crate::pair::{Way, all_lanes, assert_equal, compare, effort, tell};
use fast::{Parameter, Parameters, Values};
use proptest::prelude::*;
use proptest::test_runner::{TestError, TestRunner};
use scene::{Scene, Settings};
use std::cell::Cell;

/// Scenes with few balls, many balls and moving balls. The search radii are large, so that many photons contribute.
fn scenes() -> Vec<(Scene, Settings)> {
    let small = |name| {
        let scene = files::builtin::scene(name).unwrap();
        let size = Settings { width: 40, height: 27, iterations: 2, ..scene.settings };
        (scene, Settings { photons_per_iteration: 3000, initial_radius: 5.0, ..size })
    };
    ["cornell", "random", "motion"].map(small).into()
}

/// A valid value of a parameter, sometimes an end of its range.
fn value(parameter: &Parameter) -> BoxedStrategy<f64> {
    let Parameter { least, most, values, .. } = *parameter;
    let ends = prop_oneof![Just(least), Just(most)];
    match values {
        Values::Any => prop_oneof![1 => ends, 4 => least..=most].boxed(),
        // These are limits on the number of balls; only small limits matter for the test scenes.
        Values::Whole => prop_oneof![1 => ends, 4 => (0..300_u32).prop_map(f64::from)].boxed(),
        Values::PowersOfTwo => (least.log2() as i32..=most.log2() as i32).prop_map(|k| 2_f64.powi(k)).boxed(),
    }
}

/// Random values of all parameters.
fn parameters() -> impl Strategy<Value = Parameters> {
    let values: Vec<_> = Parameters::ALL.iter().map(value).collect();
    values.prop_map(|values| {
        let named = Parameters::ALL.iter().zip(values);
        named.fold(Parameters::default(), |all, (p, value)| all.with(p.name, value).unwrap())
    })
}

/// Every kind of lanes with the given parameters.
fn ways(parameters: Parameters, threads: usize) -> Vec<Way> {
    all_lanes(threads).into_iter().map(|way| Way { parameters, ..way }).collect()
}

/// Runs a test on random cases and shows the simplest case that fails.
fn check<T: std::fmt::Debug>(
    cases: u32,
    what: &str,
    strategy: &impl Strategy<Value = T>,
    test: impl Fn(&T) -> Result<usize, String>,
) {
    let renders = Cell::new(0);
    let result = TestRunner::new(effort(cases)).run(strategy, |case| {
        renders.set(renders.get() + test(&case).map_err(TestCaseError::fail)?);
        Ok(())
    });
    match result {
        Ok(()) => tell(renders.get(), what),
        Err(TestError::Fail(why, case)) => panic!("{why}\n{case:?}"),
        Err(TestError::Abort(why)) => panic!("{what}: {why}"),
    }
}

#[test]
fn either_end_of_each_range() {
    let mut renders = 0;
    for (scene, settings) in scenes() {
        let ends = Parameters::ALL.iter().flat_map(|p| [(p.name, p.least), (p.name, p.most)]);
        let all: Vec<Way> =
            ends.flat_map(|(name, end)| ways(Parameters::default().with(name, end).unwrap(), 2)).collect();
        renders += assert_equal(&scene, &settings, &all);
    }
    tell(renders, "built-in scenes with a free parameter at an end of its range");
}

#[test]
fn any_parameters_on_built_in_scenes() {
    let scenes = scenes();
    let cases = (0..scenes.len(), parameters(), 1..=5_usize);
    check(60, "built-in scenes with any free parameters", &cases, |(scene, parameters, threads)| {
        let (scene, settings) = &scenes[*scene];
        let ways = ways(*parameters, *threads);
        compare(scene, settings, &ways).map(|_| ways.len())
    });
}

#[test]
fn any_parameters_on_random_scenes() {
    let cases = (case(1..=60), parameters(), 1..=3_usize);
    let test = |(Case { scene, settings, .. }, parameters, threads): &(Case, Parameters, usize)| {
        let ways = ways(*parameters, *threads);
        compare(scene, settings, &ways).map(|_| ways.len())
    };
    check(100, "random scenes with any free parameters", &cases, test);
}
