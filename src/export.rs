//! The command `export`: scenes in the formats of other renderers.

use crate::args::ExportArgs;
use crate::error::Error;
use crate::outputs::check_distinct;
use crate::scenes::{self, Opened};
use crate::text::{complain, print};
use clap::ValueEnum;
use files::atomic_file;
use files::export::{self, Exported, Renderer, View};
use scene::settings::SettingsError;
use scene::{Settings, Vec3};
use std::io::Write as _;

/// A renderer to write for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Format {
    /// Mitsuba 3: XML
    Mitsuba,
    /// pbrt-v4
    Pbrt,
}

/// Writes a scene in another renderer's format.
pub(crate) fn run(args: &ExportArgs) -> Result<(), Error> {
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
        version: env!("CARGO_PKG_VERSION"),
    };
    let renderer = match args.format {
        Format::Mitsuba => Renderer::Mitsuba,
        Format::Pbrt => Renderer::Pbrt,
    };
    let Exported { text, notes } = export::write(renderer, &view).map_err(Error::BadInput)?;
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
