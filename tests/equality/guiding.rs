//! Closed rooms of which the eye sees a part, in which photons are guided: what is learnt, and whole renders.

use crate::cases;
use crate::pair::{MOST_THREADS, Way, compare, effort, lanes_in_turn, scaled, tell};
use crate::room::case;
use fast::kernels;
use proptest::prelude::*;
use proptest::test_runner::TestRunner;
use reference::survey::survey;
use std::cell::Cell;

/// Compares surveys and renders. In some of the rooms photons must be guided: of 60, a quarter mostly are.
#[test]
fn rooms_of_which_a_part_is_seen() {
    const CASES: u32 = 60;
    let (renders, guided, left) = (Cell::new(0), Cell::new(0), Cell::new(0));
    let result = TestRunner::new(effort(CASES)).run(&case(), |(room, settings)| {
        let scene = room.scene();
        let expected = survey(&scene, &settings);
        let ways = lanes_in_turn(1 + settings.seed as usize % MOST_THREADS, settings.seed);
        for Way { lanes, .. } in &ways {
            let actual = kernels::survey(&scene, &settings, *lanes);
            prop_assert_eq!(&actual, &expected, "{:?}", lanes);
        }
        compare(&scene, &settings, &ways).map_err(TestCaseError::fail)?;
        renders.set(renders.get() + ways.len());
        let is_guided = expected.guide.is_some();
        guided.set(guided.get() + u32::from(is_guided));
        left.set(left.get() + u32::from(is_guided && settings.photons_per_iteration >= 8192));
        Ok(())
    });
    result.unwrap();
    tell(renders.get(), "rooms");
    cases::tell("equality", renders.get(), "surveys equal the reference");
    let some = guided.get() > CASES / 12 && left.get() > CASES / 20;
    assert!(scaled(CASES) < CASES || some, "{} are guided, {} as they leave", guided.get(), left.get());
}
