//! Radius schedules: how the search radius of photon mapping shrinks from iteration to iteration.
//!
//! Per pixel (Hachisuka and Jensen 2009), a radius depends on all photons that the pixel has counted before. Globally (Knaus
//! and Zwicker 2011, "Progressive photon mapping: a probabilistic approach"), it depends on the number of the iteration
//! alone, so iterations are independent of each other and can be rendered in any order, on any machine:
//!
//! ```text
//! r_1 = the initial radius,   r_(i+1)^2 = r_i^2 (i + alpha) / (i + 1),   alpha = 2/3
//! ```

use serde::{Deserialize, Serialize};
use std::fmt;

/// How the search radius shrinks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RadiusSchedule {
    /// In each pixel by the photons that it has counted.
    #[default]
    PerPixel,
    /// In all pixels alike, by the number of the iteration.
    Global,
}

impl RadiusSchedule {
    /// All schedules.
    pub const ALL: [Self; 2] = [Self::PerPixel, Self::Global];

    /// Its name in scene files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::PerPixel => "per-pixel",
            Self::Global => "global",
        }
    }
}

impl fmt::Display for RadiusSchedule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// The global schedule: the factor by which the squared radius of an iteration is smaller than that of the first.
///
/// It is a product of quotients `(3 k - 1) / (3 k)`, one for each k from 2 to the number of the iteration (from 1), multiplied
/// in this order in `f64`. So it is the same wherever a render begins; to begin at iteration n takes n steps, about a
/// nanosecond each.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shrinking {
    /// The iteration that `factor` is of, from 0.
    iteration: u32,
    factor: f64,
}

impl Default for Shrinking {
    fn default() -> Self {
        Self { iteration: 0, factor: 1.0 }
    }
}

impl Shrinking {
    /// The squared radius of iteration `iteration`, counted from 0, where that of the first is `initial_squared`.
    pub fn radius_squared(&mut self, initial_squared: f32, iteration: u32) -> f32 {
        if iteration < self.iteration {
            *self = Self::default();
        }
        for done in self.iteration..iteration {
            // With i = done + 1: (i + 2/3) / (i + 1), whose terms times 3 are whole numbers.
            let below = 3.0 * (f64::from(done) + 2.0);
            self.factor *= (below - 1.0) / below;
        }
        self.iteration = iteration;
        (f64::from(initial_squared) * self.factor) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::de::IntoDeserializer;
    use serde::de::value::Error;

    #[test]
    fn the_first_radius_is_the_initial_one_and_others_follow_the_recurrence() {
        let mut squared = 4.0_f64;
        let mut shrinking = Shrinking::default();
        for i in 1..1000_u32 {
            let found = f64::from(shrinking.radius_squared(4.0, i - 1));
            assert!((found / squared - 1.0).abs() < 1e-6, "iteration {i}: {found}, not {squared}");
            squared *= (f64::from(i) + 2.0 / 3.0) / (f64::from(i) + 1.0);
        }
        assert_eq!(Shrinking::default().radius_squared(4.0, 0), 4.0);
    }

    /// Whatever was asked for before, and whether it begins there or comes there step by step.
    #[test]
    fn a_radius_depends_on_the_iteration_alone() {
        let mut stepwise = Shrinking::default();
        let all: Vec<u32> = (0..500).map(|i| stepwise.radius_squared(0.37, i).to_bits()).collect();
        let mut jumping = Shrinking::default();
        for i in [499, 3, 3, 250, 0, 498] {
            assert_eq!(jumping.radius_squared(0.37, i).to_bits(), all[i as usize]);
            assert_eq!(Shrinking::default().radius_squared(0.37, i).to_bits(), all[i as usize]);
        }
    }

    /// The squared radius falls as i^(-1/3): by 2 in 8 times as many iterations.
    #[test]
    fn radii_fall_with_the_cube_root() {
        let mut shrinking = Shrinking::default();
        let [near, far] = [10_000, 80_000].map(|i| shrinking.radius_squared(1.0, i));
        assert!((near / far - 2.0).abs() < 1e-3, "{near} and {far}");
    }

    #[test]
    fn schedules_have_the_names_that_files_have_for_them() {
        for schedule in RadiusSchedule::ALL {
            let name = IntoDeserializer::<Error>::into_deserializer(schedule.name());
            assert_eq!(
                (RadiusSchedule::deserialize(name), schedule.to_string()),
                (Ok(schedule), schedule.name().into())
            );
        }
        assert_eq!(RadiusSchedule::default(), RadiusSchedule::ALL[0]);
    }
}
