//! Rules of a style: for which particles, and what they set. Each is a list of keys with values, all of them texts, in
//! scene files and on the command line.

use crate::color::{Map, Screen};
use crate::selection::Selection;
use scene::check::MAX_IOR;
use std::fmt;

/// A rule. What it does not set stays as rules before it have made it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rule {
    /// Which particles it is for; all of them if there is none.
    pub only: Option<Selection>,
    /// Where radii come from.
    pub radius: Option<Radius>,
    /// Multiplies the radius, be it of this rule or of one before.
    pub scale: Option<f64>,
    /// Where colours come from.
    pub color: Option<Paint>,
    /// The colours of values.
    pub map: Option<Map>,
    /// The values at both ends of the map; the least and the greatest if there is none.
    pub range: Option<Range>,
    /// What the surface is.
    pub material: Option<Finish>,
    /// Whether particles are left out.
    pub hide: Option<bool>,
}

/// Where radii come from. Lengths are in the unit of the file.
#[derive(Clone, Debug, PartialEq)]
pub enum Radius {
    /// Van der Waals radii of elements.
    VanDerWaals,
    /// Covalent radii of elements.
    Covalent,
    /// Half the median distance of nearest neighbours, for all alike.
    Touch,
    /// A numeric column; `radius` is the file's own.
    Column(String),
    /// A length.
    Constant(f64),
}

/// Where colours come from.
#[derive(Clone, Debug, PartialEq)]
pub enum Paint {
    /// The colours of elements as Jmol has them.
    Jmol,
    /// The colours of elements by Corey, Pauling and Koltun.
    Cpk,
    /// The file's own.
    File,
    /// A column: by a palette what has names (and molecules), by a map what has values.
    Column(String),
    /// One for all.
    Constant(Screen),
}

/// What a surface is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Finish {
    /// Reflects equally in all directions.
    Matte,
    /// A mirror.
    Mirror,
    /// Glass with this index of refraction.
    Glass(f32),
    /// A lamp, whose radiance is its colour times this.
    Light(f32),
}

/// An end of a range of values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum End {
    /// A value.
    Value(f64),
    /// The value that this share in percent of all values does not exceed.
    Percentile(f64),
}

/// The values at both ends of a map of colours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range(pub End, pub End);

/// The index of refraction of glass if none is given.
const GLASS: f32 = 1.5;
/// The radiance of lamps if none is given: several times what a lit surface has.
const LIGHT: f32 = 4.0;
/// The least and the greatest radiance of a lamp.
const LIGHT_RANGE: [f32; 2] = [1e-6, 1e6];
/// The least and the greatest number that scales a radius.
const SCALE_RANGE: [f64; 2] = [1e-6, 1e6];

impl Rule {
    /// The keys of a rule.
    pub const KEYS: [&str; 8] = ["where", "radius", "scale", "color", "map", "range", "material", "hide"];

    /// Sets `key`, one of [`Self::KEYS`], to what `text` says.
    ///
    /// # Errors
    /// What is wrong with the text, and what would be right.
    pub fn set(&mut self, key: &str, text: &str) -> Result<(), String> {
        let text = text.trim();
        match key {
            "where" => self.only = Some(Selection::parse(text).map_err(|error| error.to_string())?),
            "radius" => self.radius = Some(Radius::parse(text)?),
            "scale" => self.scale = Some(number(text, SCALE_RANGE)?),
            "color" => self.color = Some(Paint::parse(text)?),
            "map" => self.map = Some(map(text)?),
            "range" => self.range = Some(Range::parse(text)?),
            "material" => self.material = Some(Finish::parse(text)?),
            "hide" => self.hide = Some(truth(text)?),
            _ => return Err(format!("there is no `{key}`; the keys are {}", Self::KEYS.join(", "))),
        }
        Ok(())
    }

