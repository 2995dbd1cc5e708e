//! Tone curves: how radiance, which has no upper bound, becomes what a screen shows.
//!
//! All are computed in `f64` by exactly rounded operations and the functions of `libm` in Rust, so that a pixel has the
//! same bytes on every machine.

use scene::rng::{Family, StreamKey};
use scene::{Rgb, srgb};
use serde::{Deserialize, Serialize};
use std::fmt;

/// How radiance becomes what a screen shows, in PNG and JPEG files. Each maps linear radiance, after the exposure, to
/// linear light of a screen in [0, 1], which is then encoded as sRGB.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Tone {
    /// Clamps each channel to [0, 1] and rounds to the nearest code, without dithering: what is below 1 is exact, for
    /// measurements.
    Clamp,
    /// The global operator of Reinhard, Stark, Shirley and Ferwerda, "Photographic Tone Reproduction for Digital Images"
    /// (2002), equation 4, of luminance; colours keep their hue and saturation until a channel reaches 1. The exposure
    /// takes the place of the paper's key.
    Reinhard {
        /// The least luminance that is white, above 0.
        white: f32,
    },
    /// The reference rendering and output transforms of ACES for sRGB screens, as fitted by Stephen Hill (in MJP's Baking
    /// Lab, 2016). Contrasty; middle grey is darkened to a tenth.
    Aces,
    /// AgX by Troy Sobotka (2022), in the minimal form of Benjamin Wrensch (2023), who fitted its curve by a polynomial. Bright
    /// colours fade to white as they do on film.
    #[default]
    Agx,
}

/// The `white` of [`Tone::Reinhard`] if none is asked for: two stops above 1.
pub const USUAL_WHITE: f32 = 4.0;

/// Luminance of linear sRGB (ITU-R BT.709).
const LUMINANCE: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// What is brighter is shown as this, so that squares stay finite.
const BRIGHTEST: f64 = 1e100;

type Matrix = [[f64; 3]; 3];

/// Hill: from linear sRGB to the primaries of ACES, with the reference transform's saturation.
const TO_ACES: Matrix =
    [[0.59719, 0.35458, 0.04823], [0.07600, 0.90834, 0.01566], [0.02840, 0.13383, 0.83777]];
/// Hill: back to linear sRGB, with the output transform's saturation.
const FROM_ACES: Matrix =
    [[1.60475, -0.53108, -0.07367], [-0.10208, 1.10813, -0.00605], [-0.00327, -0.07276, 1.07602]];

/// Wrensch: the inset of AgX.
const INSET: Matrix = [
    [0.842_479_062_253_094, 0.078_433_599_999_999_2, 0.079_223_745_147_764_3],
    [0.042_328_242_261_012_3, 0.878_468_636_469_772, 0.079_166_127_460_543_4],
    [0.042_375_654_905_705_1, 0.078_433_6, 0.879_142_973_793_104],
];
/// Wrensch: the outset of AgX, the inverse of the inset.
const OUTSET: Matrix = [
    [1.196_879_005_120_17, -0.098_020_881_140_136_8, -0.099_029_744_079_720_5],
    [-0.052_896_851_757_456_2, 1.151_903_129_904_17, -0.098_961_176_844_843_3],
    [-0.052_971_635_514_443_8, -0.098_043_450_117_124_1, 1.151_073_672_641_16],
];
/// The logarithms (base 2) of radiance between which the curve of AgX lies.
const STOPS: [f64; 2] = [-12.473_93, 4.026_069];
/// The exponent of the screens that AgX is made for.
const SCREEN: f64 = 2.2;

impl Tone {
    /// The names of all curves, on the command line and in files.
    pub const NAMES: [&str; 4] = ["clamp", "reinhard", "aces", "agx"];

    /// The curve called `name`; `white` is for Reinhard's. `None` if there is none of that name.
    pub fn named(name: &str, white: f32) -> Option<Self> {
        Some(match name {
            "clamp" => Self::Clamp,
            "reinhard" => Self::Reinhard { white },
            "aces" => Self::Aces,
            "agx" => Self::Agx,
            _ => return None,
        })
    }

