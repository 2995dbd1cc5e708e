//! Image files in and out: PNG for people, EXR and PFM for measurements.
//!
//! | format | out | in |
//! |---|---|---|
//! | PNG | 8 bits per channel, sRGB, clamped to [0, 1] after the exposure; a pixel with a NaN is magenta | 1 to 16 bits, grey, RGB or palette, decoded from sRGB whatever gamma or profile the file states |
//! | EXR | linear `f32`, lossless (ZIP) | R, G and B, or Y, or a single channel of any name; half, float or integer; any flat layout; the data window |
//! | PFM | linear `f32`, the very bits | colour or grey, both byte orders; samples times the scale |
//!
//! Alpha is ignored. A plane (one value per pixel) is written to EXR as channel Y, to PFM as a grey map, and to PNG
//! as a grey picture in which its greatest value is white. The bytes written depend on the pixels and on the note
//! ([`Encoding::note`]) alone.
//!
//! Readers trust nothing: a broken or hostile file gives one line of error, and takes no more memory than its own
//! length accounts for.

mod openexr;
mod pfm;
mod png;
mod rows;
#[cfg(test)]
mod tests;

pub use crate::atomic_file::FileError as ImageError;
use crate::atomic_file::{self, reason};
use scene::settings::{MAX_PIXELS, MAX_SIDE};
use scene::{Film, Picture, Plane, Rgb};
use std::fs::{self, File};
use std::io::{self, BufRead, BufReader, Cursor, Seek};
use std::path::Path;

/// The formats that are read and written, told apart by the file's extension.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// `.png`: 8 bits of sRGB.
    Png,
    /// `.exr`: linear `f32`.
    Exr,
    /// `.pfm`: linear `f32`.
    Pfm,
}

/// How radiance becomes a picture, and what is written into the file beside it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Encoding<'a> {
    /// In stops: radiance is multiplied by `2^exposure`. Only PNG heeds it: EXR and PFM hold the radiance itself.
    pub exposure: f32,
    /// A text of ASCII characters without NUL that [`read_note`] gives back: in a PNG file a `tEXt` chunk, in an EXR
    /// file a text attribute, of the name `sppm`. PFM files have no place for one.
    pub note: Option<&'a str>,
}

/// The name of [`Encoding::note`] in files.
const NOTE: &str = "sppm";

impl Format {
    /// The format of file `path` by its extension, in upper or lower case.
    ///
    /// # Errors
    /// If the extension is another.
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

/// Reads an image of at most [`MAX_PIXELS`] pixels.
///
/// # Errors
/// If the file is missing, or is no image of the format that its extension promises.
pub fn read(path: &Path) -> Result<Film, ImageError> {
    let (format, mut input, length) = open(path)?;
    decode(format, &mut input, length).map_err(|problem| ImageError::new(path, problem))
}

/// Reads the note in an image file; `None` if it has none.
///
/// # Errors
/// As [`read()`], but for the pixels, which are not read.
pub fn read_note(path: &Path) -> Result<Option<String>, ImageError> {
    let (format, mut input, length) = open(path)?;
    decode_note(format, &mut input, length).map_err(|problem| ImageError::new(path, problem))
}

/// The format, the bytes and the length of an image file.
fn open(path: &Path) -> Result<(Format, BufReader<File>, u64), ImageError> {
    let format = Format::from_path(path)?;
    let unreadable = |e: io::Error| ImageError::new(path, format!("cannot be read: {}", reason(&e)));
    // Asked before opening, as opening a pipe waits for a writer.
    let status = fs::metadata(path).map_err(unreadable)?;
    if !status.is_file() {
        return Err(ImageError::new(path, "is no regular file; name an image file"));
    }
    let input = BufReader::new(File::open(path).map_err(unreadable)?);
    Ok((format, input, status.len()))
}

/// Decodes an image file that is in memory, with the bounds of [`read`].
///
/// # Errors
/// What is wrong with it, if `bytes` are no image of that format: a sentence to be read after the file's name.
pub fn decode_bytes(format: Format, bytes: &[u8]) -> Result<Film, String> {
    decode(format, &mut Cursor::new(bytes), bytes.len() as u64)
}

/// The note in an image file that is in memory.
///
/// # Errors
/// As [`decode_bytes`], but for the pixels, which are not read.
pub fn decode_note_bytes(format: Format, bytes: &[u8]) -> Result<Option<String>, String> {
    decode_note(format, &mut Cursor::new(bytes), bytes.len() as u64)
}

/// Writes `film` to `path`, in the format of its extension, as a whole or not at all.
///
/// # Errors
/// What [`check_writable`] finds, a film without pixels, or an error of the file system.
pub fn write(path: &Path, film: &Film, encoding: &Encoding) -> Result<(), ImageError> {
    Format::from_path(path)?;
    check_pixels(path, film.width, film.height, film.pixels.len())?;
    let Film { width, height, .. } = *film;
    let pixel = |x, y| film.pixels[y as usize * width as usize + x as usize];
    write_picture(path, &Picture { width, height, pixel: &pixel }, encoding)
}

/// Like [`write()`], with pixels that are asked for as they are written: no more than some rows are held. Each is
/// asked for once or more, in whatever order suits the format.
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

/// Writes `plane` to `path`; `name`, such as `radius`, is the name of the layer in an EXR file. There is no exposure.
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

/// Like [`write_plane`], with values that are asked for as they are written; see [`write_picture`].
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

/// Finds out whether an image can be written to `path`, before it is computed.
///
/// # Errors
/// If the extension is wrong, the folder is missing or read-only, or `path` names something other than a file.
pub fn check_writable(path: &Path) -> Result<(), ImageError> {
    Format::from_path(path)?;
    atomic_file::check(path)
}

/// What decoders read from.
trait Seekable: BufRead + Seek {}

impl<T: BufRead + Seek> Seekable for T {}

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

/// A film's fields are public, so they may contradict each other.
fn check_pixels(path: &Path, width: u32, height: u32, pixels: usize) -> Result<(), ImageError> {
    if pixels as u64 == u64::from(width) * u64::from(height) {
        return Ok(());
    }
    Err(ImageError::new(path, format!("cannot hold {pixels} pixels as an image of {width} x {height}")))
}

fn check_sides<T>(path: &Path, picture: &Picture<T>) -> Result<(), ImageError> {
    check_size(picture.width.into(), picture.height.into()).map_err(|problem| ImageError::new(path, problem))
}

fn check_size(width: u64, height: u64) -> Result<(), String> {
    if width == 0 || height == 0 {
        return Err(format!("has no pixels: it is {width} x {height}"));
    }
    if width.max(height) > u64::from(MAX_SIDE) || width * height > MAX_PIXELS {
        return Err(format!(
            "is {width} x {height} pixels; at most {MAX_PIXELS} are supported, and {MAX_SIDE} in a side"
        ));
    }
    Ok(())
}

/// Refuses a file that claims to unpack to `bytes`, where not even the best compression could have made them of its
/// `length`: so a broken size never costs memory.
fn check_expansion(bytes: u64, length: u64, most_bytes_per_byte: u64) -> Result<(), String> {
    if bytes / most_bytes_per_byte > length {
        return Err(format!(
            "has {length} bytes, which cannot hold the {bytes} bytes of pixels that it announces"
        ));
    }
    Ok(())
}

fn truncated(e: &io::Error) -> String {
    match e.kind() {
        io::ErrorKind::UnexpectedEof => "ends too early".into(),
        _ => format!("cannot be read: {}", reason(e)),
    }
}
