//! New random scenes in every run, with all materials and lamps, placed such that rounding matters.

use crate::draft::{Case, case};
use crate::pair::{Way, compare, compare_hybrids, compare_paths, effort, lanes_in_turn, scaled, tell};
use proptest::prelude::*;
use proptest::test_runner::{TestError, TestRunner};
use scene::{Rgb, Scene, Settings};
use std::cell::Cell;
use std::ops::RangeInclusive;

/// Compares engines on a scene in all ways; true if the scene tests all of an engine.
type Comparison = fn(&Scene, &Settings, &[Way]) -> Result<bool, String>;

/// By photon mapping. Scenes in which no photon contributes test only half of the engine.
const PHOTONS: Comparison = |scene, settings, ways| Ok(compare(scene, settings, ways)?.contributions > 0);

/// By the path tracers. Of a scene whose image is black no light is compared.
const PATHS: Comparison =
    |scene, settings, ways| Ok(compare_paths(scene, settings, ways)?.pixels.iter().any(|c| *c != Rgb::ZERO));

/// By path tracing with photons for caustics. Scenes without caustics test the path tracer alone.
const HYBRIDS: Comparison =
    |scene, settings, ways| Ok(compare_hybrids(scene, settings, ways)?.contributions > 0);

/// Compares the engines on `cases` scenes of `spheres` spheres, and shows the simplest scene that fails.
fn check((cases, spheres): (u32, RangeInclusive<usize>), method: &str, comparison: Comparison) {
    let (least, most) = (spheres.start(), spheres.end());
    let what = format!("random scenes of {least} to {most} spheres in a room, by {method},");
    let (renders, whole) = (Cell::new(0), Cell::new(0));
    let result = TestRunner::new(effort(cases)).run(&case(spheres), |Case { scene, settings, .. }: Case| {
        let ways = lanes_in_turn(1 + settings.seed as usize % 3, settings.seed);
        let is_whole = comparison(&scene, &settings, &ways).map_err(TestCaseError::fail)?;
        renders.set(renders.get() + ways.len());
        whole.set(whole.get() + u32::from(is_whole));
        Ok(())
    });
    match result {
        Ok(()) => {
            tell(renders.get(), &what);
            // At least a third of the scenes test all, so requiring a tenth allows for chance. With fewer cases than usual
            // this is not required.
            let is_enough = whole.get() > scaled(cases) / 10;
            assert!(scaled(cases) < cases || is_enough, "only {} scenes test all", whole.get());
        }
        Err(TestError::Fail(why, case)) => panic!("{why}\n{case:?}"),
        Err(TestError::Abort(why)) => panic!("{what}: {why}"),
    }
}

#[test]
fn few_spheres() {
    check((400, 1..=12), "photons", PHOTONS);
}

#[test]
fn some_spheres() {
    check((100, 13..=60), "photons", PHOTONS);
}

#[test]
fn many_spheres() {
    check((24, 61..=300), "photons", PHOTONS);
}

#[test]
fn few_spheres_by_paths() {
    check((220, 1..=12), "paths", PATHS);
}

#[test]
fn some_spheres_by_paths() {
    check((64, 13..=60), "paths", PATHS);
}

#[test]
fn many_spheres_by_paths() {
    check((16, 61..=300), "paths", PATHS);
}

#[test]
fn few_spheres_by_both() {
    check((100, 1..=12), "paths and photons for caustics", HYBRIDS);
}

#[test]
fn some_spheres_by_both() {
    check((32, 13..=60), "paths and photons for caustics", HYBRIDS);
}