    /// The name of the curve.
    pub fn name(self) -> &'static str {
        match self {
            Self::Clamp => "clamp",
            Self::Reinhard { .. } => "reinhard",
            Self::Aces => "aces",
            Self::Agx => "agx",
        }
    }

    /// What a screen shows of linear radiance: linear light, within [0, 1].
    pub fn shown(self, radiance: [f64; 3]) -> [f64; 3] {
        self.signal(radiance).map(|v| libm::pow(v, self.exponent()))
    }

    /// The signal that a screen with this curve's [`Self::exponent`] gets for linear radiance, within [0, 1].
    fn signal(self, radiance: [f64; 3]) -> [f64; 3] {
        let light = radiance.map(|v| v.clamp(0.0, BRIGHTEST));
        let signal = match self {
            Self::Clamp => light,
            Self::Reinhard { white } => reinhard(light, white.into()),
            Self::Aces => times(FROM_ACES, times(TO_ACES, light).map(aces_fit)),
            Self::Agx => times(OUTSET, times(INSET, light).map(|v| agx_fit(agx_encoded(v)))),
        };
        signal.map(|v| v.clamp(0.0, 1.0))
    }

    /// The power of the signal that the light of the screen is.
    fn exponent(self) -> f64 {
        if self == Self::Agx { SCREEN } else { 1.0 }
    }
}

impl fmt::Display for Tone {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Reinhard { white } => write!(f, "reinhard, white {white}"),
            other => f.write_str(other.name()),
        }
    }
}

/// Maps radiance to the codes of a PNG or JPEG file.
#[derive(Clone, Debug)]
pub(super) struct Encoder {
    gain: f64,
    tone: Tone,
    /// Dithers, so that smooth gradients show no steps; `None` if codes are rounded.
    dither: Option<Dither>,
}

impl Encoder {
    /// An encoder with an `exposure` in stops. The noise of its dithering follows from `seed`.
    pub(super) fn new(exposure: f32, tone: Tone, seed: u64) -> Self {
        let dither = (tone != Tone::Clamp).then(|| Dither::new(seed, tone.exponent()));
        Self { gain: libm::exp2(exposure.into()), tone, dither }
    }

    /// The codes of the pixel with the given number, row by row, which has no NaN.
    pub(super) fn codes(&self, number: u32, radiance: Rgb) -> [u8; 3] {
        let signal = self.tone.signal(radiance.to_array().map(|v| f64::from(v) * self.gain));
        let Some(dither) = &self.dither else { return signal.map(srgb::encode_byte) };
        let mut noise = dither.key.stream(number);
        signal.map(|v| dither.code(v, noise.next_f32().into()))
    }
}

/// Chooses between the two codes next to a signal at random, so that the signals of the codes have the right mean.
#[derive(Clone, Debug)]
struct Dither {
    key: StreamKey,
    /// The signal of each code of sRGB.
    signals: [f64; 256],
    /// The greatest code whose signal is not above `i / STEPS`: where the search for a code begins.
    first_codes: Box<[u8]>,
}

/// Steps of the signal in [`Dither::first_codes`].
const STEPS: usize = 4096;

impl Dither {
    /// For a screen of this `exponent`.
    fn new(seed: u64, exponent: f64) -> Self {
        let light = |code: usize| srgb::decode_with(code as f64 / 255.0, libm::pow);
        let signals: [f64; 256] = std::array::from_fn(|code| libm::pow(light(code), 1.0 / exponent));
        let not_above = |limit: f64| signals.partition_point(|&signal| signal <= limit) - 1;
        let first_codes = (0..=STEPS).map(|step| not_above(step as f64 / STEPS as f64) as u8).collect();
        Self { key: StreamKey::new(seed, Family::Dither, 0), signals, first_codes }
    }

