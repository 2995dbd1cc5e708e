//! Measures how similar two images are, and finds where two engines first differ.
//!
//! | Question | Answer |
//! | --- | --- |
//! | How similar are two images? | [`Metrics::of`]: RMSE, relative MSE, PSNR, SSIM, FLIP |
//! | ... if they are too large for memory, or of high dynamic range? | [`Metrics::of_rows`], with HDR-FLIP |
//! | Are they similar enough? | [`Thresholds::exceeded`] |
//! | Where do they differ? | [`difference_image`] and [`DifferenceMap`]: a picture in false colours |
//! | Which pixels differ in any bit? | [`differing_pixels`] |
//! | Which value of two engines differs first? | [`planes`] of each, then [`first_difference`] |
//!
//! RMSE, relative MSE and means are computed from linear radiance. PSNR, SSIM and FLIP judge what a viewer sees, so
//! they are computed from the sRGB images, clamped to [0, 1] at exposure 0. Image A is judged against image B, the
//! reference.
//!
//! ```
//! use compare::{Metrics, Thresholds};
//! use scene::{Film, Rgb};
//!
//! let black = Film::new(16, 12);
//! let mut grey = black.clone();
//! grey.pixels.fill(Rgb::splat(0.25));
//! let metrics = Metrics::of(&grey, &black)?;
//! assert_eq!(metrics.rmse.all, 0.25);
//! let thresholds = Thresholds { max_rmse: Some(0.1), ..Thresholds::default() };
//! assert_eq!(thresholds.exceeded(&metrics)[0].to_string(), "RMSE is 0.25, above max_rmse 0.1");
//! # Ok::<(), compare::CompareError>(())
//! ```

#![forbid(unsafe_code)]

mod bits;
mod difference_image;
mod error;
mod finite;
mod flip;
mod metrics;
mod planes;
mod rank;
mod ssim;
#[cfg(test)]
mod strip_tests;
mod strips;
mod table;
#[cfg(test)]
mod tests;
mod thresholds;
mod window;

pub use bits::differing_pixels;
pub use difference_image::{DifferenceImage, DifferenceMap, difference_image};
pub use error::CompareError;
pub use metrics::{Channels, LargestDifference, Metrics, Progress};
pub use planes::{EnginePlane, PlaneDifference, PlaneKind, first_difference, planes};
pub use thresholds::{Exceeded, Thresholds};
