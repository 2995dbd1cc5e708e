//! Reconstruction filters: how a pixel averages the light that arrives around it.
//!
//! A sample belongs to one pixel, and the filter decides where in the image it is taken: the place is drawn with a
//! density in proportion to the filter's absolute value (filter importance sampling; Ernst, Stamminger and Greiner 2006).
//! So a pixel's samples keep their random numbers and its sums stay its own. Where the filter is negative the sample
//! counts negatively.
//!
//! Filters are separable. Along each axis the density is that of [`PIECES`] pieces of equal probability; a table holds
//! their ends. It is computed in `f64` by exactly rounded operations, so it is the same on every machine.

use serde::{Deserialize, Serialize};
use std::fmt;
use std::sync::LazyLock;

/// How a pixel averages the light around it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Filter {
    /// All of the pixel alike, and nothing else.
    #[default]
    Box,
    /// A Gaussian of standard deviation 0.5 pixels, cut off at 2 pixels, less its value there.
    Gaussian,
    /// The cubic filter of Mitchell and Netravali (1988) with B = C = 1/3, out to 2 pixels; negative beyond 8/7.
    Mitchell,
}

/// The pieces of a filter.
pub const PIECES: usize = 1024;

/// Samples of the filter from which its table is made.
const SAMPLES: usize = 1 << 16;

/// The table of a filter: maps a uniform number to a place along one axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Where each piece begins, in pixels from the pixel's left edge; its centre is at 0.5.
    pub begins: [f32; PIECES],
    /// The length of each piece, in pixels.
    pub lengths: [f32; PIECES],
    /// What a sample in each piece counts; 1 on the average over all pieces.
    pub weights: [f32; PIECES],
}

impl Filter {
    /// All filters.
    pub const ALL: [Self; 3] = [Self::Box, Self::Gaussian, Self::Mitchell];

    /// Its name in scene files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Box => "box",
            Self::Gaussian => "gaussian",
            Self::Mitchell => "mitchell",
        }
    }

    /// The distance from the pixel's centre beyond which the filter is zero, in pixels along each axis.
    pub fn radius(self) -> f64 {
        match self {
            Self::Box => 0.5,
            Self::Gaussian | Self::Mitchell => 2.0,
        }
    }

    /// The value at distance `x` from the pixel's centre along one axis, up to a factor.
    pub fn value(self, x: f64) -> f64 {
        let x = x.abs();
        match self {
            _ if x > self.radius() => 0.0,
            Self::Box => 1.0,
            Self::Gaussian => exp_of_minus(2.0 * x * x) - exp_of_minus(8.0),
            Self::Mitchell if x > 1.0 => ((-7.0 / 3.0 * x + 12.0) * x - 20.0) * x + 32.0 / 3.0,
            Self::Mitchell => (7.0 * x - 12.0) * x * x + 16.0 / 3.0,
        }
    }

    /// The table of the filter, made when it is first asked for; `None` for the box, whose places are the uniform numbers
    /// themselves.
    pub fn table(self) -> Option<&'static Table> {
        static GAUSSIAN: LazyLock<Box<Table>> = LazyLock::new(|| Table::new(Filter::Gaussian));
        static MITCHELL: LazyLock<Box<Table>> = LazyLock::new(|| Table::new(Filter::Mitchell));
        match self {
            Self::Box => None,
            Self::Gaussian => Some(&GAUSSIAN),
            Self::Mitchell => Some(&MITCHELL),
        }
    }
}

impl fmt::Display for Filter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl Table {
    fn new(filter: Filter) -> Box<Self> {
        let step = 2.0 * filter.radius() / SAMPLES as f64;
        let start = |i: usize| i as f64 * step - filter.radius();
        let values: Vec<f64> = (0..SAMPLES).map(|i| filter.value(start(i) + 0.5 * step)).collect();
        let all: f64 = values.iter().sum();
        let size: f64 = values.iter().map(|value| value.abs()).sum();
        let mut table =
            Box::new(Self { begins: [0.0; PIECES], lengths: [0.0; PIECES], weights: [0.0; PIECES] });
        // Walks along the samples; a piece ends where its share of `size` is used up, within a sample.
        let (mut sample, mut used) = (0, 0.0);
        let mut begin = (0.5 - filter.radius()) as f32;
        for piece in 0..PIECES {
            let (mut left, mut signed) = (size / PIECES as f64, 0.0);
            while sample < SAMPLES && values[sample].abs() - used <= left {
                left -= values[sample].abs() - used;
                signed += (values[sample].abs() - used) * values[sample].signum();
                (sample, used) = (sample + 1, 0.0);
            }
            if sample < SAMPLES {
                used += left;
                signed += left * values[sample].signum();
            }
            let share = values.get(sample).map_or(0.0, |value| used / value.abs());
            let end = (0.5 + start(sample) + share * step) as f32;
            (table.begins[piece], table.lengths[piece]) = (begin, end - begin);
            begin = end;
            table.weights[piece] = (signed * PIECES as f64 / all) as f32;
        }
        table
    }

