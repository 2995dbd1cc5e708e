//! Computes the metrics that compare two images.

use crate::bits::differing_pixels;
use crate::error::{CompareError, check};
use crate::ssim::ssim;
use scene::film::RELATIVE_MSE_EPSILON;
use scene::{Film, Rgb, srgb};
use serde::Serialize;

/// Side of the blocks of [`Metrics::block_relative_mse`].
const BLOCK: usize = 8;

/// A figure for each channel and for all channels together.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Channels {
    /// The first channel.
    pub red: f64,
    /// The second channel.
    pub green: f64,
    /// The third channel.
    pub blue: f64,
    /// All three channels.
    pub all: f64,
}

/// The place and size of the largest difference of any channel in the image.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LargestDifference {
    /// The absolute difference.
    pub value: f64,
    /// `red`, `green` or `blue`.
    pub channel: &'static str,
    /// Column of the pixel, from the left, from 0.
    pub x: usize,
    /// Row of the pixel, from the top, from 0.
    pub y: usize,
}

/// The metrics of two images.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Metrics {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// True if every bit of every pixel is the same.
    pub identical: bool,
    /// The number of pixels that differ in any bit.
    pub differing_pixels: usize,
    /// The first of the largest differences.
    pub largest_difference: LargestDifference,
    /// Mean of image A.
    pub mean_a: Channels,
    /// Mean of image B, the reference.
    pub mean_b: Channels,
    /// Root of the mean of `(a - b)^2`.
    pub rmse: Channels,
    /// Mean of `(a - b)^2 / (b^2 + epsilon)`, see [`RELATIVE_MSE_EPSILON`].
    pub relative_mse: Channels,
    /// The relative MSE of means over blocks of 8x8 pixels. Blocks are weighted by their number of pixels, which may be
    /// smaller at the right and lower border. It shows noise that is correlated between neighbours, as that of photons
    /// is: such noise looks too small in the figure for single pixels.
    pub block_relative_mse: Channels,
    /// Peak signal-to-noise ratio of the sRGB images in dB: `-10 log10` of their mean-square error over all channels.
    /// Infinite if the sRGB images are equal; in JSON this is `null`.
    pub psnr: f64,
    /// Mean index of structural similarity of the sRGB images; 1 if they are equal.
    pub ssim: Channels,
    /// Mean error of LDR-FLIP (Andersson et al. 2020) of the sRGB images at 8 bits, as seen from 0.7 m on a screen
    /// of 3840 pixels over 0.7 m (67 pixels per degree); from 0 to 1.
    pub flip: f64,
}

impl Metrics {
    /// Compares `a` with the reference `b`.
    ///
    /// # Errors
    /// If the images differ in size, have no pixels, or have some that are not finite.
    pub fn of(a: &Film, b: &Film) -> Result<Self, CompareError> {
        check(a, b)?;
        let pairs = || a.pixels.iter().zip(&b.pixels);
        let differing_pixels = differing_pixels(a, b)?.len();
        let width = a.width as usize;
        let shown = |p: &Rgb, c: usize| srgb::encode(p[c].into());
        let row = |film: &Film, c, y| film.pixels[y * width..][..width].iter().map(|p| shown(p, c)).collect();
        Ok(Self {
            width: a.width,
            height: a.height,
            identical: differing_pixels == 0,
            differing_pixels,
            largest_difference: largest_difference(a, b),
            mean_a: Channels::new(|c| mean(a.pixels.iter().map(|p| p[c].into()))),
            mean_b: Channels::new(|c| mean(b.pixels.iter().map(|p| p[c].into()))),
            rmse: Channels::new(|c| mean(pairs().map(|(p, q)| square_error(p[c].into(), q[c].into()))))
                .map(f64::sqrt),
            relative_mse: Channels::new(|c| {
                mean(pairs().map(|(p, q)| relative_error(p[c].into(), q[c].into())))
            }),
            block_relative_mse: Channels::new(|c| block_relative_mse(a, b, c)),
            psnr: -10.0
                * Channels::new(|c| mean(pairs().map(|(p, q)| square_error(shown(p, c), shown(q, c)))))
                    .all
                    .log10(),
            ssim: Channels::new(|c| ssim(width, a.height as usize, |y| [row(a, c, y), row(b, c, y)])),
            flip: flip(a, b),
        })
    }
}

impl Channels {
    /// Builds the figures from one per channel; the figure for all is their mean.
    fn new(of: impl Fn(usize) -> f64) -> Self {
        let [red, green, blue] = [0, 1, 2].map(of);
        Self { red, green, blue, all: (red + green + blue) / 3.0 }
    }

    fn map(self, f: impl Fn(f64) -> f64) -> Self {
        Self { red: f(self.red), green: f(self.green), blue: f(self.blue), all: f(self.all) }
    }

    /// Red, green, blue, all.
    pub(crate) fn to_array(self) -> [f64; 4] {
        [self.red, self.green, self.blue, self.all]
    }
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len() as f64;
    values.sum::<f64>() / count
}

fn square_error(a: f64, b: f64) -> f64 {
    (a - b) * (a - b)
}

fn relative_error(a: f64, b: f64) -> f64 {
    square_error(a, b) / (b * b + RELATIVE_MSE_EPSILON)
}

fn largest_difference(a: &Film, b: &Film) -> LargestDifference {
    let mut largest = LargestDifference { value: 0.0, channel: "red", x: 0, y: 0 };
    for (i, (p, q)) in a.pixels.iter().zip(&b.pixels).enumerate() {
        for (c, channel) in ["red", "green", "blue"].into_iter().enumerate() {
            let value = (f64::from(p[c]) - f64::from(q[c])).abs();
            if value > largest.value {
                let width = a.width as usize;
                largest = LargestDifference { value, channel, x: i % width, y: i / width };
            }
        }
    }
    largest
}

fn block_relative_mse(a: &Film, b: &Film, channel: usize) -> f64 {
    let (width, height) = (a.width as usize, a.height as usize);
    let mut sum = 0.0;
    for y in (0..height).step_by(BLOCK) {
        for x in (0..width).step_by(BLOCK) {
            let columns = BLOCK.min(width - x);
            let pixels = columns * BLOCK.min(height - y);
            let block_mean = |film: &Film| {
                let rows = film.pixels[y * width..].chunks(width).take(BLOCK);
                let values = rows.flat_map(|row| &row[x..x + columns]).map(|p| f64::from(p[channel]));
                values.sum::<f64>() / pixels as f64
            };
            sum += pixels as f64 * relative_error(block_mean(a), block_mean(b));
        }
    }
    sum / (width * height) as f64
}

fn flip(a: &Film, b: &Film) -> f64 {
    let bytes = |p: &Rgb| p.to_array().map(|v| srgb::encode_byte(v.into()));
    let image = |film: &Film| {
        let bytes: Vec<u8> = film.pixels.iter().flat_map(bytes).collect();
        nv_flip::FlipImageRgb8::with_data(film.width, film.height, &bytes)
    };
    let map = nv_flip::flip(image(b), image(a), nv_flip::DEFAULT_PIXELS_PER_DEGREE);
    mean(map.to_vec().into_iter().map(f64::from))
}
