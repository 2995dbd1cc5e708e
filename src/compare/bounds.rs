//! Bounds on metrics, for scripts that ask whether two images are near enough.

use super::Metrics;

/// What is asked of two images; `None` asks nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bounds {
    /// Greatest root-mean-square error over all channels.
    pub max_rmse: Option<f64>,
    /// Greatest relative mean-square error over all channels.
    pub max_relmse: Option<f64>,
    /// Greatest relative mean-square error of the means over 8x8 blocks.
    pub max_block_relmse: Option<f64>,
    /// Greatest mean FLIP error.
    pub max_flip: Option<f64>,
    /// Greatest absolute difference of any channel of any pixel.
    pub max_abs: Option<f64>,
    /// Least mean SSIM index.
    pub min_ssim: Option<f64>,
    /// Least peak signal-to-noise ratio, in dB.
    pub min_psnr: Option<f64>,
}

impl Bounds {
    /// One sentence for each bound that does not hold, with the option that states it.
    pub fn broken(&self, m: &Metrics) -> Vec<String> {
        let most = [
            ("RMSE", m.rmse.all, "--max-rmse", self.max_rmse),
            ("relative MSE", m.relative_mse.all, "--max-relmse", self.max_relmse),
            ("8x8 relative MSE", m.block_relative_mse.all, "--max-block-relmse", self.max_block_relmse),
            ("FLIP", m.flip, "--max-flip", self.max_flip),
            ("the largest difference", m.largest_difference.value, "--max-abs", self.max_abs),
        ];
        let least = [
            ("SSIM", m.ssim.all, "--min-ssim", self.min_ssim),
            ("PSNR", m.psnr, "--min-psnr", self.min_psnr),
        ];
        let above = most.into_iter().filter_map(|(name, value, option, bound)| {
            let bound = bound.filter(|&b| value > b)?;
            Some(format!("{name} is {value}, above {option} {bound}"))
        });
        let below = least.into_iter().filter_map(|(name, value, option, bound)| {
            let bound = bound.filter(|&b| value < b)?;
            Some(format!("{name} is {value}, below {option} {bound}"))
        });
        above.chain(below).collect()
    }
}
