//! Reads scene files. They are TOML, checked strictly; every error is one line with its position in the file.
//!
//! `files/scenes/README.md` documents each key, and the scenes in the same folder use them.

mod camera;
mod checks;
mod error;
mod material;
mod memory;
mod particles;
mod pieces;
mod reader;
pub mod revise;
mod settings;
mod sphere;
mod spheres;
mod stage;
mod syntax;
mod text;
mod top;
mod write;

pub use error::{Fault, FileError, Position};
pub use reader::{Field, Section};
pub(crate) use write::head_to_text;
pub use write::{digest, is_digest_of, to_portable_text, to_text};

use checks::Parsed;
use error::quote;
use material::Named;
use memory::{measure, of_imported, too_much};
use particles::Place;
use pieces::{Head, Kind, Pieces};
use reader::Subject;
use scene::text::mebibytes;
use scene::{Automatic, Material, Scene, Sphere};
use spheres::Spheres;
use std::io::Read;
use std::path::Path;
use syntax::syntax_fault;
pub use text::MAX_BYTES;
use text::{load_text, open, read_text};
use toml::de::DeTable;
use top::{Top, View};

/// Reads the scene in the file `path`.
///
/// # Errors
/// If the file cannot be read, or as [`parse`].
pub fn load(path: &Path) -> Result<Scene, FileError> {
    load_within(path, [None; 2], u64::MAX).map(|read| read.scene)
}

/// A scene as it was read.
#[derive(Clone, Debug)]
pub struct LoadedScene {
    /// The scene. Of the settings that are left to be chosen it has the paper's.
    pub scene: Scene,
    /// The settings that are left to be chosen.
    pub automatic: Automatic,
    /// Whether a `[stage]` has chosen camera, lamps and settings.
    pub is_staged: bool,
    /// A bound of the memory that was taken to read it, in bytes.
    pub bytes: u64,
    /// What the user should know, with its place in the file: sentences without a full stop.
    pub notes: Vec<String>,
}

/// As [`load`], but refuses to take much more than `most` bytes of memory. A `[stage]` is set for an image of this `size`
/// where that is given, else of the one that the file states.
///
/// # Errors
/// As [`load`], or if the file needs more.
pub fn load_within(path: &Path, size: [Option<u32>; 2], most: u64) -> Result<LoadedScene, FileError> {
    let name = path.to_string_lossy();
    let (file, length) = open(path, "scene")?;
    load_from(&name, (file, length), size, most)
}

/// Reads a TOML file other than a scene, with the same strict checks. Its root may have only the keys `keys`; `read`
/// converts it. Messages call the file a `kind`.
///
/// # Errors
/// If the file cannot be read, is not TOML, or has another key, or if `read` fails.
pub fn load_other<T>(
    path: &Path,
    kind: &str,
    keys: &[&str],
    read: impl FnOnce(&Section) -> Result<T, Fault>,
) -> Result<T, FileError> {
    let (name, text) = (path.to_string_lossy(), load_text(path, kind)?);
    let read = || {
        let document = DeTable::parse(&text).map_err(|e| syntax_fault(&text, &e))?;
        read(&Section::new(Subject::Other(kind), 0, document.get_ref(), keys)?)
    };
    read().map_err(|fault| FileError::in_text(&name, &text, &fault))
}

/// Reads a scene from `input`, which errors call `name`; for standard input and sockets. With it comes its length in bytes,
/// or 0 if that is not known. See [`load_within`].
///
/// # Errors
/// If `input` cannot be read or is too long, or as [`load_within`].
pub fn load_from(
    name: &str,
    (input, length): (impl Read, u64),
    size: [Option<u32>; 2],
    most: u64,
) -> Result<LoadedScene, FileError> {
    let unread = |problem: String| FileError::unread(name, &problem);
    if length > most {
        return Err(unread(too_much(length, most)));
    }
    let text = read_text(name, "scene", input, length)?;
    let (spheres, bytes) = measure(&text);
    if bytes > most {
        return Err(unread(too_much(bytes, most)));
    }
    if Vec::<u8>::new().try_reserve_exact(usize::try_from(bytes).unwrap_or(usize::MAX)).is_err() {
        let need = mebibytes(bytes);
        return Err(unread(format!("takes up to {need} to read, which the system refuses")));
    }
    let folders = [folder(name)];
    let place = Place { folders: &folders, most: most - bytes, size };
    let Meant { scene, automatic, is_staged, notes } = parse_within(name, &text, place)?;
    let bytes = bytes + of_imported(scene.spheres.get(spheres as usize..).unwrap_or_default());
    let notes = notes.iter().map(|note| FileError::in_text(name, &text, note).to_string()).collect();
    Ok(LoadedScene { scene, automatic, is_staged, bytes, notes })
}

