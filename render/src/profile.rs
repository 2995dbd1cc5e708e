//! Profiles: files with the free parameters of the fast engine, as written by `sppm tune`.

use crate::error::{Error, Field as Asked};
use crate::names::LanesName;
use fast::{ParameterError, Parameters, Values};
use files::scene_file::{Fault, Field, Section, load_other};
use std::fmt::Write;
use std::path::Path;

/// The tables of a profile: the parameters, what they were tuned for, and how the search went. Only the first is used.
const TABLES: [&str; 3] = ["parameters", "tuned", "search"];
/// The key of the lanes in the table of parameters.
const LANES: &str = "lanes";

/// The content of a profile.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Profile {
    /// The free parameters.
    pub parameters: Parameters,
    /// The lanes, if given.
    pub lanes: Option<LanesName>,
}

impl Profile {
    /// Reads the profile in the file `path`. Missing values are the defaults.
    ///
    /// # Errors
    /// If it is not valid: file, line and column of the first fault, and how to fix it.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let read = load_other(path, "profile", &TABLES, |root| {
            root.get("parameters").map_or(Ok(Self::default()), Self::parse)
        });
        read.map_err(|error| Error::named(Asked::Profile, error))
    }

    fn parse(field: Field) -> Result<Self, Fault> {
        let names = Parameters::ALL.iter().map(|parameter| parameter.name).chain([LANES]);
        let section = field.section("[parameters]", &names.collect::<Vec<_>>())?;
        let mut profile = Self { lanes: section.get(LANES).map(lanes).transpose()?, ..Self::default() };
        for parameter in Parameters::ALL {
            profile.parameters = set(&section, profile.parameters, parameter.name)?;
        }
        Ok(profile)
    }

    /// The table `[parameters]`.
    pub fn to_text(self) -> String {
        let mut text = String::from("[parameters]\n");
        for (parameter, value) in Parameters::ALL.iter().zip(self.parameters.values()) {
            // Convert back to the original `f32`, whose shortest text reads back as the same value.
            let value = value as f32;
            let _ = match parameter.values {
                Values::Any => writeln!(text, "{} = {value:?}", parameter.name),
                Values::Whole | Values::PowersOfTwo => writeln!(text, "{} = {value}", parameter.name),
            };
        }
        if let Some(lanes) = self.lanes {
            let _ = writeln!(text, "{LANES} = \"{}\"", lanes.name());
        }
        text
    }
}

/// `parameters` with the value of `name` in the section, if given.
fn set(section: &Section, parameters: Parameters, name: &'static str) -> Result<Parameters, Fault> {
    let Some(field) = section.get(name) else { return Ok(parameters) };
    let told = |error: ParameterError| field.fault(error);
    parameters.with(name, field.float()?).map_err(told)
}

fn lanes(field: Field) -> Result<LanesName, Fault> {
    let name = field.text()?;
    let known = LanesName::ALL.into_iter().find(|lanes| lanes.name() == name);
    let names = LanesName::ALL.map(LanesName::name).join(", ");
    known.ok_or_else(|| field.fault(format_args!("must be one of {names}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Profile, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.toml");
        std::fs::write(&path, text).unwrap();
        let shown = path.display().to_string();
        Profile::read(&path).map_err(|error| error.to_string().replace(&shown, "a.toml"))
    }

    #[test]
    fn what_is_written_is_read() {
        let mut profile = Profile::default();
        assert_eq!(read(&profile.to_text()), Ok(profile));
        for parameter in Parameters::ALL {
            profile.parameters = profile.parameters.with(parameter.name, parameter.least).unwrap();
        }
        profile.parameters = profile.parameters.with("cell_size", 4.37).unwrap();
        profile.lanes = Some(LanesName::Emulated);
        assert!(profile.to_text().contains("cell_size = 4.37\n"));
        assert_eq!(read(&profile.to_text()), Ok(profile));
    }

    #[test]
    fn missing_values_are_the_defaults() {
        for text in ["", "[parameters]", "[tuned]\nscene = 1\n[search]"] {
            assert_eq!(read(text), Ok(Profile::default()), "{text:?}");
        }
    }

    #[test]
    fn errors_have_a_position() {
        let cases = [
            (
                "[parameters]\ncell_size = 90",
                "a.toml:2:13: cell_size 90 of [parameters] must be a number from 2 to 12",
            ),
            (
                "[parameters]\ncell_size = \"a\"",
                "a.toml:2:13: cell_size of [parameters] must be a number, not a string",
            ),
            (
                "[parameters]\n  pixels_per_job = 1000",
                "a.toml:2:20: pixels_per_job 1000 of [parameters] must be a power of two from 256 to 16384",
            ),
            (
                "[parameters]\ncel_size = 1",
                "a.toml:2:1: unknown key \"cel_size\" in [parameters] (did you mean \"cell_size\"?)",
            ),
            (
                "[parametres]",
                "a.toml:1:2: unknown key \"parametres\" in profile (did you mean \"parameters\"?)",
            ),
            ("parameters = 1", "a.toml:1:14: parameters of profile must be a table, not a number"),
            (
                "[parameters]\nlanes = \"mmx\"",
                "a.toml:2:9: lanes \"mmx\" of [parameters] must be one of auto, avx2",
            ),
            ("cell_size = ", "a.toml:1:13: a value is missing here"),
        ];
        for (text, expected) in cases {
            let said = read(text).unwrap_err();
            assert!(said.starts_with(&format!("profile: {expected}")), "{said}");
        }
    }
}
