//! Image sizes: with complete and partial tiles of 8x8 pixels, and sizes at which the published program fails.

use crate::pair::{MOST_THREADS, all_lanes, assert_equal, tell};
use scene::Settings;

/// The pixel counts of 48x27 and 36x30 divide a table size of the published program; the other sizes give partial tiles
/// and partial vectors of every kind.
const SIZES: [(u32, u32); 26] = [
    (1, 1),
    (2, 1),
    (1, 3),
    (7, 3),
    (3, 7),
    (8, 1),
    (1, 8),
    (8, 8),
    (9, 8),
    (8, 9),
    (7, 8),
    (15, 15),
    (16, 16),
    (17, 33),
    (31, 5),
    (32, 24),
    (48, 27),
    (36, 30),
    (63, 9),
    (64, 8),
    (65, 7),
    (100, 3),
    (1, 200),
    (200, 1),
    (257, 2),
    (33, 65),
];

#[test]
fn sizes() {
    let mut cases = 0;
    for name in ["cornell", "focus"] {
        let scene = files::builtin::scene(name).unwrap();
        for (number, (width, height)) in SIZES.into_iter().enumerate() {
            let settings = Settings {
                width,
                height,
                iterations: 2,
                photons_per_iteration: 500,
                initial_radius: 8.0,
                ..scene.settings
            };
            cases += assert_equal(&scene, &settings, &all_lanes(1 + number % MOST_THREADS));
        }
    }
    tell(cases, "26 sizes");
}
