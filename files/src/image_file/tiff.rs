//! TIFF: writes linear `f32` without compression; reads the first image of a file, strip by strip.
//!
//! Integers of 8 and 16 bits are codes of sRGB, floats are linear. Alpha is ignored.

use super::guard::guarded;
use super::limits::{Seekable, check_likely, check_size, told};
use super::opened::{Opened, RowSource};
use super::rows::{First, Rows};
use super::samples::Sample;
use exr::prelude::f16;
use scene::settings::MAX_SIDE;
use scene::{Picture, Rgb, Rgba, srgb};
use std::io::{self, Seek, Write};
use tiff::ColorType;
use tiff::decoder::{Decoder, DecodingResult, Limits};
use tiff::encoder::colortype::{self, Gray32Float, RGB32Float};
use tiff::encoder::{TiffEncoder, TiffValue};
use tiff::tags::{ExtraSamples, Tag};

/// Target size of the strips that are written, in bytes.
const STRIP: usize = 1 << 16;

pub(super) fn write(out: &mut (impl Write + Seek), picture: &Picture<Rgb>) -> io::Result<()> {
    write_pixels::<RGB32Float, _, 12>(out, picture, &[], |pixel| bytes_of(&pixel.to_array()))
}

/// Colours are associated, and told to be so.
pub(super) fn write_transparent(out: &mut (impl Write + Seek), picture: &Picture<Rgba>) -> io::Result<()> {
    let extra = [ExtraSamples::AssociatedAlpha];
    write_pixels::<RGB32Float, _, 16>(out, picture, &extra, |Rgba { color, alpha }| {
        bytes_of(&[color.x, color.y, color.z, alpha])
    })
}

/// Samples as they are in memory.
fn bytes_of<const BYTES: usize>(samples: &[f32]) -> [u8; BYTES] {
    let mut bytes = [0; BYTES];
    for (bytes, sample) in bytes.chunks_exact_mut(4).zip(samples) {
        bytes.copy_from_slice(&sample.to_ne_bytes());
    }
    bytes
}

pub(super) fn write_values(out: &mut (impl Write + Seek), values: &Picture<f32>) -> io::Result<()> {
    write_pixels::<Gray32Float, _, 4>(out, values, &[], f32::to_ne_bytes)
}

/// Writes pixels of the colour type `C` and `extra` samples, `BYTES` in all.
fn write_pixels<C, T, const BYTES: usize>(
    out: &mut (impl Write + Seek),
    picture: &Picture<T>,
    extra: &[ExtraSamples],
    encode: impl Fn(T) -> [u8; BYTES] + Sync,
) -> io::Result<()>
where
    C: colortype::ColorType<Inner = f32>,
    [f32]: TiffValue,
{
    let rows_per_strip = (STRIP / (BYTES * picture.width as usize)).clamp(1, picture.height as usize);
    let mut encoder = TiffEncoder::new(out).map_err(into_io)?;
    let mut image = encoder.new_image::<C>(picture.width, picture.height).map_err(into_io)?;
    if !extra.is_empty() {
        image.extra_samples(extra).map_err(into_io)?;
    }
    image.rows_per_strip(rows_per_strip as u32).map_err(into_io)?;
    let mut strip: Vec<f32> = Vec::new();
    Rows(picture).write(First::Top, encode, |rows| {
        for sample in rows.chunks_exact(4) {
            strip.push(f32::from_ne_bytes([sample[0], sample[1], sample[2], sample[3]]));
            if strip.len() as u64 == image.next_strip_sample_count() {
                image.write_strip(&strip).map_err(into_io)?;
                strip.clear();
            }
        }
        Ok::<_, io::Error>(())
    })?;
    image.finish().map_err(into_io)
}

fn into_io(e: tiff::TiffError) -> io::Error {
    match e {
        tiff::TiffError::IoError(e) => e,
        other => io::Error::other(other),
    }
}

pub(super) fn open<'a>(input: Box<dyn Seekable + 'a>, length: u64) -> Result<Opened<'a>, String> {
    guarded("TIFF", || open_strips(input, length))
}

fn open_strips<'a>(input: Box<dyn Seekable + 'a>, length: u64) -> Result<Opened<'a>, String> {
    let mut decoder = Decoder::new(input).map_err(|e| problem(&e))?;
    let (width, height) = decoder.dimensions().map_err(|e| problem(&e))?;
    check_size(width.into(), height.into())?;
    let color = decoder.colortype().map_err(|e| problem(&e))?;
    let (per_pixel, bits) = channels(color).ok_or_else(|| {
        format!("has pixels of the kind {color:?}; they must be grey or RGB, of 8 bits or more")
    })?;
    check_layout(&mut decoder, per_pixel)?;
    let chunk = decoder.chunk_dimensions();
    let chunk = [chunk.0.min(width), chunk.1.min(height)];
    let pixel_bytes = (per_pixel * usize::from(bits).div_ceil(8)) as u64;
    check_likely(u64::from(width) * u64::from(height), length)?;
    let bytes =
        usize::try_from(u64::from(chunk[0]) * u64::from(chunk[1]) * pixel_bytes).unwrap_or(usize::MAX);
    let mut limits = Limits::default();
    limits.decoding_buffer_size = bytes;
    limits.intermediate_buffer_size = usize::try_from(length).unwrap_or(usize::MAX);
    let mut rows = StripRows {
        decoder: decoder.with_limits(limits),
        per_pixel,
        width: width as usize,
        height: height as usize,
        chunk: chunk.map(|side| side as usize),
        next: 0,
        held: Vec::new(),
        codes: (0..=u16::MAX).map(|code| srgb::decode_code(code, u16::MAX)).collect(),
    };
    // The kind of sample is only known once some are decoded.
    let sample = rows.hold(0)?;
    Ok(Opened { width, height, sample, rows: Box::new(rows) })
}

