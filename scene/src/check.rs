//! Whether a scene can be rendered: every number in its range, the lens clear of opaque surfaces, light where the eye is.
//!
//! Scene files, checkpoints and scenes that are built in code all pass the same checks.

use crate::camera::Camera;
use crate::color::Rgb;
use crate::material::Material;
use crate::settings::RADIUS_RANGE;
use crate::sphere::Sphere;
use crate::still::Lights;
use crate::world::Scene;
use glam::{DVec3, Vec3};
use std::fmt;

/// Greatest absolute value of a coordinate, a length or a channel of radiance, so that squares stay in the range of `f32`.
pub const LIMIT: f64 = 1e15;
/// Greatest index of refraction: far beyond any real material (germanium has 4), yet small enough that the products of
/// squared indices along a path stay in the range of `f32`.
pub const MAX_IOR: f32 = 100.0;
/// Sine of the least allowed angle between the viewing direction and up.
const PARALLEL: f64 = 1e-6;
/// Least distance of the eye from an opaque surface, relative to the coordinates and radius involved. Any closer, and
/// rounding to `f32` would decide on which side of the surface the eye is.
const CLEARANCE: f64 = 1e-6;

/// A part of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// The scene itself.
    Scene,
    /// The camera.
    Camera,
    /// A material, by its index.
    Material(usize),
    /// A sphere, by its index.
    Sphere(usize),
}

/// Why a scene cannot be rendered. Displays as a sentence that counts spheres and materials from 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Flaw {
    /// The part at fault.
    pub part: Part,
    /// The name of the value at fault in scene files.
    pub key: &'static str,
    /// What is wrong.
    pub problem: Problem,
}

/// What is wrong with a value of a scene.
#[derive(Clone, Debug, PartialEq)]
pub enum Problem {
    /// The value is out of its range; the rest of a sentence that begins with it.
    Range(String),
    /// The velocity takes the sphere too far.
    Escapes,
    /// The sphere passes over the eye while the shutter is open.
    PassesEye,
    /// The lens of this radius cuts through the surface of the sphere with this index.
    LensCuts(f32, usize),
    /// The eye lies on the surface of the sphere with this index.
    EyeOn(usize),
    /// There is neither a lamp nor a background.
    NoLight,
    /// Light from none of the lamps can reach the eye.
    Sealed,
    /// The power of all lamps is not a normal `f32`.
    Power,
}

impl Flaw {
    fn new(part: Part, key: &'static str, problem: Problem) -> Self {
        Self { part, key, problem }
    }

    fn range(part: Part, key: &'static str, problem: impl Into<String>) -> Self {
        Self::new(part, key, Problem::Range(problem.into()))
    }

    /// The sentence, with `name` for the names of parts.
    pub fn say(&self, name: impl Fn(Part) -> String) -> String {
        const CHOICE: &str = "it must lie clearly inside or outside of an opaque sphere";
        let sphere = |i: &usize| name(Part::Sphere(*i));
        let part = name(self.part);
        match &self.problem {
            Problem::Range(problem) => format!("{} of {part} {problem}", self.key),
            Problem::Escapes => {
                format!("velocity of {part} takes it beyond {LIMIT:e} while the shutter is open")
            }
            Problem::PassesEye => {
                format!("{part} passes over the eye while the shutter is open; keep it clear of the eye")
            }
            Problem::LensCuts(lens, i) => {
                format!("the lens, {lens} around eye, cuts through {}; {CHOICE}", sphere(i))
            }
            Problem::EyeOn(i) => format!("eye of {part} lies on the surface of {}; {CHOICE}", sphere(i)),
            Problem::NoLight => {
                "there is no light; give a sphere an emission = [r, g, b], or the scene a background".into()
            }
            Problem::Sealed => "no light reaches the eye: opaque spheres seal every light off; \
                put a light into the space that the eye is in"
                .into(),
            Problem::Power => {
                "the power of all lights, the sum of 4 (pi radius)^2 emission, is beyond the range of \
                a 32-bit float; take another unit for emission or for length"
                    .into()
            }
        }
    }
}

impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Scene => write!(f, "the scene"),
            Self::Camera => write!(f, "the camera"),
            Self::Material(i) => write!(f, "material {}", i + 1),
            Self::Sphere(i) => write!(f, "sphere {}", i + 1),
        }
    }
}

impl fmt::Display for Flaw {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.say(|part| part.to_string()))
    }
}

