//! Every row must give the reference's bits on new random scenes in every run, of the same kind as in the tests of the
//! fast engine.

use crate::cases::tell;
use crate::draft::{Case, case};
use crate::pair::first_difference;
use ladder::{Options, ROWS, Row};
use proptest::prelude::*;
use proptest::test_runner::{Config, TestError, TestRunner};
use scene::{Filter, Settings};
use std::cell::Cell;

/// Number of scenes, each of which all rows render.
const CASES: u32 = 40;

#[test]
fn random_scenes() {
    let config = Config {
        cases: CASES,
        failure_persistence: None,
        max_local_rejects: u32::MAX,
        max_shrink_time: 20_000,
        ..Config::default()
    };
    let rows: Vec<&Row> = ROWS.iter().collect();
    let reached = Cell::new(0);
    let result = TestRunner::new(config).run(&case(1..=16), |Case { scene, settings, .. }: Case| {
        // The published program has the box alone, and one first radius.
        let settings = Settings {
            filter: Filter::Box,
            radius_pilots: 0,
            radius_clearance: 0.0,
            light_samples: 1,
            glint_samples: 1,
            ..settings
        };
        let contributions =
            first_difference(&scene, &settings, &rows, &Options::exact()).map_err(TestCaseError::fail)?;
        reached.set(reached.get() + u32::from(contributions > 0));
        Ok(())
    });
    match result {
        // Photons contribute in about a third of the scenes; requiring a tenth allows for chance.
        Ok(()) => {
            assert!(reached.get() > CASES / 10, "photons count in {} scenes alone", reached.get());
            tell("ladder", CASES as usize * rows.len(), "renders of random scenes, by all rows");
        }
        Err(TestError::Fail(why, case)) => panic!("{why}\n{case:?}"),
        Err(TestError::Abort(why)) => panic!("{why}"),
    }
}
