//! A picture in false colours of where two images differ.

use crate::error::{CompareError, check};
use scene::{Film, Rgb, srgb};

/// The difference of two images in the colour map "magma": from black for equal pixels, through red, to pale yellow.
#[derive(Clone, Debug, PartialEq)]
pub struct DifferenceImage {
    /// The picture, made to be written as PNG at exposure 0.
    pub film: Film,
    /// The absolute difference of a pixel's worst channel from which the brightest colour is used.
    pub scale: f32,
}

/// The share of pixels whose difference is within the scale. It is below 1, or one firefly would leave the rest black.
const COVERED: f64 = 0.995;

/// Shows the absolute difference of each pixel's worst channel in false colours.
///
/// # Errors
/// If the images differ in size, have no pixels, or have some that are not finite.
pub fn difference_image(a: &Film, b: &Film) -> Result<DifferenceImage, CompareError> {
    check(a, b)?;
    let worst = |(a, b): (&Rgb, &Rgb)| scene::max_component((*a - *b).abs()).min(f32::MAX);
    let differences: Vec<f32> = a.pixels.iter().zip(&b.pixels).map(worst).collect();
    let scale = scale(&differences);
    let pixels = differences.iter().map(|&d| color(if scale > 0.0 { d / scale } else { 0.0 })).collect();
    Ok(DifferenceImage { film: Film { width: a.width, height: a.height, pixels }, scale })
}

/// The difference that the share [`COVERED`] of the pixels does not exceed; if that is zero, the greatest one.
fn scale(differences: &[f32]) -> f32 {
    let mut sorted = differences.to_vec();
    let rank = ((sorted.len() - 1) as f64 * COVERED).ceil() as usize;
    let (_, &mut covered, rest) = sorted.select_nth_unstable_by(rank, f32::total_cmp);
    if covered > 0.0 { covered } else { rest.iter().copied().fold(0.0, f32::max) }
}

/// The map's colour at `t`, with `t` limited to at most 1, as linear values: encoding as PNG gives the colour back.
fn color(t: f32) -> Rgb {
    let c = colorous::MAGMA.eval_continuous(f64::from(t.min(1.0)));
    Rgb::from_array([c.r, c.g, c.b].map(|byte| srgb::decode_code(byte.into(), 255)))
}

#[cfg(test)]
mod tests {
    use super::*;

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
