//! Arguments that name a scene, and how it is found and read.

use super::particles::ParticleArgs;
use crate::terminal::busy::Busy;
use crate::terminal::error::Error;
use crate::terminal::logs::{Level, say};
use clap::builder::{PossibleValue, TypedValueParser};
use clap::{Arg, Args as ClapArgs, Command, ValueHint};
use files::builtin::SCENES;
use files::named::{self, Opened};
use files::scene_file;
use scene::text::one_line;
use std::ffi::{OsStr, OsString};
use std::io::{self, IsTerminal as _};
use std::path::{Path, PathBuf};

/// What is rendered.
#[derive(Debug, ClapArgs)]
pub(crate) struct SceneArg {
    /// A built-in scene (see `sppm scenes`), a scene file ending in .toml, a file of molecules or particles (.xyz, .pdb,
    /// .cif, .gro, .dump, .gsd, .ply, .csv, .npy, .npz), or - for standard input
    #[arg(value_name = "SCENE", value_parser = SceneName, hide_possible_values = true)]
    pub name: OsString,

    #[command(flatten)]
    pub particles: ParticleArgs,
}

impl SceneArg {
    /// Finds and reads the scene. Particles are staged for an image of this `size`, if it is asked for.
    pub(crate) fn open(&self, size: [Option<u32>; 2]) -> Result<Opened, Error> {
        if self.particles.asks_for_a_page() {
            let problem =
                "--view: give it a direction, such as iso; the page is of render, resume and compare";
            return Err(Error::BadInput(problem.into()));
        }
        open(&self.name, &self.particles, size, u64::MAX)
    }
}

/// What is rendered: a scene, or what was rendered before.
#[derive(Debug, ClapArgs)]
pub(crate) struct SourceArgs {
    /// A built-in scene (see `sppm scenes`), a scene file ending in .toml, a file of molecules or particles (.xyz, .pdb,
    /// .cif, .gro, .dump, .gsd, .ply, .csv, .npy, .npz), or - for standard input
    #[arg(value_name = "SCENE", required_unless_present = "like")]
    #[arg(value_parser = SceneName, hide_possible_values = true)]
    pub scene: Option<OsString>,

    /// Repeat the render that wrote FILE, an image or a checkpoint: its scene, settings, engine, exposure and tone, but for
    /// what other options say
    ///
    /// A scene of more than a mebibyte is not in the file; then SCENE must be given too, and is checked to be the same.
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub like: Option<PathBuf>,

    #[command(flatten)]
    pub particles: ParticleArgs,
}

/// Accepts any name, and offers those of the built-in scenes to shell completion.
#[derive(Clone)]
pub(crate) struct SceneName;

impl TypedValueParser for SceneName {
    type Value = OsString;

    fn parse_ref(&self, _: &Command, _: Option<&Arg>, value: &OsStr) -> Result<OsString, clap::Error> {
        Ok(value.to_owned())
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        Some(Box::new(SCENES.iter().map(|scene| PossibleValue::new(scene.name).help(scene.about))))
    }
}

/// Finds and reads the scene `name`, in at most about `most` bytes of memory. A file of particles is shown as `particles`
/// says. A stage is set for an image of this `size`, if it is asked for.
pub(crate) fn open(
    name: &OsStr,
    particles: &ParticleArgs,
    size: [Option<u32>; 2],
    most: u64,
) -> Result<Opened, Error> {
    let told = if name == "-" { "standard input".into() } else { one_line(&name.to_string_lossy()) };
    let busy = Busy::with(format!("reading {told}"));
    if named::is_particles(name) {
        let opened = particles.open(Path::new(name), size, most)?;
        drop(busy);
        opened.notes.iter().for_each(|note| say(Level::INFO, &format!("note: {told}: {note}")));
        return Ok(opened);
    }
    particles.refuse(&told)?;
    let opened = if name == "-" {
        from_standard_input(size, most)
    } else {
        named::open(name, size, most).map_err(Error::BadInput)
    }?;
    drop(busy);
    opened.notes.iter().for_each(|note| say(Level::INFO, &format!("note: {note}")));
    Ok(opened)
}

/// Reads the scene that is piped into this process.
fn from_standard_input(size: [Option<u32>; 2], most: u64) -> Result<Opened, Error> {
    let input = io::stdin();
    if input.is_terminal() {
        let problem =
            "-: standard input is a terminal; pipe a scene into it, as by `sppm render - < mine.toml`";
        return Err(Error::BadInput(problem.into()));
    }
    let loaded = scene_file::load_from("stdin", (input.lock(), 0), size, most);
    let loaded = loaded.map_err(|error| Error::BadInput(error.to_string()))?;
    Ok(named::of_scene_file(loaded, "stdin".into(), None))
}

/// The instant given by `--time`, else the one at which the shutter opens.
pub(crate) fn instant(opened: &Opened, asked: Option<f32>) -> Result<f32, Error> {
    let [open, close] = opened.scene.camera.shutter;
    match asked {
        Some(time) if !(open..=close).contains(&time) => Err(Error::BadInput(format!(
            "--time: {time} is not while the shutter is open, {open} to {close}"
        ))),
        Some(time) => Ok(time),
        None => Ok(open),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::args::of_render;

    /// Nobody has typed it as a file, so it is not called by what was typed.
    #[test]
    fn standard_input_is_told_as_such() {
        let particles = of_render(&["-", "--zoom", "2"]).source.particles;
        let problem = open("-".as_ref(), &particles, [None; 2], u64::MAX).unwrap_err().to_string();
        assert!(
            problem.starts_with("--zoom: ") && problem.contains(", and standard input is none"),
            "{problem}"
        );
    }

    #[test]
    fn an_instant_is_while_the_shutter_is_open() {
        let opened = |shutter| {
            let mut opened = named::open("cornell".as_ref(), [None; 2], u64::MAX).unwrap();
            opened.scene.camera.shutter = shutter;
            opened
        };
        let of = |asked| instant(&opened([1.0, 2.0]), asked).map_err(|error| error.to_string());
        assert_eq!(
            [of(None), of(Some(1.0)), of(Some(1.5)), of(Some(2.0))],
            [Ok(1.0), Ok(1.0), Ok(1.5), Ok(2.0)]
        );
        for asked in [0.5, 2.5, f32::NAN] {
            let problem = format!("--time: {asked} is not while the shutter is open, 1 to 2");
            assert_eq!(of(Some(asked)), Err(problem));
        }
    }
}
