//! Scenes for the tests of this crate.

use crate::camera::Camera;
use crate::color::Rgb;
use crate::material::Material;
use crate::settings::Settings;
use crate::sphere::Sphere;
use crate::world::Scene;
use glam::Vec3;

/// Grey balls, each with centre, radius and radiance. The eye is beside the origin.
pub(crate) fn balls(balls: &[(Vec3, f32, f32)]) -> Scene {
    let sphere = |&(center, radius, radiance): &(Vec3, f32, f32)| Sphere {
        center,
        velocity: Vec3::ZERO,
        radius,
        material: 0,
        emission: Rgb::splat(radiance),
    };
    Scene {
        name: String::new(),
        camera: Camera { eye: Vec3::new(0.0, -3.0, 0.0), ..Camera::default() },
        materials: vec![Material::Diffuse { albedo: Rgb::splat(0.5) }],
        spheres: balls.iter().map(sphere).collect(),
        background: Rgb::ZERO,
        transparent_background: false,
        settings: Settings::default(),
        imports: Vec::new(),
    }
}
