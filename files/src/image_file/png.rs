//! PNG: writes 8-bit sRGB; reads every colour type and bit depth.

use super::encoding::{Encoding, NOTE};
use super::limits::{Seekable, check_expansion, check_size};
use super::opened::{Opened, RowSource};
use super::rows::{First, Rows};
use super::samples::{Sample, Samples};
use super::shown;
use crate::atomic_file::reason;
use scene::{Picture, Rgb, Rgba};
use std::io::{self, Write};

/// The best compression ratio: deflate encodes 258 bytes in at least 2 bits.
const MOST_BYTES_PER_BYTE: u64 = 1032;

/// Bytes of compressed pixels in each `IDAT` chunk.
const CHUNK: usize = 1 << 15;

pub(super) fn write(out: &mut impl Write, picture: &Picture<Rgb>, encoding: Encoding) -> io::Result<()> {
    let codes = shown::codes(picture, &encoding);
    let codes = Picture { width: picture.width, height: picture.height, pixel: &codes };
    write_codes(out, &codes, png::ColorType::Rgb, encoding.note).map_err(into_io)
}

pub(super) fn write_transparent(
    out: &mut impl Write,
    picture: &Picture<Rgba>,
    encoding: &Encoding,
) -> io::Result<()> {
    let codes = shown::codes_with_alpha(picture, encoding);
    let codes = Picture { width: picture.width, height: picture.height, pixel: &codes };
    write_codes(out, &codes, png::ColorType::Rgba, encoding.note).map_err(into_io)
}

fn into_io(e: png::EncodingError) -> io::Error {
    match e {
        png::EncodingError::IoError(e) => e,
        other => io::Error::other(other),
    }
}

/// Writes the values as a grey image in which the greatest finite value is white.
pub(super) fn write_values(
    out: &mut impl Write,
    values: &Picture<f32>,
    note: Option<&str>,
) -> io::Result<()> {
    let scale = shown::greatest(values);
    let pixel = |x, y| Rgb::splat(values.pixel.at(x, y) / scale);
    let grey = Picture { width: values.width, height: values.height, pixel: &pixel };
    write(out, &grey, Encoding { note, ..Encoding::default() })
}

fn write_codes<const SAMPLES: usize>(
    out: &mut impl Write,
    codes: &Picture<[u8; SAMPLES]>,
    color: png::ColorType,
    note: Option<&str>,
) -> Result<(), png::EncodingError> {
    let mut encoder = png::Encoder::new(out, codes.width, codes.height);
    encoder.set_color(color);
    encoder.set_depth(png::BitDepth::Eight);
    // Noise hardly compresses: the best compression takes ten times as long and saves only a few percent.
    encoder.set_compression(png::Compression::Fast);
    encoder.set_source_srgb(png::SrgbRenderingIntent::RelativeColorimetric);
    if let Some(note) = note {
        encoder.add_text_chunk(NOTE.into(), note.into())?;
    }
    let mut writer = encoder.write_header()?;
    let mut rows = writer.stream_writer_with_size(CHUNK)?;
    Rows(codes).write(First::Top, |code| code, |encoded| rows.write_all(encoded))?;
    rows.finish()?;
    writer.finish()
}

pub(super) fn open<'a>(input: Box<dyn Seekable + 'a>, length: u64) -> Result<Opened<'a>, String> {
    // The decoder's own limit covers only what it holds besides the image, such as compressed profiles.
    let mut decoder = png::Decoder::new(input);
    decoder.set_transformations(png::Transformations::EXPAND);
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    let info = decoder.read_header_info().map_err(|e| problem(&e))?;
    let (width, height, is_interlaced) = (info.width, info.height, info.interlaced);
    check_size(width.into(), height.into())?;
    let packed = info.raw_row_length() as u64 * u64::from(height);
    check_expansion(packed, length, MOST_BYTES_PER_BYTE)?;

    let mut reader = decoder.read_info().map_err(|e| problem(&e))?;
    let (color, depth) = reader.output_color_type();
    let sample = if depth == png::BitDepth::Sixteen { Sample::BigWord } else { Sample::Byte };
    let samples = Samples::new(sample, color.samples());
    let rows: Box<dyn RowSource + 'a> = if is_interlaced {
        let mut bytes = vec![0; reader.output_buffer_size().ok_or("is too large for this machine")?];
        reader.next_frame(&mut bytes).map_err(|e| problem(&e))?;
        Box::new(WholeRows { bytes, samples, next: 0 })
    } else {
        Box::new(PngRows { reader, samples, width: width as usize, left: height as usize })
    };
    Ok(Opened { width, height, sample, rows })
}

/// The rows of an image that is decoded as they are read.
struct PngRows<'a> {
    reader: png::Reader<Box<dyn Seekable + 'a>>,
    samples: Samples,
    width: usize,
    left: usize,
}

impl RowSource for PngRows<'_> {
    fn read(&mut self, pixels: &mut [Rgb]) -> Result<(), String> {
        for row in pixels.chunks_exact_mut(self.width) {
            let stored = self.reader.next_row().map_err(|e| problem(&e))?.ok_or("ends too early")?;
            self.samples.decode(stored.data(), row);
            self.left -= 1;
        }
        // Finds damage behind the last row, and damaged checksums.
        if self.left == 0 { self.reader.finish().map_err(|e| problem(&e)) } else { Ok(()) }
    }
}

/// The rows of an interlaced image, all of which are decoded together.
struct WholeRows {
    bytes: Vec<u8>,
    samples: Samples,
    /// Where the next row begins.
    next: usize,
}

impl RowSource for WholeRows {
    fn read(&mut self, pixels: &mut [Rgb]) -> Result<(), String> {
        self.samples.decode(&self.bytes[self.next..], pixels);
        self.next += pixels.len() * self.samples.bytes_per_pixel();
        Ok(())
    }
}

pub(super) fn read_note(input: &mut (impl Seekable + ?Sized), length: u64) -> Result<Option<String>, String> {
    // A text is in memory twice, raw, in a buffer that grows by doubling, and decoded. Even the smallest files need some
    // memory.
    let bytes = usize::try_from(length.saturating_mul(4)).unwrap_or(usize::MAX).max(1 << 16);
    let limits = png::Limits { bytes };
    let mut decoder = png::Decoder::new_with_limits(input, limits);
    decoder.set_ignore_iccp_chunk(true);
    let reader = decoder.read_info().map_err(|e| problem(&e))?;
    let mut texts = reader.info().uncompressed_latin1_text.iter();
    Ok(texts.find(|text| text.keyword == NOTE).map(|text| text.text.clone()))
}

fn problem(e: &png::DecodingError) -> String {
    let reason = reason(e);
    // Where the first chunk is another, the decoder shows its own structures.
    let reason = if reason.contains("ChunkType {") { "its chunks are damaged" } else { &reason };
    format!("is no PNG file that can be read: {reason}")
}
