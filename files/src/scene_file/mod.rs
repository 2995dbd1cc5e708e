//! Reads scene files. They are TOML, checked strictly; every error is one line with its position in the file.
//!
//! `files/scenes/README.md` documents each key, and the scenes in the same folder use them.

mod camera;
mod checks;
mod error;
mod material;
mod particles;
mod pieces;
mod reader;
pub mod revise;
mod settings;
mod sphere;
mod spheres;
mod stage;
mod syntax;
mod write;

pub use error::{Fault, FileError, Position};
pub use reader::{Field, Section};
pub(crate) use write::head_to_text;
pub use write::{digest, is_digest_of, to_portable_text, to_text};

use crate::atomic_file::reason;
use crate::input;
use crate::particles::BYTES_PER_PARTICLE;
use checks::Parsed;
use error::{escape, quote};
use material::Named;
use particles::{Found, Place};
use pieces::{Head, Kind, MOST_BYTES as MOST_PIECE_BYTES, Pieces};
use reader::Subject;
use scene::text::mebibytes;
use scene::{Automatic, Camera, Material, Rgb, Scene, Sphere};
use settings::{Stated, Usual};
use spheres::Spheres;
use std::fs::File;
use std::io::{self, ErrorKind, Read};
use std::path::Path;
use syntax::syntax_fault;
use toml::de::DeTable;

/// Larger files are rejected.
pub const MAX_BYTES: u64 = 1 << 32;

/// Memory per sphere while a scene is read, beside the text: in the scene; 42 were measured, and 62, 86 and 247 with what
/// follows.
const BYTES_PER_SPHERE: u64 = 48;
/// The same in a scene in which something may move, in addition: where the sphere is at one instant.
const BYTES_PER_MOVED_SPHERE: u64 = 48;
/// The same per sphere with a material of its own, in addition.
const BYTES_PER_OWN_MATERIAL: u64 = 28;
/// The same per lamp, in addition: what is found out about its light.
const BYTES_PER_LAMP: u64 = 224;
/// The same per material with a name.
const BYTES_PER_MATERIAL: u64 = 192;
/// Memory per byte of the head, which is parsed at once.
const BYTES_PER_HEAD_BYTE: u64 = 48;

const KEYS: [&str; 9] = [
    "name",
    "background",
    "transparent_background",
    "camera",
    "stage",
    "settings",
    "materials",
    "sphere",
    "particles",
];

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
    let Meant { scene, automatic, is_staged } = parse_within(name, &text, place)?;
    let imported = scene.spheres.get(spheres as usize..).unwrap_or_default();
    let lamps = imported.iter().filter(|sphere| sphere.is_emitter()).count() as u64;
    let bytes = bytes + BYTES_PER_PARTICLE * imported.len() as u64 + BYTES_PER_LAMP * lamps;
    Ok(LoadedScene { scene, automatic, is_staged, bytes })
}

fn too_much(bytes: u64, most: u64) -> String {
    format!("takes up to {} to read, more than the limit of {}", mebibytes(bytes), mebibytes(most))
}

/// The number of spheres, and a bound of the memory that reading them and the rest takes, the text included. Of a sphere, the
/// words tell what it may be.
fn measure(text: &str) -> (u64, u64) {
    let (mut spheres, mut head, mut bytes) = (0, 0, text.len() as u64);
    let mut moves = false;
    for piece in Pieces::new(text) {
        let piece_text = &text[piece.span.clone()];
        match piece.kind {
            Kind::Sphere => {
                spheres += 1;
                // Letters of a word may be escaped.
                let may = |word: &str| piece_text.contains(word) || piece_text.contains('\\');
                // A material in braces, or in a table of its own.
                let has_own = may("{") || may("sphere.");
                bytes += BYTES_PER_SPHERE;
                bytes += if has_own { BYTES_PER_OWN_MATERIAL } else { 0 };
                bytes += if may("emission") { BYTES_PER_LAMP } else { 0 };
                moves |= may("velocity");
            }
            Kind::Material => bytes += BYTES_PER_MATERIAL,
            Kind::Head => head += piece_text.len() as u64,
        }
    }
    let of_moved = if moves { BYTES_PER_MOVED_SPHERE * spheres } else { 0 };
    (spheres, bytes + of_moved + BYTES_PER_HEAD_BYTE * head.min(MOST_PIECE_BYTES as u64))
}

/// Opens the file `path`, which messages call a `kind`; also returns its length.
fn open(path: &Path, kind: &str) -> Result<(File, u64), FileError> {
    let opened = input::open(path, &format!("a {kind} is a file"));
    opened.map_err(|problem| FileError::unread(&path.to_string_lossy(), &problem))
}

/// The text of the file `path`, which messages call a `kind`.
fn load_text(path: &Path, kind: &str) -> Result<String, FileError> {
    let (file, length) = open(path, kind)?;
    read_text(&path.to_string_lossy(), kind, file, length)
}

/// The text of `input`, which messages call `name` and a `kind`. It has `length` bytes, if that is known.
fn read_text(name: &str, kind: &str, input: impl Read, length: u64) -> Result<String, FileError> {
    let unread = |message: &str| FileError::unread(name, message);
    let bytes = read_bytes(input, length).map_err(|e| match e.kind() {
        ErrorKind::FileTooLarge => {
            unread(&format!("is too large; a {kind} file has at most {MAX_BYTES} bytes"))
        }
        _ => unread(&format!("cannot be read: {}", reason(&e))),
    })?;
    String::from_utf8(bytes).map_err(|error| {
        let (valid, rest) = error.as_bytes().split_at(error.utf8_error().valid_up_to());
        let message = format!("byte 0x{:02x} is not UTF-8; a {kind} file is UTF-8 text", rest[0]);
        let text = String::from_utf8_lossy(valid);
        FileError::in_text(name, &text, &Fault::new(valid.len(), message))
    })
}

