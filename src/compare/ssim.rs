//! The structural similarity index of Wang, Bovik, Sheikh and Simoncelli (2004), as they define it.
//!
//! Written out because the crate `image-compare` computes something else under the name: its windows are disjoint
//! 8x8 squares without weights, and its variances are sums rather than means, so that C1 and C2 lose their meaning.
//!
//! Windows are Gaussian, 11x11, sigma 1.5, one around every pixel. At the border the image is reflected about its
//! outermost pixels (the default of `OpenCV`), so that images of any size have an index.

/// Half the side of the window, its middle not counted.
const REACH: usize = 5;
const SIGMA: f64 = 1.5;
/// `(K1 L)^2` and `(K2 L)^2` with the paper's K1, K2 and a dynamic range L of 1.
const C1: f64 = 0.01 * 0.01;
const C2: f64 = 0.03 * 0.03;

/// The mean SSIM index of two images of one channel, of values in [0, 1], `width` of them in a row.
pub(super) fn ssim(a: &[f64], b: &[f64], width: usize) -> f64 {
    let moment = |f: &dyn Fn(f64, f64) -> f64| blur(a.iter().zip(b).map(|(&a, &b)| f(a, b)).collect(), width);
    let (mean_a, mean_b) = (moment(&|a, _| a), moment(&|_, b| b));
    let (aa, bb, ab) = (moment(&|a, _| a * a), moment(&|_, b| b * b), moment(&|a, b| a * b));
    let index = |i: usize| {
        let (ma, mb) = (mean_a[i], mean_b[i]);
        let (variances, covariance) = (aa[i] - ma * ma + (bb[i] - mb * mb), ab[i] - ma * mb);
        (2.0 * ma * mb + C1) * (2.0 * covariance + C2) / ((ma * ma + mb * mb + C1) * (variances + C2))
    };
    (0..a.len()).map(index).sum::<f64>() / a.len() as f64
}

/// The image under the Gaussian window, row by row and then column by column.
fn blur(mut values: Vec<f64>, width: usize) -> Vec<f64> {
    let height = values.len() / width;
    let weights = weights();
    for row in values.chunks_exact_mut(width) {
        let source = row.to_vec();
        for (x, v) in row.iter_mut().enumerate() {
            *v = weighted(&weights, x, width, |x| source[x]);
        }
    }
    let source = values.clone();
    for (y, row) in values.chunks_exact_mut(width).enumerate() {
        for (x, v) in row.iter_mut().enumerate() {
            *v = weighted(&weights, y, height, |y| source[y * width + x]);
        }
    }
    values
}

/// The Gaussian at `-REACH..=REACH`, of sum 1.
fn weights() -> [f64; 2 * REACH + 1] {
    let gaussian = |i: usize| {
        let x = (i as f64 - REACH as f64) / SIGMA;
        (-0.5 * x * x).exp()
    };
    let sum: f64 = (0..=2 * REACH).map(gaussian).sum();
    std::array::from_fn(|i| gaussian(i) / sum)
}

/// The weighted mean around place `middle` of `length`.
fn weighted(weights: &[f64], middle: usize, length: usize, at: impl Fn(usize) -> f64) -> f64 {
    weights.iter().enumerate().map(|(i, w)| w * at(reflect(middle + i, length))).sum()
}

/// Place `shifted - REACH` brought into `0..length` by reflection about the ends, which occur once.
fn reflect(shifted: usize, length: usize) -> usize {
    if length == 1 {
        return 0;
    }
    let period = 2 * (length - 1);
    // Made positive first: REACH below 0 is as many periods up as it takes.
    let place = (shifted + REACH * period - REACH) % period;
    place.min(period - place)
}

#[cfg(test)]
mod tests {
    use super::*;

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
        assert_eq!(ssim(&a, &a, 7), 1.0);
        assert_eq!(ssim(&[0.3], &[0.3], 1), 1.0);
    }

    #[test]
    fn of_constants_only_the_luminance_term_is_left() {
        let expected = (2.0 * 0.2 * 0.6 + C1) / (0.2 * 0.2 + 0.6 * 0.6 + C1);
        approx::assert_relative_eq!(ssim(&[0.2; 12], &[0.6; 12], 4), expected, max_relative = 1e-12);
    }

    #[test]
    fn rows_and_columns_are_alike() {
        let value = |x: usize, y: usize, k: usize| ((x * 7 + y * k) % 13) as f64 / 13.0;
        let image = |k| (0..60).map(|i| value(i % 12, i / 12, k)).collect::<Vec<_>>();
        let transposed = |k| (0..60).map(|i| value(i / 5, i % 5, k)).collect::<Vec<_>>();
        let (across, down) = (ssim(&image(3), &image(5), 12), ssim(&transposed(3), &transposed(5), 5));
        assert!(across < 0.9, "{across}");
        approx::assert_relative_eq!(across, down, max_relative = 1e-12);
    }

    #[test]
    fn two_pixels_by_hand() {
        // Reflected, a row of two alternates; `e` is the share of the five even neighbours and the pixel itself.
        let g = |x: f64| (-0.5 * x * x / 2.25).exp();
        let even = 1.0 + 2.0 * (g(2.0) + g(4.0));
        let e = even / (even + 2.0 * (g(1.0) + g(3.0) + g(5.0)));
        // a = (1, 0), b = (0, 1): means are e and 1 - e, squares are the values themselves, and products vanish.
        let product = e * (1.0 - e);
        let expected = (2.0 * product + C1) * (C2 - 2.0 * product)
            / ((e * e + (1.0 - e) * (1.0 - e) + C1) * (2.0 * product + C2));
        approx::assert_relative_eq!(ssim(&[1.0, 0.0], &[0.0, 1.0], 2), expected, max_relative = 1e-12);
    }
}
