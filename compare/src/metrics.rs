//! Computes the metrics that compare two images, strip by strip.
//!
//! Sums are over each row from the left, and then over the rows from the top. So they do not depend on the strips or on
//! the number of threads.

use crate::bits::differ;
use crate::error::CompareError;
use crate::finite::Finite;
use crate::flip::{self, Exposures, luminance};
use crate::rank::Coarse;
use crate::ssim;
use crate::strips::{HALO, Pair, Strip, rows_at_once};
use rayon::prelude::*;
use scene::film::RELATIVE_MSE_EPSILON;
use scene::{Film, FilmRows, RowReader, srgb};
use serde::Serialize;
use std::ops::{Add, AddAssign};

/// Side of the blocks of [`Metrics::block_relative_mse`].
pub(crate) const BLOCK: usize = 8;

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
    /// Mean error of HDR-FLIP (Andersson et al. 2021) of the radiance, seen alike: the greatest LDR-FLIP error of each
    /// pixel over exposures from the reference's brightest pixel to its median, tone-mapped by ACES. `None` unless it is
    /// asked for, and if the reference is black.
    pub hdr_flip: Option<f64>,
}

/// Progress: called with the rows that are done, and the rows of all passes together.
pub type Progress<'a> = &'a mut dyn FnMut(u64, u64);

impl Metrics {
    /// Compares `a` with the reference `b`, except for HDR-FLIP.
    ///
    /// # Errors
    /// If the images differ in size, have no pixels, or have some that are not finite.
    pub fn of(a: &Film, b: &Film) -> Result<Self, CompareError> {
        Self::of_rows(&mut FilmRows::new(a), &mut FilmRows::new(b), false, &mut |_, _| {})
    }

    /// Like [`Self::of`], for images of which only some rows are held in memory: about 250 bytes for each of 10^6 pixels.
    /// With `hdr_flip`, computes that too, for which the reference is read three times.
    ///
    /// # Errors
    /// Like [`Self::of`], and if an image cannot be read.
    pub fn of_rows(
        a: &mut dyn RowReader,
        b: &mut dyn RowReader,
        hdr_flip: bool,
        progress: Progress,
    ) -> Result<Self, CompareError> {
        let width = a.size()[0] as usize;
        measure(&mut Pair { a, b }, hdr_flip, rows_at_once(width), progress)
    }
}

/// The metrics, computed over strips of `rows_at_once` rows, a multiple of [`BLOCK`].
pub(crate) fn measure(
    pair: &mut Pair,
    hdr_flip: bool,
    rows_at_once: usize,
    progress: Progress,
) -> Result<Metrics, CompareError> {
    let [width, height] = pair.size()?;
    let passes = if hdr_flip { 3 } else { 1 };
    let mut tell =
        |pass: u64, rows: usize| progress(pass * height as u64 + rows as u64, passes * height as u64);
    let exposures = if hdr_flip { exposures(pair, rows_at_once, &mut tell)? } else { None };
    let mut sums = Sums { hdr_flip: exposures.map(|_| 0.0), ..Sums::default() };
    pair.for_each_strip(rows_at_once, HALO, |strip| {
        sums.finite.add(strip);
        if sums.finite.check().is_ok() {
            sums.add(strip, exposures);
        }
        tell(passes - 1, strip.rows.end);
        Ok(())
    })?;
    sums.metrics(width, height)
}

/// The exposures for HDR-FLIP; `None` if the reference is black.
fn exposures(
    pair: &mut Pair,
    rows_at_once: usize,
    tell: &mut dyn FnMut(u64, usize),
) -> Result<Option<Exposures>, CompareError> {
    let mut coarse = Coarse::new();
    let mut pass = |number: u64, see: &mut dyn FnMut(f32)| {
        pair.for_each_strip_of_b(rows_at_once, |pixels, bottom| {
            pixels.iter().map(|&pixel| luminance(pixel)).for_each(&mut *see);
            tell(number, bottom);
        })
    };
    pass(0, &mut |v| coarse.add(v))?;
    let Some(ranks) = Exposures::ranks(&coarse) else { return Ok(None) };
    let mut fine = coarse.refine(ranks);
    pass(1, &mut |v| fine.add(v))?;
    Ok(Some(Exposures::new(&coarse, &fine)))
}

