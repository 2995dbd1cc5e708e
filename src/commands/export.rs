//! The command `export`: writes a scene in the format of another renderer.

use crate::args::files::check_distinct;
use crate::args::scene::{SceneArg, instant};
use crate::args::values::{amount, number, whole};
use crate::terminal::error::Error;
use crate::terminal::text::{complain, print};
use clap::{Args as ClapArgs, ValueEnum};
use files::atomic_file;
use files::export::{self, Exported, Renderer, View};
use files::lock::Lock;
use files::named::Opened;
use scene::settings::{BYTES_PER_PIXEL, MAX_ITERATIONS, MAX_SIDE, SettingsError};
use scene::{Settings, Vec3};
use std::io::Write as _;
use std::path::PathBuf;

/// A renderer to write for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Format {
    /// Mitsuba 3: XML
    Mitsuba,
    /// pbrt-v4
    Pbrt,
}

/// Write a scene in the format of another renderer
///
/// The file asks that renderer for a path tracer of unlimited depth, which converges to the same image as sppm does
/// with a large --depth. What the format cannot express is refused, or, where the image differs but little, told in
/// the file and on standard error.
#[derive(Debug, ClapArgs)]
#[command(after_long_help = EXPORT_EXAMPLES)]
pub(crate) struct ExportArgs {
    #[command(flatten)]
    scene: SceneArg,

    /// The renderer to write for
    #[arg(long, value_enum)]
    format: Format,

    /// The file to write [default: -, standard output]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,

    /// Freeze the scene at this instant, in shutter time
    #[arg(long, value_name = "T", value_parser = number(-1e15, 1e15), allow_hyphen_values = true)]
    time: Option<f32>,

    /// Width of the image, in pixels [default: the scene's own]
    #[arg(long, value_name = "W", value_parser = amount(MAX_SIDE, BYTES_PER_PIXEL), allow_hyphen_values = true)]
    width: Option<u32>,

    /// Height of the image, in pixels [default: the scene's own]
    #[arg(long, value_name = "H", value_parser = amount(MAX_SIDE, BYTES_PER_PIXEL), allow_hyphen_values = true)]
    height: Option<u32>,

    /// Samples per pixel
    #[arg(long, value_name = "N", default_value = "256", allow_hyphen_values = true)]
    #[arg(value_parser = whole::<u32>(1, MAX_ITERATIONS.into()))]
    samples: u32,
}

const EXPORT_EXAMPLES: &str = "\
Examples:
  sppm export cornell --format mitsuba -o cornell.xml && mitsuba -m scalar_rgb cornell.xml
  sppm export motion --format mitsuba --time 0.5 -o motion.xml
  sppm export surgery --format pbrt -o surgery.pbrt";

/// Runs the command.
pub(crate) fn run(args: &ExportArgs) -> Result<(), Error> {
    let opened = args.scene.open([args.width, args.height])?;
    let time = still_instant(&opened, args.time)?;
    let settings = settings(&opened, args).map_err(|error| Error::BadInput(format!("--{error}")))?;
    let output = args.output.as_ref().filter(|output| output.as_os_str() != "-");
    if let Some(output) = output {
        let scene_file = opened.file.as_deref().map(|path| ("the scene", path));
        check_distinct(scene_file.as_slice(), &[("--output", output)])?;
        atomic_file::check(output).map_err(|error| Error::BadInput(format!("--output: {error}")))?;
    }
    // Until it is written: a render may be about to write the same file.
    let locked = output.filter(|output| output.is_file() || !output.exists());
    let lock = locked.map(|output| Lock::take(output)).transpose();
    let _lock = lock.map_err(|error| Error::BadInput(format!("--output: {error}")))?;
    let scene = &opened.scene;
    let view = View {
        name: &scene.name,
        camera: &scene.camera,
        still: &scene.at(time),
        time,
        width: settings.width,
        height: settings.height,
        filter: settings.filter,
        samples: args.samples,
        version: env!("CARGO_PKG_VERSION"),
    };
    let renderer = match args.format {
        Format::Mitsuba => Renderer::Mitsuba,
        Format::Pbrt => Renderer::Pbrt,
    };
    let Exported { text, notes } = export::write(renderer, &view).map_err(Error::BadInput)?;
    match output {
        Some(output) => atomic_file::replace(output, |out| out.write_all(text.as_bytes()))
            .map_err(|error| Error::Failed(error.to_string()))?,
        None => print(text.as_bytes())?,
    }
    if !notes.is_empty() {
        complain(&format!("note: {}", notes.join("; ")));
    }
    Ok(())
}

/// The instant to export. A scene with moving spheres requires `--time`.
fn still_instant(opened: &Opened, asked: Option<f32>) -> Result<f32, Error> {
    let [open, close] = opened.scene.camera.shutter;
    let moves = opened.scene.spheres.iter().any(|s| s.velocity != Vec3::ZERO);
    if moves && open < close && asked.is_none() {
        return Err(Error::BadInput(format!(
            "{}: an exported scene stands still, and spheres of this one move; choose an instant from {open} to {close} \
             by --time",
            opened.scene.name
        )));
    }
    instant(opened, asked)
}

fn settings(opened: &Opened, args: &ExportArgs) -> Result<Settings, SettingsError> {
    let own = opened.scene.settings;
    let settings =
        Settings { width: args.width.unwrap_or(own.width), height: args.height.unwrap_or(own.height), ..own };
    settings.validate().map(|()| settings)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_moves_is_frozen_at_an_instant() {
        let open = |name: &str| files::named::open(name.as_ref(), [None; 2], u64::MAX).unwrap();
        let (motion, still) = (open("motion"), open("cornell"));
        let problem = still_instant(&motion, None).unwrap_err().to_string();
        assert!(
            problem.contains("an exported scene stands still") && problem.ends_with("by --time"),
            "{problem}"
        );
        let [begin, end] = motion.scene.camera.shutter;
        assert_eq!(still_instant(&motion, Some(end)).unwrap(), end);
        assert!(still_instant(&motion, Some(end + 1.0)).is_err());
        assert_eq!(still_instant(&still, None).unwrap(), still.scene.camera.shutter[0]);
        // What moves makes the difference, not how long the shutter is open; and one sphere is enough.
        let mut waiting = open("cornell");
        waiting.scene.camera.shutter = [begin, end];
        assert_eq!(still_instant(&waiting, None).unwrap(), begin);
        let mut whole = open("motion");
        whole.scene.spheres.retain(|sphere| sphere.velocity != Vec3::ZERO);
        assert!(!whole.scene.spheres.is_empty() && still_instant(&whole, None).is_err());
        // While the shutter is closed there is one instant alone.
        let mut closed = open("motion");
        closed.scene.camera.shutter = [begin, begin];
        assert_eq!(still_instant(&closed, None).unwrap(), begin);
    }
}
