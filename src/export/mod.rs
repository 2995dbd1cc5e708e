//! The command `export`: scenes in the formats of other renderers.

mod mitsuba;
mod pbrt;

use crate::args::ExportArgs;
use crate::error::Error;
use crate::outputs::check_distinct;
use crate::scenes::{self, Opened};
use crate::text::{complain, print};
use clap::ValueEnum;
use scene::settings::SettingsError;
use scene::{Camera, Settings, Still, Vec3, atomic_file};
use std::io::Write as _;

/// A renderer to write for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Format {
    /// Mitsuba 3: XML
    Mitsuba,
    /// pbrt-v4
    Pbrt,
}

/// A scene at one instant, with all that its file says.
struct View<'a> {
    name: &'a str,
    camera: &'a Camera,
    still: &'a Still<'a>,
    time: f32,
    width: u32,
    height: u32,
    samples: u32,
}

/// A file, and what in it is not quite the scene.
struct Exported {
    text: String,
    notes: Vec<String>,
}

/// Writes a scene in another renderer's format.
pub(crate) fn export(args: &ExportArgs) -> Result<(), Error> {
    let opened = scenes::open(&args.scene.name)?;
    let time = instant(&opened, args.time)?;
    let settings = settings(&opened, args).map_err(|error| Error::BadInput(format!("--{error}")))?;
    if let Some(output) = &args.output {
        let scene_file = opened.file.as_deref().map(|path| ("the scene", path));
        check_distinct(scene_file.as_slice(), &[("--output", output)])?;
        atomic_file::check(output).map_err(|error| Error::BadInput(format!("--output: {error}")))?;
    }
    let scene = &opened.scene;
    let view = View {
        name: &scene.name,
        camera: &scene.camera,
        still: &scene.at(time),
        time,
        width: settings.width,
        height: settings.height,
        samples: args.samples,
    };
    let Exported { text, notes } = match args.format {
        Format::Mitsuba => mitsuba::write(&view)?,
        Format::Pbrt => pbrt::write(&view),
    };
    match &args.output {
        Some(output) => atomic_file::replace(output, |out| out.write_all(text.as_bytes()))
            .map_err(|error| Error::Failed(error.to_string()))?,
        None => print(text.as_bytes())?,
    }
    if !notes.is_empty() {
        complain(&format!("note: {}", notes.join("; ")));
    }
    Ok(())
}

/// The instant to export; a scene in motion needs one.
fn instant(opened: &Opened, asked: Option<f32>) -> Result<f32, Error> {
    let [open, close] = opened.scene.camera.shutter;
    let moves = opened.scene.spheres.iter().any(|s| s.velocity != Vec3::ZERO);
    if moves && open < close && asked.is_none() {
        return Err(Error::BadInput(format!(
            "{}: an exported scene stands still, and spheres of this one move; choose an instant from {open} to {close} \
             by --time",
            opened.scene.name
        )));
    }
    opened.instant(asked)
}

fn settings(opened: &Opened, args: &ExportArgs) -> Result<Settings, SettingsError> {
    let own = opened.scene.settings;
    let settings =
        Settings { width: args.width.unwrap_or(own.width), height: args.height.unwrap_or(own.height), ..own };
    settings.validate().map(|()| settings)
}

impl View<'_> {
    /// What every exported file says of itself.
    fn introduction(&self) -> Vec<String> {
        let mut lines = vec![
            format!("{}, exported by sppm {}", self.name, env!("CARGO_PKG_VERSION")),
            "Paths are of any length here; sppm ends them at max_depth: compare with a large one.".into(),
        ];
        if self.camera.shutter[0] < self.camera.shutter[1] {
            lines.push(format!("Frozen at shutter time {}.", self.time));
        }
        lines
    }

    /// A point that the camera looks at: as far away as the eye is from the origin, so that rounding it to 32 bits
    /// leaves the direction.
    fn target(&self) -> [f64; 3] {
        let eye = self.camera.eye.as_dvec3();
        let direction = self.camera.direction.as_dvec3().normalize();
        (eye + direction * eye.length().max(1.0)).into()
    }
}

/// `text` fit for a comment: one line, and none of the pairs of dashes that XML forbids there.
fn comment(text: &str) -> String {
    let is_odd = |c: char| c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}');
    let mut line: String = text.chars().map(|c| if is_odd(c) { ' ' } else { c }).collect();
    while line.contains("--") {
        line = line.replace("--", "- -");
    }
    line
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_keep_to_their_line() {
        assert_eq!(comment("a\nb"), "a b");
        for text in ["--", "---", "a--b---->"] {
            assert!(!comment(text).contains("--"), "{text}");
        }
    }
}
