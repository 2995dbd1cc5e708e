//! The filters of FLIP: contrast sensitivity per opponent colour, and detectors of edges and points.

/// Pixels per degree of visual angle.
const PIXELS_PER_DEGREE: f32 = 67.0;
/// Columns and rows that filters reach from their centre: three standard deviations of the widest.
pub(super) const REACH: usize = 10;
const WINDOW: usize = 2 * REACH + 1;
/// Width of the feature detectors in degrees.
const FEATURE_WIDTH: f32 = 0.082;
/// The detectors reach three standard deviations.
const FEATURE_REACH: f32 = 9.0;

/// Weights from `-REACH` to `REACH`.
type Weights = [f32; WINDOW];

/// The filters, each of which is applied along rows and over rows.
pub(super) struct Filters {
    /// For luminance, red-green, and the two parts of blue-yellow.
    pub(super) spatial: [Weights; 4],
    /// The first derivative of a Gaussian: positive weights sum to 1, negative to -1.
    pub(super) first: Weights,
    /// The second derivative, normalised alike.
    pub(super) second: Weights,
    /// The Gaussian, with sum 1.
    pub(super) gaussian: Weights,
}

impl Filters {
    pub(super) fn new() -> Self {
        // Amplitudes and widths of Gaussians in the frequency domain (table 1 of the paper).
        let [y, x, z1, z2] = [(1.0, 0.0047), (1.0, 0.0053), (34.1, 0.04), (13.5, 0.025)]
            .map(|(amplitude, width): (f32, f32)| sensitivity(amplitude, width));
        let scale = 1.0 / (sum(&z1) * sum(&z1) + sum(&z2) * sum(&z2)).sqrt();
        let deviation = 0.5 * FEATURE_WIDTH * PIXELS_PER_DEGREE;
        let gaussian = weights(|x| {
            let value = (-(x * x) / (2.0 * deviation * deviation)).exp();
            if x.abs() > FEATURE_REACH { 0.0 } else { value }
        });
        let of = |factor: &dyn Fn(f32) -> f32| {
            let mut index = 0;
            gaussian.map(|g| {
                index += 1;
                factor(place(index - 1)) * g
            })
        };
        Self {
            spatial: [
                scaled(&y, 1.0 / sum(&y)),
                scaled(&x, 1.0 / sum(&x)),
                scaled(&z1, scale),
                scaled(&z2, scale),
            ],
            first: balanced(&of(&|x| -x)),
            second: balanced(&of(&|x| x * x / (deviation * deviation) - 1.0)),
            gaussian: scaled(&gaussian, 1.0 / sum(&gaussian)),
        }
    }
}

/// The Gaussian whose product along rows and over rows is `amplitude sqrt(pi / width) exp(-pi^2 r^2 / width)`, with r in
/// degrees. Normalisation follows.
fn sensitivity(amplitude: f32, width: f32) -> Weights {
    use std::f32::consts::PI;
    weights(|x| {
        let degrees = x / PIXELS_PER_DEGREE;
        (amplitude * (PI / width).sqrt()).sqrt() * (-PI * PI * degrees * degrees / width).exp()
    })
}

fn place(index: usize) -> f32 {
    index as f32 - REACH as f32
}

fn weights(of: impl Fn(f32) -> f32) -> Weights {
    std::array::from_fn(|index| of(place(index)))
}

fn sum(weights: &Weights) -> f32 {
    weights.iter().sum()
}

fn scaled(weights: &Weights, factor: f32) -> Weights {
    weights.map(|weight| weight * factor)
}

/// Scales the positive weights to the sum 1, and the negative ones to -1.
fn balanced(weights: &Weights) -> Weights {
    let positive: f32 = weights.iter().filter(|weight| **weight > 0.0).sum();
    let negative: f32 = weights.iter().filter(|weight| **weight < 0.0).sum();
    weights.map(|weight| if weight > 0.0 { weight / positive } else { weight / -negative })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_reach_is_three_deviations_of_the_widest() {
        let widest = (0.04 / (2.0 * std::f32::consts::PI * std::f32::consts::PI)).sqrt() * PIXELS_PER_DEGREE;
        assert_eq!(REACH, (3.0 * widest).ceil() as usize);
        assert_eq!(FEATURE_REACH, (3.0 * 0.5 * FEATURE_WIDTH * PIXELS_PER_DEGREE).ceil());
    }
}
