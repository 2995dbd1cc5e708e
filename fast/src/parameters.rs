//! The free parameters: speed depends on them, the image does not.
//!
//! The defaults are measured (`ARCHITECTURE.md`). The best values differ a little between scenes and machines;
//! `sppm tune` searches for them. Sizes that kernels need when they are compiled are constants instead: the room of a
//! batch, the pixels of a group, the window of a look-up, and the number of bins. So is
//! [`DEPOSITS_AT_ONCE`](crate::DEPOSITS_AT_ONCE), on which memory depends more than speed.

use crate::paths::BATCH;
use crate::search::Search;
use std::fmt;

/// The name and range of a parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// Its name.
    pub name: &'static str,
    /// The least value that is allowed.
    pub least: f64,
    /// The greatest value that is allowed.
    pub most: f64,
    /// Which values between them are allowed.
    pub values: Values,
}

/// Which values of its range a parameter may have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Values {
    /// Any number in its range.
    Any,
    /// Whole numbers.
    Whole,
    /// Powers of two, including those below 1.
    PowersOfTwo,
}

/// A value that a parameter cannot have, or an unknown name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ParameterError(String);

impl fmt::Display for ParameterError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for ParameterError {}

impl Parameter {
    /// Checks a value.
    ///
    /// # Errors
    /// If the value is not allowed; the message says which values are.
    pub fn check(&self, value: f64) -> Result<(), ParameterError> {
        let is_allowed = match self.values {
            Values::Any => true,
            Values::Whole => value.fract() == 0.0,
            // The logarithm of a number that is not positive, or is infinite, is not finite: its fraction is NaN, not zero.
            Values::PowersOfTwo => value.log2().fract() == 0.0,
        };
        if is_allowed && (self.least..=self.most).contains(&value) {
            return Ok(());
        }
        let kind = match self.values {
            Values::Any => "a number",
            Values::Whole => "a whole number",
            Values::PowersOfTwo => "a power of two",
        };
        Err(ParameterError(format!("must be {kind} from {} to {}", self.least, self.most)))
    }
}

