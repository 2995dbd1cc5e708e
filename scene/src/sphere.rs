//! The only shape there is.

use crate::color::Rgb;
use glam::Vec3;

/// A sphere that may emit, and that may move along a line while the shutter is open.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Centre at shutter time 0, in scene units.
    pub center: Vec3,
    /// Displacement of the centre per unit of shutter time; zero for what stands still.
    pub velocity: Vec3,
    /// Radius in scene units, positive.
    pub radius: f32,
    /// Index into [`crate::Scene::materials`].
    pub material: u32,
    /// Radiance that every point of the surface emits to both of its sides, in all directions alike
    /// (Lambertian), per channel; zero for what does not glow. It comes on top of what the material reflects.
    pub emission: Rgb,
}

impl Sphere {
    /// The sphere as it stands at shutter time `time`.
    #[must_use]
    pub fn at(&self, time: f32) -> Self {
        Self { center: self.center + self.velocity * time, velocity: Vec3::ZERO, ..*self }
    }

    /// True if the sphere emits in any channel.
    pub fn is_emitter(&self) -> bool {
        self.emission != Rgb::ZERO
    }
}
