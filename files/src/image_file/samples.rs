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
