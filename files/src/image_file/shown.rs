//! What PNG and JPEG show of an image: 8 bits of sRGB, clamped to [0, 1] after the exposure.

use super::rows::Rows;
use scene::{Picture, Rgb, srgb};

/// The colour of a pixel with a NaN: magenta, because it is easily noticed.
const NOT_A_NUMBER: [u8; 3] = [255, 0, 255];

/// The codes of a pixel at `exposure`, in stops.
pub(super) fn code(exposure: f32) -> impl Fn(Rgb) -> [u8; 3] + Copy + Sync {
    let gain = f64::from(exposure).exp2();
    move |pixel: Rgb| {
        if pixel.is_nan() {
            return NOT_A_NUMBER;
        }
        pixel.to_array().map(|v| srgb::encode_byte(f64::from(v) * gain))
    }
}

/// The greatest finite value, which is shown as white; 1 if none is positive.
pub(super) fn greatest(values: &Picture<f32>) -> f32 {
    let all = (0..values.height).flat_map(|y| Rows(values).row(y));
    let greatest = all.filter(|v| v.is_finite()).fold(0.0, f32::max);
    if greatest > 0.0 { greatest } else { 1.0 }
}