impl std::error::Error for Flaw {}

impl Scene {
    /// Checks that the scene can be rendered. A background must be a sky already ([`Scene::with_sky`]). The settings
    /// have a check of their own, [`crate::Settings::validate`].
    ///
    /// # Errors
    /// The first flaw.
    pub fn check(&self) -> Result<(), Flaw> {
        self.check_ranges()?;
        self.check_places()?;
        self.check_light()
    }

    /// Checks every number by itself.
    fn check_ranges(&self) -> Result<(), Flaw> {
        check_camera(&self.camera)?;
        for (i, material) in self.materials.iter().enumerate() {
            check_material(Part::Material(i), material)?;
        }
        check_radiance(Part::Scene, "background", self.background)?;
        for (i, sphere) in self.without_sky().iter().enumerate() {
            check_sphere(Part::Sphere(i), sphere, self.materials.len())?;
        }
        let last = self.spheres.last().map_or(Rgb::ZERO, |sphere| sphere.emission);
        if self.background != Rgb::ZERO && last != self.background {
            let problem = "is no light yet; let the scene make it one (with_sky)";
            return Err(Flaw::range(Part::Scene, "background", problem));
        }
        Ok(())
    }

    /// Checks the paths of moving spheres, and that the lens stays on one side of each opaque surface.
    ///
    /// # Errors
    /// The first flaw.
    pub fn check_places(&self) -> Result<(), Flaw> {
        for (i, sphere) in self.without_sky().iter().enumerate() {
            self.check_motion(i, sphere)?;
            self.check_lens(i, sphere)?;
        }
        Ok(())
    }

    /// Checks that light reaches the eye.
    ///
    /// # Errors
    /// If none does.
    pub fn check_light(&self) -> Result<(), Flaw> {
        if !self.spheres.iter().any(Sphere::is_emitter) {
            return Err(Flaw::new(Part::Scene, "background", Problem::NoLight));
        }
        let [open, close] = self.camera.shutter;
        self.check_lights(&self.lights_at(open))?;
        if close > open && self.spheres.iter().any(|s| s.velocity != Vec3::ZERO) {
            self.check_lights(&self.lights_at(close))?;
        }
        Ok(())
    }

    /// The spheres but for the sky that [`Scene::with_sky`] has added.
    pub fn without_sky(&self) -> &[Sphere] {
        let skies = usize::from(self.background != Rgb::ZERO).min(self.spheres.len());
        &self.spheres[..self.spheres.len() - skies]
    }

    fn check_motion(&self, i: usize, sphere: &Sphere) -> Result<(), Flaw> {
        if sphere.velocity == Vec3::ZERO {
            return Ok(());
        }
        let stays = |time| f64::from(sphere.at(time).center.abs().max_element()) <= LIMIT;
        if self.camera.shutter.into_iter().all(stays) {
            Ok(())
        } else {
            Err(Flaw::new(Part::Sphere(i), "velocity", Problem::Escapes))
        }
    }

    /// Checks that the whole lens stays on one side of the surface of sphere `i` while the shutter is open.
    fn check_lens(&self, i: usize, sphere: &Sphere) -> Result<(), Flaw> {
        let camera = &self.camera;
        if !self.materials[sphere.material as usize].is_opaque() {
            return Ok(());
        }
        let eye = camera.eye.as_dvec3();
        let [open, close] = camera.shutter.map(|time| sphere.at(time).center.as_dvec3() - eye);
        let (lens, r) = (f64::from(camera.aperture_radius), f64::from(sphere.radius));
        let slack = CLEARANCE * (r + eye.abs().max_element());
        let clear = |from: DVec3, to: DVec3, lens: f64| {
            let farthest = from.length().max(to.length());
            nearest(from, to) - lens > r + slack || farthest + lens < r - slack
        };
        if clear(open, close, lens) {
            Ok(())
        } else if clear(open, close, 0.0) {
            let cuts = Problem::LensCuts(camera.aperture_radius, i);
            Err(Flaw::new(Part::Camera, "aperture_radius", cuts))
        } else if sphere.velocity != Vec3::ZERO && clear(open, open, 0.0) {
            Err(Flaw::new(Part::Sphere(i), "velocity", Problem::PassesEye))
        } else {
            Err(Flaw::new(Part::Camera, "eye", Problem::EyeOn(i)))
        }
    }

