//! The colours of FLIP: opponent colours in which images are filtered, and how different two colours look.

use scene::{Rgb, srgb};
use std::sync::LazyLock;

/// Luminance, red-green and blue-yellow: `YCxCz`, which is linear in the light.
pub(super) type Opponent = [f32; 3];

/// XYZ of the white of sRGB (D65), and its inverse.
const WHITE: Opponent = [0.950_428_55, 1.0, 1.088_900_3];
const INVERSE_WHITE: Opponent = [1.052_156_9, 1.0, 0.918_357_7];

const TO_XYZ: [Opponent; 3] = [
    [10_135_552.0 / 24_577_794.0, 8_788_810.0 / 24_577_794.0, 4_435_075.0 / 24_577_794.0],
    [2_613_072.0 / 12_288_897.0, 8_788_810.0 / 12_288_897.0, 887_015.0 / 12_288_897.0],
    [1_425_312.0 / 73_733_382.0, 8_788_810.0 / 73_733_382.0, 70_074_185.0 / 73_733_382.0],
];
const TO_RGB: [Opponent; 3] = [
    [3.241_003_3, -1.537_398_9, -0.498_615_86],
    [-0.969_224_33, 1.875_930_1, 0.041_554_224],
    [0.055_639_423, -0.204_011_2, 1.057_148_9],
];

/// Exponent of colour differences; differences below [`KNEE`] of the largest are stretched to [`KNEE_ERROR`].
const EXPONENT: f32 = 0.7;
const KNEE: f32 = 0.4;
const KNEE_ERROR: f32 = 0.95;

/// The linear light of each 8-bit code of sRGB.
static LIGHT: LazyLock<[f32; 256]> = LazyLock::new(|| {
    std::array::from_fn(|code| {
        let code = code as f32 / 255.0;
        if code <= 0.04045 { code / 12.92 } else { ((code + 0.055) / 1.055).powf(2.4) }
    })
});

/// The largest difference, between green and blue.
static LARGEST: LazyLock<f32> =
    LazyLock::new(|| hyab(hunt_lab([0.0, 1.0, 0.0]), hunt_lab([0.0, 0.0, 1.0])).powf(EXPONENT));

/// The opponent colour of a pixel as an 8-bit sRGB image shows it.
pub(crate) fn from_codes(pixel: Rgb) -> Opponent {
    opponent(pixel.to_array().map(|v| LIGHT[usize::from(srgb::encode_byte(v.into()))]))
}

/// The opponent colour of a pixel that is tone-mapped at `exposure`, in stops.
pub(crate) fn tone_mapped(exposure: f32) -> impl Fn(Rgb) -> Opponent + Copy + Sync {
    /// Far beyond white, and its square is a float.
    const BRIGHTEST: f32 = 1e15;
    let gain = exposure.exp2();
    move |pixel| {
        opponent(pixel.to_array().map(|v| {
            let v = (v.max(0.0) * gain).min(BRIGHTEST);
            let [a, b, c, d, e, f] = ACES;
            ((v * v * a + v * b + c) / (v * v * d + v * e + f)).clamp(0.0, 1.0)
        }))
    }
}

/// Narkowicz's fit of the ACES curve, `(a v^2 + b v + c) / (d v^2 + e v + f)`, as FLIP scales it.
pub(super) const ACES: [f32; 6] = [0.6 * 0.6 * 2.51, 0.6 * 0.03, 0.0, 0.6 * 0.6 * 2.43, 0.6 * 0.59, 0.14];

fn opponent(light: [f32; 3]) -> Opponent {
    let [x, y, z] = times(product(&TO_XYZ, light), INVERSE_WHITE);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// How different two opponent colours look, in [0, 1].
pub(super) fn difference(a: Opponent, b: Opponent) -> f32 {
    let [a, b] = [a, b].map(|color| hunt_lab(shown(color)));
    let (difference, largest) = (hyab(a, b).powf(EXPONENT), *LARGEST);
    let knee = KNEE * largest;
    if difference < knee {
        difference * (KNEE_ERROR / knee)
    } else {
        KNEE_ERROR + ((difference - knee) / (largest - knee)) * (1.0 - KNEE_ERROR)
    }
}

/// The light of an opponent colour, as far as a screen shows it.
fn shown([y, x, z]: Opponent) -> [f32; 3] {
    let y = (y + 16.0) / 116.0;
    let xyz = times([y + x / 500.0, y, y - z / 200.0], WHITE);
    product(&TO_RGB, xyz).map(|v| v.clamp(0.0, 1.0))
}

/// CIELAB, with chroma less in dark colours (the Hunt effect).
fn hunt_lab(light: [f32; 3]) -> Opponent {
    const DELTA: f32 = 6.0 / 29.0;
    let f = |t: f32| {
        if t > DELTA * DELTA * DELTA { t.powf(1.0 / 3.0) } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 }
    };
    let [x, y, z] = times(product(&TO_XYZ, light), INVERSE_WHITE).map(f);
    let lightness = 116.0 * y - 16.0;
    let chroma = 0.01 * lightness;
    [lightness, chroma * (500.0 * (x - y)), chroma * (200.0 * (y - z))]
}

/// The distance `HyAB`: of lightness, plus of chroma.
fn hyab([la, aa, ba]: Opponent, [lb, ab, bb]: Opponent) -> f32 {
    (la - lb).abs() + ((aa - ab) * (aa - ab) + (ba - bb) * (ba - bb)).sqrt()
}

fn product(matrix: &[Opponent; 3], v: Opponent) -> Opponent {
    matrix.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

fn times(a: Opponent, b: Opponent) -> Opponent {
    std::array::from_fn(|i| a[i] * b[i])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_of_lightness_and_of_chroma() {
        assert_eq!(hyab([5.0, 0.0, 0.0], [2.0, 3.0, 4.0]), 8.0);
        assert_eq!(hyab([2.0, 3.0, 4.0], [5.0, 0.0, 0.0]), 8.0);
        assert_eq!(hyab([1.0, -2.0, 3.0], [1.0, -2.0, 3.0]), 0.0);
        assert_eq!(
            product(&[[1.0, 2.0, 3.0], [0.0, 1.0, 0.0], [0.0, 0.0, 4.0]], [1.0, 10.0, 100.0]),
            [321.0, 10.0, 400.0]
        );
        assert_eq!(times([1.0, 2.0, 3.0], [4.0, 5.0, 6.0]), [4.0, 10.0, 18.0]);
    }

    /// White, black and grey have no chroma; white has a lightness of 100, and black of 0.
    #[test]
    fn greys_have_lightness_alone() {
        for (grey, lightness) in [(1.0, 100.0), (0.0, 0.0), (0.184_187, 50.0), (0.008, 7.226)] {
            let [l, a, b] = hunt_lab([grey; 3]);
            assert!(
                (l - lightness).abs() < 0.01 && a.abs() < 0.01 && b.abs() < 0.01,
                "{grey}: {l}, {a}, {b}"
            );
        }
    }
}
