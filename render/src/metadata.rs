//! What an image says of itself: enough to know what it is, and to make it again bit for bit.
//!
//! It depends on the render alone, with neither times nor names of machines or files, so that the same render gives
//! the same bytes.

use crate::names::{EngineName, LanesName};
use files::scene_file;
use scene::{Scene, Settings};
use serde::{Deserialize, Serialize};
use std::fmt::Write;

/// Longer scene files are left out.
pub(crate) const MOST_SCENE: usize = 1 << 20;

/// The JSON object that stands in the files.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Metadata {
    /// Of the program that wrote it.
    pub version: String,
    /// The scene's own name.
    pub scene: String,
    /// SHA-256 of the scene, see `files::scene_file::digest`.
    pub scene_digest: String,
    /// Of the render; the iterations are those that the image holds.
    pub settings: Settings,
    /// Photons emitted over all iterations; none by the path tracer.
    pub photons: u64,
    /// What rendered.
    pub engine: EngineName,
    /// On which lanes, if it has any.
    pub lanes: Option<LanesName>,
    /// In stops; only of images that are exposed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub exposure: Option<f32>,
    /// The last estimate of the relative error, if one was asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub estimated_error: Option<f64>,
    /// The scene file with the settings, if it is not too long.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scene_file: Option<String>,
}

impl Metadata {
    /// As it is written: JSON in ASCII.
    pub fn to_note(&self) -> String {
        ascii(&serde_json::to_string(self).unwrap_or_default()) // never fails: it is numbers and texts
    }

    /// As it is read; `None` if the note is no such thing.
    pub fn from_note(note: &str) -> Option<Self> {
        serde_json::from_str(note).ok()
    }
}

/// The scene file of `scene`, if it is short enough to be written into images.
pub(crate) fn scene_file(scene: &Scene, settings: &Settings) -> Option<String> {
    /// No sphere takes fewer bytes: do not make what will not be used.
    const BYTES_PER_SPHERE: usize = 64;
    (scene.spheres.len() <= MOST_SCENE / BYTES_PER_SPHERE)
        .then(|| scene_file::to_text(scene, settings))
        .filter(|text| text.len() <= MOST_SCENE)
}

/// JSON with all that is not ASCII, which stands in strings alone, escaped.
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

    #[test]
    fn notes_are_ascii_and_read_back() {
        let scene = files::builtin::scene("cornell").unwrap();
        let metadata = Metadata {
            version: "1".into(),
            scene: "a \"b\"\\ é \u{1f600}\u{7f}\u{1}".into(),
            scene_digest: scene_file::digest(&scene),
            settings: Settings { initial_radius: 0.1, seed: u64::MAX, ..scene.settings },
            photons: 3,
            engine: EngineName::Fast,
            lanes: Some(LanesName::Emulated),
            exposure: Some(-0.1),
            estimated_error: None,
            scene_file: scene_file(&scene, &scene.settings),
        };
        let note = metadata.to_note();
        assert!(note.bytes().all(|b| (b' '..0x7f).contains(&b)));
        assert_eq!(Metadata::from_note(&note), Some(metadata));
        assert_eq!(Metadata::from_note("{}"), None);
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
}
