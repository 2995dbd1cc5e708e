//! Arguments that name a scene, and how it is found and read.

use crate::terminal::error::Error;
use clap::{Args as ClapArgs, ValueHint};
use files::named::{self, Opened};
use std::ffi::{OsStr, OsString};
use std::path::PathBuf;

/// What is rendered.
#[derive(Debug, ClapArgs)]
pub(crate) struct SceneArg {
    /// A built-in scene (see `sppm scenes`), or a scene file ending in .toml
    #[arg(value_name = "SCENE")]
    pub name: OsString,
}

impl SceneArg {
    /// Finds and reads the scene.
    pub(crate) fn open(&self) -> Result<Opened, Error> {
        open(&self.name)
    }
}

/// What is rendered: a scene, or what was rendered before.
#[derive(Debug, ClapArgs)]
pub(crate) struct SourceArgs {
    /// A built-in scene (see `sppm scenes`), or a scene file ending in .toml
    #[arg(value_name = "SCENE", required_unless_present = "like")]
    pub scene: Option<OsString>,

    /// Repeat the render that wrote FILE, an image or a checkpoint: its scene, settings, engine and exposure, but for
    /// what other options say
    ///
    /// A scene of more than a mebibyte is not in the file; then SCENE must be given too, and is checked to be the same.
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub like: Option<PathBuf>,
}

/// Finds and reads the scene `name`.
pub(crate) fn open(name: &OsStr) -> Result<Opened, Error> {
    named::open(name).map_err(Error::BadInput)
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
