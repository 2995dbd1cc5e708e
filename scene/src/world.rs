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
    /// Whether images are written with alpha in place of the background where the camera sees it; it lights the scene all
    /// the same ([`Scene::background_alone`]). Engines do not read this field.
    pub transparent_background: bool,
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
    ///     transparent_background: false,
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
        // Around an eye that is alone and has no lens, any size will do.
        let radius = if radius > 0.0 { radius * SKY_MARGIN } else { 1.0 };
        let sky = Sphere {
            center,
            velocity: Vec3::ZERO,
            radius: radius as f32,
            material: self.materials.len() as u32,
            emission: self.background,
        };
        self.spheres.push(sky);
        self.materials.push(Material::Diffuse { albedo: Rgb::ZERO });
    }

    /// The scene in which the background alone is seen: it has the radiance 1, nothing else emits light, and everything but
    /// glass is black. Its image is the share of each pixel through which the camera sees the background, directly or by
    /// way of glass, with the tint of that.
    ///
    /// Camera paths have the random numbers of this scene's, and end where they do or at the first surface that is not
    /// glass. So the image of `n` iterations holds exactly the samples of this scene's that reached the background.
    #[must_use]
    pub fn background_alone(&self) -> Self {
        let black = Material::Diffuse { albedo: Rgb::ZERO };
        let seen_through = |material: &Material| if material.is_opaque() { black } else { *material };
        let dark = |sphere: &Sphere| Sphere { emission: Rgb::ZERO, ..*sphere };
        // Exact sizes, as memory that grows is copied once more for the sky.
        let own = self.without_sky();
        let mut spheres = Vec::with_capacity(own.len() + 1);
        spheres.extend(own.iter().map(dark));
        Self {
            name: self.name.clone(),
            camera: self.camera,
            materials: self.materials.iter().map(seen_through).collect(),
            spheres: spheres.into(),
            background: Rgb::ONE,
            transparent_background: false,
            settings: self.settings,
            imports: Vec::new(),
        }
        .with_sky()
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

    /// One sphere is outermost at the end of the exposure, another at its beginning; of the far eye the lens is as well.
    #[test]
    fn the_sky_lies_around_everything_as_long_as_the_shutter_is_open() {
        for (distance, lens) in [(300.0, 20.0), (3000.0, 200.0)] {
            let eye = Vec3::Z * distance;
            let at = |center: Vec3, velocity: Vec3, radius: f32| Sphere {
                center,
                velocity,
                radius,
                material: 0,
                emission: Rgb::ZERO,
            };
            let moving = [
                at(Vec3::X * 10.0, Vec3::X * 100.0, 1.0),
                at(Vec3::Y * -10.0, Vec3::Y * 200.0, 5.0),
                at(Vec3::ZERO, Vec3::ZERO, 2.0),
            ];
            let scene = Scene {
                name: "moving".into(),
                camera: Camera { eye, aperture_radius: lens, shutter: [-1.0, 2.0], ..Camera::default() },
                materials: Vec::new(),
                spheres: moving.to_vec().into(),
                background: Rgb::ONE,
                transparent_background: false,
                settings: Settings::default(),
                imports: Vec::new(),
            };
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

    fn ball(x: f32, material: u32) -> Sphere {
        Sphere { center: Vec3::X * x, velocity: Vec3::ZERO, radius: 0.25, material, emission: Rgb::ZERO }
    }

    /// What is of files of particles comes after what is the scene's own, and before the sky.
    #[test]
    fn own_spheres_and_materials_are_those_before_the_first_import() {
        let import = |spheres, materials| Import {
            file: "a.xyz".into(),
            digest: String::new(),
            table: String::new(),
            spheres,
            materials,
        };
        let mut scene = crate::test_scenes::balls(&[(Vec3::Y, 0.5, 1.0), (Vec3::Z, 0.5, 0.0)]);
        scene.spheres.extend([ball(2.0, 1), ball(3.0, 2), ball(4.0, 3)]);
        let own = scene.materials[0];
        scene.materials.extend([Material::Diffuse { albedo: Rgb::ONE }; 3]);
        let all = (scene.spheres.to_vec(), scene.materials.clone());
        let sky = Scene { background: Rgb::X, ..scene.clone() }.with_sky();
        assert_eq!((sky.spheres.len(), sky.materials.len()), (6, 5));
        // Without imports all is the scene's own but the sky and its material.
        for scene in [&scene, &sky] {
            assert_eq!((scene.own_spheres(), scene.own_materials()), (&all.0[..], &all.1[..]));
        }
        for mut scene in [scene, sky] {
            scene.imports = vec![import(2..4, 1..3), import(4..5, 3..4)];
            assert_eq!((scene.own_spheres(), scene.own_materials()), (&all.0[..2], &[own][..]));
            let alone = scene.background_alone();
            assert_eq!((alone.imports.len(), alone.spheres.len(), alone.own_spheres().len()), (0, 6, 5));
        }
    }

    /// A black background is none; around an eye that is alone there is a sky all the same.
    #[test]
    fn a_sky_has_some_size_whatever_is_in_it() {
        let eye = Vec3::new(5.0, 6.0, 7.0);
        let empty = crate::test_scenes::balls(&[]);
        let of = |background: Rgb, aperture_radius: f32| {
            let camera = Camera { eye, aperture_radius, ..empty.camera };
            Scene { camera, background, ..empty.clone() }.with_sky()
        };
        assert_eq!((of(Rgb::ZERO, 0.0).spheres.len(), of(Rgb::ZERO, 0.0).materials.len()), (0, 1));
        for (lens, radius) in [(0.0, 1.0), (2.0, 2.02)] {
            let sky = of(Rgb::Y, lens);
            let expected =
                Sphere { center: eye, velocity: Vec3::ZERO, radius, material: 1, emission: Rgb::Y };
            assert_eq!(sky.spheres[..], [expected]);
        }
    }
}
