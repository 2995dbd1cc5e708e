//! The settings behind `--quick`, for commands that measure.

use scene::Settings;

/// Settings for a small image and few photons, with the seed of `own`.
pub(crate) fn quick(own: &Settings) -> Settings {
    Settings {
        width: 128,
        height: 96,
        iterations: 2,
        photons_per_iteration: 20_000,
        max_depth: 5,
        initial_radius: 2.0,
        seed: own.seed,
        filter: own.filter,
        radius_schedule: own.radius_schedule,
        radius_pilots: 0,
        light_samples: 1,
    }
}
