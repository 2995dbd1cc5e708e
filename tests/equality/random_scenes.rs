//! Scenes made fresh in every run: all materials and lamps, in places where rounding decides.

use crate::draft::{Case, case};
use crate::pair::{all_lanes, effort, first_difference, tell};
use proptest::prelude::*;
use proptest::test_runner::{Config, TestError, TestRunner};
use std::cell::Cell;

/// Compares `cases` scenes of `spheres` spheres, and for one that fails shows the simplest that does.
fn check(cases: u32, spheres: std::ops::RangeInclusive<usize>) {
    let what = format!("random scenes of {} to {} spheres", spheres.start(), spheres.end());
    let config = Config {
        cases: cases * effort(),
        failure_persistence: None,
        max_local_rejects: u32::MAX,
        max_shrink_time: 20_000,
        ..Config::default()
    };
    let renders = Cell::new(0);
    let result = TestRunner::new(config).run(&case(spheres), |Case { scene, settings, .. }: Case| {
        let ways = all_lanes(1 + settings.seed as usize % 3);
        if let Some(difference) = first_difference(&scene, &settings, &ways) {
            return Err(TestCaseError::fail(difference));
        }
        renders.set(renders.get() + ways.len());
        Ok(())
    });
    match result {
        Ok(()) => tell(renders.get(), &what),
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