/// Sums over all rows so far.
#[derive(Default)]
struct Sums {
    finite: Finite,
    differing_pixels: usize,
    largest: Option<LargestDifference>,
    mean_a: PerChannel,
    mean_b: PerChannel,
    square: PerChannel,
    relative: PerChannel,
    blocks: PerChannel,
    shown: PerChannel,
    ssim: PerChannel,
    flip: f64,
    hdr_flip: Option<f64>,
}

/// A sum for each channel.
#[derive(Clone, Copy, Default)]
struct PerChannel([f64; 3]);

impl AddAssign<[f64; 3]> for PerChannel {
    fn add_assign(&mut self, sums: [f64; 3]) {
        for (all, sum) in self.0.iter_mut().zip(sums) {
            *all += sum;
        }
    }
}

impl PerChannel {
    fn mean(self, count: f64) -> Channels {
        Channels::new(|c| self.0[c] / count)
    }
}

/// Sums over one row.
struct RowSums {
    differing_pixels: usize,
    largest: Option<LargestDifference>,
    mean_a: [f64; 3],
    mean_b: [f64; 3],
    square: [f64; 3],
    relative: [f64; 3],
}

impl Sums {
    fn add(&mut self, strip: &Strip, exposures: Option<Exposures>) {
        for row in strip.map_rows(|y| RowSums::of(strip, y)) {
            self.differing_pixels += row.differing_pixels;
            let is_larger = |new: &LargestDifference| self.largest.is_none_or(|old| new.value > old.value);
            self.largest = row.largest.filter(is_larger).or(self.largest);
            self.mean_a += row.mean_a;
            self.mean_b += row.mean_b;
            self.square += row.square;
            self.relative += row.relative;
        }
        for channel in 0..3 {
            self.blocks.0[channel] =
                block_sums(strip, channel).into_iter().fold(self.blocks.0[channel], f64::add);
            self.add_shown(strip, channel);
        }
        let flip = flip::errors(strip, flip::from_codes);
        self.flip = row_sums(&flip).fold(self.flip, |all, row| all + row);
        if let (Some(sum), Some(exposures)) = (&mut self.hdr_flip, exposures) {
            *sum = row_sums(&worst(strip, exposures)).fold(*sum, |all, row| all + row);
        }
    }

    /// Adds the metrics of one channel of the sRGB images.
    fn add_shown(&mut self, strip: &Strip, channel: usize) {
        let top = strip.held().start;
        let codes: Vec<[Vec<f64>; 2]> = strip.map_held(|y| {
            strip.row(y).map(|row| row.iter().map(|pixel| srgb::encode(pixel[channel].into())).collect())
        });
        let row = |y: usize| codes[y - top].each_ref().map(Vec::as_slice);
        let errors = strip.map_rows(|y| {
            let [a, b] = row(y);
            a.iter().zip(b).map(|(&a, &b)| square_error(a, b)).sum::<f64>()
        });
        let indices = ssim::row_sums(strip.rows.clone(), strip.height, row);
        for (error, index) in errors.into_iter().zip(indices) {
            self.shown.0[channel] += error;
            self.ssim.0[channel] += index;
        }
    }

