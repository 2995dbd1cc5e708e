//! Images in memory: linear `f32`, rows from the top.

use crate::color::Rgb;

/// The integer that represents a photon's nominal power (see `reference::photon_pass`). Fluxes are rounded to
/// multiples of 2^-21 of the nominal power, with an error of 2^-22 of it at most.
pub const FLUX_ONE: u32 = 1 << 21;

/// The power that a flux of 1 stands for: `part` of the nominal power, in W. Their product may be too small for an `f32`, so sums of fluxes
/// are multiplied by `part` first, which is a power of two.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FluxUnit {
    /// The nominal power, in W.
    pub nominal: f32,
    /// The flux of 1 over it.
    pub part: f32,
}

impl FluxUnit {
    /// That of photons whose powers are multiplied by `scale` before they are rounded ([`Aim::scale`](crate::aim::Aim::scale)).
    pub fn new(nominal: f32, scale: f32) -> Self {
        Self { nominal, part: 1.0 / (FLUX_ONE as f32 * scale) }
    }
}

/// Added to the divisor of relative square errors, to keep those of black pixels finite. It has the usual value 0.01,
/// the square of a tenth of white. In pixels darker than that the absolute error counts, as it does to the eye.
pub const RELATIVE_MSE_EPSILON: f64 = 0.01;

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

/// An image whose pixels are given when they are asked for, so that it need not be held in memory. Pixels are colours or single
/// values.
#[derive(Clone, Copy)]
pub struct Picture<'a, T> {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// What gives its pixels.
    pub pixel: &'a dyn Pixels<T>,
}

/// What gives the pixels of an image. Any function of column and row does.
pub trait Pixels<T>: Sync {
    /// The pixel in column x, from the left, and row y, from the top, both from 0.
    fn at(&self, x: u32, y: u32) -> T;

    /// The tile whose upper left pixel is in that column and row, if all of it is in the image. To ask for tiles is less work than to
    /// ask for pixels, if what gives them keeps them by tiles.
    fn tile(&self, left: u32, top: u32) -> Tile<T> {
        tile_of(left, top, |x, y| self.at(x, y))
    }
}

impl<T, F: Fn(u32, u32) -> T + Sync> Pixels<T> for F {
    fn at(&self, x: u32, y: u32) -> T {
        self(x, y)
    }
}

/// Rows and columns of a tile.
pub const TILE_SIDE: u32 = 8;

/// The pixels of a tile, along the Z curve: [`TILE_PLACES`] has their places.
pub type Tile<T> = [T; (TILE_SIDE * TILE_SIDE) as usize];

/// A tile, by a function of column and row; its upper left pixel is in column `left` and row `top`.
pub fn tile_of<T>(left: u32, top: u32, pixel: impl Fn(u32, u32) -> T) -> Tile<T> {
    TILE_PLACES.map(|[x, y]| pixel(left + u32::from(x), top + u32::from(y)))
}

/// Column and row of each pixel of a tile: the inverse of [`morton`](crate::sobol::morton).
pub const TILE_PLACES: Tile<[u8; 2]> = {
    let mut places = [[0; 2]; (TILE_SIDE * TILE_SIDE) as usize];
    let mut number = 0;
    while number < places.len() {
        let mut bit = 0;
        while bit < 6 {
            places[number][bit % 2] |= ((number >> bit & 1) as u8) << (bit / 2);
            bit += 1;
        }
        number += 1;
    }
    places
};

/// An image whose rows are read one after another, so that it need not be held in memory.
pub trait RowReader: Send {
    /// Width and height in pixels.
    fn size(&self) -> [u32; 2];

    /// Reads the next rows, from the top. `pixels` holds whole rows, and not more than are left.
    ///
    /// # Errors
    /// If they cannot be read: one line, which names the file.
    fn read(&mut self, pixels: &mut [Rgb]) -> Result<(), String>;

    /// Begins again at the first row.
    ///
    /// # Errors
    /// As for [`Self::read`].
    fn rewind(&mut self) -> Result<(), String>;
}

/// The rows of an image in memory.
#[derive(Clone, Debug)]
pub struct FilmRows<'a> {
    film: &'a Film,
    /// The first pixel that has not been read.
    next: usize,
}

