//! Computes and encodes the rows of an image on all threads, a few bands of rows at a time, so that the whole image is
//! never in memory.

use rayon::current_num_threads;
use rayon::prelude::*;
use scene::Picture;
use scene::film::{TILE_PLACES, TILE_SIDE};
use std::mem::swap;
use std::ops::Range;

/// Target size of the rows that are encoded at once, in bytes; at least one band per thread is.
const ENCODED_AT_ONCE: usize = 1 << 17;

/// Rows of a band: those of a tile, as bands are encoded by tiles.
const BAND: usize = TILE_SIDE as usize;

/// Which row of the image comes first in the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum First {
    Top,
    Bottom,
}

/// The rows of an image, for encoders.
#[derive(Clone, Copy)]
pub(super) struct Rows<'a, 'b, T>(pub(super) &'b Picture<'a, T>);

impl<T> Rows<'_, '_, T> {
    /// The pixels of a row, from the left.
    pub(super) fn row(self, y: u32) -> impl Iterator<Item = T> {
        (0..self.0.width).map(move |x| self.0.pixel.at(x, y))
    }

    /// Encodes every pixel as `N` bytes and passes whole rows to `write`. While one group of rows is written, all
    /// threads encode the next one; only these two are in memory.
    pub(super) fn write<const N: usize, E>(
        &self,
        first: First,
        encode: impl Fn(T) -> [u8; N] + Sync,
        mut write: impl FnMut(&[u8]) -> Result<(), E>,
    ) -> Result<(), E> {
        let height = self.0.height as usize;
        let fitting = ENCODED_AT_ONCE / (N * self.0.width as usize);
        let at_once = fitting.next_multiple_of(BAND).max(BAND * current_num_threads());
        let parts = height.div_ceil(at_once);
        let rows = |number| {
            let begin = at_once * if first == First::Top { number } else { parts - 1 - number };
            begin..height.min(begin + at_once)
        };
        let (mut encoded, mut next) = (Vec::new(), Vec::new());
        self.encode_all(rows(0), first, &encode, &mut next);
        for number in 1..=parts {
            swap(&mut encoded, &mut next);
            rayon::in_place_scope(|scope| {
                if number < parts {
                    scope.spawn(|_| self.encode_all(rows(number), first, &encode, &mut next));
                }
                write(&encoded)
            })?;
        }
        Ok(())
    }

    /// Encodes rows on all threads.
    fn encode_all<const N: usize>(
        &self,
        rows: Range<usize>,
        first: First,
        encode: &(impl Fn(T) -> [u8; N] + Sync),
        bytes: &mut Vec<u8>,
    ) {
        let row_bytes = N * self.0.width as usize;
        bytes.resize(rows.len() * row_bytes, 0);
        let mut bands: Vec<_> = match first {
            First::Top => bytes.chunks_mut(BAND * row_bytes).collect(),
            First::Bottom => bytes.rchunks_mut(BAND * row_bytes).collect(),
        };
        let numbered = bands.par_iter_mut().enumerate();
        numbered.for_each(|(band, bytes)| self.encode_band(rows.start + BAND * band, first, encode, bytes));
    }

    /// Encodes rows from `top` on, as many as fit into `bytes`.
    ///
    /// By tiles, as `fast` keeps pixels: row by row, memory accesses would take two thirds of the time.
    fn encode_band<const N: usize>(
        &self,
        top: usize,
        first: First,
        encode: &impl Fn(T) -> [u8; N],
        bytes: &mut [u8],
    ) {
        let width = self.0.width as usize;
        let rows = bytes.len() / (N * width);
        let mut put = |x: usize, y: usize, pixel: T| {
            let row = if first == First::Top { y } else { rows - 1 - y };
            bytes[N * (row * width + x)..][..N].copy_from_slice(&encode(pixel));
        };
        for left in (0..width).step_by(BAND) {
            if left + BAND <= width && rows == BAND {
                let tile = self.0.pixel.tile(left as u32, top as u32);
                for ([x, y], pixel) in TILE_PLACES.into_iter().zip(tile) {
                    put(left + usize::from(x), usize::from(y), pixel);
                }
                continue;
            }
            for (x, y) in (0..rows).flat_map(|y| (left..width.min(left + BAND)).map(move |x| (x, y))) {
                put(x, y, self.0.pixel.at(x as u32, (top + y) as u32));
            }
        }
    }
}

/// What `code` gives for all pixels of an image as large as `picture`, computed on all threads.
pub(super) fn collected<T, U: Send>(picture: &Picture<T>, code: impl Fn(u32, u32) -> U + Sync) -> Vec<U> {
    let Picture { width, height, .. } = *picture;
    let code = &code;
    (0..height).into_par_iter().flat_map_iter(|y| (0..width).map(move |x| code(x, y))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_written_in_order_whatever_the_size() {
        // Several groups of rows, the last of them short; one group; one band; less than a tile; one pixel; rows
        // longer than what is encoded at once.
        for (width, height) in [(1024, 601), (40, 27), (13, 8), (3, 5), (1, 1), (140_000, 9)] {
            let pixel = |x: u32, y: u32| (x, y);
            let picture = Picture { width, height, pixel: &pixel };
            let row = |y: u32| (0..width).flat_map(move |x| [x, y]).flat_map(u32::to_le_bytes);
            for first in [First::Top, First::Bottom] {
                let mut written = Vec::new();
                let encode = |(x, y): (u32, u32)| (u64::from(y) << 32 | u64::from(x)).to_le_bytes();
                let write = |rows: &[u8]| std::io::Write::write_all(&mut written, rows);
                Rows(&picture).write(first, encode, write).unwrap();
                let expected: Vec<u8> = match first {
                    First::Top => (0..height).flat_map(row).collect(),
                    First::Bottom => (0..height).rev().flat_map(row).collect(),
                };
                assert!(written == expected, "{width} x {height}, {first:?}");
            }
        }
    }
}
