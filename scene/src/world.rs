//! The scene: camera, spheres, materials and background, as a scene file states them.

use crate::camera::Camera;
use crate::color::Rgb;
use crate::import::Import;
use crate::material::Material;
use crate::settings::Settings;
use crate::sphere::Sphere;
use crate::spheres::Spheres;
use glam::{DVec3, Vec3};

/// A scene. [`Scene::check`] says whether it can be rendered; scenes read from files have passed it.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// The name of the scene.
    pub name: String,
    /// The camera that sees it.
    pub camera: Camera,
    /// The materials that spheres refer to.
    pub materials: Vec<Material>,
    /// The spheres, in file order. Of two hits at the same distance, the sphere with the lower index counts.
    pub spheres: Spheres,
    /// Radiance that arrives from every direction in which there is no sphere; zero for black.
    ///
    /// [`Scene::with_sky`] turns it into a sphere, the last of `spheres`. Engines do not read this field.
    pub background: Rgb,
    /// Settings that suit the scene; the command line may override each.
    pub settings: Settings,
    /// Which of `spheres` come from files of particles: the last ones but for the sky, in this order. Engines do not read
    /// this field.
    pub imports: Vec<Import>,
}

/// The sky is larger than needed by this factor, so that nothing touches it by rounding.
const SKY_MARGIN: f64 = 1.01;

impl Scene {
    /// True if some sphere moves while the shutter is open.
    pub fn moves(&self) -> bool {
        self.spheres.iter().any(|s| s.velocity != Vec3::ZERO)
    }

    /// The scene with its background as a light: a black diffuse sphere around everything, which emits
    /// `background` and comes last of the spheres. A scene with a black background is returned as it is.
    ///
    /// Radiance does not change along a ray, so a uniform sky gives the same image at any distance. Like every emitter,
    /// the sky lights surfaces, casts caustics and is visible. Its photons are aimed at what the eye depends on
    /// ([`crate::aim`]), however wide it is. If the eye is inside an opaque sphere, the sky is hidden: it is not treated
    /// as a light, and no photon is lost.
    ///
    /// ```
    /// use scene::{Camera, Rgb, Scene, Settings, Spheres};
    ///
    /// let camera = Camera::default();
    /// let (spheres, materials) = (Spheres::default(), Vec::new());
    /// let scene = Scene {
    ///     name: "fog".into(),
    ///     camera,
    ///     spheres,
    ///     materials,
    ///     background: Rgb::ONE,
    ///     settings: Settings::default(),
    ///     imports: Vec::new(),
    /// };
    /// assert_eq!(scene.with_sky().spheres.len(), 1);
    /// ```
    #[must_use]
    pub fn with_sky(mut self) -> Self {
        self.add_sky();
        self
    }

    /// As [`Scene::with_sky`], of a scene that has no sky yet.
    pub fn add_sky(&mut self) {
        if self.background == Rgb::ZERO {
            return;
        }
        let (center, radius) = self.bounding_ball();
        let sky = Sphere {
            center,
            velocity: Vec3::ZERO,
            radius: (radius * SKY_MARGIN) as f32,
            material: self.materials.len() as u32,
            emission: self.background,
        };
        self.spheres.push(sky);
        self.materials.push(Material::Diffuse { albedo: Rgb::ZERO });
    }

    /// The spheres that are not from files of particles, nor the sky.
    pub fn own_spheres(&self) -> &[Sphere] {
        let spheres = self.without_sky();
        let own = self.imports.first().map_or(spheres.len(), |import| import.spheres.start);
        &spheres[..own.min(spheres.len())]
    }

    /// The materials of [`Self::own_spheres`], used or not.
    pub fn own_materials(&self) -> &[Material] {
        let skies = self.spheres.len() - self.without_sky().len();
        let materials = &self.materials[..self.materials.len().saturating_sub(skies)];
        let own = self.imports.first().map_or(materials.len(), |import| import.materials.start);
        &materials[..own.min(materials.len())]
    }

    /// Centre and radius of a ball that contains the lens and every sphere while the shutter is open.
    fn bounding_ball(&self) -> (Vec3, f64) {
        let camera = &self.camera;
        let at_open_and_close =
            |s: &Sphere| camera.shutter.map(|time| (s.at(time).center.as_dvec3(), f64::from(s.radius)));
        let lens = (camera.eye.as_dvec3(), f64::from(camera.aperture_radius));
        let balls = || std::iter::once(lens).chain(self.spheres.iter().flat_map(at_open_and_close));
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for (center, radius) in balls() {
            low = low.min(center - radius);
            high = high.max(center + radius);
        }
        let center = (0.5 * (low + high)).as_vec3();
        let reach = |(c, r): (DVec3, f64)| c.distance(center.as_dvec3()) + r;
        (center, balls().map(reach).fold(0.0, f64::max))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One sphere is outermost at the end of the exposure, another at its beginning.
    #[test]
    fn the_sky_lies_around_everything_as_long_as_the_shutter_is_open() {
        let mut scene = Scene {
            name: "moving".into(),
            camera: Camera::default(),
            materials: Vec::new(),
            spheres: Spheres::default(),
            background: Rgb::ONE,
            settings: Settings::default(),
            imports: Vec::new(),
        };
        let at = |center: Vec3, velocity: Vec3, radius: f32| Sphere {
            center,
            velocity,
            radius,
            material: 0,
            emission: Rgb::ZERO,
        };
        scene.camera.shutter = [-1.0, 2.0];
        scene.camera.eye = Vec3::new(0.0, 0.0, 300.0);
        scene.camera.aperture_radius = 20.0;
        scene.spheres = vec![
            at(Vec3::X * 10.0, Vec3::X * 100.0, 1.0),
            at(Vec3::Y * -10.0, Vec3::Y * 200.0, 5.0),
            at(Vec3::ZERO, Vec3::ZERO, 2.0),
        ]
        .into();
        let moving = scene.spheres.clone();
        let (eye, lens) = (scene.camera.eye, scene.camera.aperture_radius);
        let scene = scene.with_sky();
        let sky = *scene.spheres.last().unwrap();
        assert_eq!((sky.velocity, sky.emission), (Vec3::ZERO, Rgb::ONE));
        assert_eq!(scene.materials[sky.material as usize], Material::Diffuse { albedo: Rgb::ZERO });
        let reach = |center: Vec3, radius: f32| center.distance(sky.center) + radius;
        let farthest = scene
            .camera
            .shutter
            .into_iter()
            .flat_map(|time| moving.iter().map(move |s| reach(s.at(time).center, s.radius)))
            .fold(reach(eye, lens), f32::max);
        // Nothing touches the sky, and it is not much larger than needed.
        let share = farthest / sky.radius;
        assert!((0.98..0.995).contains(&share), "the farthest is at {share} of the sky's radius");
    }
}
