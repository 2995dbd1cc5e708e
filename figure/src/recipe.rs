//! What makes spheres of a file's particles: one table `[[particles]]` of a scene file, but for the file itself.

use crate::rule::{Rule, truth};
use crate::selection::Selection;
use crate::units::Length;
use importers::{Frame, Properties, Request};

/// What makes spheres of particles.
#[derive(Clone, Debug, PartialEq)]
pub struct Recipe {
    /// The frame of the file.
    pub frame: Frame,
    /// The unit of lengths, if the file's own is not to be believed.
    pub unit: Option<Length>,
    /// This point of the file is the origin of the scene. It is subtracted in `f64`, so that what is far from the file's
    /// origin keeps its digits.
    pub origin: [f64; 3],
    /// Whether particles outside of a periodic cell are moved into it.
    pub wrap: bool,
    /// Only particles that all of these select are kept.
    pub cut: Vec<Selection>,
    /// Which bonds are drawn.
    pub bonds: Option<Bonds>,
    /// Whether the edges of the cell are drawn.
    pub cell: bool,
    /// The style: later rules win.
    pub style: Vec<Rule>,
}

/// Where bonds come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bonds {
    /// The file.
    File,
    /// Distances: see [`importers::bonds::by_distance`].
    Distance,
}

impl Default for Recipe {
    fn default() -> Self {
        Self {
            frame: Frame::Number(0),
            unit: None,
            origin: [0.0; 3],
            wrap: false,
            cut: Vec::new(),
            bonds: None,
            cell: false,
            style: Vec::new(),
        }
    }
}

impl Recipe {
    /// The keys that have one text each. Beside them there are `origin`, `cut` and `style`.
    pub const KEYS: [&str; 5] = ["frame", "unit", "wrap", "bonds", "cell"];

    /// Sets `key`, one of [`Self::KEYS`], to what `text` says.
    ///
    /// # Errors
    /// What is wrong with the text, and what would be right.
    pub fn set(&mut self, key: &str, text: &str) -> Result<(), String> {
        match key {
            "frame" => self.frame = parse_frame(text)?,
            "unit" => self.unit = Some(Length::parse(text)?),
            "wrap" => self.wrap = truth(text)?,
            "bonds" => self.bonds = Some(Bonds::parse(text)?),
            "cell" => self.cell = truth(text)?,
            _ => return Err(format!("there is no `{key}`; the keys are {}", Self::KEYS.join(", "))),
        }
        Ok(())
    }

    /// The keys of [`Self::KEYS`] that differ from the default, with the texts that set them.
    pub fn entries(&self) -> Vec<(&'static str, String)> {
        let frame = match self.frame {
            Frame::Number(0) => None,
            Frame::Number(number) => Some(number.to_string()),
            Frame::Last => Some("last".into()),
        };
        let values = [
            frame,
            self.unit.map(|unit| unit.name().into()),
            self.wrap.then(|| "true".into()),
            self.bonds.map(|bonds| bonds.name().into()),
            self.cell.then(|| "true".into()),
        ];
        Self::KEYS.into_iter().zip(values).filter_map(|(key, value)| Some((key, value?))).collect()
    }

    /// What to read of the file, in at most `memory` bytes.
    pub fn request(&self, memory: u64) -> Request {
        let cuts = self.cut.iter().flat_map(Selection::columns);
        let mut names: Vec<String> =
            self.style.iter().flat_map(Rule::columns).chain(cuts).map(Into::into).collect();
        names.sort_unstable();
        names.dedup();
        let properties = if names.is_empty() { Properties::None } else { Properties::Named(names) };
        Request { frame: self.frame, properties, memory }
    }
}

/// Parses the number of a frame, from 0, or `last`.
///
/// # Errors
/// If it is neither.
pub fn parse_frame(text: &str) -> Result<Frame, String> {
    let number = || text.parse().map(Frame::Number).ok();
    let frame = if text == "last" { Some(Frame::Last) } else { number() };
    frame.ok_or_else(|| format!("`{text}` must be the number of a frame, from 0, or last"))
}

impl Bonds {
    /// Both.
    pub const ALL: [Self; 2] = [Self::File, Self::Distance];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::File => "file",
            Self::Distance => "distance",
        }
    }

    fn parse(text: &str) -> Result<Self, String> {
        let found = Self::ALL.into_iter().find(|bonds| bonds.name() == text);
        found.ok_or_else(|| format!("`{text}` must be file (those that it states) or distance"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_read_back() {
        let mut recipe = Recipe::default();
        assert_eq!(recipe.entries(), []);
        for (key, text) in [
            ("frame", "last"),
            ("unit", "nanometre"),
            ("wrap", "true"),
            ("bonds", "distance"),
            ("cell", "true"),
        ] {
            recipe.set(key, text).unwrap();
        }
        let mut again = Recipe::default();
        for (key, text) in recipe.entries() {
            again.set(key, &text).unwrap();
        }
        assert_eq!(again, recipe);
        assert_eq!(recipe.entries().len(), Recipe::KEYS.len());
        // As Americans write it.
        for (text, unit) in [("nanometer", Length::Nanometre), ("meter", Length::Metre)] {
            recipe.set("unit", text).unwrap();
            assert_eq!(recipe.unit, Some(unit), "{text}");
        }
        for (key, text) in [
            ("frame", "-1"),
            ("unit", "inch"),
            ("wrap", "1"),
            ("bonds", "all"),
            ("cell", ""),
            ("sell", "true"),
        ] {
            assert!(recipe.set(key, text).is_err(), "{key} {text}");
        }
    }

    #[test]
    fn the_columns_of_a_style_are_asked_for() {
        let mut recipe = Recipe::default();
        assert_eq!(recipe.request(9).properties, Properties::None);
        recipe.style.push(Rule::parse("a > 1 and not b in (2, 3): color=c, radius=a").unwrap());
        recipe.cut.push(Selection::parse("1 > d or (e == 'x') or 2 <= f").unwrap());
        let names = ["a", "b", "c", "d", "e", "f"].map(Into::into).to_vec();
        let request = recipe.request(9);
        assert_eq!((request.properties, request.memory), (Properties::Named(names), 9));
    }
}
