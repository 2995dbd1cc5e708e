//! The settings behind `--quick`, for commands that measure.

use crate::args::settings::SettingsArgs;
use crate::terminal::error::Error;
use scene::Settings;

/// The settings to measure with: those that options state, else of a quick measurement or of the scene, which has `own`.
pub(crate) fn measured(own: &Settings, is_quick: bool, options: &SettingsArgs) -> Result<Settings, Error> {
    options.apply_numbers(&if is_quick { quick(own) } else { *own })
}

/// Settings for a small image and few photons, with the seed of `own`.
fn quick(own: &Settings) -> Settings {
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
            radius_clearance: 0.5,
            light_samples: 4,
            glint_samples: 16,
            ..Settings::default()
        };
        let found = quick(&own);
        assert_eq!(
            (found.seed, found.filter, found.radius_schedule),
            (own.seed, own.filter, own.radius_schedule)
        );
        assert_eq!((found.iterations, found.radius_pilots, found.light_samples), (2, 0, 1));
        // What takes time for a better image is left out.
        assert_eq!((found.radius_clearance, found.glint_samples), (0.0, 1));
    }

    #[test]
    fn a_quick_measurement_is_of_a_small_image_and_few_photons() {
        let own = Settings {
            width: 800,
            height: 600,
            photons_per_iteration: 1_000_000,
            max_depth: 64,
            initial_radius: 9.0,
            ..Settings::default()
        };
        let found = quick(&own);
        assert_eq!((found.width, found.height, found.photons_per_iteration), (128, 96, 20_000));
        assert_eq!((found.max_depth, found.initial_radius), (5, 2.0));
    }

    #[test]
    fn what_options_state_is_as_stated_in_quick_measurements_too() {
        use clap::Parser as _;
        #[derive(clap::Parser)]
        struct Alone {
            #[command(flatten)]
            settings: SettingsArgs,
        }
        let options = Alone::parse_from(["sppm", "--width", "40", "--photons", "700"]).settings;
        let own = Settings { iterations: 99, ..Settings::default() };
        let found = [false, true].map(|is_quick| measured(&own, is_quick, &options).unwrap());
        assert_eq!(
            found.map(|s| (s.width, s.photons_per_iteration, s.iterations)),
            [(40, 700, 99), (40, 700, 2)]
        );
    }
}
