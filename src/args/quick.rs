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
        radius_clearance: 0.0,
        light_samples: 1,
        glint_samples: 1,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_makes_the_image_another_stays() {
        let own = Settings {
            seed: 9,
            filter: scene::Filter::Gaussian,
            iterations: 99,
            radius_pilots: 2,
            ..Settings::default()
        };
        let found = quick(&own);
        assert_eq!(
            (found.seed, found.filter, found.radius_schedule),
            (own.seed, own.filter, own.radius_schedule)
        );
        assert_eq!((found.iterations, found.radius_pilots, found.light_samples), (2, 0, 1));
    }
}
