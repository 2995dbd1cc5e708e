//! Compares values by their bits: 0 differs from -0, and a NaN equals itself.

use crate::error::{CompareError, check_size};
use scene::{Film, Rgb};

/// The indices of the pixels that differ in any bit, in the order of rows.
///
/// # Errors
/// If the images differ in size.
pub fn differing_pixels(a: &Film, b: &Film) -> Result<Vec<usize>, CompareError> {
    check_size(a, b)?;
    let pairs = a.pixels.iter().zip(&b.pixels).enumerate();
    Ok(pairs.filter(|(_, (p, q))| differ(p, q)).map(|(index, _)| index).collect())
}

/// Whether two pixels differ in any bit.
pub(crate) fn differ(p: &Rgb, q: &Rgb) -> bool {
    let bits = |pixel: &Rgb| pixel.to_array().map(f32::to_bits);
    bits(p) != bits(q)
}

/// The indices of the values that differ in any bit.
pub(crate) fn differing_values<'a>(a: &'a [f32], b: &'a [f32]) -> impl Iterator<Item = usize> + 'a {
    let pairs = a.iter().zip(b).enumerate();
    pairs.filter(|(_, (a, b))| a.to_bits() != b.to_bits()).map(|(index, _)| index)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(values: &[f32]) -> Film {
        let pixels = values.iter().map(|&value| Rgb::new(0.0, 0.0, value)).collect();
        Film { width: values.len() as u32, height: 1, pixels }
    }

    #[test]
    fn bits_are_compared_and_not_values() {
        let expected = row(&[0.0, f32::NAN, 1.0]);
        assert_eq!(differing_pixels(&expected, &row(&[-0.0, f32::NAN, 1.000_000_1])), Ok(vec![0, 2]));
        assert!(differing_pixels(&expected, &row(&[0.0])).is_err());
    }
}
