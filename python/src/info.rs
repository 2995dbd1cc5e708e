//! What made an image, or what a checkpoint holds.

use crate::errors::{FileError, of_render};
use crate::work::work;
use files::image_file::Tone;
use pyo3::prelude::*;
use render::{LanesName, Made, Note, Renderer};
use scene::{Iterations, Settings};
use serde::Serialize;
use std::path::PathBuf;

/// The JSON that `sppm info --json` prints.
#[derive(Serialize)]
struct Info {
    kind: &'static str,
    version: String,
    transport: u32,
    scene: String,
    scene_digest: String,
    settings: Settings,
    iterations: u32,
    /// The iterations in it, unless they are the first ones.
    #[serde(skip_serializing_if = "Option::is_none")]
    which: Option<Iterations>,
    photons: u64,
    #[serde(flatten)]
    renderer: Renderer,
    lanes: Option<LanesName>,
    exposure: Option<f32>,
    tone: Option<Tone>,
    estimated_error: Option<f64>,
}

impl From<Made> for Info {
    fn from(made: Made) -> Self {
        match made {
            Made::Image(made) => Self {
                kind: "image",
                version: made.version,
                transport: made.transport,
                scene: made.scene,
                scene_digest: made.scene_digest,
                settings: made.settings,
                iterations: made.settings.iterations,
                which: made.which,
                photons: made.photons,
                renderer: made.renderer,
                lanes: made.lanes,
                exposure: made.exposure,
                tone: made.tone,
                estimated_error: made.estimated_error,
            },
            Made::Checkpoint(loaded) => {
                let note = Note::of(&loaded);
                let (scene, account) = (loaded.checkpoint.scene, loaded.checkpoint.account);
                Self {
                    kind: "checkpoint",
                    renderer: note.renderer_of(account.sums),
                    version: account.version,
                    transport: account.transport,
                    scene: scene.name,
                    scene_digest: account.scene,
                    settings: scene.settings,
                    iterations: account.iterations,
                    which: account.which,
                    photons: account.stats.photons,
                    lanes: None,
                    exposure: note.exposure,
                    tone: note.tone,
                    estimated_error: None,
                }
            }
        }
    }
}

/// What made the file `path`, as JSON.
#[pyfunction]
pub(crate) fn info(py: Python, path: PathBuf) -> PyResult<String> {
    let made = work(py, || Made::read(&path))?.map_err(|error| of_render(&error))?;
    serde_json::to_string(&Info::from(made)).map_err(|error| FileError::new_err(error.to_string()))
}
