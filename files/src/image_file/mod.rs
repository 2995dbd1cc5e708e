//! Reads and writes images: PNG and JPEG for viewing, EXR, PFM, HDR and TIFF for measurements; reads WebP and QOI too.
//!
//! | format | written | read |
//! |---|---|---|
//! | PNG | 8 bits per channel, sRGB, after exposure and tone curve ([`Tone`]); a pixel with a NaN is magenta | 1 to 16 bits, grey, RGB or palette |
//! | JPEG | the same, lossy, quality 95 | 8 bits, grey or colour; upright as its EXIF metadata ask |
//! | EXR | linear `f32`, lossless (ZIP) | a layer with R, G and B, or Y, or a single channel of any name; half, float or integer; any flat layout; the data window |
//! | PFM | linear `f32`, bit for bit | colour or grey, both byte orders; samples times the scale |
//! | HDR | linear, 8 bits per channel with a common exponent; negative values and NaN become 0 | RGBE; its header's exposure is ignored |
//! | TIFF | linear `f32`, bit for bit | grey or RGB; 8 and 16 bits, or half, float or double; the first image |
//! | WebP | | lossy or lossless; the first image of an animation |
//! | QOI | | all |
//!
//! PNG, EXR and TIFF are also written with alpha ([`write_transparent`]).
//!
//! A file is read by what it contains, whatever its name is, and written by its extension. Integers are decoded from sRGB
//! whatever gamma or profile the file states, floats are linear. Alpha is ignored when a file is read. A plane (one value per pixel) is
//! written to EXR as channel Y, to PFM and TIFF as a grey map, to HDR as grey, and to PNG and JPEG as a grey image in
//! which its greatest value is white. The bytes of a file depend only on the pixels and the [`Encoding`], whose note PNG
//! and EXR hold.
//!
//! Readers validate their input: a broken or malicious file gives a one-line error, and the memory used is bounded in
//! terms of the file's length.

mod decoded;
mod encoding;
mod format;
mod guard;
mod hdr;
mod jpeg;
mod layers;
mod limits;
mod opened;
mod openexr;
mod pfm;
mod png;
mod reader;
mod rows;
mod samples;
mod shown;
#[cfg(test)]
mod tests;
mod tiff;
mod tone;

use crate::atomic_file;
pub use crate::atomic_file::FileError as ImageError;
pub use encoding::Encoding;
pub use format::Format;
use limits::{Seekable, check_size};
use opened::Opened;
pub use reader::ImageReader;
use scene::{Film, Picture, Plane, Rgb, Rgba};
use std::io::{self, Cursor};
use std::path::Path;
pub use tone::{Tone, USUAL_WHITE};

/// Reads an image of at most [`scene::settings::MAX_PIXELS`] pixels.
///
/// # Errors
/// If the file cannot be read, or is not a valid image.
pub fn read(path: &Path) -> Result<Film, ImageError> {
    let (format, input, length) = reader::open_file(path)?;
    let film = reader::open(format, Box::new(input), length, None).and_then(Opened::film);
    film.map_err(|problem| ImageError::new(path, problem))
}

/// Reads the note in an image file; `None` if it has none.
///
/// # Errors
/// As [`read()`], except for errors in the pixels, which are not read.
pub fn read_note(path: &Path) -> Result<Option<String>, ImageError> {
    let (format, mut input, length) = reader::open_file(path)?;
    decode_note(format, &mut input, length).map_err(|problem| ImageError::new(path, problem))
}

/// The names of the layers of an image file. Only EXR files have some.
///
/// # Errors
/// As [`read_note`].
pub fn layer_names(path: &Path) -> Result<Vec<String>, ImageError> {
    let (format, mut input, length) = reader::open_file(path)?;
    let names = if format == Format::Exr { openexr::layer_names(&mut input, length) } else { Ok(Vec::new()) };
    names.map_err(|problem| ImageError::new(path, problem))
}

/// The name of the layer that is read if none is chosen, empty if it has none; `None` if one must be chosen.
///
/// # Errors
/// As [`read_note`].
pub fn usual_layer(path: &Path) -> Result<Option<String>, ImageError> {
    let (format, mut input, length) = reader::open_file(path)?;
    let name = match format {
        Format::Exr => openexr::usual_layer(&mut input, length),
        _ => Ok(Some(String::new())),
    };
    name.map_err(|problem| ImageError::new(path, problem))
}

/// Decodes an image file in memory, with the same limits as [`read`].
///
/// # Errors
/// If `bytes` are not a valid image of that format. The message continues the file's name.
pub fn decode_bytes(format: Format, bytes: &[u8]) -> Result<Film, String> {
    reader::open(format, Box::new(Cursor::new(bytes)), bytes.len() as u64, None)?.film()
}

/// The note in an image file in memory.
///
/// # Errors
/// As [`decode_bytes`], except for errors in the pixels, which are not read.
pub fn decode_note_bytes(format: Format, bytes: &[u8]) -> Result<Option<String>, String> {
    decode_note(format, &mut Cursor::new(bytes), bytes.len() as u64)
}

