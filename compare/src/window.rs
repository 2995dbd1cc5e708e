//! Separable filters: along rows, and then over rows.

use std::ops::{AddAssign, Mul};

/// Columns that are summed together, so that they stay in registers and the nearest cache.
const COLUMNS: usize = 512;

/// A number that filters sum.
pub(crate) trait Number: Copy + Default + AddAssign + Mul<Output = Self> {}

impl<T: Copy + Default + AddAssign + Mul<Output = T>> Number for T {}

/// Sums of `weights.len()` neighbours, from the left: `sum[x]` is of `padded[x..]`.
pub(crate) fn along<T: Number>(padded: &[T], weights: &[T]) -> Vec<T> {
    let shifted = |k: usize| &padded[k..];
    weighted(padded.len() + 1 - weights.len(), weights, shifted)
}

/// Sums over rows, from the first: `row(k)` is the row with weight `weights[k]`.
pub(crate) fn weighted<'a, T: Number + 'a>(
    width: usize,
    weights: &[T],
    row: impl Fn(usize) -> &'a [T],
) -> Vec<T> {
    let mut sums = vec![T::default(); width];
    for (part, sums) in sums.chunks_mut(COLUMNS).enumerate() {
        for (k, &weight) in weights.iter().enumerate() {
            for (sum, &value) in sums.iter_mut().zip(&row(k)[part * COLUMNS..]) {
                *sum += weight * value;
            }
        }
    }
    sums
}

/// The values with the first and the last repeated `reach` times.
pub(crate) fn padded<T: Copy>(values: &[T], reach: usize) -> Vec<T> {
    let (first, last) = (values[0], values[values.len() - 1]);
    let ends = |value| std::iter::repeat_n(value, reach);
    ends(first).chain(values.iter().copied()).chain(ends(last)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_are_of_neighbours() {
        let values: Vec<f64> = (0..1200).map(|i| f64::from(i % 7)).collect();
        let sums = along(&padded(&values, 1), &[0.25, 0.5, 2.0]);
        assert_eq!(sums.len(), 1200);
        let at = |i: isize| values[i.clamp(0, 1199) as usize];
        for (x, sum) in sums.iter().enumerate() {
            let x = x as isize;
            assert_eq!(*sum, 0.25 * at(x - 1) + 0.5 * at(x) + 2.0 * at(x + 1));
        }
    }
}
