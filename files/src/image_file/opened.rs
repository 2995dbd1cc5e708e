//! An image whose rows a decoder is about to read.

use super::samples::Sample;
use scene::{Film, Rgb};

/// Rows of an image, from the top.
pub(super) trait RowSource: Send {
    /// Reads the next rows; `pixels` holds whole rows and not more than are left.
    fn read(&mut self, pixels: &mut [Rgb]) -> Result<(), String>;
}

/// An image whose pixels are about to be read.
pub(super) struct Opened<'a> {
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) sample: Sample,
    pub(super) rows: Box<dyn RowSource + 'a>,
}

impl Opened<'_> {
    pub(super) fn film(mut self) -> Result<Film, String> {
        let mut film = Film::new(self.width, self.height);
        self.rows.read(&mut film.pixels)?;
        Ok(film)
    }
}
