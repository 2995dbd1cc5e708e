//! Reads and writes images: PNG for viewing, EXR and PFM for measurements.
//!
//! | format | written | read |
//! |---|---|---|
//! | PNG | 8 bits per channel, sRGB, clamped to [0, 1] after the exposure; a pixel with a NaN is magenta | 1 to 16 bits, grey, RGB or palette, decoded from sRGB whatever gamma or profile the file states |
//! | EXR | linear `f32`, lossless (ZIP) | R, G and B, or Y, or a single channel of any name; half, float or integer; any flat layout; the data window |
//! | PFM | linear `f32`, bit for bit | colour or grey, both byte orders; samples times the scale |
//!
//! Alpha is ignored. A plane (one value per pixel) is written to EXR as channel Y, to PFM as a grey map, and to PNG
//! as a grey image in which its greatest value is white. The bytes of a file depend only on the pixels, the exposure
//! and the note ([`Encoding`]).
//!
//! Readers validate their input: a broken or malicious file gives a one-line error, and the memory used is bounded in
//! terms of the file's length.

mod encoding;
mod limits;
mod openexr;
mod pfm;
mod png;
mod rows;
#[cfg(test)]
mod tests;

pub use crate::atomic_file::FileError as ImageError;
use crate::atomic_file::{self, reason};
pub use encoding::Encoding;
use limits::{Seekable, check_size};
use scene::{Film, Picture, Plane, Rgb};
use std::fs::{self, File};
use std::io::{self, BufReader, Cursor};
use std::path::Path;

/// An image format, chosen by the file's extension.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// `.png`: 8 bits of sRGB.
    Png,
    /// `.exr`: linear `f32`.
    Exr,
    /// `.pfm`: linear `f32`.
    Pfm,
}

impl Format {
    /// The format of the file `path` by its extension, in upper or lower case.
    ///
    /// # Errors
    /// If the extension is not one of these.
    pub fn from_path(path: &Path) -> Result<Self, ImageError> {
        let extension = path.extension().unwrap_or_default().to_string_lossy();
        match extension.to_ascii_lowercase().as_str() {
            "png" => Ok(Self::Png),
            "exr" => Ok(Self::Exr),
            "pfm" => Ok(Self::Pfm),
            "" => Err(ImageError::new(path, "has no extension; it must be .png, .exr or .pfm")),
            other => {
                let other = other.escape_debug();
                Err(ImageError::new(
                    path,
                    format!("has the extension .{other}; it must be .png, .exr or .pfm"),
                ))
            }
        }
    }
}

/// Reads an image of at most [`scene::settings::MAX_PIXELS`] pixels.
///
/// # Errors
/// If the file cannot be read, or is not a valid image of the format that its extension names.
pub fn read(path: &Path) -> Result<Film, ImageError> {
    let (format, mut input, length) = open(path)?;
    decode(format, &mut input, length).map_err(|problem| ImageError::new(path, problem))
}

/// Reads the note in an image file; `None` if it has none.
///
/// # Errors
/// As [`read()`], except for errors in the pixels, which are not read.
pub fn read_note(path: &Path) -> Result<Option<String>, ImageError> {
    let (format, mut input, length) = open(path)?;
    decode_note(format, &mut input, length).map_err(|problem| ImageError::new(path, problem))
}

/// The format, the bytes and the length of an image file.
fn open(path: &Path) -> Result<(Format, BufReader<File>, u64), ImageError> {
    let format = Format::from_path(path)?;
    let unreadable = |e: io::Error| ImageError::new(path, format!("cannot be read: {}", reason(&e)));
    // Checked before opening, because opening a pipe blocks until there is a writer.
    let status = fs::metadata(path).map_err(unreadable)?;
    if !status.is_file() {
        return Err(ImageError::new(path, "is no regular file; name an image file"));
    }
    let input = BufReader::new(File::open(path).map_err(unreadable)?);
    Ok((format, input, status.len()))
}

/// Decodes an image file in memory, with the same limits as [`read`].
///
/// # Errors
/// If `bytes` are not a valid image of that format. The message continues the file's name.
pub fn decode_bytes(format: Format, bytes: &[u8]) -> Result<Film, String> {
    decode(format, &mut Cursor::new(bytes), bytes.len() as u64)
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
        Format::Exr => openexr::write(out, picture, encoding.note),
        Format::Pfm => pfm::write(out, picture),
    })
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
        Format::Exr => openexr::write_values(out, values, name, encoding.note),
        Format::Pfm => pfm::write_values(out, values),
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

/// Decodes an image file of `length` bytes.
fn decode(format: Format, input: &mut impl Seekable, length: u64) -> Result<Film, String> {
    match format {
        Format::Png => png::read(input, length),
        Format::Exr => openexr::read(input, length),
        Format::Pfm => pfm::read(input, length),
    }
}

fn decode_note(format: Format, input: &mut impl Seekable, length: u64) -> Result<Option<String>, String> {
    match format {
        Format::Png => png::read_note(input, length),
        Format::Exr => openexr::read_note(input, length),
        Format::Pfm => Ok(None),
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
