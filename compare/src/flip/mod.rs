//! FLIP, the difference that someone sees who flips between two images.
//!
//! LDR-FLIP is as in Andersson et al., "FLIP: A Difference Evaluator for Alternating Images" (2020), and HDR-FLIP as in
//! Andersson et al., "Visualizing Errors in Rendered High Dynamic Range Images" (2021), with the separable filters of
//! their program. Images are seen from 0.7 m on a screen of 3840 pixels over 0.7 m: 67 pixels per degree.
//!
//! It is implemented here because the crate `nv-flip` compares whole images of 8 bits only: that takes 100 bytes per
//! pixel, one thread, and no HDR-FLIP. The tests compare with that crate.

mod color;
mod exposures;
mod filters;

use crate::strips::Strip;
use crate::window::{along, padded, weighted};
use color::{Opponent, difference};
pub(crate) use color::{from_codes, tone_mapped};
pub(crate) use exposures::{Exposures, luminance};
use filters::{Filters, REACH};
use rayon::prelude::*;
use scene::Rgb;
use std::array;

const _: () = assert!(REACH <= crate::strips::HALO);

/// The error of each pixel of the rows of a strip, in [0, 1]. `opponent` gives the colour of a pixel of either image.
pub(crate) fn errors(strip: &Strip, opponent: impl Fn(Rgb) -> Opponent + Sync) -> Vec<Vec<f32>> {
    let filters = Filters::new();
    let rows: Vec<[Filtered; 2]> = strip
        .held()
        .into_par_iter()
        .map(|y| strip.row(y).map(|row| Filtered::along(row, &opponent, &filters)))
        .collect();
    let top = strip.held().start;
    strip.map_rows(|y| {
        let around = |k: usize| (y + k).saturating_sub(REACH).min(strip.height - 1) - top;
        let [a, b] = [0, 1].map(|image| Seen::over(|k| &rows[around(k)][image], &filters));
        (0..strip.width).map(|x| error(&a, &b, x)).collect()
    })
}

/// A row filtered along itself.
struct Filtered {
    /// Luminance, red-green, and blue-yellow twice.
    spatial: [Vec<f32>; 4],
    /// Luminance by the first derivative, the second derivative, and the Gaussian.
    features: [Vec<f32>; 3],
}

impl Filtered {
    fn along(row: &[Rgb], opponent: &impl Fn(Rgb) -> Opponent, filters: &Filters) -> Self {
        let colors: Vec<Opponent> = row.iter().map(|&pixel| opponent(pixel)).collect();
        let plane = |c: usize| padded(&colors.iter().map(|color| color[c]).collect::<Vec<f32>>(), REACH);
        let [luminance, red_green, blue_yellow] = array::from_fn(plane);
        let [y, x, z1, z2] = &filters.spatial;
        let grey: Vec<f32> = luminance.iter().map(|y| y * (1.0 / 116.0) + 16.0 / 116.0).collect();
        Self {
            spatial: [
                along(&luminance, y),
                along(&red_green, x),
                along(&blue_yellow, z1),
                along(&blue_yellow, z2),
            ],
            features: [&filters.first, &filters.second, &filters.gaussian]
                .map(|weights| along(&grey, weights)),
        }
    }
}

/// What is seen of a row: its filtered colours, and how much edge and point is at each pixel.
struct Seen {
    spatial: [Vec<f32>; 4],
    edges: Vec<f32>,
    points: Vec<f32>,
}

impl Seen {
    /// Filters over rows; `row(k)` is the row with the weight number `k`.
    fn over<'a>(row: impl Fn(usize) -> &'a Filtered, filters: &Filters) -> Self {
        let width = row(0).spatial[0].len();
        let spatial = |p: usize| weighted(width, &filters.spatial[p], |k| row(k).spatial[p].as_slice());
        let feature = |p: usize, weights| weighted(width, weights, |k| row(k).features[p].as_slice());
        let [across, curved] = [0, 1].map(|p| feature(p, &filters.gaussian));
        let [down, curved_down] = [&filters.first, &filters.second].map(|weights| feature(2, weights));
        let lengths = |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(a, b)| (a * a + b * b).sqrt()).collect();
        Self {
            spatial: array::from_fn(spatial),
            edges: lengths(&across, &down),
            points: lengths(&curved, &curved_down),
        }
    }

    fn color(&self, x: usize) -> Opponent {
        let [y, red_green, z1, z2] = &self.spatial;
        [y[x], red_green[x], z1[x] + z2[x]]
    }
}

/// The error of the pixel in column `x`: the difference of its colours, greater where edges or points differ.
fn error(a: &Seen, b: &Seen, x: usize) -> f32 {
    let feature = (a.edges[x] - b.edges[x]).abs().max((a.points[x] - b.points[x]).abs());
    let feature = (std::f32::consts::FRAC_1_SQRT_2 * feature).sqrt();
    difference(a.color(x), b.color(x)).powf(1.0 - feature)
}
