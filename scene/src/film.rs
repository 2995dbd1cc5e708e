//! Film: images in memory, linear `f32`, rows from the top.

use crate::Rgb;
use rayon::prelude::*;
use std::mem::swap;
use std::ops::Range;

/// The integer that stands for a photon's nominal power (see `reference::photon_pass`): fluxes are quantised to
/// multiples of 2^-21 of it, an error of 2^-22 at most.
pub const FLUX_ONE: u32 = 1 << 21;

/// An RGB image of linear radiance.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// `width * height` pixels, row by row from the top, each row from the left.
    pub pixels: Vec<Rgb>,
}

/// An image of one value per pixel, such as the radius or the photon count.
#[derive(Clone, Debug, PartialEq)]
pub struct Plane {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// `width * height` values, row by row from the top, each row from the left.
    pub values: Vec<f32>,
}

/// An image whose pixels are asked for one by one, so that it need not be held in memory: colours, or single values.
#[derive(Clone, Copy)]
pub struct Picture<'a, T> {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// The pixel in column x, from the left, and row y, from the top, both from 0.
    pub pixel: &'a (dyn Fn(u32, u32) -> T + Sync),
}

impl Film {
    /// A black image.
    pub fn new(width: u32, height: u32) -> Self {
        Self { width, height, pixels: vec![Rgb::ZERO; width as usize * height as usize] }
    }
}

impl Plane {
    /// The same value thrice per pixel: a grey film, as image files store it.
    pub fn to_film(&self) -> Film {
        let pixels = self.values.iter().map(|&v| Rgb::splat(v)).collect();
        Film { width: self.width, height: self.height, pixels }
    }
}

/// Bytes of rows that are encoded at once, unless those of one band have more.
const ENCODED_AT_ONCE: usize = 1 << 20;

/// Rows that are encoded together, and columns at a time: the tiles along whose curve `fast` keeps its pixels.
const BAND: usize = 8;

/// Which row of a file is its first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum From {
    Top,
    Bottom,
}

impl<T> Picture<'_, T> {
    /// The pixels of a row, from the left.
    pub(crate) fn row(&self, y: u32) -> impl Iterator<Item = T> {
        (0..self.width).map(move |x| (self.pixel)(x, y))
    }

    /// Encodes every pixel as `N` bytes, and hands whole rows to `write`. All threads share the work on some rows, while
    /// the rows before are written; no more are held.
    pub(crate) fn write_rows<const N: usize, E>(
        &self,
        from: From,
        encode: impl Fn(T) -> [u8; N] + Sync,
        mut write: impl FnMut(&[u8]) -> Result<(), E>,
    ) -> Result<(), E> {
        let height = self.height as usize;
        let at_once = (ENCODED_AT_ONCE / (N * self.width as usize)).max(1).next_multiple_of(BAND);
        let parts = height.div_ceil(at_once);
        let rows = |number| {
            let first = at_once * if from == From::Top { number } else { parts - 1 - number };
            first..height.min(first + at_once)
        };
        let (mut encoded, mut next) = (Vec::new(), Vec::new());
        self.encode_rows(rows(0), from, &encode, &mut next);
        for number in 1..=parts {
            swap(&mut encoded, &mut next);
            rayon::in_place_scope(|scope| {
                if number < parts {
                    scope.spawn(|_| self.encode_rows(rows(number), from, &encode, &mut next));
                }
                write(&encoded)
            })?;
        }
        Ok(())
    }

    /// Encodes rows by all threads.
    fn encode_rows<const N: usize>(
        &self,
        rows: Range<usize>,
        from: From,
        encode: &(impl Fn(T) -> [u8; N] + Sync),
        bytes: &mut Vec<u8>,
    ) {
        let row_bytes = N * self.width as usize;
        bytes.resize(rows.len() * row_bytes, 0);
        let mut bands: Vec<_> = match from {
            From::Top => bytes.chunks_mut(BAND * row_bytes).collect(),
            From::Bottom => bytes.rchunks_mut(BAND * row_bytes).collect(),
        };
        let numbered = bands.par_iter_mut().enumerate();
        numbered.for_each(|(band, bytes)| self.encode_band(rows.start + BAND * band, from, encode, bytes));
    }

    /// Encodes rows from `top` on, as many as there is room for in `bytes`.
    ///
    /// Pixels are asked for along the curve by which `fast` keeps them: row by row memory takes two thirds of the time.
    fn encode_band<const N: usize>(
        &self,
        top: usize,
        from: From,
        encode: &impl Fn(T) -> [u8; N],
        bytes: &mut [u8],
    ) {
        let width = self.width as usize;
        let rows = bytes.len() / (N * width);
        for left in (0..width).step_by(BAND) {
            let places = tile_places().map(|(x, y)| (left + x, y)).filter(|&(x, y)| x < width && y < rows);
            for (x, y) in places {
                let row = if from == From::Top { y } else { rows - 1 - y };
                let code = encode((self.pixel)(x as u32, (top + y) as u32));
                bytes[N * (row * width + x)..][..N].copy_from_slice(&code);
            }
        }
    }
}

/// Columns and rows of the pixels of a tile, as [`crate::sobol::morton`] numbers them.
fn tile_places() -> impl Iterator<Item = (usize, usize)> {
    let gather = |bits: usize| (bits & 1) | ((bits >> 1) & 2) | ((bits >> 2) & 4);
    (0..BAND * BAND).map(move |number| (gather(number), gather(number >> 1)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sobol::morton;

    #[test]
    fn tiles_are_walked_as_they_are_numbered() {
        let numbers = tile_places().map(|(x, y)| morton(x as u32, y as u32));
        assert!(numbers.eq(0..64));
    }

    #[test]
    fn rows_are_written_in_order_whatever_the_size() {
        // Of many parts, the last of which is short; of one part; of one band; of less than a tile; of rows longer than what
        // is encoded at once.
        for (width, height) in [(1024, 601), (40, 27), (13, 8), (3, 5), (1, 1), (140_000, 9)] {
            let pixel = |x, y| (x, y);
            let picture = Picture { width, height, pixel: &pixel };
            let row = |y: u32| (0..width).flat_map(move |x| [x, y]).flat_map(u32::to_le_bytes);
            for from in [From::Top, From::Bottom] {
                let mut written = Vec::new();
                let encode = |(x, y): (u32, u32)| (u64::from(y) << 32 | u64::from(x)).to_le_bytes();
                let write = |rows: &[u8]| std::io::Write::write_all(&mut written, rows);
                picture.write_rows(from, encode, write).unwrap();
                let expected: Vec<u8> = match from {
                    From::Top => (0..height).flat_map(row).collect(),
                    From::Bottom => (0..height).rev().flat_map(row).collect(),
                };
                assert!(written == expected, "{width} x {height}, {from:?}");
            }
        }
    }
}
