//! Scenes by name or by file, and the command `scenes`.

use crate::args::{ScenesArgs, SettingsArgs};
use crate::error::Error;
use crate::text;
use files::builtin::{self, Builtin, SCENES};
use scene::settings::SettingsError;
use scene::{Scene, Settings};
use std::ffi::{OsStr, OsString};
use std::path::PathBuf;

/// A scene and where it came from.
pub(crate) struct Opened {
    /// The scene.
    pub scene: Scene,
    /// The name of its image: the built-in name, or the file's without its extension.
    pub stem: OsString,
    /// The file it was read from.
    pub file: Option<PathBuf>,
}

impl Opened {
    /// The instant that `--time` asks for, or else the one at which the shutter opens.
    pub(crate) fn instant(&self, asked: Option<f32>) -> Result<f32, Error> {
        let [open, close] = self.scene.camera.shutter;
        match asked {
            Some(time) if !(open..=close).contains(&time) => Err(Error::BadInput(format!(
                "--time: {time} is not while the shutter is open, {open} to {close}"
            ))),
            Some(time) => Ok(time),
            None => Ok(open),
        }
    }
}

/// Finds and reads the scene that the command line names.
pub(crate) fn open(name: &OsString) -> Result<Opened, Error> {
    let path = PathBuf::from(name);
    if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("toml")) {
        let scene = files::scene_file::load(&path).map_err(|error| Error::BadInput(error.to_string()))?;
        let stem = path.file_stem().unwrap_or(OsStr::new("scene")).to_owned();
        return Ok(Opened { scene, stem, file: Some(path) });
    }
    let builtin = find(name)?;
    Ok(Opened { scene: builtin.scene(), stem: builtin.name.into(), file: None })
}

/// The command `scenes`.
pub(crate) fn show(args: &ScenesArgs) -> Result<(), Error> {
    match &args.name {
        Some(name) => text::print(find(name)?.text.as_bytes()),
        None => text::print(listing().as_bytes()),
    }
}

fn listing() -> String {
    let width = SCENES.iter().map(|s| s.name.len()).max().unwrap_or(0);
    let line = |builtin: &Builtin| {
        let spheres = text::counted(builtin.scene().spheres.len() as u64, "sphere");
        format!("{:width$}  {spheres:>12}  {}\n", builtin.name, builtin.about)
    };
    SCENES.iter().map(line).collect()
}

fn find(name: &OsStr) -> Result<&'static Builtin, Error> {
    name.to_str().and_then(builtin::find).ok_or_else(|| Error::BadInput(unknown(&name.to_string_lossy())))
}

/// What to say of `name`, which is neither a built-in scene nor a scene file.
fn unknown(name: &str) -> String {
    let near = SCENES
        .iter()
        .map(|scene| (strsim::damerau_levenshtein(name, scene.name), scene.name))
        .filter(|&(distance, candidate)| distance <= candidate.len() / 2)
        .min_by_key(|&(distance, _)| distance)
        .map_or(String::new(), |(_, candidate)| format!(" (did you mean {candidate}?)"));
    let names: Vec<&str> = SCENES.iter().map(|s| s.name).collect();
    format!(
        "there is no scene {name:?}{near}; a scene is one of {}, or a file ending in .toml",
        names.join(", ")
    )
}

impl SettingsArgs {
    /// The settings of `opened` with those of the command line in their place.
    pub(crate) fn apply(&self, opened: &Opened) -> Result<Settings, Error> {
        let own = opened.scene.settings;
        let settings = Settings {
            width: self.width.unwrap_or(own.width),
            height: self.height.unwrap_or(own.height),
            iterations: self.iterations.unwrap_or(own.iterations),
            photons_per_iteration: self.photons.unwrap_or(own.photons_per_iteration),
            max_depth: self.depth.unwrap_or(own.max_depth),
            initial_radius: self.radius.unwrap_or(own.initial_radius),
            seed: self.seed.unwrap_or(own.seed),
        };
        settings.validate().map_err(|error| Error::BadInput(self.blame(&error)))?;
        Ok(settings)
    }

    /// `error` in terms of the options that were given. A scene's own settings are in bounds (its file was checked
    /// when it was read), so if the option at fault was not given then the one it is bound to was.
    fn blame(&self, error: &SettingsError) -> String {
        let SettingsError { option, problem } = error;
        let options = [
            ("width", "--width", self.width.is_some(), "--height"),
            ("height", "--height", self.height.is_some(), "--width"),
            ("photons_per_iteration", "--photons", self.photons.is_some(), "--depth"),
        ];
        match options.into_iter().find(|(field, ..)| field == option) {
            Some((_, name, true, _)) => format!("{name} {problem}"),
            Some((_, _, false, partner)) => format!("{partner}: {option} {problem}"),
            None => error.to_string(),
        }
    }
}
