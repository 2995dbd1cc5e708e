//! What the page asks for, and what it is told, as JSON.

use render::{EngineName, MethodName};
use scene::Material;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// What a page asks for.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(tag = "type", rename_all = "snake_case")]
pub(crate) enum Request {
    /// The last picture is drawn: the next may come.
    Ack,
    /// Shows another layer.
    Layer {
        /// Its number.
        layer: u32,
    },
    /// Moves the camera.
    Camera {
        /// What the answer is to name.
        id: u32,
        /// The camera.
        camera: CameraParts,
        /// Whether more is to follow at once: then speed counts more than resolution.
        #[serde(default)]
        moving: bool,
    },
    /// Changes a sphere.
    Sphere {
        /// Its number, from 0.
        index: usize,
        /// What is changed.
        #[serde(flatten)]
        parts: SphereParts,
        /// Whether it is changed of all spheres of its style, which are those of its material.
        #[serde(default)]
        styled: bool,
        /// Whether more is to follow at once.
        #[serde(default)]
        moving: bool,
    },
    /// Asks for a sphere that is not listed.
    Describe {
        /// What the answer is to name.
        id: u32,
        /// The number of the sphere, from 0.
        index: usize,
    },
    /// Changes settings.
    Settings(SettingsParts),
    /// Renders by another method or engine.
    Engine {
        /// The method.
        method: MethodName,
        /// The engine.
        engine: EngineName,
    },
    /// Takes back the last change.
    Undo,
    /// Makes the change that was taken back.
    Redo,
    /// Takes back all changes.
    Reset,
    /// Asks what is seen at a place.
    Pick {
        /// What the answer is to name.
        id: u32,
        /// From the left edge of the image, 0, to the right one, 1.
        x: f32,
        /// From the top, 0, to the bottom, 1.
        y: f32,
    },
    /// Pauses the render or lets it go on.
    Pause {
        /// Whether it is to pause.
        paused: bool,
    },
    /// Asks for the image as it is, to be downloaded.
    Keep {
        /// What the answer is to name.
        id: u32,
    },
}

/// A camera as a page gives it. See [`scene::Camera`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct CameraParts {
    pub(crate) eye: [f32; 3],
    pub(crate) direction: [f32; 3],
    pub(crate) up: [f32; 3],
    pub(crate) vertical_fov_degrees: f32,
    pub(crate) aperture_radius: f32,
    pub(crate) focus_distance: f32,
}

/// What may be changed of a sphere; what is not given stays. See [`scene::Sphere`].
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
pub(crate) struct SphereParts {
    pub(crate) center: Option<[f32; 3]>,
    pub(crate) radius: Option<f32>,
    pub(crate) emission: Option<[f32; 3]>,
    pub(crate) material: Option<Material>,
}

/// What may be changed of the settings; what is not given stays. See [`scene::Settings`].
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
pub(crate) struct SettingsParts {
    pub(crate) width: Option<u32>,
    pub(crate) height: Option<u32>,
    pub(crate) photons_per_iteration: Option<u32>,
    pub(crate) max_depth: Option<u32>,
    pub(crate) initial_radius: Option<f32>,
    /// In decimal digits: numbers of JavaScript do not hold all 64 bits.
    pub(crate) seed: Option<String>,
}

/// An answer to one page.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "type", rename_all = "snake_case")]
pub(crate) enum Answer {
    /// A move of the camera was taken; pictures show it from `version` on.
    Taken {
        /// That of the request.
        id: u32,
        /// See [`crate::picture::Caption`].
        version: u32,
    },
    /// What is seen at a place.
    Picked {
        /// That of the request.
        id: u32,
        /// The number of the sphere; `None` for the background.
        sphere: Option<u32>,
        /// The point, in scene units.
        point: Option<[f32; 3]>,
        /// Its distance along the viewing direction, at which the lens would be focused on it.
        depth: Option<f32>,
    },
    /// A sphere, as it is listed.
    Described {
        /// That of the request.
        id: u32,
        /// The sphere, or `None` if there is no such one.
        sphere: Option<Value>,
    },
    /// The image is ready for download at `save/{number}/...`.
    Kept {
        /// That of the request.
        id: u32,
        /// Its number.
        number: u32,
        /// Iterations in it.
        iterations: u32,
        /// The files' name without extension.
        stem: String,
    },
    /// Nothing was changed.
    Refused {
        /// One sentence that says why.
        problem: String,
    },
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Option<Request> {
        serde_json::from_str(text).ok()
    }

    #[test]
    fn requests_are_read() {
        assert_eq!(read(r#"{"type":"ack"}"#), Some(Request::Ack));
        let pick = Request::Pick { id: 3, x: 0.5, y: 0.25 };
        assert_eq!(read(r#"{"type":"pick","id":3,"x":0.5,"y":0.25}"#), Some(pick));
        let material = Some(Material::Diffuse { albedo: [1.0, 0.0, 0.0].into() });
        let parts = SphereParts { material, ..SphereParts::default() };
        let text = r#"{"type":"sphere","index":6,"material":{"type":"diffuse","albedo":[1,0,0]}}"#;
        assert_eq!(read(text), Some(Request::Sphere { index: 6, parts, styled: false, moving: false }));
        let settings = SettingsParts { max_depth: Some(9), ..SettingsParts::default() };
        assert_eq!(read(r#"{"type":"settings","max_depth":9}"#), Some(Request::Settings(settings)));
        for bad in ["", "{}", "[]", r#"{"type":"format_disk"}"#, r#"{"type":"pick","id":-1,"x":0,"y":0}"#] {
            assert_eq!(read(bad), None, "{bad}");
        }
    }
}
