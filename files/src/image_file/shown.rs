//! What PNG and JPEG show of an image: 8 bits of sRGB, after exposure and tone curve.

use super::encoding::Encoding;
use super::rows::Rows;
use super::tone::Encoder;
use scene::{Picture, Rgb, Rgba};

/// The colour of a pixel with a NaN: magenta, because it is easily noticed.
const NOT_A_NUMBER: [u8; 3] = [255, 0, 255];

/// The codes of the pixel in a column and a row of `picture`.
pub(super) fn codes<'a>(
    picture: &'a Picture<Rgb>,
    encoding: &Encoding,
) -> impl Fn(u32, u32) -> [u8; 3] + Sync + use<'a> {
    let encoder = Encoder::new(encoding.exposure, encoding.tone, encoding.seed);
    move |x, y| {
        let pixel = picture.pixel.at(x, y);
        if pixel.is_nan() { NOT_A_NUMBER } else { encoder.codes(y * picture.width + x, pixel) }
    }
}

/// The codes of the pixel in a column and a row of `picture`, and of its alpha: the colour of what covers the pixel, and how
/// much of it that is.
pub(super) fn codes_with_alpha<'a>(
    picture: &'a Picture<Rgba>,
    encoding: &Encoding,
) -> impl Fn(u32, u32) -> [u8; 4] + Sync + use<'a> {
    let encoder = Encoder::new(encoding.exposure, encoding.tone, encoding.seed);
    move |x, y| {
        let Rgba { color, alpha } = picture.pixel.at(x, y);
        if color.is_nan() || alpha.is_nan() {
            let [r, g, b] = NOT_A_NUMBER;
            return [r, g, b, u8::MAX];
        }
        let opacity = (alpha.clamp(0.0, 1.0) * f32::from(u8::MAX)).round() as u8;
        if opacity == 0 {
            return [0; 4];
        }
        let [r, g, b] = encoder.codes(y * picture.width + x, color / alpha);
        [r, g, b, opacity]
    }
}

/// The greatest finite value, which is shown as white; 1 if none is positive.
pub(super) fn greatest(values: &Picture<f32>) -> f32 {
    let all = (0..values.height).flat_map(|y| Rows(values).row(y));
    let greatest = all.filter(|v| v.is_finite()).fold(0.0, f32::max);
    if greatest > 0.0 { greatest } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::super::tone::Tone;
    use super::*;
    use scene::film::Pixels;

    fn picture<T>(pixel: &dyn Pixels<T>) -> Picture<'_, T> {
        Picture { width: 3, height: 2, pixel }
    }

    #[test]
    fn what_is_no_number_is_shown_at_once() {
        let pixel = |x, _| Rgb::new(1.0, if x == 1 { f32::NAN } else { 0.0 }, 0.0);
        let picture = picture(&pixel);
        let codes = codes(&picture, &Encoding::default());
        assert_eq!([codes(0, 0), codes(1, 0), codes(2, 1)], [[255, 0, 0], NOT_A_NUMBER, [255, 0, 0]]);
    }

    /// The colour is that of what covers the pixel, which may have been scaled by its share.
    #[test]
    fn colours_are_those_of_what_covers_a_pixel() {
        let shown = |color, alpha| {
            let pixel = |_, _| Rgba { color, alpha };
            codes_with_alpha(&picture(&pixel), &Encoding::default())(0, 0)
        };
        assert_eq!(shown(Rgb::X * 0.25, 0.25), [255, 0, 0, 64]);
        assert_eq!(shown(Rgb::X, 1.0), [255, 0, 0, 255]);
        assert_eq!(shown(Rgb::X, 0.001), [0; 4]);
        assert_eq!(shown(Rgb::X, -0.1), [0; 4]);
        assert_eq!(shown(Rgb::ONE * 1.1, 1.1), [255; 4]);
        assert_eq!(shown(Rgb::ONE, f32::NAN), [255, 0, 255, 255]);
        assert_eq!(shown(Rgb::Y * f32::NAN, 0.0), [255, 0, 255, 255]);
    }

    /// What covers its pixel whole is shown as in an image without alpha.
    #[test]
    fn alpha_changes_neither_exposure_nor_curve() {
        let color = |x: u32, y: u32| Rgb::new(0.1, 0.02 * x as f32, 0.3) * (1 + y) as f32;
        let opaque = |x, y| Rgba { color: color(x, y), alpha: 1.0 };
        let encoding = Encoding { exposure: 1.5, tone: Tone::Agx, seed: 9, note: None };
        let (plain, with_alpha) = (picture(&color), picture(&opaque));
        let (codes, with_alpha) = (codes(&plain, &encoding), codes_with_alpha(&with_alpha, &encoding));
        for (x, y) in (0..2).flat_map(|y| (0..3).map(move |x| (x, y))) {
            let [r, g, b] = codes(x, y);
            assert_eq!(with_alpha(x, y), [r, g, b, 255], "({x}, {y})");
        }
    }

    #[test]
    fn the_greatest_value_that_is_finite_is_white() {
        let of = |values: [f32; 6]| greatest(&picture(&|x, y| values[(3 * y + x) as usize]));
        assert_eq!(of([0.0, 2.0, 1.0, 0.5, 4.0, 3.0]), 4.0);
        assert_eq!(of([f32::INFINITY, f32::NAN, 0.0, -1.0, 0.25, 0.0]), 0.25);
        assert_eq!(of([0.0, -1.0, 0.0, -0.0, f32::NAN, 0.0]), 1.0);
    }
}
