//! Scenes that threads share, with the sphere that their background becomes.

use crate::errors::of_flaw;
use pyo3::prelude::*;
use scene::{Material, Rgb, Scene, Sphere};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// A scene that threads share. It is locked only while the interpreter's lock is not held.
#[derive(Clone)]
pub(crate) struct Shared(Arc<Mutex<Held>>);

/// A scene, at times with the sphere that its background becomes. That is added where the scene is, so that a render shares
/// the spheres, and removed before the scene is changed.
#[derive(Clone)]
pub(crate) struct Held {
    pub(crate) scene: Scene,
    has_sky: bool,
}

impl Held {
    /// Spheres from files of particles are the scene's own: they can be changed.
    fn new(mut scene: Scene) -> Self {
        scene.imports.clear();
        let has_sky = scene.without_sky().len() < scene.spheres.len();
        Self { scene, has_sky }
    }

    /// Without the sky.
    pub(crate) fn bare(&mut self) -> &mut Scene {
        if std::mem::take(&mut self.has_sky) {
            self.scene.spheres.pop();
            self.scene.materials.pop();
        }
        &mut self.scene
    }

    /// With the sky, as libraries expect it.
    pub(crate) fn whole(&mut self) -> &Scene {
        if !self.has_sky && self.scene.background != Rgb::ZERO {
            self.scene.add_sky();
            self.has_sky = true;
        }
        &self.scene
    }

    /// The spheres but for the sky.
    pub(crate) fn spheres(&self) -> &[Sphere] {
        &self.scene.spheres[..self.scene.spheres.len() - usize::from(self.has_sky)]
    }

    /// The materials but for the sky's.
    pub(crate) fn materials(&self) -> &[Material] {
        &self.scene.materials[..self.scene.materials.len() - usize::from(self.has_sky)]
    }
}

impl Shared {
    pub(crate) fn new(scene: Scene) -> Self {
        Self(Arc::new(Mutex::new(Held::new(scene))))
    }

    /// A copy that changes by itself. It shares the spheres until one of the two is changed.
    pub(crate) fn copy(&self) -> Self {
        let held = self.lock().clone();
        Self(Arc::new(Mutex::new(held)))
    }

    pub(crate) fn lock(&self) -> MutexGuard<'_, Held> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The scene as it can be rendered. It shares the spheres.
    ///
    /// # Errors
    /// If the scene cannot be rendered.
    pub(crate) fn checked(&self) -> PyResult<Scene> {
        let scene = self.lock().whole().clone();
        scene.check().map_err(|flaw| of_flaw(&flaw))?;
        Ok(scene)
    }
}
