//! Finds scenes by name: the name of a built-in scene, or the path of a scene file or of a file of particles.

use crate::builtin::{self, Builtin, SCENES};
use crate::particles::{self, BYTES_PER_PARTICLE, Problem, Staged};
use crate::scene_file::{self, LoadedScene};
use figure::{Recipe, Stage};
use importers::Format;
use scene::{Automatic, Scene};
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

/// A scene and its source.
#[derive(Clone, Debug)]
pub struct Opened {
    /// The scene. Of the settings that are left to be chosen it has the paper's.
    pub scene: Scene,
    /// The settings that are left to be chosen.
    pub automatic: Automatic,
    /// Whether camera, lamps and settings follow from what it shows: it is a file of particles, or has a `[stage]`.
    pub is_staged: bool,
    /// A bound of the memory that was taken to read it, in bytes.
    pub bytes: u64,
    /// The default name of its image, without extension: the built-in name, or the file's name.
    pub stem: OsString,
    /// The file that it was read from, unless it is built in.
    pub file: Option<PathBuf>,
    /// What the user should know: sentences without a full stop.
    pub notes: Vec<String>,
}

/// Whether `name` is that of a file of particles.
pub fn is_particles(name: &OsStr) -> bool {
    Format::of_name(Path::new(name)).is_some()
}

/// Finds and reads the scene `name`, in at most about `most` bytes of memory. If it is on a stage, that is set for an image of
/// this `size`, where it is given.
///
/// # Errors
/// If there is no such scene, or if its file is not valid or needs more memory: one line that says how to fix it.
pub fn open(name: &OsStr, size: [Option<u32>; 2], most: u64) -> Result<Opened, String> {
    let path = Path::new(name);
    if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("toml")) {
        let loaded = scene_file::load_within(path, size, most).map_err(|error| error.to_string())?;
        let stem = path.file_stem().unwrap_or(OsStr::new("scene")).to_owned();
        return Ok(of_scene_file(loaded, stem, Some(path.into())));
    }
    if is_particles(name) {
        let usual = Stage::default();
        let size = [0, 1].map(|side| size[side].unwrap_or(usual.size[side]));
        let opened = open_particles(path, &Recipe::default(), &Stage { size, ..usual }, most);
        return opened.map_err(|problem| problem.to_string());
    }
    let builtin = find(name)?;
    let (scene, automatic) = builtin.open();
    let stem = builtin.name.into();
    Ok(Opened { scene, automatic, is_staged: false, bytes: 0, stem, file: None, notes: Vec::new() })
}

/// The scene of a scene file, whose image has the name `stem`.
pub fn of_scene_file(loaded: LoadedScene, stem: OsString, file: Option<PathBuf>) -> Opened {
    let LoadedScene { scene, automatic, is_staged, bytes, notes } = loaded;
    Opened { scene, automatic, is_staged, bytes, stem, file, notes }
}

/// Reads the file of particles `path` and puts it on a stage; see [`particles::staged`].
///
/// # Errors
/// As [`particles::staged`].
pub fn open_particles(path: &Path, recipe: &Recipe, stage: &Stage, most: u64) -> Result<Opened, Problem> {
    particles::staged(path, recipe, stage, most).map(|staged| of_particles(path, staged))
}

/// The file of particles `path`, which is on its stage.
pub fn of_particles(path: &Path, Staged { scene, notes }: Staged) -> Opened {
    let stem = particles::stem(path).into();
    let bytes = scene.spheres.len() as u64 * BYTES_PER_PARTICLE;
    // The stage has chosen all settings.
    let automatic = Automatic::default();
    Opened { scene, automatic, is_staged: true, bytes, stem, file: Some(path.into()), notes }
}

/// Finds the built-in scene `name`.
///
/// # Errors
/// If there is no such scene: one line that lists the built-in scenes.
pub fn find(name: &OsStr) -> Result<&'static Builtin, String> {
    name.to_str().and_then(builtin::find).ok_or_else(|| unknown(&name.to_string_lossy()))
}

/// The message for a `name` that is neither a built-in scene nor a scene file.
fn unknown(name: &str) -> String {
    let near = SCENES
        .iter()
        .map(|scene| (strsim::damerau_levenshtein(name, scene.name), scene.name))
        .filter(|&(distance, candidate)| distance <= candidate.len() / 2)
        .min_by_key(|&(distance, _)| distance)
        .map_or(String::new(), |(_, candidate)| format!(" (did you mean {candidate}?)"));
    let names: Vec<&str> = SCENES.iter().map(|s| s.name).collect();
    format!(
        "there is no scene {name:?}{near}; a scene is one of {}, a file ending in .toml, or one of \
         particles, such as .xyz, .pdb, .gro, .dump, .gsd, .ply, .csv or .npy",
        names.join(", ")
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use scene::Settings;

    #[test]
    fn the_nearest_of_all_names_is_guessed() {
        // From mirror, which comes before it, there are three letters to change.
        assert!(unknown("motior").starts_with("there is no scene \"motior\" (did you mean motion?); "));
        assert!(unknown("nothing").starts_with("there is no scene \"nothing\"; a scene is one of cornell, "));
    }

    /// As other programs write them; the name of the image keeps its letters.
    #[test]
    fn extensions_are_known_in_upper_case() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("My.Box.TOML");
        std::fs::write(&path, builtin::find("cornell").unwrap().text).unwrap();
        let opened = open(path.as_os_str(), [None; 2], u64::MAX).unwrap();
        assert_eq!(
            (opened.stem.to_str(), opened.file, opened.is_staged),
            (Some("My.Box"), Some(path), false)
        );
        assert_eq!(opened.scene, builtin::scene("cornell").unwrap());
        let path = folder.path().join("Water.XYZ");
        std::fs::write(&path, "2\n\nO 0 0 0\nH 1 0 0\n").unwrap();
        let opened = open(path.as_os_str(), [Some(30), None], u64::MAX).unwrap();
        assert_eq!((opened.stem.to_str(), opened.file, opened.is_staged), (Some("Water"), Some(path), true));
        let Settings { width, height, .. } = opened.scene.settings;
        assert_eq!([width, height], [30, Stage::default().size[1]]);
        assert_eq!(opened.bytes, opened.scene.spheres.len() as u64 * BYTES_PER_PARTICLE);
    }
}