    fn metrics(self, width: usize, height: usize) -> Result<Metrics, CompareError> {
        self.finite.check()?;
        let count = width as f64 * height as f64;
        let none = LargestDifference { value: 0.0, channel: "red", x: 0, y: 0 };
        Ok(Metrics {
            width: width as u32,
            height: height as u32,
            identical: self.differing_pixels == 0,
            differing_pixels: self.differing_pixels,
            largest_difference: self.largest.unwrap_or(none),
            mean_a: self.mean_a.mean(count),
            mean_b: self.mean_b.mean(count),
            rmse: self.square.mean(count).map(f64::sqrt),
            relative_mse: self.relative.mean(count),
            block_relative_mse: self.blocks.mean(count),
            psnr: -10.0 * self.shown.mean(count).all.log10(),
            ssim: self.ssim.mean(count),
            flip: self.flip / count,
            hdr_flip: self.hdr_flip.map(|sum| sum / count),
        })
    }
}

impl RowSums {
    fn of(strip: &Strip, y: usize) -> Self {
        let sum = |of: fn(f64, f64) -> f64| {
            [0, 1, 2].map(|c| strip.pairs(y).map(|(p, q)| of(p[c].into(), q[c].into())).sum::<f64>())
        };
        Self {
            differing_pixels: strip.pairs(y).filter(|(p, q)| differ(p, q)).count(),
            largest: largest_difference(strip, y),
            mean_a: sum(|a, _| a),
            mean_b: sum(|_, b| b),
            square: sum(square_error),
            relative: sum(relative_error),
        }
    }
}

/// The sum of each row.
fn row_sums(rows: &[Vec<f32>]) -> impl Iterator<Item = f64> {
    rows.iter().map(|row| row.iter().map(|&v| f64::from(v)).sum())
}

/// The greatest LDR-FLIP error of each pixel at any of the exposures.
fn worst(strip: &Strip, exposures: Exposures) -> Vec<Vec<f32>> {
    let mut worst = vec![vec![0.0_f32; strip.width]; strip.rows.len()];
    for exposure in exposures.iter() {
        for (worst, errors) in worst.iter_mut().zip(flip::errors(strip, flip::tone_mapped(exposure))) {
            for (worst, error) in worst.iter_mut().zip(errors) {
                *worst = worst.max(error);
            }
        }
    }
    worst
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

fn square_error(a: f64, b: f64) -> f64 {
    (a - b) * (a - b)
}

fn relative_error(a: f64, b: f64) -> f64 {
    square_error(a, b) / (b * b + RELATIVE_MSE_EPSILON)
}

/// The first of the largest differences in a row; `None` if there is none.
fn largest_difference(strip: &Strip, y: usize) -> Option<LargestDifference> {
    let mut largest: Option<LargestDifference> = None;
    for (x, (p, q)) in strip.pairs(y).enumerate() {
        for (c, channel) in ["red", "green", "blue"].into_iter().enumerate() {
            let value = (f64::from(p[c]) - f64::from(q[c])).abs();
            if value > largest.map_or(0.0, |largest| largest.value) {
                largest = Some(LargestDifference { value, channel, x, y });
            }
        }
    }
    largest
}

/// The weighted relative errors of the means over the blocks of a strip.
fn block_sums(strip: &Strip, channel: usize) -> Vec<f64> {
    let tops: Vec<usize> = strip.rows.clone().step_by(BLOCK).collect();
    tops.into_par_iter().map(|top| block_row(strip, top, channel)).collect()
}

/// The same for the blocks whose first row is `top`.
fn block_row(strip: &Strip, top: usize, channel: usize) -> f64 {
    let bottom = strip.rows.end.min(top + BLOCK);
    let lefts = (0..strip.width).step_by(BLOCK);
    let error = |left: usize| {
        let right = strip.width.min(left + BLOCK);
        let pixels = ((right - left) * (bottom - top)) as f64;
        let mean = |image: usize| {
            let values = (top..bottom).flat_map(|y| &strip.row(y)[image][left..right]);
            values.map(|pixel| f64::from(pixel[channel])).sum::<f64>() / pixels
        };
        pixels * relative_error(mean(0), mean(1))
    };
    lefts.map(error).sum()
}
