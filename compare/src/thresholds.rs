//! Thresholds on metrics, for scripts that check whether two images are similar enough.

use crate::metrics::Metrics;
use std::fmt;

/// Bounds on the metrics of two images; `None` means no bound.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Thresholds {
    /// Greatest root-mean-square error over all channels.
    pub max_rmse: Option<f64>,
    /// Greatest relative mean-square error over all channels.
    pub max_relmse: Option<f64>,
    /// Greatest relative mean-square error of the means over 8x8 blocks.
    pub max_block_relmse: Option<f64>,
    /// Greatest mean FLIP error.
    pub max_flip: Option<f64>,
    /// Greatest mean HDR-FLIP error. It holds if that is not computed.
    pub max_hdr_flip: Option<f64>,
    /// Greatest absolute difference of any channel of any pixel.
    pub max_abs: Option<f64>,
    /// Least mean SSIM index.
    pub min_ssim: Option<f64>,
    /// Least peak signal-to-noise ratio, in dB.
    pub min_psnr: Option<f64>,
}

/// A metric that is worse than its threshold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exceeded {
    /// The name of the metric.
    pub metric: &'static str,
    /// Its value.
    pub value: f64,
    /// The field of [`Thresholds`] that states the threshold.
    pub field: &'static str,
    /// The threshold.
    pub threshold: f64,
    /// True if the value lies above the threshold, false if below.
    pub is_above: bool,
}

impl fmt::Display for Exceeded {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { metric, value, field, threshold, is_above } = self;
        let side = if *is_above { "above" } else { "below" };
        write!(f, "{metric} is {value}, {side} {field} {threshold}")
    }
}

impl Thresholds {
    /// The metrics that are worse than their thresholds.
    pub fn exceeded(&self, m: &Metrics) -> Vec<Exceeded> {
        let greatest = [
            ("RMSE", m.rmse.all, "max_rmse", self.max_rmse),
            ("relative MSE", m.relative_mse.all, "max_relmse", self.max_relmse),
            ("8x8 relative MSE", m.block_relative_mse.all, "max_block_relmse", self.max_block_relmse),
            ("FLIP", m.flip, "max_flip", self.max_flip),
            ("HDR-FLIP", m.hdr_flip.unwrap_or(0.0), "max_hdr_flip", self.max_hdr_flip),
            ("the largest difference", m.largest_difference.value, "max_abs", self.max_abs),
        ];
        let least =
            [("SSIM", m.ssim.all, "min_ssim", self.min_ssim), ("PSNR", m.psnr, "min_psnr", self.min_psnr)];
        let above = greatest.into_iter().filter_map(|(metric, value, field, threshold)| {
            let threshold = threshold.filter(|&threshold| value > threshold)?;
            Some(Exceeded { metric, value, field, threshold, is_above: true })
        });
        let below = least.into_iter().filter_map(|(metric, value, field, threshold)| {
            let threshold = threshold.filter(|&threshold| value < threshold)?;
            Some(Exceeded { metric, value, field, threshold, is_above: false })
        });
        above.chain(below).collect()
    }
}
