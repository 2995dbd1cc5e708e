//! Unit tests of whole iterations.

use super::render::Sppm;
use crate::join::GroupSums;
use crate::pixels::GROUP;
use scene::{Engine, Settings, Stats};
use std::time::Instant;

/// Per iteration, on one thread: the pairs tested, the bytes held, and whether the next join will be long.
fn iterations(mut engine: Sppm, count: u32) -> Vec<(u64, u64, Option<bool>)> {
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let iteration = |_| {
        let before = engine.stats().candidates;
        one_thread.install(|| engine.iterate());
        (engine.stats().candidates - before, engine.stats().bytes, engine.join.was_long)
    };
    (0..count).map(iteration).collect()
}

/// Sums of all pixels are held for a join that is long, as the last one tells.
#[test]
fn a_join_is_long_after_one_that_tested_many_pairs() {
    let scene = files::builtin::scene("cornell").unwrap();
    let settings = Settings { width: 64, height: 48, photons_per_iteration: 20_000, ..scene.settings };
    let engine = || Sppm::new(&scene, &settings);
    let short = iterations(engine(), 3);
    assert!(short.iter().all(|iteration| iteration.2 == Some(false)));
    let most = short.iter().map(|iteration| iteration.0).max().unwrap();
    assert_eq!(iterations(engine().long_join(most + 1), 3), short);
    let sums = size_of::<GroupSums>() as u64 * 64 * 48 / GROUP as u64;
    let from_the_second = iterations(engine().long_join(1), 3);
    let always = iterations(engine().long_join(0), 3);
    for (number, iteration) in short.iter().enumerate() {
        let (pairs, bytes, _) = *iteration;
        let held = if number > 0 { bytes + sums } else { bytes };
        assert_eq!(from_the_second[number], (pairs, held, Some(true)));
        assert_eq!(always[number], (pairs, bytes + sums, Some(true)));
    }
}

/// The first join is long if there are many deposits, as no other has told.
#[test]
fn a_first_join_is_long_where_there_are_many_deposits() {
    let scene = files::builtin::scene("cornell").unwrap();
    let bytes = |photons, long_join: Option<u64>| {
        let settings = Settings {
            width: 16,
            height: 16,
            photons_per_iteration: photons,
            initial_radius: 20.0,
            ..scene.settings
        };
        let engine = Sppm::new(&scene, &settings);
        iterations(if let Some(pairs) = long_join { engine.long_join(pairs) } else { engine }, 1)[0].1
    };
    assert!(bytes(10_000, None) < bytes(10_000, Some(0)));
    assert_eq!(bytes(1 << 20, None), bytes(1 << 20, Some(0)));
}

#[test]
fn seconds_of_passes_add_up_to_no_more_than_all() {
    let scene = files::builtin::scene("cornell").unwrap();
    let settings = Settings { width: 40, height: 30, photons_per_iteration: 5000, ..scene.settings };
    let began = Instant::now();
    let mut engine = Sppm::new(&scene, &settings);
    for _ in 0..3 {
        engine.iterate();
        let all = began.elapsed().as_secs_f64();
        let Stats { camera_seconds, build_grid_seconds, photon_seconds, consolidate_seconds, .. } =
            *engine.stats();
        let passes = [camera_seconds, build_grid_seconds, photon_seconds, consolidate_seconds];
        assert!(passes.iter().all(|&seconds| seconds > 0.0), "{passes:?}");
        assert!(passes.iter().sum::<f64>() <= all, "{passes:?} in {all}");
    }
}
