//! Search radii: from one that finds nothing to one that finds all, and radii that spread over many iterations.

use crate::pair::{all_lanes, assert_equal, tell};
use scene::Settings;

/// Radii with the width and height of their images: where everything is a candidate of everything, few pixels do.
const RADII: [(f32, u32, u32); 14] = [
    (1e-15, 16, 16),
    (1e-8, 16, 16),
    (1e-5, 24, 24),
    (1e-4, 32, 24),
    (3e-4, 32, 24),
    (6e-4, 32, 24),
    (1e-3, 32, 24),
    (0.01, 32, 24),
    (0.3, 32, 24),
    (5.0, 24, 24),
    (60.0, 16, 16),
    (500.0, 9, 9),
    (1e5, 5, 3),
    (1e15, 5, 3),
];

#[test]
fn first_radii() {
    let mut cases = 0;
    for name in ["cornell", "random", "motion"] {
        let scene = scene::builtin::scene(name).unwrap();
        for (initial_radius, width, height) in RADII {
            let settings = Settings {
                width,
                height,
                iterations: 3,
                photons_per_iteration: 2000,
                initial_radius,
                ..scene.settings
            };
            cases += assert_equal(&scene, &settings, &all_lanes(1));
        }
    }
    tell(cases, "14 radii");
}

#[test]
fn radii_that_spread() {
    let mut cases = 0;
    for (name, initial_radius) in [("cornell", 40.0), ("mirror", 15.0), ("focus", 6.0)] {
        let scene = scene::builtin::scene(name).unwrap();
        let settings = Settings {
            width: 24,
            height: 24,
            iterations: 48,
            photons_per_iteration: 200,
            initial_radius,
            ..scene.settings
        };
        cases += assert_equal(&scene, &settings, &all_lanes(2));
    }
    tell(cases, "48 iterations");
}