/// Writes `film` to `path` atomically, in the format of the extension.
///
/// # Errors
/// If [`check_writable`] fails, if the film's size is zero or does not match its pixels, or if writing fails.
pub fn write(path: &Path, film: &Film, encoding: &Encoding) -> Result<(), ImageError> {
    Format::from_path(path)?;
    check_pixels(path, film.width, film.height, film.pixels.len())?;
    let Film { width, height, .. } = *film;
    let pixel = |x, y| film.pixels[y as usize * width as usize + x as usize];
    write_picture(path, &Picture { width, height, pixel: &pixel }, encoding)
}

/// Like [`write()`], but computes the pixels while writing, so that only a few rows are in memory at a time. Each pixel
/// is computed at least once, in any order.
///
/// # Errors
/// Like [`write()`].
pub fn write_picture(path: &Path, picture: &Picture<Rgb>, encoding: &Encoding) -> Result<(), ImageError> {
    let format = Format::from_path(path)?;
    check_sides(path, picture)?;
    atomic_file::replace(path, |out| match format {
        Format::Png => png::write(out, picture, *encoding),
        Format::Jpeg => jpeg::write(out, picture, encoding),
        Format::Exr => openexr::write(out, picture, encoding.note),
        Format::Pfm => pfm::write(out, picture),
        Format::Hdr => hdr::write(out, picture),
        Format::Tiff => tiff::write(out, picture),
        Format::WebP | Format::Qoi => Err(io::ErrorKind::Unsupported.into()),
    })
}

/// Like [`write_picture`], with alpha: to EXR and TIFF with associated colours as they are; to PNG with those of what covers a
/// pixel, divided by alpha, as its standard asks.
///
/// # Errors
/// Like [`write()`], or if the format has no alpha ([`Format::has_alpha`]).
pub fn write_transparent(
    path: &Path,
    picture: &Picture<Rgba>,
    encoding: &Encoding,
) -> Result<(), ImageError> {
    let format = Format::from_path(path)?;
    check_sides(path, picture)?;
    atomic_file::replace(path, |out| match format {
        Format::Png => png::write_transparent(out, picture, encoding),
        Format::Exr => openexr::write_transparent(out, picture, encoding.note),
        Format::Tiff => tiff::write_transparent(out, picture),
        _ => Err(io::ErrorKind::Unsupported.into()),
    })
}

/// The codes that a PNG file of `picture` holds, row by row from the top.
pub fn codes(picture: &Picture<Rgb>, encoding: &Encoding) -> Vec<[u8; 3]> {
    rows::collected(picture, shown::codes(picture, encoding))
}

/// The codes that a PNG file of `picture` with alpha holds, as [`codes`].
pub fn codes_with_alpha(picture: &Picture<Rgba>, encoding: &Encoding) -> Vec<[u8; 4]> {
    rows::collected(picture, shown::codes_with_alpha(picture, encoding))
}

/// Writes `plane` to `path`. `name`, such as `radius`, is the name of the layer in an EXR file. Exposure is ignored.
///
/// # Errors
/// Like [`write()`].
pub fn write_plane(path: &Path, plane: &Plane, name: &str, encoding: &Encoding) -> Result<(), ImageError> {
    Format::from_path(path)?;
    check_pixels(path, plane.width, plane.height, plane.values.len())?;
    let Plane { width, height, .. } = *plane;
    let pixel = |x, y| plane.values[y as usize * width as usize + x as usize];
    write_values(path, &Picture { width, height, pixel: &pixel }, name, encoding)
}

/// Like [`write_plane`], but computes the values while writing; see [`write_picture`].
///
/// # Errors
/// Like [`write()`].
pub fn write_values(
    path: &Path,
    values: &Picture<f32>,
    name: &str,
    encoding: &Encoding,
) -> Result<(), ImageError> {
    let format = Format::from_path(path)?;
    check_sides(path, values)?;
    atomic_file::replace(path, |out| match format {
        Format::Png => png::write_values(out, values, encoding.note),
        Format::Jpeg => jpeg::write_values(out, values),
        Format::Exr => openexr::write_values(out, values, name, encoding.note),
        Format::Pfm => pfm::write_values(out, values),
        Format::Hdr => hdr::write_values(out, values),
        Format::Tiff => tiff::write_values(out, values),
        Format::WebP | Format::Qoi => Err(io::ErrorKind::Unsupported.into()),
    })
}

/// Checks in advance whether an image can be written to `path`.
///
/// # Errors
/// If the extension is not supported, the folder is missing or read-only, or `path` is something other than a file.
pub fn check_writable(path: &Path) -> Result<(), ImageError> {
    Format::from_path(path)?;
    atomic_file::check(path)
}

fn decode_note(format: Format, input: &mut impl Seekable, length: u64) -> Result<Option<String>, String> {
    match format {
        Format::Png => png::read_note(input, length),
        Format::Exr => openexr::read_note(input, length),
        _ => Ok(None),
    }
}

/// Checks that the number of pixels matches the size: the fields of a film are public and may be inconsistent.
fn check_pixels(path: &Path, width: u32, height: u32, pixels: usize) -> Result<(), ImageError> {
    if pixels as u64 == u64::from(width) * u64::from(height) {
        return Ok(());
    }
    Err(ImageError::new(path, format!("cannot hold {pixels} pixels as an image of {width} x {height}")))
}

fn check_sides<T>(path: &Path, picture: &Picture<T>) -> Result<(), ImageError> {
    check_size(picture.width.into(), picture.height.into()).map_err(|problem| ImageError::new(path, problem))
}
