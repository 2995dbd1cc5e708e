//! An image that stays as it was when somebody asked for it, with what belongs to it, ready for download.
//!
//! It is kept in files, so that a large image takes no memory.

use files::checkpoint::{self, Contents};
use files::image_file::{self, Encoding, Tone};
use files::scene_file;
use render::{EngineChoice, Metadata, Note};
use scene::{Picture, Resumable, Scene, Settings};
use std::fmt::Display;
use std::fs::{self, File};
use std::io::{BufWriter, Write as _};
use std::path::Path;
use std::sync::Arc;
use tempfile::TempDir;

/// What a render is of.
#[derive(Debug)]
pub(crate) struct Subject {
    /// The scene, with its settings.
    pub(crate) scene: Scene,
    pub(crate) engine: EngineChoice,
    /// The text of the file that the scene was read from, if there is one.
    pub(crate) text: Option<Arc<str>>,
    /// The name for files, without extension.
    pub(crate) stem: String,
}

/// A kept image.
#[derive(Debug)]
pub struct Kept {
    /// Its number.
    pub number: u32,
    /// Iterations in it.
    pub iterations: u32,
    /// The scene file that renders it.
    pub text: String,
    stem: String,
    metadata: Metadata,
    folder: TempDir,
}

/// How a PNG shows radiance.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Look {
    /// In stops.
    pub exposure: f32,
    /// The curve.
    pub tone: Tone,
}

/// A file for download.
#[derive(Debug)]
pub struct Download {
    /// Its content.
    pub bytes: Vec<u8>,
    /// Its name.
    pub name: String,
    /// Its media type.
    pub kind: &'static str,
}

const IMAGE: &str = "image.exr";
const STATE: &str = "state.sppm";

impl Kept {
    /// Keeps the image of `engine`, which renders `subject`.
    pub(crate) fn new(number: u32, engine: &dyn Resumable, subject: &Subject) -> Result<Self, String> {
        let failed = |error: &dyn Display| format!("cannot keep the image: {error}");
        let iterations = engine.iterations();
        // What renders this image is as many iterations as it has.
        let settings = Settings { iterations: iterations.max(1), ..*engine.settings() };
        let scene = Scene { settings, ..subject.scene.clone() };
        let digest = scene_file::digest(&scene);
        let metadata = Metadata::of(engine, &scene, &digest, subject.engine);
        let folder = TempDir::with_prefix("sppm-view-").map_err(|error| failed(&error))?;
        let pixel = |x, y| engine.probe(x, y).radiance;
        let picture = Picture { width: settings.width, height: settings.height, pixel: &pixel };
        let note = metadata.to_note();
        let encoding = Encoding { seed: settings.seed, note: Some(&note), ..Encoding::default() };
        image_file::write_picture(&folder.path().join(IMAGE), &picture, &encoding)
            .map_err(|error| failed(&error))?;
        write_state(&folder.path().join(STATE), engine, &scene, &digest, subject.engine)
            .map_err(|error| failed(&error))?;
        let original = subject.text.as_deref();
        let text = original.and_then(|text| scene_file::revise::revise(text, &scene));
        let text = text.unwrap_or_else(|| scene_file::to_text(&scene, &settings));
        Ok(Self { number, iterations, text, stem: subject.stem.clone(), metadata, folder })
    }

    /// The names of the files that it has.
    pub const FILES: [&str; 4] = ["image.png", "image.exr", "scene.toml", "state.sppm"];

    /// The name of its files, without extension.
    pub(crate) fn stem(&self) -> &str {
        &self.stem
    }

    /// The file `name`, one of [`Self::FILES`]; `None` for other names.
    ///
    /// # Errors
    /// If it cannot be made.
    pub fn file(&self, name: &str, look: Look) -> Option<Result<Download, String>> {
        let (bytes, extension, kind) = match name {
            "image.png" => (self.png(look), "png", "image/png"),
            "image.exr" => (self.read(IMAGE), "exr", "image/x-exr"),
            "scene.toml" => (Ok(self.text.clone().into_bytes()), "toml", "application/toml"),
            "state.sppm" => (self.read(STATE), "sppm", "application/octet-stream"),
            _ => return None,
        };
        let name = format!("{}.{extension}", self.stem);
        Some(bytes.map(|bytes| Download { bytes, name, kind }))
    }

    /// Writes the image to the file `path`, in the format of its extension.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write_image(&self, path: &Path, look: Look) -> Result<(), String> {
        let film = image_file::read(&self.folder.path().join(IMAGE)).map_err(|error| error.to_string())?;
        let is_shown = render::is_exposed(path);
        let metadata = Metadata {
            exposure: Some(look.exposure).filter(|stops| is_shown && *stops != 0.0),
            tone: is_shown.then_some(look.tone),
            ..self.metadata.clone()
        };
        let (seed, note) = (metadata.settings.seed, metadata.to_note());
        let encoding = Encoding { exposure: look.exposure, tone: look.tone, seed, note: Some(&note) };
        image_file::write(path, &film, &encoding).map_err(|error| error.to_string())
    }

    fn png(&self, look: Look) -> Result<Vec<u8>, String> {
        let folder = TempDir::with_prefix("sppm-view-").map_err(|error| error.to_string())?;
        let path = folder.path().join("image.png");
        self.write_image(&path, look)?;
        fs::read(path).map_err(|error| error.to_string())
    }

    fn read(&self, name: &str) -> Result<Vec<u8>, String> {
        fs::read(self.folder.path().join(name)).map_err(|error| error.to_string())
    }
}

fn write_state(
    path: &Path,
    engine: &dyn Resumable,
    scene: &Scene,
    digest: &str,
    choice: EngineChoice,
) -> std::io::Result<()> {
    let note = Note { renderer: Some(choice.renderer()), ..Note::default() };
    let note = serde_json::to_string(&note)?;
    let contents =
        Contents { scene, digest, version: env!("CARGO_PKG_VERSION"), note: &note, which: None, past: None };
    let mut out = BufWriter::new(File::create(path)?);
    checkpoint::write(&mut out, engine, &contents)?;
    out.flush()
}
