//! Ratios of render times, their median, and its confidence interval.

/// The confidence level of intervals.
const CONFIDENCE: f64 = 0.95;

/// Ratios of a candidate's times to those of the defaults, one per pair of renders.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Ratios {
    /// In increasing order.
    sorted: Vec<f64>,
}

impl Ratios {
    /// The ratios of one pair of renders or more.
    pub(crate) fn new(mut ratios: Vec<f64>) -> Self {
        ratios.sort_by(f64::total_cmp);
        Self { sorted: ratios }
    }

    /// Merges two sets of ratios.
    pub(crate) fn and(self, other: Self) -> Self {
        Self::new([self.sorted, other.sorted].concat())
    }

    /// The median; for an even number, the geometric mean of the two in the middle.
    pub(crate) fn median(&self) -> f64 {
        let n = self.sorted.len();
        (self.sorted[(n - 1) / 2] * self.sorted[n / 2]).sqrt()
    }

    /// The confidence interval of the median by the sign test, which assumes no distribution. The probability that the
    /// median lies outside of the interval from the k-th least to the k-th greatest ratio is twice the probability that
    /// a fair coin shows heads fewer than k times. If there are too few ratios for the confidence level, the interval
    /// goes from the least to the greatest. Works for at most 1000 ratios.
    pub(crate) fn interval(&self) -> [f64; 2] {
        let n = self.sorted.len();
        let (mut below, mut probability, mut k) = (0.0, 0.5_f64.powi(n as i32), 0);
        // The probability of heads exactly k times.
        while below + probability <= (1.0 - CONFIDENCE) / 2.0 {
            below += probability;
            probability *= (n - k) as f64 / (k + 1) as f64;
            k += 1;
        }
        let k = k.max(1);
        [self.sorted[k - 1], self.sorted[n - k]]
    }

    /// The least and the greatest ratio.
    pub(crate) fn ends(&self) -> [f64; 2] {
        [self.sorted[0], self.sorted[self.sorted.len() - 1]]
    }

    /// The number of pairs.
    pub(crate) fn count(&self) -> usize {
        self.sorted.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ratios(values: impl IntoIterator<Item = u32>) -> Ratios {
        Ratios::new(values.into_iter().map(f64::from).collect())
    }

    #[test]
    fn medians() {
        assert_eq!(ratios([3, 1, 2]).median(), 2.0);
        assert_eq!(ratios([4, 1]).median(), 2.0);
        assert_eq!(ratios([5]).and(ratios([7, 6])), ratios([5, 6, 7]));
        assert_eq!(ratios([1, 2, 3, 4]).count(), 4);
        assert_eq!(ratios([5, 9, 2, 7, 4, 3, 8, 6, 1]).ends(), [1.0, 9.0]);
    }

    /// The expected values are from published tables of the sign test.
    #[test]
    fn intervals_are_those_of_the_sign_test() {
        for (n, k) in
            [(6, 1), (8, 1), (9, 2), (11, 2), (12, 3), (15, 4), (20, 6), (21, 6), (25, 8), (1000, 469)]
        {
            assert_eq!(ratios(1..=n).interval(), [f64::from(k), f64::from(n + 1 - k)], "{n}");
        }
        assert_eq!(ratios([2, 1]).interval(), [1.0, 2.0]);
    }
}
