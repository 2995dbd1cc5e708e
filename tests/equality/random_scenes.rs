//! New random scenes in every run, with all materials and lamps, placed such that rounding matters.

use crate::draft::{Case, case};
use crate::pair::{all_lanes, compare, effort, scaled, tell};
use proptest::prelude::*;
use proptest::test_runner::{TestError, TestRunner};
use std::cell::Cell;

/// Compares the engines on `cases` scenes of `spheres` spheres, and shows the simplest scene that fails.
fn check(cases: u32, spheres: std::ops::RangeInclusive<usize>) {
    let what = format!("random scenes of {} to {} spheres in a room", spheres.start(), spheres.end());
    let (renders, reached) = (Cell::new(0), Cell::new(0));
    let result = TestRunner::new(effort(cases)).run(&case(spheres), |Case { scene, settings, .. }: Case| {
        let ways = all_lanes(1 + settings.seed as usize % 3);
        let stats = compare(&scene, &settings, &ways).map_err(TestCaseError::fail)?;
        renders.set(renders.get() + ways.len());
        reached.set(reached.get() + u32::from(stats.contributions > 0));
        Ok(())
    });
    match result {
        Ok(()) => {
            tell(renders.get(), &what);
            // Scenes in which no photon contributes test only half of the engine. In at least a third of the scenes
            // some do, so requiring a tenth allows for chance. With fewer cases than usual this is not required.
            let is_whole = scaled(cases) >= cases;
            let least = scaled(cases) / 10;
            assert!(!is_whole || reached.get() > least, "photons count in {} scenes alone", reached.get());
        }
        Err(TestError::Fail(why, case)) => panic!("{why}\n{case:?}"),
        Err(TestError::Abort(why)) => panic!("{what}: {why}"),
    }
}

#[test]
fn few_spheres() {
    check(400, 1..=12);
}

#[test]
fn some_spheres() {
    check(100, 13..=60);
}

#[test]
fn many_spheres() {
    check(24, 61..=300);
}
