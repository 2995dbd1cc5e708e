//! Reads which render made an image or a checkpoint.

use crate::error::{Error, Field};
use crate::metadata::Metadata;
use crate::names::Renderer;
use crate::save::Note;
use files::checkpoint::{Loaded, Store};
use files::image_file::{self, Format, Tone};
use files::scene_file;
use scene::{Scene, Settings};
use std::fs::File;
use std::io::{ErrorKind, Read};
use std::path::Path;

/// The origin of a file.
#[derive(Debug)]
pub enum Made {
    /// The metadata of an image.
    Image(Box<Metadata>),
    /// A checkpoint.
    Checkpoint(Box<Loaded>),
}

impl Made {
    /// Reads the origin of the file `path`.
    ///
    /// # Errors
    /// If it cannot be read, or is an image without metadata.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let bad = |problem: String| Error::input(Field::Like, problem);
        let missing = || bad(format!("{}: there is no such file", path.display()));
        if is_checkpoint(path) {
            let loaded = Store::new(path).load().map_err(|error| bad(error.to_string()))?;
            return loaded.map(|loaded| Self::Checkpoint(Box::new(loaded))).ok_or_else(missing);
        }
        // Before the extension of its name is looked at.
        match path.metadata() {
            Err(error) if error.kind() == ErrorKind::NotFound => return Err(missing()),
            Ok(status) if !status.is_file() => {
                let what = if status.is_dir() { "directory" } else { "pipe or a device" };
                return Err(bad(format!("{}: this is a {what}; name a file", path.display())));
            }
            _ => {}
        }
        let note = image_file::read_note(path).map_err(|error| bad(error.to_string()))?;
        let metadata = note.as_deref().and_then(Metadata::from_note);
        metadata.map(|metadata| Self::Image(Box::new(metadata))).ok_or_else(|| {
            let path = path.display();
            bad(format!("{path} does not say what made it; only .png and .exr images by sppm do"))
        })
    }
}

/// Whether a file begins with a checkpoint's magic number; or else has its extension, and does not begin as an image.
fn is_checkpoint(path: &Path) -> bool {
    let is_file = path.metadata().is_ok_and(|status| status.is_file());
    let mut start = Vec::new();
    if is_file && let Ok(file) = File::open(path) {
        // What cannot be read is left to the reader of checkpoints, to say why.
        let _ = file.take(12).read_to_end(&mut start);
    }
    let has_extension = || path.extension().is_some_and(|extension| extension == "sppm");
    start.starts_with(b"\x89SPPM") || (has_extension() && Format::of_content(&start).is_none())
}

/// What is needed to repeat a render.
pub(crate) struct Repeated {
    /// The scene, unless it was too large to be stored in an image.
    pub(crate) scene: Option<Scene>,
    pub(crate) digest: String,
    pub(crate) settings: Settings,
    pub(crate) renderer: Renderer,
    pub(crate) exposure: Option<f32>,
    pub(crate) tone: Option<Tone>,
    /// The version of the light transport.
    pub(crate) transport: u32,
}

impl Repeated {
    /// Reads how to repeat the render that wrote the file `path`; files of particles may be in `folder`.
    pub(crate) fn read(path: &Path, folder: Option<&Path>) -> Result<Self, Error> {
        let bad = |problem: String| Error::input(Field::Like, format!("{}: {problem}", path.display()));
        match Made::read(path)? {
            Made::Image(metadata) => {
                let Metadata {
                    scene_file,
                    scene_digest,
                    settings,
                    renderer,
                    exposure,
                    tone,
                    transport,
                    which,
                    ..
                } = *metadata;
                if let Some(which) = which {
                    return Err(bad(format!(
                        "it holds the iterations {which} of a render; repeat that by its own options"
                    )));
                }
                // Files of particles stand beside the image, or where the command runs.
                let beside = path.parent().unwrap_or(Path::new(""));
                let folders = [folder.unwrap_or(beside), beside, Path::new("")];
                let parsed =
                    scene_file.map(|text| scene_file::parse_in("scene", &text, &folders)).transpose();
                let scene = parsed.map_err(|error| bad(format!("its scene cannot be used: {error}")))?;
                settings.validate().map_err(|error| bad(error.to_string()))?;
                Ok(Self { scene, digest: scene_digest, settings, renderer, exposure, tone, transport })
            }
            Made::Checkpoint(loaded) => {
                let note = Note::of(&loaded);
                let checkpoint = loaded.checkpoint;
                let transport = checkpoint.account.transport;
                let (settings, digest) = (checkpoint.scene.settings, checkpoint.account.scene);
                let renderer = note.renderer_of(checkpoint.account.sums);
                let scene = Some(checkpoint.scene);
                let Note { exposure, tone, .. } = note;
                Ok(Self { scene, digest, settings, renderer, exposure, tone, transport })
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::choice::EngineChoice;

    /// What an image says of its render may have been changed by hand, or by a program that knows other settings.
    #[test]
    fn a_render_that_cannot_be_is_not_repeated() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let mut scene = files::builtin::scene("cornell").unwrap();
        (scene.settings.width, scene.settings.height) = (3, 2);
        let engine = fast::Sppm::new(&scene, &scene.settings);
        let usual = Metadata::of(&engine, &scene, &scene_file::digest(&scene), EngineChoice::default());
        let read = |metadata: &Metadata| {
            let (film, note) = (scene::Film::new(3, 2), metadata.to_note());
            let encoding = image_file::Encoding { note: Some(&note), ..image_file::Encoding::default() };
            image_file::write(&path, &film, &encoding).unwrap();
            let repeated = Repeated::read(&path, None);
            repeated.map(|_| ()).map_err(|error| error.to_string().replace(&path.display().to_string(), "it"))
        };
        assert_eq!(read(&usual), Ok(()));
        // A scene may be too large to be stored.
        assert_eq!(read(&Metadata { scene_file: None, ..usual.clone() }), Ok(()));
        let settings = Settings { width: 0, ..usual.settings };
        let said = read(&Metadata { settings, ..usual.clone() }).unwrap_err();
        assert!(said.starts_with("it: ") && said.contains("is 0; it must be at least 1"), "{said}");
        let said = read(&Metadata { scene_file: Some("name = ".into()), ..usual }).unwrap_err();
        assert!(said.starts_with("it: its scene cannot be used: "), "{said}");
    }

    #[test]
    fn what_is_no_file_is_told() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("text"), "text").unwrap();
        let said = |name: &str| {
            let path = folder.path().join(name);
            let problem = Made::read(&path).err().unwrap().to_string();
            problem.replace(&path.display().to_string(), "it")
        };
        assert_eq!(said("none.png"), "it: there is no such file");
        assert_eq!(said("none.sppm"), "it: there is no such file");
        assert_eq!(said(""), "it: this is a directory; name a file");
        // In what is no folder there may be something that cannot be looked at.
        assert!(!said("text/a.png").contains("there is no such file"), "{}", said("text/a.png"));
        let image = folder.path().join("a.png");
        let (film, encoding) = (scene::Film::new(2, 2), image_file::Encoding::default());
        image_file::write(&image, &film, &encoding).unwrap();
        assert_eq!(said("a.png"), "it does not say what made it; only .png and .exr images by sppm do");
    }
}
