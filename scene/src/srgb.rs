//! The transfer function of sRGB (IEC 61966-2-1), piecewise as in the standard.

use std::sync::LazyLock;

/// The code value in [0, 1] of linear `v`, which is clamped to [0, 1]; NaN stays NaN.
pub fn encode(v: f64) -> f64 {
    let v = v.clamp(0.0, 1.0);
    if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 }
}

/// The linear value of code value `c`.
pub fn decode(c: f64) -> f64 {
    decode_with(c, f64::powf)
}

/// As [`decode`], with a power function of the caller's, such as one that is the same on every machine.
pub fn decode_with(c: f64, power: impl Fn(f64, f64) -> f64) -> f64 {
    if c <= 0.040_45 { c / 12.92 } else { power((c + 0.055) / 1.055, 2.4) }
}

/// The linear values at which the code rounds to the next byte.
static THRESHOLDS: LazyLock<[f64; 255]> =
    LazyLock::new(|| std::array::from_fn(|i| decode((i as f64 + 0.5) / 255.0)));

/// The number of equal steps of linear value in [`FIRST_CODES`].
const STEPS: usize = 4096;

/// The code of the least value of each step, where the search for a code begins. At most two thresholds lie within a
/// step.
static FIRST_CODES: LazyLock<[u8; STEPS + 1]> = LazyLock::new(|| {
    std::array::from_fn(|step| THRESHOLDS.partition_point(|&t| t <= step as f64 / STEPS as f64) as u8)
});

/// The nearest of 256 codes for linear `v`; 0 for NaN.
///
/// Uses tables, for speed and for exactness: the C library's power function may differ between machines, but here only
/// the 255 thresholds depend on it.
pub fn encode_byte(v: f64) -> u8 {
    let step = (v.clamp(0.0, 1.0) * STEPS as f64) as usize; // 0 for NaN
    let mut code = FIRST_CODES[step];
    while code < 255 && THRESHOLDS[usize::from(code)] <= v {
        code += 1;
    }
    code
}

/// The linear value of code `c` out of `0..=largest`.
pub fn decode_code(c: u16, largest: u16) -> f32 {
    decode(f64::from(c) / f64::from(largest)) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_values() {
        // From the standard's formulas, to six digits or more.
        for (code, linear) in [
            (0, 0.0),
            (1, 3.035_27e-4),
            (10, 3.035_27e-3),
            (11, 3.346_536e-3),
            (128, 0.215_860_5),
            (255, 1.0),
        ] {
            approx::assert_relative_eq!(decode_code(code, 255), linear, max_relative = 2e-7);
        }
        assert_eq!(encode_byte(0.18), 118); // middle grey
        assert_eq!(encode_byte(0.5), 188);
        approx::assert_relative_eq!(encode(0.5), 0.735_356_983, max_relative = 1e-9);
    }

    #[test]
    fn bytes_are_those_of_the_thresholds() {
        for i in -10..200_000 {
            let v = f64::from(i) / 190_000.0;
            assert_eq!(usize::from(encode_byte(v)), THRESHOLDS.partition_point(|&t| t <= v), "{v}");
        }
        assert_eq!(
            [encode_byte(f64::NAN), encode_byte(f64::INFINITY), encode_byte(f64::NEG_INFINITY)],
            [0, 255, 0]
        );
    }

    #[test]
    fn every_code_survives_a_round_trip() {
        for c in 0..=255 {
            assert_eq!(u16::from(encode_byte(f64::from(decode_code(c, 255)))), c);
        }
    }

    #[test]
    fn bytes_are_the_rounded_function() {
        for i in 0..=100_000 {
            let v = f64::from(i) / 100_000.0;
            assert_eq!(f64::from(encode_byte(v)), (255.0 * encode(v)).round(), "{v}");
        }
    }

    #[test]
    fn what_is_out_of_range_is_clamped() {
        assert_eq!([-1.0, f64::NEG_INFINITY, f64::NAN, -0.0].map(encode_byte), [0; 4]);
        assert_eq!([1.0, 1e30, f64::INFINITY].map(encode_byte), [255; 3]);
    }

    #[test]
    fn no_decoded_value_is_near_enough_to_a_rounding_boundary_for_c_libraries_to_disagree() {
        for c in 0..=u16::MAX {
            let v = decode(f64::from(c) / 65535.0);
            let few_ulps = 4.0 * f64::EPSILON;
            assert_eq!((v * (1.0 - few_ulps)) as f32, (v * (1.0 + few_ulps)) as f32, "{c}");
        }
    }
}
