//! Formats metrics as a table of text.

use crate::metrics::{LargestDifference, Metrics};
use std::fmt;

impl Metrics {
    /// The metrics as text, one per line.
    pub fn table(&self) -> String {
        self.to_string()
    }

    fn write_pixels(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} x {} pixels, ", self.width, self.height)?;
        if self.identical {
            return writeln!(f, "identical to the last bit");
        }
        let share = self.differing_pixels as f64 / (f64::from(self.width) * f64::from(self.height));
        writeln!(f, "of which {} differ ({:.2} %)", self.differing_pixels, 100.0 * share)
    }
}

impl fmt::Display for Metrics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.write_pixels(f)?;
        writeln!(f, "{:<18}{:>14}{:>14}{:>14}{:>14}", "", "red", "green", "blue", "all")?;
        for (name, figures) in [
            ("mean of A", self.mean_a),
            ("mean of B", self.mean_b),
            ("RMSE", self.rmse),
            ("relative MSE", self.relative_mse),
            ("8x8 relative MSE", self.block_relative_mse),
            ("SSIM", self.ssim),
        ] {
            let [red, green, blue, all] = figures.to_array().map(figure);
            writeln!(f, "{name:<18}{red:>14}{green:>14}{blue:>14}{all:>14}")?;
        }
        writeln!(f, "{:<60}{:>14}", "PSNR in dB", figure(self.psnr))?;
        writeln!(f, "{:<60}{:>14}", "FLIP", figure(self.flip))?;
        if let Some(hdr_flip) = self.hdr_flip {
            writeln!(f, "{:<60}{:>14}", "HDR-FLIP", figure(hdr_flip))?;
        }
        let LargestDifference { value, channel, x, y } = self.largest_difference;
        if value > 0.0 {
            writeln!(f, "largest difference {} in {channel} at ({x}, {y})", figure(value))?;
        }
        Ok(())
    }
}

/// Formats a number with six digits, with an exponent if it is very small or large.
fn figure(v: f64) -> String {
    let plain = v == 0.0 || !v.is_finite() || (1e-3..1e5).contains(&v.abs());
    if plain { format!("{v:.6}") } else { format!("{v:.5e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_an_exponent_only_if_they_are_very_small_or_large() {
        for (number, text) in [
            (0.0, "0.000000"),
            (0.001, "0.001000"),
            (-12.5, "-12.500000"),
            (99_999.5, "99999.500000"),
            (0.000_999, "9.99000e-4"),
            (-0.000_001_25, "-1.25000e-6"),
            (100_000.0, "1.00000e5"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(figure(number), text);
        }
    }
}
