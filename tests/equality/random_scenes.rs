//! Scenes made fresh in every run: all materials and lamps, in places where rounding decides.

use crate::draft::{Case, case};
use crate::pair::{all_lanes, compare, effort, scaled, tell};
use proptest::prelude::*;
use proptest::test_runner::{TestError, TestRunner};
use std::cell::Cell;

/// Compares `cases` scenes of `spheres` spheres, and for one that fails shows the simplest that does.
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
            // Scenes in which no photon reaches a visible point put only half of the engine to the test. In a third
            // and more photons do count, so a tenth leaves room for chance; not where fewer are tried than usual.
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
