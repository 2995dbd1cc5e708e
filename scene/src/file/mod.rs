//! The scene file: TOML, read strictly, with every fault told in one line that names its place.
//!
//! `fixtures/scenes/README.md` documents each key, and the scenes beside it show them in use.

mod camera;
mod checks;
mod error;
mod material;
mod reader;
mod settings;
mod sphere;

pub use error::{FileError, Position};

use crate::{Rgb, Scene, Settings};
use checks::Checks;
use error::{Fault, escape, quote};
use material::Materials;
use reader::{Section, Subject};
use std::fs::File;
use std::io::{ErrorKind, Read};
use std::path::Path;
use toml::de::DeTable;

/// Larger files are refused: a million spheres take a tenth of this.
pub const MAX_BYTES: u64 = 1 << 30;

const KEYS: [&str; 6] = ["name", "background", "camera", "settings", "materials", "sphere"];

/// Reads the scene in the file `path`.
///
/// # Errors
/// If the file cannot be read, or as [`parse`].
pub fn load(path: &Path) -> Result<Scene, FileError> {
    let name = path.to_string_lossy();
    let unread = |message: &str| FileError::unread(&name, message);
    let bytes = read_bytes(path).map_err(|e| match e.kind() {
        ErrorKind::NotFound => unread("there is no such file"),
        ErrorKind::IsADirectory => unread("this is a directory; a scene is a file"),
        _ => unread(&format!("cannot be read: {e}")),
    })?;
    if bytes.len() as u64 > MAX_BYTES {
        return Err(unread(&format!(
            "is too large; a scene file has at most {MAX_BYTES} bytes"
        )));
    }
    match std::str::from_utf8(&bytes) {
        Ok(text) => parse(&name, text),
        Err(e) => {
            let (valid, rest) = bytes.split_at(e.valid_up_to());
            let message = format!("byte 0x{:02x} is not UTF-8; a scene file is UTF-8 text", rest[0]);
            let text = String::from_utf8_lossy(valid);
            Err(FileError::in_text(
                &name,
                &text,
                &Fault::new(valid.len(), message),
            ))
        }
    }
}

/// The bytes of a file, but at most one more than allowed.
fn read_bytes(path: &Path) -> std::io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    File::open(path)?.take(MAX_BYTES + 1).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// Reads the scene in `text`; `name` is the path that errors show.
///
/// A scene that is returned can be rendered: every number is in its range, the lens lies clear of all opaque
/// surfaces, light reaches the space that the eye is in, and a background has become a sky
/// ([`Scene::with_sky`]).
///
/// # Errors
/// Names the first fault, its place, and what would be right.
pub fn parse(name: &str, text: &str) -> Result<Scene, FileError> {
    read(name, text).map_err(|fault| FileError::in_text(name, text, &fault))
}

fn read(name: &str, text: &str) -> Result<Scene, Fault> {
    let document = DeTable::parse(text).map_err(|e| syntax_fault(text, &e))?;
    if document.get_ref().is_empty() {
        return Err(Fault::new(
            0,
            "there is no scene here; it takes a [camera], a [[sphere]] and a light",
        ));
    }
    let root = Section::new(Subject::Scene, 0, document.get_ref(), &KEYS)?;
    let camera_section = camera::section(root.require("camera", "[camera]")?)?;
    let camera = camera::camera(&camera_section)?;
    let settings = root.or("settings", Settings::default(), settings::settings)?;
    let mut materials = root.or("materials", Materials::default(), Materials::read)?;
    let array = sphere::array(root.require("sphere", "[[sphere]] with center, radius and material")?)?;
    let spheres = array.iter().enumerate();
    let spheres = spheres.map(|(i, value)| sphere::sphere(&sphere::section(i, value)?, &mut materials));
    let scene = Scene {
        name: root.or("name", stem(name), |field| sphere::name(field).map(Into::into))?,
        camera,
        spheres: spheres.collect::<Result<_, _>>()?,
        materials: materials.list,
        background: root.or("background", Rgb::ZERO, |field| field.rgb(sphere::radiance))?,
        settings,
    };
    let checks = Checks {
        text,
        root,
        camera: camera_section,
        spheres: array,
    };
    checks.before_sky(&scene)?;
    let scene = scene.with_sky();
    checks.after_sky(&scene)?;
    Ok(scene)
}

/// What a scene without a name is called: the name of its file, without folders and extension.
fn stem(name: &str) -> String {
    escape(&Path::new(name).file_stem().unwrap_or_default().to_string_lossy())
}

fn syntax_fault(text: &str, error: &toml::de::Error) -> Fault {
    let span = error.span().unwrap_or_default();
    let message = match error.message() {
        "duplicate key" => {
            format!(
                "key {} is given twice; keep one",
                quote(text.get(span.clone()).unwrap_or_default())
            )
        }
        other => format!("this is not TOML: {other}"),
    };
    Fault::new(span.start, message)
}
