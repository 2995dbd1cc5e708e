//! Spheres, the only shape.

use crate::color::Rgb;
use glam::Vec3;

/// A sphere. It may emit light, and it may move along a line while the shutter is open.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Centre at shutter time 0, in scene units.
    pub center: Vec3,
    /// Displacement of the centre per unit of shutter time; zero for a sphere at rest.
    pub velocity: Vec3,
    /// Radius in scene units, positive.
    pub radius: f32,
    /// Index into [`crate::Scene::materials`].
    pub material: u32,
    /// Radiance per channel that every point of the surface emits to both of its sides, equally in all directions
    /// (Lambertian). Zero for a sphere that is not a light. It adds to what the material reflects.
    pub emission: Rgb,
}

impl Sphere {
    /// The sphere at rest where it is at shutter time `time`.
    #[must_use]
    pub fn at(&self, time: f32) -> Self {
        Self { center: self.center + self.velocity * time, velocity: Vec3::ZERO, ..*self }
    }

    /// True if the sphere emits in any channel.
    pub fn is_emitter(&self) -> bool {
        self.emission != Rgb::ZERO
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sphere_is_at_rest_where_it_is() {
        let moving = Sphere {
            center: Vec3::new(1.0, 2.0, 3.0),
            velocity: Vec3::new(2.0, 0.0, -4.0),
            radius: 0.5,
            material: 3,
            emission: Rgb::X,
        };
        let at = moving.at(0.5);
        assert_eq!(at, Sphere { center: Vec3::new(2.0, 2.0, 1.0), velocity: Vec3::ZERO, ..moving });
        assert!(moving.is_emitter() && !Sphere { emission: Rgb::ZERO, ..moving }.is_emitter());
    }
}
