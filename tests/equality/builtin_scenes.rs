//! Every built-in scene, with its own settings except for a smaller size and fewer photons and iterations.

use crate::pair::{all_lanes, assert_equal, tell};
use files::builtin::SCENES;
use scene::Settings;

#[test]
fn built_in_scenes() {
    let mut cases = 0;
    for builtin in SCENES {
        let scene = builtin.scene();
        let settings =
            Settings { width: 52, height: 39, iterations: 2, photons_per_iteration: 5000, ..scene.settings };
        let ways: Vec<_> = [1, 2].into_iter().flat_map(all_lanes).collect();
        cases += assert_equal(&scene, &settings, &ways);
    }
    tell(cases, "built-in scenes");
}

#[test]
fn every_number_of_threads() {
    let scene = files::builtin::scene("cornell").unwrap();
    // Several work items for every thread: 79 of photons and 24 of pixels, as each has 1024 of them.
    let settings =
        Settings { width: 192, height: 128, iterations: 2, photons_per_iteration: 80_001, ..scene.settings };
    let ways: Vec<_> = (1..=crate::pair::MOST_THREADS).flat_map(all_lanes).collect();
    tell(assert_equal(&scene, &settings, &ways), "one scene on 1 to 5 threads");
}
