//! Reads an image file row by row, whatever its format.

use super::limits::Seekable;
use super::opened::Opened;
use super::{Format, ImageError, decoded, openexr, pfm, png, tiff};
use crate::atomic_file::reason;
use crate::input;
use scene::{Rgb, RowReader};
use std::fmt;
use std::fs::File;
use std::io::{self, BufReader, Read, Seek};
use std::path::{Path, PathBuf};

/// Opens an image of `length` bytes. `layer` chooses a layer of an EXR file.
pub(super) fn open<'a>(
    format: Format,
    input: Box<dyn Seekable + 'a>,
    length: u64,
    layer: Option<&str>,
) -> Result<Opened<'a>, String> {
    if let (Some(layer), false) = (layer, format == Format::Exr) {
        let layer = layer.escape_debug();
        return Err(format!("is a {} file, which has no layers; only EXR can have `{layer}`", format.name()));
    }
    match format {
        Format::Png => png::open(input, length),
        Format::Exr => openexr::open(input, length, layer),
        Format::Pfm => pfm::open(input, length),
        Format::Tiff => tiff::open(input, length),
        Format::Jpeg | Format::Hdr | Format::WebP | Format::Qoi => decoded::open(format, input, length),
    }
}

/// An image file that is read row by row, from the top. Of PNG (unless interlaced), EXR, PFM and TIFF only some rows are
/// in memory; other formats are decoded whole and held as they store their samples.
pub struct ImageReader {
    path: PathBuf,
    layer: Option<String>,
    format: Format,
    opened: Opened<'static>,
}

impl ImageReader {
    /// Opens the image file `path`. `layer` names a layer of an EXR file that has several.
    ///
    /// # Errors
    /// If the file cannot be read, is no image, or has no such layer. Some faults show only when rows are read.
    pub fn open(path: &Path, layer: Option<&str>) -> Result<Self, ImageError> {
        let (format, input, length) = open_file(path)?;
        let opened = open(format, Box::new(input), length, layer);
        let opened = opened.map_err(|problem| ImageError::new(path, problem))?;
        Ok(Self { path: path.to_owned(), layer: layer.map(str::to_owned), format, opened })
    }

    /// The format of the file's content.
    pub fn format(&self) -> Format {
        self.format
    }

    /// Whether the file holds linear radiance, not codes of sRGB.
    pub fn is_linear(&self) -> bool {
        self.opened.sample.is_linear()
    }

    /// What the file stores per sample, such as `8 bits of sRGB`.
    pub fn samples(&self) -> impl fmt::Display {
        self.opened.sample
    }
}

impl fmt::Debug for ImageReader {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ImageReader")
            .field("path", &self.path)
            .field("format", &self.format)
            .finish_non_exhaustive()
    }
}

impl RowReader for ImageReader {
    fn size(&self) -> [u32; 2] {
        [self.opened.width, self.opened.height]
    }

    fn read(&mut self, pixels: &mut [Rgb]) -> Result<(), String> {
        self.opened.rows.read(pixels).map_err(|problem| ImageError::new(&self.path, problem).to_string())
    }

    fn rewind(&mut self) -> Result<(), String> {
        let size = self.size();
        *self = Self::open(&self.path, self.layer.as_deref()).map_err(|error| error.to_string())?;
        if self.size() == size {
            return Ok(());
        }
        Err(ImageError::new(&self.path, "was replaced by an image of another size while it was read")
            .to_string())
    }
}

/// The format, the bytes and the length of an image file.
pub(super) fn open_file(path: &Path) -> Result<(Format, BufReader<File>, u64), ImageError> {
    let fail = |problem: String| ImageError::new(path, problem);
    let unreadable = |e: io::Error| fail(format!("cannot be read: {}", reason(&e)));
    let (file, length) = input::open(path, "name an image file").map_err(fail)?;
    let mut input = BufReader::new(file);
    let mut start = Vec::new();
    input.by_ref().take(12).read_to_end(&mut start).map_err(unreadable)?;
    input.rewind().map_err(unreadable)?;
    // A file with another beginning is left to the format that its name promises, to say what is wrong.
    let format = Format::of_content(&start)
        .or_else(|| Format::of_extension(path))
        .ok_or_else(|| fail("is no image: neither PNG, JPEG, EXR, PFM, HDR, TIFF, WebP nor QOI".into()))?;
    Ok((format, input, length))
}
