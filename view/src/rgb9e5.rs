//! RGB9E5: linear light in 4 bytes a pixel, three mantissas of 9 bits over one exponent (OpenGL 4.6, section 8.5.2).
//!
//! The greatest error of a channel is 2^-10 of the brightest channel. There are no negative values; they become 0, and so
//! does NaN.

/// The greatest value.
pub const MOST: f32 = 65408.0;
/// The least exponent, that of mantissas which are whole numbers.
const BIAS: i32 = 24;

/// The word of a pixel: red in the lowest 9 bits, then green, then blue, then the exponent in 5 bits.
pub fn encode(rgb: [f32; 3]) -> u32 {
    let rgb = rgb.map(|v| if v > 0.0 { v.min(MOST) } else { 0.0 });
    let most = rgb[0].max(rgb[1]).max(rgb[2]);
    let logarithm = (most.to_bits() >> 23) as i32 - 127;
    let mut exponent = logarithm.max(-16) + 16;
    // What rounds up to 2^9 needs the next exponent.
    if most * power(BIAS - exponent) >= 511.5 {
        exponent += 1;
    }
    let scale = power(BIAS - exponent);
    let [red, green, blue] = rgb.map(|v| (v * scale + 0.5) as u32);
    red | green << 9 | blue << 18 | (exponent as u32) << 27
}

/// The inverse of [`encode`].
pub fn decode(word: u32) -> [f32; 3] {
    let scale = power((word >> 27) as i32 - BIAS);
    [word, word >> 9, word >> 18].map(|mantissa| (mantissa & 511) as f32 * scale)
}

/// 2 to the power `n`, which is exact.
pub(crate) fn power(n: i32) -> f32 {
    f32::from_bits(((n.clamp(-126, 127) + 127) as u32) << 23)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn what_has_no_code_becomes_the_nearest_that_has() {
        assert_eq!(encode([0.0, -1.0, f32::NAN]), 0);
        assert_eq!(decode(encode([f32::INFINITY, 1e9, 0.0])), [MOST, MOST, 0.0]);
        assert_eq!(decode(encode([1.0, 0.5, 0.25])), [1.0, 0.5, 0.25]);
        assert_eq!(decode(encode([0.999_99, 0.0, 0.0])), [1.0, 0.0, 0.0]);
        assert_eq!(decode(encode([1e-9; 3])), [0.0; 3]);
    }

    proptest! {
        #[test]
        fn channels_are_as_exact_as_the_brightest_allows(rgb in [0.0..65408_f32, 0.0..300_f32, 0.0..1_f32]) {
            let most = rgb.into_iter().fold(0.0, f32::max);
            for (given, read) in rgb.into_iter().zip(decode(encode(rgb))) {
                // Half a step of the mantissa, of which the brightest channel has at least 256.
                prop_assert!((given - read).abs() <= most / 512.0 + 1e-7, "{given} {read}");
            }
        }
    }
}