/// Samples per pixel, and bits per sample.
fn channels(color: ColorType) -> Option<(usize, u8)> {
    let (samples, bits) = match color {
        ColorType::Gray(bits) => (1, bits),
        ColorType::Multiband { bit_depth, num_samples: 2 } => (2, bit_depth),
        ColorType::RGB(bits) => (3, bits),
        ColorType::RGBA(bits) => (4, bits),
        _ => return None,
    };
    (bits >= 8).then_some((samples, bits))
}

/// Rejects images that lie on their side, planes one after the other, and tiles larger than any image.
fn check_layout(decoder: &mut Decoder<Box<dyn Seekable + '_>>, samples: usize) -> Result<(), String> {
    let mut tag = |tag| decoder.find_tag_unsigned::<u32>(tag).map_err(|e| problem(&e));
    if let Some(orientation) = tag(Tag::Orientation)?.filter(|&orientation| orientation != 1) {
        return Err(format!("is stored with orientation {orientation}; it must be upright, orientation 1"));
    }
    if samples > 1 && tag(Tag::PlanarConfiguration)? == Some(2) {
        return Err("stores each channel apart; the samples of a pixel must be together".into());
    }
    for side in [Tag::TileWidth, Tag::TileLength] {
        if let Some(side) = tag(side)?.filter(|&side| side == 0 || side > MAX_SIDE) {
            return Err(format!("has tiles of {side} pixels in a side; it must be from 1 to {MAX_SIDE}"));
        }
    }
    Ok(())
}

/// The rows of an image, of which one row of strips or tiles is held.
struct StripRows<'a> {
    decoder: Decoder<Box<dyn Seekable + 'a>>,
    per_pixel: usize,
    width: usize,
    height: usize,
    /// Width and height of a strip or tile.
    chunk: [usize; 2],
    next: usize,
    /// The pixels of the row of strips or tiles in which `next` is.
    held: Vec<Rgb>,
    /// The linear value of every code of 16 bits.
    codes: Vec<f32>,
}

impl StripRows<'_> {
    /// Decodes row `down` of strips or tiles.
    fn hold(&mut self, down: usize) -> Result<Sample, String> {
        let [wide, high] = self.chunk;
        let across = self.width.div_ceil(wide);
        let mut sample = Sample::Float;
        self.held = vec![Rgb::ZERO; self.width * high.min(self.height - down * high)];
        for place in 0..across {
            let decoded = self.decoder.read_chunk((down * across + place) as u32).map_err(|e| problem(&e))?;
            sample = self.place(&decoded, place * wide)?;
        }
        Ok(sample)
    }

    /// Copies the samples of a strip or tile whose left column is `left`.
    fn place(&mut self, decoded: &DecodingResult, left: usize) -> Result<Sample, String> {
        let codes = std::mem::take(&mut self.codes);
        let sample = match decoded {
            DecodingResult::U8(v) => {
                self.put(v, left, |v| codes[257 * usize::from(v)]);
                Some(Sample::Byte)
            }
            DecodingResult::U16(v) => {
                self.put(v, left, |v| codes[usize::from(v)]);
                Some(Sample::NativeWord)
            }
            DecodingResult::F16(v) => {
                self.put(v, left, f16::to_f32);
                Some(Sample::Float)
            }
            DecodingResult::F32(v) => {
                self.put(v, left, |v| v);
                Some(Sample::Float)
            }
            DecodingResult::F64(v) => {
                self.put(v, left, |v| v as f32);
                Some(Sample::Float)
            }
            _ => None,
        };
        self.codes = codes;
        sample.ok_or_else(|| {
            "has integers other than of 8 or 16 bits without sign; use these, or floats".into()
        })
    }

    fn put<T: Copy>(&mut self, samples: &[T], left: usize, value: impl Fn(T) -> f32) {
        let wide = self.chunk[0].min(self.width - left);
        let rows = self.held.chunks_exact_mut(self.width);
        for (row, samples) in rows.zip(samples.chunks_exact(wide * self.per_pixel)) {
            for (pixel, s) in row[left..left + wide].iter_mut().zip(samples.chunks_exact(self.per_pixel)) {
                *pixel = match s {
                    [r, g, b, ..] => Rgb::new(value(*r), value(*g), value(*b)),
                    grey => Rgb::splat(value(grey[0])),
                };
            }
        }
    }
}

impl RowSource for StripRows<'_> {
    fn read(&mut self, pixels: &mut [Rgb]) -> Result<(), String> {
        let high = self.chunk[1];
        for row in pixels.chunks_exact_mut(self.width) {
            if self.next > 0 && self.next.is_multiple_of(high) {
                guarded("TIFF", || self.hold(self.next / high))?;
            }
            row.copy_from_slice(&self.held[self.next % high * self.width..][..self.width]);
            self.next += 1;
        }
        Ok(())
    }
}

fn problem(e: &tiff::TiffError) -> String {
    told("TIFF", e)
}
