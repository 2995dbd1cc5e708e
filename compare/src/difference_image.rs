//! A picture in false colours of where two images differ.

use crate::error::CompareError;
use crate::finite::Finite;
use crate::metrics::Progress;
use crate::rank::Coarse;
use crate::strips::{Pair, rows_at_once};
use scene::{Film, FilmRows, Rgb, RowReader, srgb};
use std::array;

/// The difference of two images in the colour map "magma": from black for equal pixels, through red, to pale yellow.
#[derive(Clone, Debug, PartialEq)]
pub struct DifferenceImage {
    /// The picture, made to be written as PNG at exposure 0.
    pub film: Film,
    /// The absolute difference of a pixel's worst channel from which the brightest colour is used.
    pub scale: f32,
}

/// The same as a byte per pixel, for images that are too large for a film.
#[derive(Clone, Debug, PartialEq)]
pub struct DifferenceMap {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// As in [`DifferenceImage`].
    pub scale: f32,
    /// The number of the colour of each pixel, row by row.
    codes: Vec<u8>,
    colors: [Rgb; COLORS],
}

/// The number of colours of the map.
const COLORS: usize = 256;

/// The share of pixels whose difference is within the scale. It is below 1, or one firefly would leave the rest black.
const COVERED: f64 = 0.995;

/// Shows the absolute difference of each pixel's worst channel in false colours.
///
/// # Errors
/// If the images differ in size, have no pixels, or have some that are not finite.
pub fn difference_image(a: &Film, b: &Film) -> Result<DifferenceImage, CompareError> {
    let map = DifferenceMap::of_rows(&mut FilmRows::new(a), &mut FilmRows::new(b), &mut |_, _| {})?;
    let film = Film::from_fn(map.width, map.height, |x, y| map.color(x, y));
    Ok(DifferenceImage { film, scale: map.scale })
}

impl DifferenceMap {
    /// Maps the differences of images of which only some rows are held in memory. They are read three times.
    ///
    /// # Errors
    /// Like [`difference_image`], and if an image cannot be read.
    pub fn of_rows(
        a: &mut dyn RowReader,
        b: &mut dyn RowReader,
        progress: Progress,
    ) -> Result<Self, CompareError> {
        let mut pair = Pair { a, b };
        let [width, height] = pair.size()?;
        let mut finite = Finite::default();
        let mut pass = |number: usize, see: &mut dyn FnMut(f32)| {
            pair.for_each_strip(rows_at_once(width), 0, |strip| {
                finite.add(strip);
                for row in strip.map_rows(|y| strip.pairs(y).map(|(p, q)| worst(p, q)).collect::<Vec<_>>()) {
                    row.into_iter().for_each(&mut *see);
                }
                progress((number * height + strip.rows.end) as u64, 3 * height as u64);
                Ok(())
            })?;
            finite.check()
        };
        let mut coarse = Coarse::new();
        pass(0, &mut |v| coarse.add(v))?;
        let rank = ((coarse.count - 1) as f64 * COVERED).ceil() as u64;
        let mut fine = coarse.refine([rank]);
        pass(1, &mut |v| fine.add(v))?;
        let covered = fine.value(rank);
        let scale = if covered > 0.0 { covered } else { coarse.greatest };
        let mut codes = Vec::with_capacity(width * height);
        pass(2, &mut |v| codes.push(code(if scale > 0.0 { v / scale } else { 0.0 })))?;
        Ok(Self { width: width as u32, height: height as u32, scale, codes, colors: colors() })
    }

    /// The colour of a pixel, as linear values: encoding as PNG gives the map's colour back.
    pub fn color(&self, x: u32, y: u32) -> Rgb {
        self.colors[usize::from(self.codes[y as usize * self.width as usize + x as usize])]
    }
}

/// The absolute difference of the worst channel.
fn worst(p: Rgb, q: Rgb) -> f32 {
    scene::max_component((p - q).abs()).min(f32::MAX)
}

/// The number of the colour for `t`, with `t` limited to at most 1.
fn code(t: f32) -> u8 {
    (t * 255.0).round() as u8
}

fn colors() -> [Rgb; COLORS] {
    array::from_fn(|code| {
        let c = colorous::MAGMA.eval_continuous(code as f64 / 255.0);
        Rgb::from_array([c.r, c.g, c.b].map(|byte| srgb::decode_code(byte.into(), 255)))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn color(t: f32) -> Rgb {
        colors()[usize::from(code(t))]
    }

    fn row(values: &[f32]) -> Film {
        Film {
            width: values.len() as u32,
            height: 1,
            pixels: values.iter().map(|&v| Rgb::new(0.0, v, 0.0)).collect(),
        }
    }

    #[test]
    fn alike_is_the_darkest_colour_and_the_scale_the_brightest() {
        let d = difference_image(&row(&[1.0, 2.0, 3.0]), &row(&[1.0, 4.0, 2.0])).unwrap();
        assert_eq!(d.scale, 2.0);
        assert_eq!(d.film.pixels, [color(0.0), color(1.0), color(0.5)]);
        let byte = |p: Rgb| p.to_array().map(|v| srgb::encode_byte(f64::from(v)));
        assert_eq!(byte(color(0.0)), [0, 0, 4]);
        assert_eq!(byte(color(7.0)), [252, 253, 191]);
    }

    #[test]
    fn identical_images_have_scale_zero() {
        let d = difference_image(&row(&[1.0, 2.0]), &row(&[1.0, 2.0])).unwrap();
        assert_eq!((d.scale, d.film.pixels), (0.0, vec![color(0.0); 2]));
    }

    #[test]
    fn a_firefly_does_not_set_the_scale_unless_it_is_all_there_is() {
        let mut values = vec![1.0; 1000];
        values[17] = 1e6;
        assert_eq!(difference_image(&row(&values), &row(&[0.0; 1000])).unwrap().scale, 1.0);
        assert_eq!(difference_image(&row(&values), &row(&[1.0; 1000])).unwrap().scale, 1e6 - 1.0);
    }

    #[test]
    fn differences_beyond_the_range_of_floats_are_held() {
        let d = difference_image(&row(&[f32::MAX]), &row(&[f32::MIN])).unwrap();
        assert_eq!((d.scale, d.film.pixels), (f32::MAX, vec![color(1.0)]));
    }
}
