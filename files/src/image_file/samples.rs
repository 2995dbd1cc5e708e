//! How the samples of a decoded image become linear pixels.

use scene::{Rgb, srgb};
use std::fmt;

/// How a sample is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sample {
    /// 8 bits of sRGB.
    Byte,
    /// 16 bits of sRGB, most significant byte first.
    BigWord,
    /// 16 bits of sRGB in the machine's byte order.
    NativeWord,
    /// A linear `f32` in the machine's byte order.
    Float,
}

/// How pixels are stored: as one sample (grey) or three (RGB), with or without alpha, which is ignored.
pub(super) struct Samples {
    pub(super) sample: Sample,
    pub(super) per_pixel: usize,
    /// The linear value of every code; none for floats.
    linear: Vec<f32>,
}

impl Samples {
    pub(super) fn new(sample: Sample, per_pixel: usize) -> Self {
        let largest = match sample {
            Sample::Byte => 255,
            Sample::BigWord | Sample::NativeWord => u16::MAX,
            Sample::Float => return Self { sample, per_pixel, linear: Vec::new() },
        };
        let linear = (0..=largest).map(|code| srgb::decode_code(code, largest)).collect();
        Self { sample, per_pixel, linear }
    }

    pub(super) fn bytes_per_pixel(&self) -> usize {
        self.per_pixel * self.sample.bytes()
    }

    /// The pixel stored as `bytes`.
    pub(super) fn pixel(&self, bytes: &[u8]) -> Rgb {
        let word = |i: usize| [bytes[2 * i], bytes[2 * i + 1]];
        let value = |i: usize| match self.sample {
            Sample::Byte => self.linear[usize::from(bytes[i])],
            Sample::BigWord => self.linear[usize::from(u16::from_be_bytes(word(i)))],
            Sample::NativeWord => self.linear[usize::from(u16::from_ne_bytes(word(i)))],
            Sample::Float => f32::from_ne_bytes(std::array::from_fn(|k| bytes[4 * i + k])),
        };
        if self.per_pixel < 3 { Rgb::splat(value(0)) } else { Rgb::new(value(0), value(1), value(2)) }
    }

    pub(super) fn decode(&self, bytes: &[u8], pixels: &mut [Rgb]) {
        for (pixel, bytes) in pixels.iter_mut().zip(bytes.chunks_exact(self.bytes_per_pixel())) {
            *pixel = self.pixel(bytes);
        }
    }
}

impl Sample {
    fn bytes(self) -> usize {
        match self {
            Self::Byte => 1,
            Self::BigWord | Self::NativeWord => 2,
            Self::Float => 4,
        }
    }

    /// Whether values are radiance, not codes of sRGB.
    pub(super) fn is_linear(self) -> bool {
        self == Self::Float
    }
}

impl fmt::Display for Sample {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Byte => "8 bits of sRGB",
            Self::BigWord | Self::NativeWord => "16 bits of sRGB",
            Self::Float => "linear floats",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// In each way to store them, one sample or three, whatever follows.
    #[test]
    fn samples_become_linear_pixels() {
        let byte = |per_pixel, bytes: &[u8]| Samples::new(Sample::Byte, per_pixel).pixel(bytes);
        let of = |code: u8| srgb::decode_code(code.into(), 255);
        assert_eq!(byte(1, &[7]), Rgb::splat(of(7)));
        assert_eq!(byte(2, &[7, 200]), Rgb::splat(of(7)));
        assert_eq!(byte(3, &[0, 7, 255]), Rgb::new(0.0, of(7), 1.0));
        assert_eq!(byte(4, &[255, 7, 0, 9]), Rgb::new(1.0, of(7), 0.0));
        let word = srgb::decode_code(0x1234, u16::MAX);
        assert_eq!(Samples::new(Sample::BigWord, 1).pixel(&[0x12, 0x34]), Rgb::splat(word));
        assert_eq!(
            Samples::new(Sample::NativeWord, 2).pixel(&[&0x1234_u16.to_ne_bytes()[..], &[1, 2]].concat()),
            Rgb::splat(word)
        );
        let floats: Vec<u8> = [0.5_f32, -1.5, 3e9].into_iter().flat_map(f32::to_ne_bytes).collect();
        assert_eq!(Samples::new(Sample::Float, 3).pixel(&floats), Rgb::new(0.5, -1.5, 3e9));
        let mut pixels = [Rgb::ZERO; 2];
        Samples::new(Sample::Byte, 2).decode(&[7, 0, 255, 0], &mut pixels);
        assert_eq!(pixels, [Rgb::splat(of(7)), Rgb::ONE]);
    }

    #[test]
    fn bytes_are_those_of_all_samples() {
        let bytes = |sample, per_pixel| Samples::new(sample, per_pixel).bytes_per_pixel();
        assert_eq!(
            [
                bytes(Sample::Byte, 3),
                bytes(Sample::BigWord, 4),
                bytes(Sample::NativeWord, 1),
                bytes(Sample::Float, 3)
            ],
            [3, 8, 2, 12]
        );
        assert!(Sample::Float.is_linear() && !Sample::BigWord.is_linear());
        assert_eq!(Sample::Byte.to_string(), "8 bits of sRGB");
    }
}
