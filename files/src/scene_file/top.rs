//! Reads the head of a scene file: everything but its own materials and spheres.

use super::error::{Fault, escape};
use super::particles::{self, Found, Place};
use super::reader::{Section, Subject};
use super::settings::{self, Stated, Usual};
use super::{camera, sphere, stage};
use scene::{Automatic, Camera, Material, Rgb, Scene, Sphere};
use std::path::Path;
use toml::de::DeTable;

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

/// What the head of a scene file states.
pub(super) struct Top<'a> {
    pub(super) root: Section<'a>,
    pub(super) view: View<'a>,
    /// What it says of settings, beside the usual ones of what it shows before that is seen.
    stated: Stated,
    background: Rgb,
    transparent_background: bool,
    name: String,
}

/// From where the scene is seen.
#[derive(Clone, Copy)]
pub(super) enum View<'a> {
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

    /// The table that says so.
    pub(super) fn section(self) -> Section<'a> {
        match self {
            Self::Camera(section, _) | Self::Stage(section) => section,
        }
    }
}

impl<'a> Top<'a> {
    /// Reads the head, whose root is `root`, of a file with `count` spheres in pieces of their own.
    pub(super) fn read(file: &str, root: &'a DeTable<'a>, count: usize) -> Result<Self, Fault> {
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

    /// The scene with these spheres and those of files of particles, the settings that are left to be chosen, and what the user
    /// should know of the particles.
    pub(super) fn scene(
        self,
        spheres: Vec<Sphere>,
        materials: Vec<Material>,
        place: Place<'_>,
    ) -> Result<(Scene, Automatic, Vec<Fault>), Fault> {
        let Self { root, view, stated, background, transparent_background, name } = self;
        let Stated { settings, automatic } = stated;
        let camera = if let View::Camera(_, camera) = view { camera } else { Camera::default() };
        let (spheres, imports) = (spheres.into(), Vec::new());
        let mut scene =
            Scene { name, camera, spheres, materials, background, transparent_background, settings, imports };
        let mut found = Found { is_centered: matches!(view, View::Stage(_)), ..Found::default() };
        particles::read(&root, place, &mut scene, &mut found)?;
        let View::Stage(section) = view else { return Ok((scene.with_sky(), automatic, found.notes)) };
        let size = [0, 1].map(|side| place.size[side].unwrap_or([settings.width, settings.height][side]));
        let usual = stage::set(&section, &mut scene, found.has_cell, size)?;
        let Stated { settings, automatic } = settings::stated(&root, Usual::Staged(usual))?;
        scene.settings = settings;
        Ok((scene.with_sky(), automatic, found.notes))
    }
}

/// The default name of a scene: the name of its file, without folders and extension.
fn stem(name: &str) -> String {
    escape(&Path::new(name).file_stem().unwrap_or_default().to_string_lossy())
}