    /// The code of a `signal` in [0, 1], for uniform `u` in [0, 1). Black and white stay as they are.
    fn code(&self, signal: f64, u: f64) -> u8 {
        let mut code = self.first_codes[(signal * STEPS as f64) as usize];
        while code < u8::MAX && self.signals[usize::from(code) + 1] <= signal {
            code += 1;
        }
        if code == u8::MAX {
            return code;
        }
        let [low, high] = [0, 1].map(|next| self.signals[usize::from(code) + next]);
        code + u8::from(u * (high - low) < signal - low)
    }
}

fn reinhard(light: [f64; 3], white: f64) -> [f64; 3] {
    let luminance: f64 = light.iter().zip(LUMINANCE).map(|(v, weight)| v * weight).sum();
    let scale = (1.0 + luminance / (white * white)) / (1.0 + luminance);
    light.map(|v| v * scale)
}

fn aces_fit(v: f64) -> f64 {
    (v * (v + 0.024_578_6) - 0.000_090_537) / (v * (0.983_729 * v + 0.432_951_0) + 0.238_081)
}

/// The place of `v` on the curve of AgX, in [0, 1].
fn agx_encoded(v: f64) -> f64 {
    let [least, most] = STOPS;
    (libm::log2(v).clamp(least, most) - least) / (most - least)
}

/// The curve of AgX, from its place in [0, 1].
fn agx_fit(x: f64) -> f64 {
    let coefficients = [15.5, -40.14, 31.96, -6.868, 0.4298, 0.1191, -0.002_32];
    coefficients.into_iter().fold(0.0, |sum, coefficient| sum * x + coefficient)
}

fn times(matrix: Matrix, [x, y, z]: [f64; 3]) -> [f64; 3] {
    matrix.map(|[a, b, c]| a * x + b * y + c * z)
}

#[cfg(test)]
mod tests {
    use super::*;

    const CURVES: [Tone; 4] = [Tone::Clamp, Tone::Reinhard { white: USUAL_WHITE }, Tone::Aces, Tone::Agx];

    fn grey(tone: Tone, v: f64) -> f64 {
        let [r, g, b] = tone.shown([v; 3]);
        // Rows of the published matrices add up to 1 but for 2e-4: grey stays grey within a third of a code.
        assert!((r - g).abs() < 1e-3 && (g - b).abs() < 1e-3, "{tone} {v}: {r} {g} {b}");
        g
    }

    #[test]
    fn names_are_read_back() {
        for tone in CURVES {
            assert_eq!(Tone::named(tone.name(), USUAL_WHITE), Some(tone));
            assert_eq!(serde_json::from_str::<Tone>(&serde_json::to_string(&tone).unwrap()).unwrap(), tone);
        }
        assert_eq!(CURVES.map(Tone::name), Tone::NAMES);
        assert_eq!(Tone::named("gamma", 1.0), None);
    }

