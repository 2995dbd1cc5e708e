//! The structural similarity index (SSIM) as Wang, Bovik, Sheikh and Simoncelli (2004) define it.
//!
//! It is implemented here because the crate `image-compare` computes something else under this name: its windows are
//! disjoint 8x8 squares without weights, and its variances are sums instead of means, so that C1 and C2 lose their
//! meaning.
//!
//! Windows are Gaussian, 11x11, sigma 1.5, one around every pixel. At the border the image is reflected about its
//! outermost pixels (the default of `OpenCV`), so that images of any size have an index.

use crate::window::{along, weighted};
use rayon::prelude::*;
use std::array;
use std::ops::Range;

/// Pixels of the window on each side of its centre.
const REACH: usize = 5;
const WINDOW: usize = 2 * REACH + 1;
const SIGMA: f64 = 1.5;
/// `(K1 L)^2` and `(K2 L)^2` with the paper's K1, K2 and a dynamic range L of 1.
const C1: f64 = 0.01 * 0.01;
const C2: f64 = 0.03 * 0.03;

/// The sum of the SSIM index over each of `rows`, of images of one channel with `height` rows of values in [0, 1].
/// `row` returns one row of each; rows farther than [`REACH`] from `rows` are not asked for.
pub(crate) fn row_sums<'a>(
    rows: Range<usize>,
    height: usize,
    row: impl Fn(usize) -> [&'a [f64]; 2] + Sync,
) -> Vec<f64> {
    let weights = weights();
    let first = rows.start.saturating_sub(REACH);
    let around = first..height.min(rows.end + REACH);
    let moments: Vec<Moments> = around.into_par_iter().map(|y| moments(row(y), &weights)).collect();
    let sum = |y: usize| {
        let window: [&Moments; WINDOW] = array::from_fn(|i| &moments[reflect(y + i, height) - first]);
        let means: Moments =
            array::from_fn(|m| weighted(window[0][m].len(), &weights, |k| window[k][m].as_slice()));
        (0..means[0].len()).map(|x| index(array::from_fn(|m| means[m][x]))).sum()
    };
    rows.into_par_iter().map(sum).collect()
}

/// The weighted means of a, b, a^2, b^2 and ab over windows.
type Moments = [Vec<f64>; 5];

/// The moments of one row, with windows along the row only.
fn moments([a, b]: [&[f64]; 2], weights: &[f64; WINDOW]) -> Moments {
    let of: [fn(f64, f64) -> f64; 5] = [|a, _| a, |_, b| b, |a, _| a * a, |_, b| b * b, |a, b| a * b];
    of.map(|of| {
        let around = (0..a.len() + 2 * REACH).map(|x| reflect(x, a.len()));
        let values: Vec<f64> = around.map(|x| of(a[x], b[x])).collect();
        along(&values, weights)
    })
}

/// The SSIM index of one window.
fn index([ma, mb, aa, bb, ab]: [f64; 5]) -> f64 {
    let (variances, covariance) = (aa - ma * ma + (bb - mb * mb), ab - ma * mb);
    (2.0 * ma * mb + C1) * (2.0 * covariance + C2) / ((ma * ma + mb * mb + C1) * (variances + C2))
}

/// The Gaussian at `-REACH..=REACH`, normalised to the sum 1.
fn weights() -> [f64; WINDOW] {
    let gaussian = |i: usize| {
        let x = (i as f64 - REACH as f64) / SIGMA;
        (-0.5 * x * x).exp()
    };
    let sum: f64 = (0..WINDOW).map(gaussian).sum();
    array::from_fn(|i| gaussian(i) / sum)
}

/// Maps the index `shifted - REACH` into `0..length` by reflection about the end pixels, which are not repeated.
fn reflect(shifted: usize, length: usize) -> usize {
    if length == 1 {
        return 0;
    }
    let period = 2 * (length - 1);
    // Adds REACH periods before the subtraction, so that the index stays positive.
    let place = (shifted + REACH * period - REACH) % period;
    place.min(period - place)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The index of whole images with `width` values in a row.
    fn of(a: &[f64], b: &[f64], width: usize) -> f64 {
        let height = a.len() / width;
        let sums = row_sums(0..height, height, |y| [a, b].map(|values| &values[y * width..][..width]));
        sums.iter().sum::<f64>() / a.len() as f64
    }

    #[test]
    fn reflection_keeps_the_ends_single() {
        let around =
            |middle: usize, length| (0..=2 * REACH).map(|i| reflect(middle + i, length)).collect::<Vec<_>>();
        assert_eq!(around(0, 8), [5, 4, 3, 2, 1, 0, 1, 2, 3, 4, 5]);
        assert_eq!(around(7, 8), [2, 3, 4, 5, 6, 7, 6, 5, 4, 3, 2]);
        assert_eq!(around(0, 2), [1, 0, 1, 0, 1, 0, 1, 0, 1, 0, 1]);
        assert_eq!(around(0, 1), [0; 11]);
    }

    #[test]
    fn of_an_image_and_itself_it_is_one() {
        let a: Vec<f64> = (0..35).map(|i| f64::from(i * 37 % 11) / 11.0).collect();
        assert_eq!(of(&a, &a, 7), 1.0);
        assert_eq!(of(&[0.3], &[0.3], 1), 1.0);
    }

    #[test]
    fn of_constants_only_the_luminance_term_is_left() {
        let expected = (2.0 * 0.2 * 0.6 + C1) / (0.2 * 0.2 + 0.6 * 0.6 + C1);
        approx::assert_relative_eq!(of(&[0.2; 12], &[0.6; 12], 4), expected, max_relative = 1e-12);
    }

    #[test]
    fn rows_and_columns_are_alike() {
        let value = |x: usize, y: usize, k: usize| ((x * 7 + y * k) % 13) as f64 / 13.0;
        let image = |k| (0..60).map(|i| value(i % 12, i / 12, k)).collect::<Vec<_>>();
        let transposed = |k| (0..60).map(|i| value(i / 5, i % 5, k)).collect::<Vec<_>>();
        let (across, down) = (of(&image(3), &image(5), 12), of(&transposed(3), &transposed(5), 5));
        assert!(across < 0.9, "{across}");
        approx::assert_relative_eq!(across, down, max_relative = 1e-12);
    }

    #[test]
    fn two_pixels_by_hand() {
        // Reflected, a row of two pixels alternates. `e` is the weight of the positions at even distances, 0 included.
        let g = |x: f64| (-0.5 * x * x / 2.25).exp();
        let even = 1.0 + 2.0 * (g(2.0) + g(4.0));
        let e = even / (even + 2.0 * (g(1.0) + g(3.0) + g(5.0)));
        // For a = (1, 0) and b = (0, 1): means are e and 1 - e, squares equal the values, and products are 0.
        let product = e * (1.0 - e);
        let expected = (2.0 * product + C1) * (C2 - 2.0 * product)
            / ((e * e + (1.0 - e) * (1.0 - e) + C1) * (2.0 * product + C2));
        approx::assert_relative_eq!(of(&[1.0, 0.0], &[0.0, 1.0], 2), expected, max_relative = 1e-12);
    }
}
