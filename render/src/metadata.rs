//! Metadata stored in images: enough to identify the render and to repeat it bit for bit.
//!
//! It contains no times and no names of machines or files, so that the same render always writes the same bytes.

use crate::choice::EngineChoice;
use crate::names::{LanesName, Renderer};
use files::image_file::Tone;
use files::scene_file;
use scene::{Iterations, Resumable, Scene, Settings, TRANSPORT};
use serde::{Deserialize, Serialize};
use std::fmt::Write;

/// Longer scene files are not stored.
const MOST_SCENE: usize = 1 << 20;

/// The JSON object that is stored in images.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Metadata {
    /// Version of the program that wrote it.
    pub version: String,
    /// Version of the light transport that made it, [`scene::TRANSPORT`]: another one makes another image.
    #[serde(default = "first")]
    pub transport: u32,
    /// The scene's own name.
    pub scene: String,
    /// SHA-256 of the scene, see `files::scene_file::digest`.
    pub scene_digest: String,
    /// Settings of the render, with the number of iterations in the image.
    pub settings: Settings,
    /// The iterations in the image, unless they are the first ones.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub which: Option<Iterations>,
    /// Photons emitted in all iterations; 0 for the path tracer.
    pub photons: u64,
    /// The method and the engine.
    #[serde(flatten)]
    pub renderer: Renderer,
    /// The lanes that it ran on, if it has any.
    pub lanes: Option<LanesName>,
    /// Exposure in stops, if one was given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub exposure: Option<f32>,
    /// Tone curve, of an image for viewing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tone: Option<Tone>,
    /// The last estimate of the relative error, if there is an error goal.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub estimated_error: Option<f64>,
    /// The scene file with the settings, unless it is too long.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scene_file: Option<String>,
}

/// See [`Metadata::transport`]: it was not noted at first.
fn first() -> u32 {
    1
}

impl Metadata {
    /// That of the image which `engine` holds, of a `scene` with this digest ([`scene_file::digest`]) rendered by `choice`.
    /// Exposure, tone curve, error and
    /// which iterations they are, if not the first, are left out.
    pub fn of(engine: &dyn Resumable, scene: &Scene, digest: &str, choice: EngineChoice) -> Self {
        let done = engine.iterations();
        // The number of iterations in the image, which may be fewer than requested.
        let settings = Settings { iterations: done.max(1), ..*engine.settings() };
        let photons = u64::from(settings.photons_per_iteration) * u64::from(done);
        Self {
            version: env!("CARGO_PKG_VERSION").into(),
            transport: TRANSPORT,
            scene: scene.name.clone(),
            scene_digest: digest.into(),
            settings,
            which: None,
            photons: if engine.has_photons() { photons } else { 0 },
            renderer: choice.renderer(),
            lanes: choice.lanes(),
            exposure: None,
            tone: None,
            estimated_error: None,
            scene_file: scene_file(scene, &settings),
        }
    }

    /// The text stored in images: JSON in ASCII.
    pub fn to_note(&self) -> String {
        ascii(&serde_json::to_string(self).unwrap_or_default()) // cannot fail: there are only numbers and strings
    }

    /// Parses the text stored in an image; `None` if it is not valid metadata.
    pub fn from_note(note: &str) -> Option<Self> {
        serde_json::from_str(note).ok()
    }
}

/// The scene file of `scene`, if it is short enough to be stored in images.
pub(crate) fn scene_file(scene: &Scene, settings: &Settings) -> Option<String> {
    /// The text of a sphere is at least this long, so scenes with more spheres need not be written out to be measured.
    const BYTES_PER_SPHERE: usize = 64;
    (scene.own_spheres().len() <= MOST_SCENE / BYTES_PER_SPHERE)
        .then(|| scene_file::to_portable_text(scene, settings))
        .filter(|text| text.len() <= MOST_SCENE)
}

/// JSON with all non-ASCII characters escaped; they occur only in strings.
fn ascii(json: &str) -> String {
    let mut text = String::with_capacity(json.len());
    for c in json.chars() {
        if c.is_ascii() && c != '\u{7f}' {
            text.push(c);
        } else {
            for unit in c.encode_utf16(&mut [0; 2]) {
                let _ = write!(text, "\\u{unit:04x}"); // writing to a String cannot fail
            }
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::names::MethodName;

    #[test]
    fn notes_are_ascii_and_read_back() {
        let scene = files::builtin::scene("cornell").unwrap();
        let metadata = Metadata {
            version: "1".into(),
            transport: 7,
            scene: "a \"b\"\\ é \u{1f600}\u{7f}\u{1}".into(),
            scene_digest: scene_file::digest(&scene),
            settings: Settings { initial_radius: 0.1, seed: u64::MAX, ..scene.settings },
            which: Some((2..5).into()),
            photons: 3,
            renderer: Renderer::default(),
            lanes: Some(LanesName::Emulated),
            exposure: Some(-0.1),
            tone: Some(Tone::Reinhard { white: 0.1 }),
            estimated_error: None,
            scene_file: scene_file(&scene, &scene.settings),
        };
        let note = metadata.to_note();
        assert!(note.bytes().all(|b| (b' '..0x7f).contains(&b)));
        assert_eq!(Metadata::from_note(&note), Some(metadata));
        assert_eq!(Metadata::from_note("{}"), None);
        let unnoted = note.replace(r#""transport":7,"#, "");
        assert_eq!(Metadata::from_note(&unnoted).map(|old| old.transport), Some(1));
        // Earlier versions had three engines, and no methods.
        let old = note.replace(r#""method":"sppm","engine":"fast""#, r#""engine":"path""#);
        assert_ne!(old, note);
        assert_eq!(Metadata::from_note(&old).map(|old| old.renderer), Some(MethodName::Path.into()));
    }

    #[test]
    fn long_scenes_are_left_out() {
        let mut scene = files::builtin::scene("cornell").unwrap();
        scene.spheres = scene.spheres.iter().copied().cycle().take(1 << 14).collect();
        assert_eq!(scene_file(&scene, &scene.settings), None);
        scene.spheres.extend_from_within(..);
        assert_eq!(scene_file(&scene, &scene.settings), None);
        scene.spheres.truncate(1 << 12);
        assert!(scene_file(&scene, &scene.settings).is_some());
    }

    /// However many spheres a file of particles has, the scene's own text names it in a few lines.
    #[test]
    fn particles_do_not_make_a_scene_too_long() {
        let mut scene = files::builtin::scene("cornell").unwrap();
        let (own, materials) = (scene.spheres.len(), scene.materials.len());
        let particle = scene.spheres[0];
        scene.spheres.extend(std::iter::repeat_n(particle, 1 << 15));
        scene.imports = vec![scene::Import {
            file: "/a/atoms.xyz".into(),
            digest: "0123".into(),
            table: String::new(),
            spheres: own..scene.spheres.len(),
            materials: materials..materials,
        }];
        let text = scene_file(&scene, &scene.settings).unwrap();
        assert!(text.contains("atoms.xyz") && text.len() < 1 << 14, "{} bytes", text.len());
    }
}