/// Makes the struct, its defaults, and the table of names.
macro_rules! parameters {
    ($($(#[$about:meta])* $name:ident: $type:ty = $default:expr, $values:ident $least:literal ..= $most:literal;)*) => {
        /// Values of all free parameters, each within its range. [`Parameters::default`] has the measured ones.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct Parameters {
            $($(#[$about])* pub(crate) $name: $type,)*
        }

        impl Default for Parameters {
            fn default() -> Self {
                Self { $($name: $default,)* }
            }
        }

        impl Parameters {
            /// All parameters, in the order of [`Parameters::values`].
            pub const ALL: &[Parameter] = &[$(
                Parameter { name: stringify!($name), least: $least, most: $most, values: Values::$values },
            )*];

            /// The values of all parameters, in the order of [`Parameters::ALL`].
            pub fn values(&self) -> Vec<f64> {
                vec![$(f64::from(self.$name)),*]
            }

            /// The same with another value of the parameter `name`.
            ///
            /// # Errors
            /// If there is no such parameter, or if the value is not allowed; the message says which values are.
            pub fn with(mut self, name: &str, value: f64) -> Result<Self, ParameterError> {
                let parameter = Self::ALL.iter().find(|parameter| parameter.name == name);
                parameter.ok_or_else(|| ParameterError(format!("is no parameter: {name}")))?.check(value)?;
                match name {
                    $(stringify!($name) => self.$name = value as $type,)*
                    _ => unreachable!("it is in the table"),
                }
                Ok(self)
            }
        }
    };
}

parameters! {
    /// Size of the join's cells over the typical search radius, if one photon counts at a visible point. With more
    /// photons at a point, cells are smaller by the fourth root of their number. Smaller cells take more look-ups, larger
    /// ones bring more photons that are too far away. Measured on the five scenes of the paper: a size of 2 is best at 26
    /// photons per point, 3 at 7, 4 at 3, and 6 at 1; a size of 1 is worse everywhere.
    cell_size: f32 = 5.0, Any 2.0..=12.0;
    /// Photons that count at a visible point, as assumed for the first iteration. Later ones take the last iteration's.
    neighbours_at_first: f32 = 8.0, Any 0.25..=64.0;
    /// Buckets of the join's table, over the photons of an iteration. With few buckets, photons from elsewhere are
    /// tested; many do not fit into the cache.
    buckets_per_photon: f32 = 1.0, PowersOfTwo 0.125..=4.0;
    /// Size of the occupancy map's cells over the largest search radius. The map drops photons that no visible point can
    /// reach; smaller cells drop more of them and are more work to mark.
    occupancy_cell_size: f32 = 2.0, Any 0.5..=8.0;
    /// Bits of the occupancy map. With few bits, cells collide and fewer photons are dropped; many do not fit into the
    /// cache.
    occupancy_bits: u32 = 1 << 19, PowersOfTwo 32_768.0..=2_097_152.0;
    /// Camera paths of a batch. Large batches overlap more packets, small ones stay nearer in the caches.
    pixels_per_batch: u32 = 256, PowersOfTwo 64.0..=256.0;
    /// Photons of a batch.
    photons_per_batch: u32 = 256, PowersOfTwo 64.0..=256.0;
    /// Pixels of a work item. Small items spread evenly over threads, large ones start less often.
    pixels_per_job: u32 = 1024, PowersOfTwo 256.0..=16_384.0;
    /// Photons of a work item.
    photons_per_job: u32 = 1024, PowersOfTwo 256.0..=32_768.0;
    /// The most balls (spheres that rays meet from outside) that are tested one by one.
    most_balls_in_turn: u32 = 12, Whole 0.0..=4096.0;
    /// The most balls that are put in clusters; more are put in a tree.
    most_balls_in_clusters: u32 = 1024, Whole 0.0..=4096.0;
}

impl Parameters {
    /// The search for so many balls.
    pub fn search(&self, balls: usize) -> Search {
        if balls <= self.most_balls_in_turn as usize {
            Search::InTurn
        } else if balls <= self.most_balls_in_clusters as usize {
            Search::Clusters
        } else {
            Search::Tree
        }
    }

    /// The least number of buckets for so many photons.
    pub(crate) fn buckets(&self, photons: u32) -> usize {
        (f64::from(photons) * f64::from(self.buckets_per_photon)).ceil() as usize
    }
}

// The ranges above end with what batches have room for.
const _: () = assert!(BATCH == 256);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_are_allowed() {
        let parameters = Parameters::default();
        let values = parameters.values();
        assert_eq!(values.len(), Parameters::ALL.len());
        for (parameter, value) in Parameters::ALL.iter().zip(values) {
            assert_eq!(parameter.check(value), Ok(()), "{parameter:?}");
            assert_eq!(parameters.with(parameter.name, value), Ok(parameters));
        }
    }

    #[test]
    fn each_name_sets_its_own_value() {
        for (place, parameter) in Parameters::ALL.iter().enumerate() {
            let changed = Parameters::default().with(parameter.name, parameter.most).unwrap().values();
            let mut expected = Parameters::default().values();
            expected[place] = parameter.most;
            assert_eq!(changed, expected, "{parameter:?}");
        }
    }

    #[test]
    fn other_values_are_refused() {
        let refused = |name, value| Parameters::default().with(name, value).unwrap_err().to_string();
        assert_eq!(refused("cell_size", 1.9), "must be a number from 2 to 12");
        assert_eq!(refused("cell_size", f64::NAN), "must be a number from 2 to 12");
        assert_eq!(refused("pixels_per_batch", 192.0), "must be a power of two from 64 to 256");
        assert_eq!(refused("photons_per_job", 65536.0), "must be a power of two from 256 to 32768");
        assert_eq!(refused("buckets_per_photon", 0.0), "must be a power of two from 0.125 to 4");
        assert_eq!(refused("most_balls_in_turn", 1.5), "must be a whole number from 0 to 4096");
        assert_eq!(refused("colour", 1.0), "is no parameter: colour");
    }

    #[test]
    fn limits_choose_the_search() {
        let search = |turn, clusters, balls| {
            let parameters = Parameters::default().with("most_balls_in_turn", turn);
            parameters.and_then(|p| p.with("most_balls_in_clusters", clusters)).unwrap().search(balls)
        };
        assert_eq!(search(12.0, 1024.0, 12), Search::InTurn);
        assert_eq!(search(12.0, 1024.0, 13), Search::Clusters);
        assert_eq!(search(12.0, 1024.0, 1024), Search::Clusters);
        assert_eq!(search(12.0, 1024.0, 1025), Search::Tree);
        assert_eq!(search(0.0, 0.0, 1), Search::Tree);
        assert_eq!(search(20.0, 10.0, 15), Search::InTurn);
    }
}