    /// The paper: `L (1 + L / white^2) / (1 + L)`, which is 1 at the white point and L / (1 + L) far below it.
    #[test]
    fn reinhard_is_equation_4_of_the_paper() {
        let white = |white| Tone::Reinhard { white };
        for (l, w, expected) in [
            (0.18, 4.0, 0.18 * (1.0 + 0.18 / 16.0) / 1.18),
            (1.0, 4.0, 1.0625 / 2.0),
            (2.0, 2.0, 1.0),
            (8.0, 8.0, 1.0),
            (1.0, 1e6, 0.5),
        ] {
            approx::assert_relative_eq!(grey(white(w), l), expected, max_relative = 1e-10);
        }
        // Of colours the luminance counts (Rec. 709).
        for [r, g, b] in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.9, 0.4, 0.1]] {
            let l = 0.2126 * r + 0.7152 * g + 0.0722 * b;
            let expected = [r, g, b].map(|v| v * (1.0 + l / 9.0) / (1.0 + l));
            for (shown, expected) in white(3.0).shown([r, g, b]).into_iter().zip(expected) {
                approx::assert_relative_eq!(shown, expected, max_relative = 1e-10);
            }
        }
        // Colours keep their ratios.
        let [r, g, b] = white(4.0).shown([0.4, 0.2, 0.1]);
        approx::assert_relative_eq!(r / g, 2.0, max_relative = 1e-12);
        approx::assert_relative_eq!(g / b, 2.0, max_relative = 1e-12);
    }

    /// Computed with the published shader's formulas in another language.
    #[test]
    fn aces_is_hills_fit() {
        for (v, expected) in [(0.0, 0.0), (0.18, 0.105_6), (0.5, 0.374_3), (1.0, 0.619_1), (4.0, 0.909_0)] {
            assert!((grey(Tone::Aces, v) - expected).abs() < 5e-4, "{v}: {}", grey(Tone::Aces, v));
        }
        let expected = KNOWN_RED[0];
        for (shown, expected) in Tone::Aces.shown([2.0, 0.2, 0.05]).into_iter().zip(expected) {
            approx::assert_relative_eq!(shown, expected, max_relative = 1e-9);
        }
    }

    /// (2, 0.2, 0.05) by ACES and by AgX, computed with the published shaders' formulas in another language.
    const KNOWN_RED: [[f64; 3]; 2] = [
        [0.976_446_761_068_496_8, 0.198_753_376_292_190_45, 0.045_492_852_601_607_27],
        [0.840_134_970_314_351_6, 0.280_814_266_568_375_5, 0.152_629_578_699_130_33],
    ];

    /// Sobotka's curve: through (0, 0), (1, 1) and its pivot (20/33, 1/2) with slope 2; powers 3 below and 3.25 above.
    fn sobotka(x: f64) -> f64 {
        let pivot = 20.0 / 33.0;
        let d = x - pivot;
        let (power, room) = if d < 0.0 { (3.0, pivot) } else { (3.25, 1.0 - pivot) };
        let scale = ((2.0 * room / 0.5_f64).powf(power) - 1.0) / room.powf(power);
        0.5 + 2.0 * d * (1.0 + scale * d.abs().powf(power)).powf(-1.0 / power)
    }

    #[test]
    fn agx_is_wrenschs_fit_of_sobotkas_curve() {
        assert!((sobotka(0.0)).abs() < 1e-12 && (sobotka(1.0) - 1.0).abs() < 1e-12);
        let square = |i: i32| (agx_fit(f64::from(i) / 1e4) - sobotka(f64::from(i) / 1e4)).powi(2);
        let mean = (0..=10_000).map(square).sum::<f64>() / 1e4;
        // Published: 3.7e-6, against the table that Sobotka's transform has in place of the formula.
        assert!(mean < 1e-5, "{mean}");
        for (v, expected) in [(0.18, 0.214_5), (0.5, 0.425_2), (1.0, 0.590_2), (4.0, 0.861_0)] {
            assert!((grey(Tone::Agx, v) - expected).abs() < 5e-4, "{v}: {}", grey(Tone::Agx, v));
        }
        for (shown, expected) in Tone::Agx.shown([2.0, 0.2, 0.05]).into_iter().zip(KNOWN_RED[1]) {
            approx::assert_relative_eq!(shown, expected, max_relative = 1e-9);
        }
        let identity = INSET.map(|row| times(transposed(OUTSET), row));
        for (i, row) in identity.into_iter().enumerate() {
            for (j, v) in row.into_iter().enumerate() {
                assert!((v - f64::from(u8::from(i == j))).abs() < 1e-12, "{i} {j}: {v}");
            }
        }
    }

    fn transposed(m: Matrix) -> Matrix {
        std::array::from_fn(|i| std::array::from_fn(|j| m[j][i]))
    }

    #[test]
    fn curves_rise_and_stay_in_range_whatever_the_radiance() {
        for tone in CURVES {
            let mut last = 0.0;
            for i in 0..=400 {
                let shown = grey(tone, libm::exp2(f64::from(i) / 10.0 - 20.0));
                // ACES begins at a value below 0, and AgX lies at both ends where its polynomial is not quite flat.
                assert!((last - 1e-3..=1.0).contains(&shown), "{tone} {i}: {shown} after {last}");
                last = shown;
            }
            assert!(last > 0.99, "{tone}: {last}");
            let extremes =
                [0.0, -0.0, -1.0, 1e-300, f64::from(f32::MAX), 1e308, f64::INFINITY, f64::NEG_INFINITY];
            for r in extremes {
                for g in extremes {
                    let shown = tone.shown([r, g, 0.5]);
                    assert!(shown.iter().all(|v| (0.0..=1.0).contains(v)), "{tone} {r} {g}: {shown:?}");
                }
            }
            assert!(grey(tone, 0.0) < 1e-3 && tone.shown([f64::INFINITY; 3])[1] > 0.99, "{tone}");
        }
    }

    #[test]
    fn dithering_has_the_right_mean_and_two_codes() {
        for tone in [Tone::Aces, Tone::Agx] {
            let encoder = Encoder::new(0.0, tone, 7);
            for v in [0.001_f32, 0.01, 0.18, 0.7, 3.0] {
                let exact = 255.0 * srgb::encode(tone.shown([v.into(); 3])[1]);
                let codes: Vec<u8> = (0..1 << 16).map(|i| encoder.codes(i, Rgb::splat(v))[1]).collect();
                assert!(codes.iter().all(|&code| (f64::from(code) - exact).abs() < 1.0), "{tone} {v}");
                let signal = |code: &u8| srgb::decode(f64::from(*code) / 255.0).powf(1.0 / tone.exponent());
                let mean = codes.iter().map(signal).sum::<f64>() / codes.len() as f64;
                let expected = tone.signal([v.into(); 3])[1];
                let step = signal(&(exact as u8 + 1)) - signal(&(exact as u8));
                // Six standard deviations of the mean of as many numbers 0 or 1.
                assert!(
                    (mean - expected).abs() < 6.0 * step * 0.5 / 256.0,
                    "{tone}: {mean} instead of {expected}"
                );
            }
        }
    }

    #[test]
    fn black_white_and_every_exact_code_are_not_dithered() {
        for exponent in [1.0, SCREEN] {
            let dither = Dither::new(1, exponent);
            for u in [0.0, 0.5, 0.999_999] {
                for code in 0..=255 {
                    assert_eq!(dither.code(dither.signals[usize::from(code)], u), code, "{exponent} {u}");
                }
            }
            for signal in [1e-9, 0.3, 0.999_999] {
                assert_eq!(dither.code(signal, 0.0), 1 + dither.code(signal, 0.999_999_999_999), "{signal}");
            }
        }
    }

    /// The same pixel always gets the same codes; another pixel, channel or seed other noise.
    #[test]
    fn dithering_is_a_function_of_seed_pixel_and_channel() {
        let all = |seed| {
            let encoder = Encoder::new(1.0, Tone::Agx, seed);
            (0..4096).map(|i| encoder.codes(i, Rgb::splat(0.2))).collect::<Vec<_>>()
        };
        let (codes, other) = (all(1), all(2));
        assert_eq!(codes, all(1));
        let share = |equal: usize| equal as f64 / 4096.0;
        let [mut seeds, mut neighbours, mut channels] = [0; 3];
        for i in 0..4096 {
            seeds += usize::from(codes[i][0] == other[i][0]);
            neighbours += usize::from(codes[i][0] == codes[(i + 1) % 4096][0]);
            channels += usize::from(codes[i][0] == codes[i][1]);
        }
        for equal in [seeds, neighbours, channels] {
            assert!(share(equal) < 0.95, "{seeds} {neighbours} {channels} of 4096 are equal");
        }
    }

    #[test]
    fn clamping_is_exact_and_not_dithered() {
        let encoder = Encoder::new(0.0, Tone::Clamp, 3);
        for code in 0..=255 {
            let v = srgb::decode_code(code, 255);
            assert_eq!(encoder.codes(u32::from(code), Rgb::splat(v)), [code as u8; 3]);
        }
        assert_eq!(Encoder::new(2.0, Tone::Clamp, 3).codes(0, Rgb::new(0.125, -1.0, 9.0)), [188, 0, 255]);
    }
}
