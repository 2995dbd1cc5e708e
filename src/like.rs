//! What was rendered before: read out of an image or a checkpoint.

use crate::checkpoints::Note;
use crate::engines::EngineName;
use crate::error::Error;
use crate::metadata::Metadata;
use crate::scenes::Opened;
use files::checkpoint::{Loaded, Store};
use files::{image_file, scene_file};
use scene::{Scene, Settings};
use std::ffi::OsString;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// A render that can be repeated.
pub(crate) struct Like {
    /// The scene, unless it is too large to stand in an image.
    scene: Option<Scene>,
    digest: String,
    settings: Settings,
    pub engine: EngineName,
    pub exposure: Option<f32>,
}

/// What made a file.
pub(crate) enum Made {
    /// An image, and what it says.
    Image(Metadata),
    /// A checkpoint.
    Checkpoint(Box<Loaded>),
}

/// Finds out what made the file `path`.
pub(crate) fn made(path: &Path) -> Result<Made, Error> {
    let bad = |error: &dyn ToString| Error::BadInput(error.to_string());
    if is_checkpoint(path) {
        let loaded = Store::new(path).load().map_err(|error| bad(&error))?;
        return loaded.map(|loaded| Made::Checkpoint(Box::new(loaded))).ok_or_else(|| missing(path));
    }
    let note = image_file::read_note(path).map_err(|error| bad(&error))?;
    let metadata = note.as_deref().and_then(Metadata::from_note);
    metadata.map(Made::Image).ok_or_else(|| {
        Error::BadInput(format!(
            "{} does not say what made it; .png and .exr images by sppm do",
            path.display()
        ))
    })
}

fn missing(path: &Path) -> Error {
    Error::BadInput(format!("{}: there is no such file", path.display()))
}

/// Whether a file begins like a checkpoint, or has the name of one.
fn is_checkpoint(path: &Path) -> bool {
    let is_file = path.metadata().is_ok_and(|status| status.is_file());
    let mut start = [0; 5];
    let begins = is_file && File::open(path).and_then(|mut file| file.read_exact(&mut start)).is_ok();
    (begins && start == *b"\x89SPPM") || path.extension().is_some_and(|extension| extension == "sppm")
}

/// Reads what is to be repeated.
pub(crate) fn read(path: &Path) -> Result<Like, Error> {
    match made(path)? {
        Made::Image(metadata) => {
            let Metadata { scene_file, scene_digest, settings, engine, exposure, .. } = metadata;
            let parsed = scene_file.map(|text| scene_file::parse("scene", &text)).transpose();
            let scene = parsed.map_err(|error| {
                Error::BadInput(format!("{}: its scene cannot be used: {error}", path.display()))
            })?;
            settings.validate().map_err(|error| Error::BadInput(format!("{}: {error}", path.display())))?;
            Ok(Like { scene, digest: scene_digest, settings, engine, exposure })
        }
        Made::Checkpoint(loaded) => {
            let note = Note::of(&loaded);
            let checkpoint = loaded.checkpoint;
            let (settings, digest) = (checkpoint.scene.settings, checkpoint.account.scene);
            let engine = note.engine.unwrap_or(EngineName::of(checkpoint.account.sums));
            Ok(Like { scene: Some(checkpoint.scene), digest, settings, engine, exposure: note.exposure })
        }
    }
}

impl Like {
    /// The scene to render, which is the one in the file at `path` and, if one was named, that too.
    pub(crate) fn open(&mut self, named: Option<Opened>, path: &Path) -> Result<Opened, Error> {
        let bad = |what: &str| Err(Error::BadInput(format!("--like: {}: {what}", path.display())));
        let opened = match (named, self.scene.take()) {
            (Some(named), _) => named,
            (None, Some(scene)) => {
                let stem = OsString::from(scene.name.replace(['/', '\\'], "-"));
                Opened { scene, stem, file: None }
            }
            (None, None) => return bad("its scene is too large to stand in it; name the scene too"),
        };
        if scene_file::digest(&opened.scene) != self.digest {
            return bad("the scene is another than the one that made it");
        }
        Ok(Opened { scene: Scene { settings: self.settings, ..opened.scene }, ..opened })
    }
}