    /// The place along one axis, in pixels from the pixel's left edge, for the uniform number `u` in [0, 1), and what a
    /// sample there counts.
    #[inline]
    pub fn place(&self, u: f32) -> (f32, f32) {
        let scaled = u * PIECES as f32;
        let piece = scaled as usize;
        (self.begins[piece] + (scaled - piece as f32) * self.lengths[piece], self.weights[piece])
    }
}

/// `exp(-x)` for `x` from 0 to 8: 1 over the Taylor series at `x / 8`, raised to the eighth power.
fn exp_of_minus(x: f64) -> f64 {
    let (mut sum, mut term) = (0.0, 1.0);
    for k in 1..24 {
        sum += term;
        term *= x / (8.0 * f64::from(k));
    }
    let square = sum * sum;
    let fourth = square * square;
    1.0 / (fourth * fourth)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::de::IntoDeserializer;
    use serde::de::value::Error;

    #[test]
    fn the_series_is_the_exponential_function() {
        for i in 0..800 {
            let x = f64::from(i) * 0.01;
            approx::assert_relative_eq!(exp_of_minus(x), (-x).exp(), max_relative = 1e-14);
        }
    }

    /// Weighted places have the filter's integrals over any interval, exactly but for the pieces.
    #[test]
    fn places_have_the_density_of_the_filter() {
        /// Half a piece: an interval's ends cut two pieces, within which the density is constant and the filter is not.
        const TOLERANCE: f64 = 0.5 / PIECES as f64;
        const COUNT: u32 = 1 << 16;
        for filter in [Filter::Gaussian, Filter::Mitchell] {
            let table = filter.table().unwrap();
            let places: Vec<(f32, f32)> =
                (0..COUNT).map(|i| table.place((i as f32 + 0.5) / COUNT as f32)).collect();
            let integral = |from: f64, to: f64| {
                let step = (to - from) / 1e5;
                (0..100_000).map(|i| filter.value(from + (f64::from(i) + 0.5) * step) * step).sum::<f64>()
            };
            let all = integral(-filter.radius(), filter.radius());
            for i in 0..32 {
                let [from, to] = [i, i + 1].map(|i| (f64::from(i) / 16.0 - 1.0) * filter.radius());
                let within = |x: f32| (from..to).contains(&(f64::from(x) - 0.5));
                let found: f64 = places.iter().filter(|(x, _)| within(*x)).map(|(_, w)| f64::from(*w)).sum();
                let (found, stated) = (found / f64::from(COUNT), integral(from, to) / all);
                assert!(
                    (found - stated).abs() < TOLERANCE,
                    "{filter}, {from} to {to}: {found}, not {stated}"
                );
            }
        }
    }

    #[test]
    fn weights_are_1_on_the_average_and_1_where_the_filter_is_positive() {
        for (filter, most) in [(Filter::Gaussian, 1.0), (Filter::Mitchell, 1.1)] {
            let table = filter.table().unwrap();
            let mean = table.weights.iter().map(|&w| f64::from(w)).sum::<f64>() / PIECES as f64;
            assert!((mean - 1.0).abs() < 1e-6, "{filter}: {mean}");
            assert!(table.weights.iter().all(|w| w.abs() <= most), "{filter}");
            assert!(table.lengths.iter().all(|length| *length > 0.0), "{filter}");
        }
        assert!(Filter::Gaussian.table().unwrap().weights.iter().all(|w| *w == 1.0));
        assert!(Filter::Mitchell.table().unwrap().weights[0] < -1.0);
    }

    /// The cubic is that of the paper with B = C = 1/3: continuous, and its shifts by whole pixels sum to one number.
    #[test]
    fn shifted_filters_of_mitchell_and_netravali_sum_to_one_number() {
        let sum = |x: f64| (-2..=2).map(|k| Filter::Mitchell.value(x + f64::from(k))).sum::<f64>();
        for i in 0..100 {
            approx::assert_relative_eq!(sum(f64::from(i) * 0.01), 6.0, max_relative = 1e-12);
        }
        approx::assert_abs_diff_eq!(Filter::Mitchell.value(8.0 / 7.0), 0.0, epsilon = 1e-12);
    }

    #[test]
    fn filters_have_the_names_that_files_have_for_them() {
        for filter in Filter::ALL {
            let name = IntoDeserializer::<Error>::into_deserializer(filter.name());
            assert_eq!((Filter::deserialize(name), filter.to_string()), (Ok(filter), filter.name().into()));
        }
        assert_eq!(Filter::default(), Filter::ALL[0]);
    }
}
