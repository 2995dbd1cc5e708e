//! The structural similarity index (SSIM) as Wang, Bovik, Sheikh and Simoncelli (2004) define it.
//!
//! It is implemented here because the crate `image-compare` computes something else under this name: its windows are
//! disjoint 8x8 squares without weights, and its variances are sums instead of means, so that C1 and C2 lose their
//! meaning.
//!
//! Windows are Gaussian, 11x11, sigma 1.5, one around every pixel. At the border the image is reflected about its
//! outermost pixels (the default of `OpenCV`), so that images of any size have an index.

use std::array;

/// Pixels of the window on each side of its centre.
const REACH: usize = 5;
const WINDOW: usize = 2 * REACH + 1;
const SIGMA: f64 = 1.5;
/// `(K1 L)^2` and `(K2 L)^2` with the paper's K1, K2 and a dynamic range L of 1.
const C1: f64 = 0.01 * 0.01;
const C2: f64 = 0.03 * 0.03;

/// The mean SSIM index of two images of one channel, with `height` rows of `width` values in [0, 1]. `rows` returns one
/// row of each. Only as many rows are held in memory as a window is high.
pub(crate) fn ssim(width: usize, height: usize, rows: impl Fn(usize) -> [Vec<f64>; 2]) -> f64 {
    let weights = weights();
    let mut ring: [Moments; WINDOW] = array::from_fn(|_| Moments::default());
    let (mut sum, mut next) = (0.0, 0);
    for y in 0..height {
        while next < height.min(y + REACH + 1) {
            ring[next % WINDOW] = moments(&rows(next), &weights);
            next += 1;
        }
        let window: [&Moments; WINDOW] = array::from_fn(|i| &ring[reflect(y + i, height) % WINDOW]);
        for x in 0..width {
            let weighted = |m: usize| weights.iter().zip(window).map(|(w, row)| w * row[m][x]).sum();
            sum += index(array::from_fn(weighted));
        }
    }
    sum / (width * height) as f64
}

/// The weighted means of a, b, a^2, b^2 and ab over windows.
type Moments = [Vec<f64>; 5];

/// The moments of one row, with windows along the row only.
fn moments([a, b]: &[Vec<f64>; 2], weights: &[f64; WINDOW]) -> Moments {
    let of: [fn(f64, f64) -> f64; 5] = [|a, _| a, |_, b| b, |a, _| a * a, |_, b| b * b, |a, b| a * b];
    of.map(|of| {
        let around = (0..a.len() + 2 * REACH).map(|x| reflect(x, a.len()));
        let values: Vec<f64> = around.map(|x| of(a[x], b[x])).collect();
        values.windows(WINDOW).map(|window| weights.iter().zip(window).map(|(w, v)| w * v).sum()).collect()
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
        let row = |values: &[f64], y: usize| values[y * width..][..width].to_vec();
        ssim(width, a.len() / width, |y| [row(a, y), row(b, y)])
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
