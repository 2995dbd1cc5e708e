//! Radiance HDR, written row by row: 8 bits per channel with a common exponent (Ward, "Real Pixels", Graphics Gems II).
//!
//! The brightest channel of a pixel is off by at most 2^-8 of itself, and the others by as much in absolute terms.
//! Negative values and NaN become 0. The greatest value is about 1.7e38.

use super::rows::{First, Rows};
use scene::{Picture, Rgb};
use std::io::{self, Write};

/// Widths for which the format defines run-length coding.
const CODED_WIDTHS: std::ops::Range<usize> = 8..0x8000;
/// The longest run, and the longest sequence without one.
const LONGEST_RUN: usize = 127;
const LONGEST_PLAIN: usize = 128;
/// A shorter run costs as much as it saves.
const SHORTEST_RUN: usize = 3;
/// The exponent of the byte 0, for mantissas of 8 bits.
const BIAS: i32 = 136;

pub(super) fn write(out: &mut impl Write, picture: &Picture<Rgb>) -> io::Result<()> {
    write_pixels(out, picture, encode)
}

/// Writes the values as grey pixels.
pub(super) fn write_values(out: &mut impl Write, values: &Picture<f32>) -> io::Result<()> {
    write_pixels(out, values, |value| encode(Rgb::splat(value)))
}

fn write_pixels<T>(
    out: &mut impl Write,
    picture: &Picture<T>,
    encode: impl Fn(T) -> [u8; 4] + Sync,
) -> io::Result<()> {
    let width = picture.width as usize;
    write!(out, "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {} +X {width}\n", picture.height)?;
    let mut packed = Vec::new();
    Rows(picture).write(First::Top, encode, |rows| {
        if !CODED_WIDTHS.contains(&width) {
            return out.write_all(rows);
        }
        for row in rows.chunks_exact(4 * width) {
            packed.clear();
            packed.extend([2, 2, (width >> 8) as u8, width as u8]);
            for channel in 0..4 {
                let bytes: Vec<u8> = row.iter().skip(channel).step_by(4).copied().collect();
                pack(&bytes, &mut packed);
            }
            out.write_all(&packed)?;
        }
        Ok(())
    })
}

/// The mantissas and the exponent of a pixel.
fn encode(pixel: Rgb) -> [u8; 4] {
    let values = pixel.to_array().map(|v| if v > 0.0 { f64::from(v) } else { 0.0 });
    let greatest = values.into_iter().fold(0.0, f64::max);
    if greatest == 0.0 {
        return [0; 4];
    }
    // The exponent for which the greatest mantissa is in [128, 256); one more where it rounds up to 256.
    let mut exponent = exponent(greatest) - 7;
    if (greatest * f64::from(-exponent).exp2()).round() > 255.0 {
        exponent += 1;
    }
    let byte = exponent + BIAS;
    if byte < 1 {
        return [0; 4];
    }
    if byte > 255 {
        return values
            .map(|v| if v > 0.0 { 255 } else { 0 })
            .into_iter()
            .chain([255])
            .collect::<Vec<_>>()
            .try_into()
            .unwrap_or([255; 4]);
    }
    let [r, g, b] = values.map(|v| (v * f64::from(-exponent).exp2()).round() as u8);
    [r, g, b, byte as u8]
}

/// The largest `e` such that `2^e <= v`, for a positive normal `v`; that of the largest `f32` for infinity.
fn exponent(v: f64) -> i32 {
    ((v.to_bits() >> 52) as i32 - 1023).min(f32::MAX_EXP)
}

/// Appends the run-length code of `bytes`.
fn pack(bytes: &[u8], packed: &mut Vec<u8>) {
    let mut plain = 0; // where the bytes begin that are in no run
    let mut at = 0;
    while at < bytes.len() {
        let run = bytes[at..].iter().take(LONGEST_RUN).take_while(|&&byte| byte == bytes[at]).count();
        if run >= SHORTEST_RUN {
            pack_plain(&bytes[plain..at], packed);
            packed.extend([128 + run as u8, bytes[at]]);
            plain = at + run;
        }
        at += run;
    }
    pack_plain(&bytes[plain..], packed);
}

fn pack_plain(bytes: &[u8], packed: &mut Vec<u8>) {
    for bytes in bytes.chunks(LONGEST_PLAIN) {
        packed.push(bytes.len() as u8);
        packed.extend(bytes);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_pixels() {
        for (pixel, expected) in [
            ([1.0, 0.5, 0.25], [128, 64, 32, 129]),
            ([0.999, 0.0, 0.0], [128, 0, 0, 129]), // 255.7 of 256 rounds up to the next exponent
            ([0.99, 0.0, -1.0], [253, 0, 0, 128]),
            ([0.0, f32::NAN, -0.0], [0, 0, 0, 0]),
            ([f32::INFINITY, 1.0, 0.0], [255, 255, 0, 255]),
            ([1e-45, 0.0, 0.0], [0, 0, 0, 0]),
        ] {
            assert_eq!(encode(pixel.into()), expected, "{pixel:?}");
        }
    }

    #[test]
    fn runs_are_packed() {
        let mut packed = Vec::new();
        pack(&[1, 2, 2, 3, 3, 3, 3, 4], &mut packed);
        assert_eq!(packed, [3, 1, 2, 2, 132, 3, 1, 4]);
        packed.clear();
        pack(&[7; 300], &mut packed);
        assert_eq!(packed, [255, 7, 255, 7, 174, 7]);
    }

    /// Rows of 256 pixels and more have a width of two bytes.
    #[test]
    fn wide_rows_say_how_wide_they_are() {
        for width in [255_u32, 256, 300, 515] {
            let pixel = |x: u32, _| Rgb::splat(x as f32);
            let mut bytes = Vec::new();
            write(&mut bytes, &Picture { width, height: 1, pixel: &pixel }).unwrap();
            let head = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X {width}\n");
            assert!(bytes.starts_with(head.as_bytes()));
            let [high, low] = (width as u16).to_be_bytes();
            assert_eq!(bytes[head.len()..][..4], [2, 2, high, low]);
        }
    }
}
