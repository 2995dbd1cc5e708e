//! Reads two images together, strip by strip, with the rows around each strip that windows reach.

use crate::error::CompareError;
use rayon::prelude::*;
use scene::{Rgb, RowReader};
use std::ops::Range;

/// Rows above and below a strip that are held with it: the reach of the largest window, which is FLIP's.
pub(crate) const HALO: usize = 10;

/// Target size of a strip in pixels. A comparison takes up to 250 bytes for each.
const PIXELS: usize = 1 << 20;
/// A strip has at least this many rows, or too many would be worked on twice; and a multiple of the blocks of metrics.
const FEWEST_ROWS: usize = 32;

/// Rows per strip of images of this width.
pub(crate) fn rows_at_once(width: usize) -> usize {
    (PIXELS / width.max(1)).max(FEWEST_ROWS).next_multiple_of(FEWEST_ROWS)
}

/// Two images of the same size.
pub(crate) struct Pair<'a> {
    pub(crate) a: &'a mut dyn RowReader,
    pub(crate) b: &'a mut dyn RowReader,
}

/// Rows of both images.
pub(crate) struct Strip {
    pub(crate) width: usize,
    /// Rows of the whole images.
    pub(crate) height: usize,
    /// The rows of the strip itself.
    pub(crate) rows: Range<usize>,
    /// The first row that is held.
    top: usize,
    a: Vec<Rgb>,
    b: Vec<Rgb>,
}

impl Pair<'_> {
    /// Width and height of both images.
    pub(crate) fn size(&self) -> Result<[usize; 2], CompareError> {
        let (a, b) = (self.a.size(), self.b.size());
        if a != b {
            return Err(CompareError::Size { a, b });
        }
        let size = a.map(|side| side as usize);
        if size.contains(&0) { Err(CompareError::Empty) } else { Ok(size) }
    }

    /// Passes each strip of `rows_at_once` rows to `see`, from the top, with `halo` rows around it.
    pub(crate) fn for_each_strip(
        &mut self,
        rows_at_once: usize,
        halo: usize,
        mut see: impl FnMut(&Strip) -> Result<(), CompareError>,
    ) -> Result<(), CompareError> {
        let [width, height] = self.size()?;
        let (a, b) = rayon::join(|| self.a.rewind(), || self.b.rewind());
        a.and(b).map_err(CompareError::Unreadable)?;
        let [a, b] = [0; 2].map(|_| Vec::with_capacity(width * height.min(rows_at_once + 2 * halo)));
        let mut strip = Strip { width, height, rows: 0..0, top: 0, a, b };
        while strip.rows.end < height {
            strip.rows = strip.rows.end..height.min(strip.rows.end + rows_at_once);
            self.advance(&mut strip, halo)?;
            see(&strip)?;
        }
        Ok(())
    }

    /// Passes the rows of image B to `see`, from the top, `rows_at_once` at a time, with the number of rows so far.
    pub(crate) fn for_each_strip_of_b(
        &mut self,
        rows_at_once: usize,
        mut see: impl FnMut(&[Rgb], usize),
    ) -> Result<(), CompareError> {
        let [width, height] = self.size()?;
        self.b.rewind().map_err(CompareError::Unreadable)?;
        let mut pixels = Vec::new();
        for top in (0..height).step_by(rows_at_once) {
            let bottom = height.min(top + rows_at_once);
            pixels.resize((bottom - top) * width, Rgb::ZERO);
            self.b.read(&mut pixels).map_err(CompareError::Unreadable)?;
            see(&pixels, bottom);
        }
        Ok(())
    }

    /// Reads the rows that `strip` needs and drops those that it does not.
    fn advance(&mut self, strip: &mut Strip, halo: usize) -> Result<(), CompareError> {
        let top = strip.rows.start.saturating_sub(halo);
        let bottom = strip.height.min(strip.rows.end + halo);
        let passed = (top - strip.top) * strip.width;
        strip.top = top;
        let held = (bottom - top) * strip.width;
        let refill = |reader: &mut dyn RowReader, pixels: &mut Vec<Rgb>| {
            pixels.drain(..passed.min(pixels.len()));
            let known = pixels.len();
            pixels.resize(held, Rgb::ZERO);
            reader.read(&mut pixels[known..])
        };
        let (a, b) = rayon::join(|| refill(self.a, &mut strip.a), || refill(self.b, &mut strip.b));
        a.and(b).map_err(CompareError::Unreadable)
    }
}

impl Strip {
    /// All rows that are held.
    pub(crate) fn held(&self) -> Range<usize> {
        self.top..self.top + self.a.len() / self.width
    }

    /// Row `y` of both images.
    pub(crate) fn row(&self, y: usize) -> [&[Rgb]; 2] {
        [&self.a, &self.b].map(|pixels| &pixels[(y - self.top) * self.width..][..self.width])
    }

    /// The pairs of pixels of row `y`.
    pub(crate) fn pairs(&self, y: usize) -> impl ExactSizeIterator<Item = (Rgb, Rgb)> {
        let [a, b] = self.row(y);
        a.iter().copied().zip(b.iter().copied())
    }

    /// `of` each row that is held, computed on all threads.
    pub(crate) fn map_held<T: Send>(&self, of: impl Fn(usize) -> T + Sync) -> Vec<T> {
        self.held().into_par_iter().map(&of).collect()
    }

    /// `of` each row of the strip, computed on all threads.
    pub(crate) fn map_rows<T: Send>(&self, of: impl Fn(usize) -> T + Sync) -> Vec<T> {
        self.rows.clone().into_par_iter().map(&of).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::BLOCK;

    /// Metrics count blocks from the top of each strip, so a strip that ends within one would cut it in two.
    #[test]
    fn strips_of_any_width_end_where_blocks_do() {
        for width in (0..5000).step_by(37).chain([40_000, 70_001, PIXELS, usize::MAX / 2]) {
            let rows = rows_at_once(width);
            assert!(rows >= FEWEST_ROWS && rows.is_multiple_of(BLOCK), "{rows} rows of {width} pixels");
            assert!(width == 0 || (rows - FEWEST_ROWS) * width < PIXELS, "{rows} rows of {width} pixels");
        }
    }
}