    /// Parses the rule of a command line: `WHERE: KEY=VALUE, KEY=VALUE`, or without a selection the pairs alone. `hide`
    /// alone is `hide=true`.
    ///
    /// # Errors
    /// What is wrong, and what would be right.
    pub fn parse(text: &str) -> Result<Self, String> {
        let (only, pairs) = match unquoted(text, ':').next() {
            Some(at) => (Some(&text[..at]), &text[at + 1..]),
            None => (None, text),
        };
        let mut rule = Self::default();
        if let Some(only) = only {
            rule.set("where", only)?;
        }
        let ends = unquoted(pairs, ',').chain([pairs.len()]);
        let mut begin = 0;
        for end in ends {
            let pair = &pairs[begin..end];
            begin = (end + 1).min(pairs.len());
            let (key, value) = match pair.split_once('=') {
                Some((key, value)) => (key.trim(), value),
                None if pair.trim() == "hide" => ("hide", "true"),
                None => {
                    return Err(format!(
                        "`{}` is no KEY=VALUE; a rule is such as 'element == \"O\": color=red, scale=0.5' or 'z > 3: hide'",
                        pair.trim()
                    ));
                }
            };
            if key == "where" {
                return Err("a selection stands before a colon, as in 'z > 3: hide'".into());
            }
            rule.set(key, value).map_err(|problem| format!("{key}: {problem}"))?;
        }
        Ok(rule)
    }

    /// The keys that are set, with the texts that set them to what they are.
    pub fn entries(&self) -> Vec<(&'static str, String)> {
        let text = |value: Option<&dyn fmt::Display>| value.map(ToString::to_string);
        let values = [
            text(self.only.as_ref().map(|v| v as _)),
            text(self.radius.as_ref().map(|v| v as _)),
            text(self.scale.as_ref().map(|v| v as _)),
            text(self.color.as_ref().map(|v| v as _)),
            self.map.map(|map| map.name().into()),
            text(self.range.as_ref().map(|v| v as _)),
            text(self.material.as_ref().map(|v| v as _)),
            text(self.hide.as_ref().map(|v| v as _)),
        ];
        Self::KEYS.into_iter().zip(values).filter_map(|(key, value)| Some((key, value?))).collect()
    }

    /// The columns that it reads.
    pub fn columns(&self) -> Vec<&str> {
        let mut names = self.only.as_ref().map_or(Vec::new(), Selection::columns);
        if let Some(Radius::Column(name)) = &self.radius {
            names.push(name);
        }
        if let Some(Paint::Column(name)) = &self.color {
            names.push(name);
        }
        names
    }
}

/// Where `sign` stands in `text`, but for places within quotes.
fn unquoted(text: &str, sign: char) -> impl Iterator<Item = usize> {
    let mut quote = None;
    text.char_indices().filter_map(move |(at, c)| {
        match quote {
            Some(open) if c == open => quote = None,
            None if c == '"' || c == '\'' => quote = Some(c),
            None if c == sign => return Some(at),
            _ => {}
        }
        None
    })
}

/// A number from `low` to `high`.
fn number(text: &str, [low, high]: [f64; 2]) -> Result<f64, String> {
    let value = text.parse::<f64>().ok().filter(|value| (low..=high).contains(value));
    value.ok_or_else(|| format!("`{text}` must be a number from {} to {}", plain(low), plain(high)))
}

/// A bound as it is written in the source: it may have been a single, whose double has many digits.
fn plain(bound: f64) -> String {
    let single = bound as f32;
    if (1e-3..1e6).contains(&bound) { single.to_string() } else { format!("{single:e}") }
}

/// `true` or `false`.
pub(crate) fn truth(text: &str) -> Result<bool, String> {
    text.parse().map_err(|_| format!("`{text}` must be true or false"))
}

/// The name of a column, or a refusal that ends with `right`.
fn column(text: &str, right: &str) -> Result<String, String> {
    let is_name = text.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_');
    if is_name && !text.contains(char::is_whitespace) {
        return Ok(text.into());
    }
    Err(format!("`{text}` is neither {right} nor the name of a column"))
}

fn map(text: &str) -> Result<Map, String> {
    let names = Map::ALL.map(Map::name).join(", ");
    Map::named(text).ok_or_else(|| format!("there is no map `{text}`; the maps are {names}"))
}

impl Radius {
    fn parse(text: &str) -> Result<Self, String> {
        /// The range of radii in scenes is smaller than this by far.
        const RANGE: [f64; 2] = [1e-30, 1e30];
        Ok(match text {
            "vdw" => Self::VanDerWaals,
            "covalent" => Self::Covalent,
            "touch" => Self::Touch,
            _ if text.parse::<f64>().is_ok() => Self::Constant(number(text, RANGE)?),
            _ => Self::Column(column(text, "vdw, covalent, touch, a length")?),
        })
    }
}