    fn check_lights(&self, lights: &Lights) -> Result<(), Flaw> {
        let problem = if lights.entries.is_empty() {
            Problem::Sealed
        } else if !lights.power.is_normal() {
            Problem::Power
        } else {
            return Ok(());
        };
        Err(match self.without_sky().iter().position(Sphere::is_emitter) {
            Some(i) => Flaw::new(Part::Sphere(i), "emission", problem),
            None => Flaw::new(Part::Scene, "background", problem),
        })
    }
}

fn check_camera(camera: &Camera) -> Result<(), Flaw> {
    let flaw = |key, problem: &str| Err(Flaw::range(Part::Camera, key, problem));
    check_vector(Part::Camera, "eye", camera.eye)?;
    for (key, vector) in [("direction", camera.direction), ("up", camera.up)] {
        if vector == Vec3::ZERO || !vector.is_finite() {
            return flaw(key, "must be finite numbers, not all zero");
        }
    }
    if is_parallel(camera.up, camera.direction) {
        return flaw("up", "is parallel to the viewing direction; take another, say [0, 0, 1]");
    }
    if !(camera.vertical_fov_degrees > 0.0 && camera.vertical_fov_degrees < 180.0) {
        return flaw("vertical_fov_degrees", "is outside (0, 180)");
    }
    if !(0.0..=LIMIT).contains(&camera.aperture_radius.into()) {
        return flaw("aperture_radius", "must be a finite number, at least 0; 0 is a pinhole");
    }
    if !(camera.focus_distance > 0.0 && camera.focus_distance.is_finite()) {
        return flaw("focus_distance", "must be a finite number above 0, the distance from the eye");
    }
    let [open, close] = camera.shutter;
    if !(open <= close && [open, close].iter().all(|time| f64::from(time.abs()) <= LIMIT)) {
        return flaw("shutter", "must be two finite numbers [open, close], the second not below the first");
    }
    Ok(())
}

/// Whether `up` is no use for a camera that looks along `direction`; neither is zero.
pub fn is_parallel(up: Vec3, direction: Vec3) -> bool {
    let sine = direction.as_dvec3().normalize().cross(up.as_dvec3().normalize()).length();
    sine <= PARALLEL
}

fn check_material(part: Part, material: &Material) -> Result<(), Flaw> {
    if !material.albedo().to_array().iter().all(|channel| (0.0..=1.0).contains(channel)) {
        return Err(Flaw::range(part, "albedo", "is outside [0, 1]"));
    }
    match material {
        Material::Dielectric { ior, .. } if !(1.0..=MAX_IOR).contains(ior) => {
            Err(Flaw::range(part, "ior", format!("must be a number from 1 to {MAX_IOR}; glass has 1.5")))
        }
        _ => Ok(()),
    }
}

fn check_sphere(part: Part, sphere: &Sphere, materials: usize) -> Result<(), Flaw> {
    check_vector(part, "center", sphere.center)?;
    let [low, high] = RADIUS_RANGE;
    if !(low..=high).contains(&sphere.radius) {
        return Err(Flaw::range(part, "radius", format!("must be above 0 (from {low:e} to {high:e})")));
    }
    if sphere.material as usize >= materials {
        let problem = format!("is index {} of {materials} materials", sphere.material);
        return Err(Flaw::range(part, "material", problem));
    }
    check_radiance(part, "emission", sphere.emission)?;
    check_vector(part, "velocity", sphere.velocity)
}

fn check_vector(part: Part, key: &'static str, vector: Vec3) -> Result<(), Flaw> {
    if vector.to_array().iter().all(|x| f64::from(x.abs()) <= LIMIT) {
        Ok(())
    } else {
        Err(Flaw::range(part, key, format!("must be finite numbers from -{LIMIT:e} to {LIMIT:e}")))
    }
}

fn check_radiance(part: Part, key: &'static str, radiance: Rgb) -> Result<(), Flaw> {
    if radiance.to_array().iter().all(|&channel| (0.0..=LIMIT).contains(&channel.into())) {
        Ok(())
    } else {
        Err(Flaw::range(part, key, format!("is outside [0, {LIMIT:e}]")))
    }
}

/// Distance of the origin from the segment between two points.
fn nearest(from: DVec3, to: DVec3) -> f64 {
    let along = to - from;
    let length_squared = along.length_squared();
    let t = if length_squared > 0.0 { (-from.dot(along) / length_squared).clamp(0.0, 1.0) } else { 0.0 };
    (from + along * t).length()
}
