//! PNG: writes 8-bit sRGB; reads every colour type and bit depth.

use super::encoding::{Encoding, NOTE};
use super::limits::{Seekable, check_expansion, check_size};
use super::rows::{First, Rows};
use crate::atomic_file::reason;
use scene::{Film, Picture, Rgb, srgb};
use std::io::{self, Write};

/// The best compression ratio: deflate encodes 258 bytes in at least 2 bits.
const MOST_BYTES_PER_BYTE: u64 = 1032;

/// The colour of a pixel with a NaN: magenta, because it is easily noticed.
const NOT_A_NUMBER: [u8; 3] = [255, 0, 255];

/// Bytes of compressed pixels in each `IDAT` chunk.
const CHUNK: usize = 1 << 15;

pub(super) fn write(out: &mut impl Write, picture: &Picture<Rgb>, encoding: Encoding) -> io::Result<()> {
    let gain = f64::from(encoding.exposure).exp2();
    let byte = |v: f32| srgb::encode_byte(f64::from(v) * gain);
    let code = |p: Rgb| if p.is_nan() { NOT_A_NUMBER } else { p.to_array().map(byte) };
    write_codes(out, picture, encoding.note, code).map_err(|e| match e {
        png::EncodingError::IoError(e) => e,
        other => io::Error::other(other),
    })
}

/// Writes the values as a grey image in which the greatest finite value is white.
pub(super) fn write_values(
    out: &mut impl Write,
    values: &Picture<f32>,
    note: Option<&str>,
) -> io::Result<()> {
    let all = (0..values.height).flat_map(|y| Rows(values).row(y));
    let greatest = all.filter(|v| v.is_finite()).fold(0.0, f32::max);
    let scale = if greatest > 0.0 { greatest } else { 1.0 };
    let pixel = |x, y| Rgb::splat((values.pixel)(x, y) / scale);
    let grey = Picture { width: values.width, height: values.height, pixel: &pixel };
    write(out, &grey, Encoding { note, ..Encoding::default() })
}

fn write_codes(
    out: &mut impl Write,
    picture: &Picture<Rgb>,
    note: Option<&str>,
    code: impl Fn(Rgb) -> [u8; 3] + Sync,
) -> Result<(), png::EncodingError> {
    let mut encoder = png::Encoder::new(out, picture.width, picture.height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    // Noise hardly compresses: the best compression takes ten times as long and saves only a few percent.
    encoder.set_compression(png::Compression::Fast);
    encoder.set_source_srgb(png::SrgbRenderingIntent::RelativeColorimetric);
    if let Some(note) = note {
        encoder.add_text_chunk(NOTE.into(), note.into())?;
    }
    let mut writer = encoder.write_header()?;
    let mut rows = writer.stream_writer_with_size(CHUNK)?;
    Rows(picture).write(First::Top, code, |encoded| rows.write_all(encoded))?;
    rows.finish()?;
    writer.finish()
}

pub(super) fn read(input: &mut impl Seekable, length: u64) -> Result<Film, String> {
    // The decoder's own limit covers only what it holds besides the image, such as compressed profiles.
    let mut decoder = png::Decoder::new(input);
    decoder.set_transformations(png::Transformations::EXPAND);
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    let info = decoder.read_header_info().map_err(|e| problem(&e))?;
    let (width, height) = (info.width, info.height);
    check_size(width.into(), height.into())?;
    let packed = info.raw_row_length() as u64 * u64::from(height);
    check_expansion(packed, length, MOST_BYTES_PER_BYTE)?;

    let mut reader = decoder.read_info().map_err(|e| problem(&e))?;
    let (color, depth) = reader.output_color_type();
    let size = reader.output_buffer_size().ok_or("is too large for this machine")?;
    let mut bytes = vec![0; size];
    reader.next_frame(&mut bytes).map_err(|e| problem(&e))?;
    Ok(Film { width, height, pixels: pixels(&bytes, color.samples(), depth) })
}

pub(super) fn read_note(input: &mut impl Seekable, length: u64) -> Result<Option<String>, String> {
    // A text is in memory twice, raw and decoded. Even the smallest files need some memory.
    let bytes = usize::try_from(length.saturating_mul(2)).unwrap_or(usize::MAX).max(1 << 16);
    let limits = png::Limits { bytes };
    let mut decoder = png::Decoder::new_with_limits(input, limits);
    decoder.set_ignore_iccp_chunk(true);
    let reader = decoder.read_info().map_err(|e| problem(&e))?;
    let mut texts = reader.info().uncompressed_latin1_text.iter();
    Ok(texts.find(|text| text.keyword == NOTE).map(|text| text.text.clone()))
}

/// Decodes sRGB codes to linear pixels. A pixel has `samples` codes: grey or RGB, with or without alpha.
fn pixels(bytes: &[u8], samples: usize, depth: png::BitDepth) -> Vec<Rgb> {
    let (wide, largest) = if depth == png::BitDepth::Sixteen { (2, u16::MAX) } else { (1, 255) };
    let table: Vec<f32> = (0..=largest).map(|c| srgb::decode_code(c, largest)).collect();
    let pixel = |codes: &[u8]| {
        let value = |i: usize| {
            let code = codes[wide * i..][..wide].iter().fold(0, |code, &byte| code << 8 | usize::from(byte));
            table[code]
        };
        if samples < 3 { Rgb::splat(value(0)) } else { Rgb::new(value(0), value(1), value(2)) }
    };
    bytes.chunks_exact(wide * samples).map(pixel).collect()
}

fn problem(e: &png::DecodingError) -> String {
    format!("is no PNG file that can be read: {}", reason(e))
}