/// At most [`MAX_BYTES`] of `input`. They are counted again while they are read, as the length may not be known, or change.
fn read_bytes(input: impl Read, length: u64) -> io::Result<Vec<u8>> {
    /// Bytes that are read at a time, after the system has granted room for them.
    const STEP: usize = 1 << 20;
    let mut bytes = Vec::new();
    let mut input = input.take(MAX_BYTES + 1);
    let grant = |bytes: &mut Vec<u8>, more: usize| {
        bytes.try_reserve(more).map_err(|_| io::Error::from(ErrorKind::OutOfMemory))
    };
    if length > MAX_BYTES {
        return Err(ErrorKind::FileTooLarge.into());
    }
    grant(&mut bytes, length as usize + STEP)?;
    while input.by_ref().take(STEP as u64 / 2).read_to_end(&mut bytes)? > 0 {
        grant(&mut bytes, STEP)?;
    }
    if bytes.len() as u64 > MAX_BYTES { Err(ErrorKind::FileTooLarge.into()) } else { Ok(bytes) }
}

/// Reads the scene in `text`; `name` is the path that errors show.
///
/// The returned scene can be rendered: every number is in range, the lens does not touch an opaque surface, light
/// reaches the space that the eye is in, and a background has become a sky ([`Scene::with_sky`]).
///
/// # Errors
/// The first fault, with its position and how to fix it.
///
/// Relative paths of files of particles start in the folder of `name`.
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
    let (scene, automatic) = top.scene(spheres, materials.list, place).map_err(in_head)?;
    let camera = view.section();
    Parsed { text, head: &head, root, camera, spheres: &places }.check(&scene)?;
    Ok(Meant { scene, automatic, is_staged: matches!(view, View::Stage(_)) })
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
        top.scene(spheres, materials, Place::of(folders)).map(|(scene, _)| scene)
    };
    read().map_err(|fault| FileError::in_text(name, text, &fault))
}

/// What the head of a scene file states.
struct Top<'a> {
    root: Section<'a>,
    view: View<'a>,
    /// What it says of settings, beside the usual ones of what it shows before that is seen.
    stated: Stated,
    background: Rgb,
    transparent_background: bool,
    name: String,
}

/// From where the scene is seen.
#[derive(Clone, Copy)]
enum View<'a> {
    Camera(Section<'a>, Camera),
    Stage(Section<'a>),
}

impl<'a> View<'a> {
    fn read(root: &Section<'a>) -> Result<Self, Fault> {
        let Some(field) = root.get("stage") else {
            let section = camera::section(root.require("camera", "[camera]")?)?;
            return Ok(Self::Camera(section, camera::camera(&section)?));
        };
        for key in ["camera", "background", "transparent_background"] {
            if let Some(other) = root.get(key) {
                let message =
                    format!("a scene with a [stage] has its {key} from that; leave out one of the two");
                return Err(Fault::new(other.at, message));
            }
        }
        stage::section(field).map(Self::Stage)
    }

    /// The settings before anything on a stage is seen.
    fn usual_settings(self) -> Usual {
        match self {
            Self::Camera(..) => Usual::Paper,
            Self::Stage(_) => Usual::Staged(stage::size_alone()),
        }
    }

    fn section(self) -> Section<'a> {
        match self {
            Self::Camera(section, _) | Self::Stage(section) => section,
        }
    }
}

impl<'a> Top<'a> {
    /// Reads the head, whose root is `root`, of a file with `count` spheres in pieces of their own.
    fn read(file: &str, root: &'a DeTable<'a>, count: usize) -> Result<Self, Fault> {
        if root.is_empty() && count == 0 {
            let message = "there is no scene here; it takes a [camera], a [[sphere]] and a light";
            return Err(Fault::new(0, message));
        }
        let root = Section::new(Subject::Scene, 0, root, &KEYS)?;
        let view = View::read(&root)?;
        Ok(Self {
            root,
            view,
            stated: settings::stated(&root, view.usual_settings())?,
            background: root.or("background", Rgb::ZERO, |field| field.rgb(sphere::radiance))?,
            transparent_background: root.or("transparent_background", false, |field| field.truth())?,
            name: root.or("name", stem(file), |field| sphere::name(field).map(Into::into))?,
        })
    }

    /// The scene with these spheres and those of files of particles, and the settings that are left to be chosen.
    fn scene(
        self,
        spheres: Vec<Sphere>,
        materials: Vec<Material>,
        place: Place<'_>,
    ) -> Result<(Scene, Automatic), Fault> {
        let Self { root, view, stated, background, transparent_background, name } = self;
        let Stated { settings, automatic } = stated;
        let camera = if let View::Camera(_, camera) = view { camera } else { Camera::default() };
        let (spheres, imports) = (spheres.into(), Vec::new());
        let mut scene =
            Scene { name, camera, spheres, materials, background, transparent_background, settings, imports };
        let mut found = Found { is_centered: matches!(view, View::Stage(_)), ..Found::default() };
        particles::read(&root, place, &mut scene, &mut found)?;
        let View::Stage(section) = view else { return Ok((scene.with_sky(), automatic)) };
        let size = [0, 1].map(|side| place.size[side].unwrap_or([settings.width, settings.height][side]));
        let usual = stage::set(&section, &mut scene, found.has_cell, size)?;
        let Stated { settings, automatic } = settings::stated(&root, Usual::Staged(usual))?;
        scene.settings = settings;
        Ok((scene.with_sky(), automatic))
    }
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

/// The default name of a scene: the name of its file, without folders and extension.
fn stem(name: &str) -> String {
    escape(&Path::new(name).file_stem().unwrap_or_default().to_string_lossy())
}