/// Reads the scene in `text`; `name` is the path that errors show.
///
/// The returned scene can be rendered: every number is in range, the lens does not touch an opaque surface, light
/// reaches the space that the eye is in, and a background has become a sky ([`Scene::with_sky`]).
///
/// Relative paths of files of particles start in the folder of `name`.
///
/// # Errors
/// The first fault, with its position and how to fix it.
pub fn parse(name: &str, text: &str) -> Result<Scene, FileError> {
    parse_with_automatic(name, text).map(|(scene, _)| scene)
}

/// As [`parse`], with the settings that are left to be chosen.
///
/// # Errors
/// As [`parse`].
pub fn parse_with_automatic(name: &str, text: &str) -> Result<(Scene, Automatic), FileError> {
    parse_within(name, text, Place::of(&[folder(name)])).map(|meant| (meant.scene, meant.automatic))
}

/// As [`parse`], for a text that was recorded: files of particles are searched in `folders` instead, also by their names
/// alone.
///
/// # Errors
/// As [`parse`].
pub fn parse_in(name: &str, text: &str, folders: &[&Path]) -> Result<Scene, FileError> {
    parse_within(name, text, Place::of(folders)).map(|meant| meant.scene)
}

fn parse_within(name: &str, text: &str, place: Place<'_>) -> Result<Meant, FileError> {
    read(name, text, place).map_err(|fault| FileError::in_text(name, text, &fault))
}

/// The folder that the file `name` is in.
fn folder(name: &str) -> &Path {
    Path::new(name).parent().unwrap_or(Path::new(""))
}

/// What a text means.
struct Meant {
    scene: Scene,
    automatic: Automatic,
    is_staged: bool,
    /// What the user should know.
    notes: Vec<Fault>,
}

fn read(name: &str, text: &str, place: Place<'_>) -> Result<Meant, Fault> {
    let (mut head, mut named, mut count) = (Head::default(), Named::default(), 0);
    for piece in Pieces::new(text) {
        match piece.kind {
            Kind::Head => head.push(text, &piece)?,
            Kind::Material => piece.parse(text, |root| named.read(root))?,
            Kind::Sphere => count += 1,
        }
    }
    let document = DeTable::parse(&head.text).map_err(|e| head.fault(syntax_fault(&head.text, &e)))?;
    let root = document.get_ref();
    let in_head = |fault| head.fault(fault);
    let top = Top::read(name, root, count).map_err(in_head)?;
    named.read(document.get_ref()).map_err(in_head)?;
    let mut materials = named.sort().map_err(|name| twice(text, &name))?;
    let places = Spheres::new(count, &top.root).map_err(in_head)?;
    let spheres = places.read(text, &head, &mut materials)?;
    let (root, view) = (top.root, top.view);
    let (scene, automatic, of_particles) = top.scene(spheres, materials.list, place).map_err(in_head)?;
    let camera = view.section();
    let of_lamps = Parsed { text, head: &head, root, camera, spheres: &places }.check(&scene)?;
    let notes = of_particles.into_iter().map(in_head).chain(of_lamps).collect();
    Ok(Meant { scene, automatic, is_staged: matches!(view, View::Stage(_)), notes })
}

/// The scene whose own materials and spheres are given, and everything else in `text`; files of particles are searched in
/// `folders`. Nothing is checked but what `text` states by itself.
///
/// # Errors
/// As [`parse`].
pub(crate) fn with_spheres(
    name: &str,
    text: &str,
    materials: Vec<Material>,
    spheres: Vec<Sphere>,
    folders: &[&Path],
) -> Result<Scene, FileError> {
    let read = || {
        let document = DeTable::parse(text).map_err(|e| syntax_fault(text, &e))?;
        let top = Top::read(name, document.get_ref(), spheres.len())?;
        top.scene(spheres, materials, Place::of(folders)).map(|(scene, ..)| scene)
    };
    read().map_err(|fault| FileError::in_text(name, text, &fault))
}

/// The fault for a material whose name is given twice, at its second place.
fn twice(text: &str, name: &str) -> Fault {
    let mut at = 0;
    for piece in Pieces::new(text).filter(|piece| piece.kind == Kind::Material) {
        let _ = piece.parse(text, |root| {
            let table = root.get("materials").and_then(|value| value.get_ref().as_table());
            if let Some((key, _)) = table.and_then(|table| table.get_key_value(name)) {
                at = piece.span.start + key.span().start;
            }
            Ok(())
        });
    }
    Fault::new(at, format!("key {} is given twice; keep one", quote(name)))
}
