//! The exposures of HDR-FLIP, from the luminances of the reference.

use super::color::ACES;
use crate::rank::{Coarse, Fine};
use scene::Rgb;

/// Exposures in stops: from the one at which the brightest pixel is just below white, to the one at which the median is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Exposures {
    first: f32,
    last: f32,
}

/// The tone-mapped value that counts as white.
const WHITE: f32 = 0.85;

/// The two ranks whose mean is the median of all values but the `least` smallest; of an odd number those before its middle and at
/// it, as in the program of FLIP's authors.
fn middle(count: u64, least: u64) -> [u64; 2] {
    let upper = (count - least) / 2;
    [least + upper.saturating_sub(1), least + upper]
}

impl Exposures {
    /// The ranks of luminances that [`Self::new`] needs; `None` if all are black.
    pub(crate) fn ranks(luminances: &Coarse) -> Option<Vec<u64>> {
        let Coarse { count, zeros, .. } = *luminances;
        (zeros < count).then(|| [middle(count, 0), middle(count, zeros)].concat())
    }

    /// The exposures for these luminances, not all of which are black. Where at least half are, the median is of the
    /// others: that of all would be brightened without end.
    pub(crate) fn new(luminances: &Coarse, ranked: &Fine) -> Self {
        let Coarse { count, zeros, greatest, .. } = *luminances;
        let median = |least| middle(count, least).map(|rank| 0.5 * ranked.value(rank)).iter().sum::<f32>();
        let all = median(0);
        let median = if all > 0.0 { all } else { median(zeros) };
        let stops = |luminance: f32| (white() / luminance).log2();
        Self { first: stops(greatest), last: stops(median) }
    }

    /// The exposures: as many as there are stops between the first and the last, rounded up, and at least two. So they may lie more
    /// than a stop apart, but not more than two.
    pub(crate) fn iter(self) -> impl ExactSizeIterator<Item = f32> {
        let count = ((self.last - self.first).ceil() as u16).max(2);
        let step = (self.last - self.first) / f32::from(count - 1);
        (0..count).map(move |i| self.first + f32::from(i) * step)
    }
}

/// The value that is tone-mapped to [`WHITE`].
fn white() -> f32 {
    let [a, b, c] = [0, 1, 2].map(|i| ACES[i] - WHITE * ACES[i + 3]);
    let half = -0.5 * (b / a);
    half + (half * half - c / a).sqrt()
}

/// The luminance of a pixel; 0 for what is negative or no number.
pub(crate) fn luminance(pixel: Rgb) -> f32 {
    let luminance = 0.2126 * pixel.x + 0.7152 * pixel.y + 0.0722 * pixel.z;
    if luminance > 0.0 && luminance.is_finite() { luminance } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(luminances: &[f32]) -> Option<Vec<f32>> {
        let mut coarse = Coarse::new();
        for &v in luminances {
            coarse.add(v);
        }
        let mut fine = coarse.refine(Exposures::ranks(&coarse)?);
        for &v in luminances {
            fine.add(v);
        }
        Some(Exposures::new(&coarse, &fine).iter().collect())
    }

    fn stops(luminance: f32) -> f32 {
        (white() / luminance).log2()
    }

    #[test]
    fn white_is_tone_mapped_to_white() {
        let (v, [a, b, c, d, e, f]) = (white(), ACES);
        let shown = (a * v * v + b * v + c) / (d * v * v + e * v + f);
        approx::assert_relative_eq!(shown, WHITE, max_relative = 1e-6);
    }

    #[test]
    fn they_reach_from_the_brightest_to_the_median() {
        // The median is 1.5, 3.4 stops below 16: as many exposures as stops, rounded up.
        let exposures = of(&[1.0, 16.0, 2.0, 1.0]).unwrap();
        assert_eq!(exposures.len(), 4);
        assert_eq!(exposures[0], stops(16.0));
        approx::assert_relative_eq!(exposures[3], stops(1.5), max_relative = 1e-5);
        let step = exposures[1] - exposures[0];
        approx::assert_relative_eq!(exposures[2] - exposures[1], step, max_relative = 1e-5);
        assert_eq!(of(&[3.0]).unwrap(), [stops(3.0); 2]);
    }

    #[test]
    fn black_pixels_count_unless_they_are_the_most() {
        let exposures = of(&[0.0, 16.0, 0.0, 4.0, 2.0, 1.0]).unwrap();
        approx::assert_relative_eq!(*exposures.last().unwrap(), stops(1.5), max_relative = 1e-5);
        assert_eq!(of(&[0.0, 0.0, 0.0, 2.0, 1.0]).unwrap(), [stops(2.0), stops(1.5)]);
        assert_eq!(of(&[0.0; 7]), None);
    }
}
