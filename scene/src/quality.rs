//! Settings that are left to be chosen from the scene, and how good the picture is to be.

use crate::radius_schedule::RadiusSchedule;
use serde::{Deserialize, Serialize};
use std::fmt;

/// How good a picture is to be.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Quality {
    /// The settings of the paper (section 4), whatever the scene.
    Paper,
    /// Enough to see what is where; noisy.
    Draft,
    /// Looks finished.
    #[default]
    Good,
    /// Noise that can hardly be seen.
    Final,
}

impl Quality {
    /// All qualities.
    pub const ALL: [Self; 4] = [Self::Paper, Self::Draft, Self::Good, Self::Final];

    /// Its name in scene files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Paper => "paper",
            Self::Draft => "draft",
            Self::Good => "good",
            Self::Final => "final",
        }
    }
}

impl fmt::Display for Quality {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// The settings of a render that are chosen from the scene, in place of the numbers in [`crate::Settings`].
///
/// Engines do not know of it: the settings are chosen before a render starts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[allow(clippy::struct_excessive_bools)] // one for each setting
pub struct Automatic {
    /// How good the picture is to be.
    pub quality: Quality,
    /// Whether the method is chosen, if the settings leave it open ([`Self::leaves_method_open`]).
    pub method: bool,
    /// Whether the number of iterations is chosen.
    pub iterations: bool,
    /// Whether the number of photons per iteration is chosen.
    pub photons_per_iteration: bool,
    /// Whether the maximal number of segments is chosen.
    pub max_depth: bool,
    /// Whether the first radius is chosen.
    pub initial_radius: bool,
    /// Whether it is chosen by how many iterations of pilots the first radii of the pixels are.
    pub radius_pilots: bool,
    /// Whether it is chosen how the first radii of the pixels are limited by clearance.
    pub radius_clearance: bool,
    /// Whether it is chosen by how many rays pixels see lamps.
    pub glint_samples: bool,
}

impl Automatic {
    /// All that can be chosen, for a picture of this quality; nothing for [`Quality::Paper`], which has settings.
    pub fn all(quality: Quality) -> Self {
        let is_chosen = quality != Quality::Paper;
        Self {
            quality,
            method: is_chosen,
            iterations: is_chosen,
            photons_per_iteration: is_chosen,
            max_depth: is_chosen,
            initial_radius: is_chosen,
            radius_pilots: is_chosen,
            radius_clearance: is_chosen,
            glint_samples: is_chosen,
        }
    }

    /// The same of what is chosen for a render that has no photons. Paths alone have more noise by caustics than by lamps that
    /// are seen, so they see these by one ray.
    #[must_use]
    pub fn without_photons(self) -> Self {
        Self {
            photons_per_iteration: false,
            initial_radius: false,
            radius_pilots: false,
            radius_clearance: false,
            glint_samples: false,
            ..self
        }
    }

    /// Whether a render with this `schedule` may be by any method: whoever states photons or a radius means photon mapping, which
    /// alone has global radii.
    pub fn leaves_method_open(&self, schedule: RadiusSchedule) -> bool {
        self.method
            && self.photons_per_iteration
            && self.initial_radius
            && self.radius_pilots
            && self.radius_clearance
            && schedule == RadiusSchedule::PerPixel
    }

    /// Whether anything is to be chosen.
    pub fn any(&self) -> bool {
        self.method
            || self.iterations
            || self.photons_per_iteration
            || self.max_depth
            || self.initial_radius
            || self.radius_pilots
            || self.radius_clearance
            || self.glint_samples
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::de::IntoDeserializer;
    use serde::de::value::Error;

    #[test]
    fn something_is_chosen_if_any_of_it_is() {
        let none = Automatic::default();
        assert!(!none.any() && !Automatic::all(Quality::Paper).any() && Automatic::all(Quality::Draft).any());
        let all = Automatic::all(Quality::Good);
        assert!(
            all.method
                && all.iterations
                && all.photons_per_iteration
                && all.max_depth
                && all.initial_radius
                && all.radius_pilots
                && all.radius_clearance
                && all.glint_samples
        );
        for (one, needs_photons) in [
            (Automatic { method: true, ..none }, false),
            (Automatic { iterations: true, ..none }, false),
            (Automatic { photons_per_iteration: true, ..none }, true),
            (Automatic { max_depth: true, ..none }, false),
            (Automatic { initial_radius: true, ..none }, true),
            (Automatic { radius_pilots: true, ..none }, true),
            (Automatic { radius_clearance: true, ..none }, true),
            (Automatic { glint_samples: true, ..none }, true),
        ] {
            assert!(one.any() && one.without_photons().any() != needs_photons, "{one:?}");
        }
    }

    /// By a statement of what only photons have, and by a quality that chooses nothing.
    #[test]
    fn the_method_is_left_open_where_nothing_is_stated_of_photons() {
        let all = Automatic::all(Quality::Good);
        let [own, global] = RadiusSchedule::ALL;
        assert!(all.leaves_method_open(own) && !all.leaves_method_open(global));
        assert!(
            Automatic { iterations: false, max_depth: false, glint_samples: false, ..all }
                .leaves_method_open(own)
        );
        for stated in [
            Automatic { method: false, ..all },
            Automatic { photons_per_iteration: false, ..all },
            Automatic { initial_radius: false, ..all },
            Automatic { radius_pilots: false, ..all },
            Automatic { radius_clearance: false, ..all },
            Automatic::all(Quality::Paper),
        ] {
            assert!(!stated.leaves_method_open(own), "{stated:?}");
        }
    }

    #[test]
    fn qualities_have_names() {
        assert_eq!(Quality::ALL.map(|quality| quality.to_string()), ["paper", "draft", "good", "final"]);
        assert_eq!(Quality::default(), Quality::Good);
        for quality in Quality::ALL {
            let name = IntoDeserializer::<Error>::into_deserializer(quality.name());
            assert_eq!(Quality::deserialize(name), Ok(quality), "files have the same names");
            let all = Automatic::all(quality);
            assert_eq!([all.quality, all.without_photons().quality], [quality; 2]);
        }
    }
}
