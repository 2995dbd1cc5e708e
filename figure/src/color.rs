//! Colours: names and `#rrggbb`, palettes for what has names, and maps for what has values.

use glam::Vec3;
use scene::Rgb;
use scene::srgb;
use std::fmt;

/// A colour of a screen: codes of sRGB.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Screen(pub [u8; 3]);

/// White matte particles reflect this share of the light. The rest leaves room for lamps that come on top of a white
/// surrounding, so that white particles differ from it.
pub const WHITE: f32 = 0.6;
/// Colours that have a name.
const NAMED: [(&str, [u8; 3]); 12] = [
    ("white", [255, 255, 255]),
    ("silver", [192, 192, 192]),
    ("grey", [128, 128, 128]),
    ("black", [0, 0, 0]),
    ("red", [214, 39, 40]),
    ("orange", [255, 127, 14]),
    ("yellow", [240, 200, 40]),
    ("green", [44, 140, 60]),
    ("teal", [23, 150, 160]),
    ("blue", [31, 119, 180]),
    ("purple", [130, 90, 170]),
    ("pink", [227, 119, 194]),
];

impl Screen {
    /// Parses `#rrggbb` or the name of a colour.
    pub fn parse(text: &str) -> Option<Self> {
        if let Some(digits) = text.strip_prefix('#') {
            let is_hexadecimal = digits.len() == 6 && digits.bytes().all(|b| b.is_ascii_hexdigit());
            let code = u32::from_str_radix(digits, 16).ok().filter(|_| is_hexadecimal)?;
            let [_, r, g, b] = code.to_be_bytes();
            return Some(Self([r, g, b]));
        }
        let name = if text == "gray" { "grey" } else { text };
        NAMED.iter().find(|(known, _)| *known == name).map(|&(_, codes)| Self(codes))
    }

    /// The names of colours, for messages.
    pub fn names() -> impl Iterator<Item = &'static str> {
        NAMED.iter().map(|(name, _)| *name)
    }

    /// The nearest codes for values in [0, 1].
    pub fn of_values(values: [f32; 3]) -> Self {
        Self(values.map(|v| (v * 255.0).round() as u8)) // saturates; 0 for NaN
    }

    /// Linear light.
    pub fn linear(self) -> Rgb {
        Vec3::from_array(self.0.map(|code| srgb::decode_code(u16::from(code), 255)))
    }
}

impl fmt::Display for Screen {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [r, g, b] = self.0;
        write!(f, "#{r:02x}{g:02x}{b:02x}")
    }
}

/// What has names is coloured by these in turn (Tableau 10).
pub fn palette(i: usize) -> Screen {
    let colors = colorous::TABLEAU10;
    of_colorous(colors[i % colors.len()])
}

/// A map from [0, 1] to colours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Map {
    /// Dark blue over green to yellow: even in lightness, for those who confuse red and green as well.
    #[default]
    Viridis,
    /// Dark blue to yellow, for all kinds of colour vision.
    Cividis,
    /// Black over red to pale yellow.
    Inferno,
    /// Black over purple to pale yellow.
    Magma,
    /// Blue over pink to yellow.
    Plasma,
    /// Blue over white to red, for values about a middle.
    Coolwarm,
    /// Grey from black to white.
    Grey,
}

impl Map {
    /// All maps.
    pub const ALL: [Self; 7] =
        [Self::Viridis, Self::Cividis, Self::Inferno, Self::Magma, Self::Plasma, Self::Coolwarm, Self::Grey];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Viridis => "viridis",
            Self::Cividis => "cividis",
            Self::Inferno => "inferno",
            Self::Magma => "magma",
            Self::Plasma => "plasma",
            Self::Coolwarm => "coolwarm",
            Self::Grey => "grey",
        }
    }

    /// The map called `name`.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|map| map.name() == name)
    }

    /// The colour at `t`, which is clamped to [0, 1]; NaN is shown as [`Map::MISSING`].
    pub fn at(self, t: f64) -> Screen {
        if t.is_nan() {
            return Self::MISSING;
        }
        // Whole codes in equal steps: few materials, and the same on every machine.
        let step = (t.clamp(0.0, 1.0) * f64::from(STEPS - 1)).round() as usize;
        let (gradient, step) = match self {
            Self::Viridis => (colorous::VIRIDIS, step),
            Self::Cividis => (colorous::CIVIDIS, step),
            Self::Inferno => (colorous::INFERNO, step),
            Self::Magma => (colorous::MAGMA, step),
            Self::Plasma => (colorous::PLASMA, step),
            // d3's scale runs from red to blue.
            Self::Coolwarm => (colorous::RED_BLUE, STEPS as usize - 1 - step),
            Self::Grey => return Screen([step as u8; 3]),
        };
        of_colorous(gradient.eval_rational(step, STEPS as usize))
    }

    /// What has no value.
    pub const MISSING: Screen = Screen([255, 0, 255]);
}

/// Colours of a map.
const STEPS: u16 = 256;

fn of_colorous(color: colorous::Color) -> Screen {
    Screen([color.r, color.g, color.b])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_parsed_and_told() {
        assert_eq!(Screen::parse("#0a80ff"), Some(Screen([10, 128, 255])));
        assert_eq!(Screen::parse("#0a80ff").map(|c| c.to_string()).as_deref(), Some("#0a80ff"));
        assert_eq!(Screen::parse("gray"), Screen::parse("grey"));
        for wrong in ["", "#", "#0a80f", "#0a80fff", "#+a80ff", "0a80ff", "reddish", "#0a80é"] {
            assert_eq!(Screen::parse(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn colours_are_made_linear() {
        // Code 188 is half of the light, by the formula of IEC 61966-2-1.
        let linear = Screen([255, 188, 0]).linear();
        assert_eq!((linear.x, linear.z), (1.0, 0.0));
        assert!((linear.y - 0.503).abs() < 1e-3, "{linear}");
    }

    #[test]
    fn after_the_last_colour_of_the_palette_comes_the_first() {
        let colors: Vec<String> = (0..20).map(|i| palette(i).to_string()).collect();
        assert_eq!(colors[..10], colors[10..]);
        assert!((1..10).all(|i| !colors[..i].contains(&colors[i])), "{colors:?}");
    }

    /// The ends of matplotlib's maps, which d3 took over.
    #[test]
    fn maps_are_those_of_their_names() {
        assert_eq!(Map::Viridis.at(0.0), Screen([68, 1, 84]));
        assert_eq!(Map::Viridis.at(1.0), Screen([253, 231, 37]));
        assert_eq!(Map::Inferno.at(-3.0), Map::Inferno.at(0.0));
        assert_eq!(Map::Grey.at(0.5), Screen([128; 3]));
        assert_eq!(Map::Cividis.at(f64::NAN), Map::MISSING);
        let [cold, warm] = [0.0, 1.0].map(|t| Map::Coolwarm.at(t).0);
        assert!(cold[2] > cold[0] && warm[0] > warm[2], "{cold:?} {warm:?}");
        for map in Map::ALL {
            assert_eq!(Map::named(map.name()), Some(map));
            assert!((0..=10).all(|i| map.at(f64::from(i) / 10.0) != Map::MISSING), "{map:?}");
        }
    }
}