impl<'a> FilmRows<'a> {
    /// The rows of `film`.
    pub fn new(film: &'a Film) -> Self {
        Self { film, next: 0 }
    }
}

impl RowReader for FilmRows<'_> {
    fn size(&self) -> [u32; 2] {
        [self.film.width, self.film.height]
    }

    fn read(&mut self, pixels: &mut [Rgb]) -> Result<(), String> {
        pixels.copy_from_slice(&self.film.pixels[self.next..][..pixels.len()]);
        self.next += pixels.len();
        Ok(())
    }

    fn rewind(&mut self) -> Result<(), String> {
        self.next = 0;
        Ok(())
    }
}

impl Film {
    /// A black image.
    pub fn new(width: u32, height: u32) -> Self {
        Self { width, height, pixels: vec![Rgb::ZERO; width as usize * height as usize] }
    }

    /// The image whose pixel in column x and row y is `pixel(x, y)`.
    pub fn from_fn(width: u32, height: u32, pixel: impl Fn(u32, u32) -> Rgb) -> Self {
        Self { width, height, pixels: row_by_row(width, height, pixel) }
    }
}

impl Plane {
    /// The image whose value in column x and row y is `value(x, y)`.
    pub fn from_fn(width: u32, height: u32, value: impl Fn(u32, u32) -> f32) -> Self {
        Self { width, height, values: row_by_row(width, height, value) }
    }

    /// A grey film, with each value in all three channels, as image files store it.
    pub fn to_film(&self) -> Film {
        let pixels = self.values.iter().map(|&v| Rgb::splat(v)).collect();
        Film { width: self.width, height: self.height, pixels }
    }
}

fn row_by_row<T>(width: u32, height: u32, pixel: impl Fn(u32, u32) -> T) -> Vec<T> {
    let mut pixels = Vec::with_capacity(width as usize * height as usize);
    for y in 0..height {
        pixels.extend((0..width).map(|x| pixel(x, y)));
    }
    pixels
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sobol::morton;

    #[test]
    fn tiles_go_along_the_z_curve() {
        let numbers = tile_of(16, 8, |x, y| morton(x - 16, y - 8));
        assert!(numbers.into_iter().eq(0..64));
        assert_eq!(Pixels::tile(&|x: u32, y: u32| (x, y), 4, 5), tile_of(4, 5, |x, y| (x, y)));
    }

    fn numbered() -> Film {
        Film::from_fn(3, 2, |x, y| Rgb::new(x as f32, y as f32, 7.0))
    }

    #[test]
    fn rows_are_read_one_after_another_and_again() {
        let film = numbered();
        let mut rows = FilmRows::new(&film);
        assert_eq!(rows.size(), [3, 2]);
        for _ in 0..2 {
            let mut pixels = [Rgb::ZERO; 3];
            for y in 0..2 {
                rows.read(&mut pixels).unwrap();
                assert_eq!(pixels, film.pixels[3 * y..][..3]);
            }
            rows.rewind().unwrap();
        }
        let mut whole = [Rgb::ZERO; 6];
        rows.read(&mut whole).unwrap();
        assert_eq!(whole[..], film.pixels);
    }

    #[test]
    fn pixels_are_row_by_row_from_the_top() {
        let film = numbered();
        assert_eq!((film.width, film.height, film.pixels.len()), (3, 2, 6));
        assert_eq!((film.pixels[2], film.pixels[3]), (Rgb::new(2.0, 0.0, 7.0), Rgb::new(0.0, 1.0, 7.0)));
        let plane = Plane::from_fn(3, 2, |x, y| (10 * y + x) as f32);
        assert_eq!(
            (plane.width, plane.height, &plane.values[..]),
            (3, 2, &[0.0, 1.0, 2.0, 10.0, 11.0, 12.0][..])
        );
        assert_eq!(plane.to_film(), Film::from_fn(3, 2, |x, y| Rgb::splat((10 * y + x) as f32)));
        assert_eq!(Film::new(3, 2), Film::from_fn(3, 2, |_, _| Rgb::ZERO));
    }
}