impl fmt::Display for Radius {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::VanDerWaals => f.write_str("vdw"),
            Self::Covalent => f.write_str("covalent"),
            Self::Touch => f.write_str("touch"),
            Self::Column(name) => f.write_str(name),
            Self::Constant(length) => write!(f, "{length:?}"),
        }
    }
}

impl Paint {
    fn parse(text: &str) -> Result<Self, String> {
        Ok(match text {
            "jmol" | "element" => Self::Jmol,
            "cpk" => Self::Cpk,
            "file" => Self::File,
            _ if text.starts_with('#') => Self::Constant(
                Screen::parse(text)
                    .ok_or_else(|| format!("`{text}` must be #rrggbb, six hexadecimal digits"))?,
            ),
            _ => match Screen::parse(text) {
                Some(color) => Self::Constant(color),
                None => Self::Column(column(text, "jmol, cpk, file, a colour such as red or #c0ffee")?),
            },
        })
    }
}

impl fmt::Display for Paint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Jmol => f.write_str("jmol"),
            Self::Cpk => f.write_str("cpk"),
            Self::File => f.write_str("file"),
            Self::Column(name) => f.write_str(name),
            Self::Constant(color) => color.fmt(f),
        }
    }
}

impl Finish {
    fn parse(text: &str) -> Result<Self, String> {
        let (name, value) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
        let value = value.trim();
        let within = |default: f32, [low, high]: [f32; 2]| {
            if value.is_empty() {
                Ok(default)
            } else {
                number(value, [low, high].map(f64::from)).map(|v| v as f32)
            }
        };
        match name {
            "glass" => Ok(Self::Glass(within(GLASS, [1.0, MAX_IOR])?)),
            "light" => Ok(Self::Light(within(LIGHT, LIGHT_RANGE)?)),
            "matte" if value.is_empty() => Ok(Self::Matte),
            "mirror" if value.is_empty() => Ok(Self::Mirror),
            _ => Err(format!(
                "there is no material `{text}`; write matte, mirror, glass, glass 1.33 (its index of refraction), light or \
                 light 10 (its radiance)"
            )),
        }
    }
}

impl fmt::Display for Finish {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Matte => f.write_str("matte"),
            Self::Mirror => f.write_str("mirror"),
            Self::Glass(ior) => write!(f, "glass {ior}"),
            Self::Light(radiance) => write!(f, "light {radiance}"),
        }
    }
}

impl Range {
    fn parse(text: &str) -> Result<Self, String> {
        let wrong = || {
            format!(
                "`{text}` must be two numbers or percentiles, the lower first, such as -1..2.5 or 5%..95%"
            )
        };
        let end = |text: &str| -> Option<End> {
            let text = text.trim();
            match text.strip_suffix('%') {
                Some(share) => {
                    share.parse().ok().filter(|share| (0.0..=100.0).contains(share)).map(End::Percentile)
                }
                None => text.parse().ok().filter(|value: &f64| value.is_finite()).map(End::Value),
            }
        };
        let (low, high) = text.split_once("..").ok_or_else(wrong)?;
        let (low, high) = end(low).zip(end(high)).ok_or_else(wrong)?;
        match (low, high) {
            (End::Value(a), End::Value(b)) | (End::Percentile(a), End::Percentile(b)) if a >= b => {
                Err(wrong())
            }
            _ => Ok(Self(low, high)),
        }
    }
}

impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let end = |end: &End| match end {
            End::Value(value) => format!("{value:?}"),
            End::Percentile(share) => format!("{share}%"),
        };
        write!(f, "{}..{}", end(&self.0), end(&self.1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn rules_are_parsed_and_told_again() {
        for (text, entries) in [
            ("hide", vec![("hide", "true")]),
            ("z > 3: hide", vec![("where", "z > 3"), ("hide", "true")]),
            (
                "element == \":,\" and z < 2: color=#FF0000, material = glass 1.33 ,scale=0.5",
                vec![
                    ("where", "element == \":,\" and z < 2"),
                    ("scale", "0.5"),
                    ("color", "#ff0000"),
                    ("material", "glass 1.33"),
                ],
            ),
            (
                "color=c_pe[1], map=inferno, range=-1..2.5, radius=vdw",
                vec![("radius", "vdw"), ("color", "c_pe[1]"), ("map", "inferno"), ("range", "-1.0..2.5")],
            ),
            (
                "radius=1e-10, range=5%..95%, material=light",
                vec![("radius", "1e-10"), ("range", "5%..95%"), ("material", "light 4")],
            ),
            ("range = 1..99%", vec![("range", "1.0..99%")]),
            ("range=0.5%..99.875%", vec![("range", "0.5%..99.875%")]),
        ] {
            let rule = Rule::parse(text).unwrap();
            let expected: Vec<_> = entries.iter().map(|(key, value)| (*key, (*value).to_string())).collect();
            assert_eq!(rule.entries(), expected, "{text}");
            let mut again = Rule::default();
            for (key, value) in rule.entries() {
                again.set(key, &value).unwrap();
            }
            assert_eq!(again, rule, "{text}");
        }
    }

    /// Within quotation marks of one kind the other kind is a sign like all others, however often it is there.
    #[test]
    fn signs_within_quotes_are_of_the_text() {
        for (open, other) in [('"', '\''), ('\'', '"')] {
            for inner in [
                format!("O5{other}"),
                format!("{other}: hide{other}, hide"),
                format!("a{other}, b: c"),
                format!("a: b{other}"),
                format!("{other}{other}{other}: ,="),
                ":".into(),
                String::new(),
            ] {
                let only = format!("name == {open}{inner}{open} and chain != {other}:,{other}");
                let rule = Rule::parse(&format!("{only}: color=red, scale = 2")).unwrap();
                let expected = Rule {
                    only: Some(Selection::parse(&only).unwrap()),
                    color: Some(Paint::parse("red").unwrap()),
                    scale: Some(2.0),
                    ..Rule::default()
                };
                assert_eq!(rule, expected, "{only}");
            }
        }
    }

    proptest! {
        /// Texts that are made of what rules are made of come through most of the parser.
        #[test]
        fn every_text_is_a_rule_that_reads_back_or_refused_with_a_reason(
            parts in prop::collection::vec(prop::sample::select(PARTS.to_vec()), 0..12),
            any in ".{0,20}",
        ) {
            for text in [parts.concat(), any] {
                match Rule::parse(&text) {
                    Err(problem) => prop_assert!(!problem.is_empty()),
                    Ok(rule) => {
                        let mut again = Rule::default();
                        for (key, value) in rule.entries() {
                            prop_assert_eq!(again.set(key, &value), Ok(()), "{} {}", key, value);
                        }
                        prop_assert_eq!(again, rule);
                    }
                }
            }
        }
    }

    const PARTS: [&str; 24] = [
        "z",
        " > ",
        "3",
        "'O'",
        "\"é\"",
        " in ",
        "(",
        ")",
        ",",
        " and ",
        " not ",
        ": ",
        "color=",
        "#0a1b2c",
        "range=",
        "1..2",
        "5%",
        "radius=",
        "1e-3",
        "hide",
        "material=",
        "glass 1.3",
        "light",
        "map=grey",
    ];

    #[test]
    fn bad_rules_are_refused() {
        for (text, expected) in [
            ("", "`` is no KEY=VALUE"),
            ("z > : hide", "column 4: this ends"),
            ("z > 3: hidden", "`hidden` is no KEY=VALUE"),
            ("colour=red", "colour: there is no `colour`; the keys are where, radius"),
            ("color=#12345", "color: `#12345` must be #rrggbb"),
            ("color=3", "color: `3` is neither jmol"),
            ("radius=-1", "radius: `-1` must be a number from 1e-30"),
            ("radius=NaN", "radius: `NaN` must be a number"),
            ("scale=0", "scale: `0` must be a number"),
            ("material=glass 0.5", "material: `0.5` must be a number from 1 to 100"),
            ("material=plastic", "material: there is no material `plastic`"),
            ("map=jet", "map: there is no map `jet`; the maps are viridis"),
            ("range=2..1", "range: `2..1` must be two numbers"),
            // Nothing is between equal ends.
            ("range=1..1", "range: `1..1` must be two numbers"),
            ("range=50%..50%", "range: `50%..50%` must be two numbers"),
            ("range=0%..101%", "range: `0%..101%` must be"),
            ("range=3", "range: `3` must be"),
            ("hide=yes", "hide: `yes` must be true or false"),
            ("where=z > 3", "a selection stands before a colon"),
        ] {
            let error = Rule::parse(text).unwrap_err();
            assert!(error.starts_with(expected), "{text}: {error}");
        }
    }
}
