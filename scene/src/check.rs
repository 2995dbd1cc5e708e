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
/// Least distance of the eye from an opaque surface, relative to the coordinates involved. Any closer, and rounding to `f32`
/// would decide on which side of the surface the eye is. The radius counts as well if the sphere moves, as its centre is then
/// rounded anew at each instant. If not, a millionth of the radius counts, for roundings in `f64`.
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
    /// Light from none of the lamps can reach the eye; with the sphere that hides the first lamp, if it is one alone.
    Sealed(Option<(Seal, usize)>),
    /// Light from this lamp cannot reach the space that the eye is in.
    Hidden {
        /// The sphere that hides it by itself, if there is one.
        by: Option<(Seal, usize)>,
        /// How many other lamps are hidden too.
        others: usize,
    },
    /// The power of all lamps is not a normal `f32`.
    Power,
}

/// How a sphere keeps the light of a lamp from the eye.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Seal {
    /// It lies where the lamp does.
    Coincides,
    /// It encloses the eye, and no part of the lamp's surface.
    HoldsEye,
    /// It encloses the lamp and not the eye.
    HoldsLamp,
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
            Problem::Sealed(seal) => {
                let what = match seal {
                    Some((Seal::Coincides, i)) => {
                        let sphere = sphere(i);
                        return format!(
                            "no light reaches the eye: {sphere} is opaque and lies exactly where {part} does; remove one"
                        );
                    }
                    Some((Seal::HoldsEye, i)) => format!("{} encloses the eye and no light", sphere(i)),
                    Some((Seal::HoldsLamp, i)) => format!("{} encloses {part}", sphere(i)),
                    None => "opaque spheres seal every light off".into(),
                };
                format!("no light reaches the eye: {what}; put a light into the space that the eye is in")
            }
            Problem::Hidden { by, others } => {
                let others = match others {
                    0 => String::new(),
                    1 => ", as does another lamp".into(),
                    _ => format!(", as do {others} other lamps"),
                };
                let why = match by {
                    Some((Seal::Coincides, i)) => {
                        format!("{} is opaque and lies exactly where it does; remove one", sphere(i))
                    }
                    Some((Seal::HoldsEye, i)) => format!("{} encloses the eye and not it", sphere(i)),
                    Some((Seal::HoldsLamp, i)) => format!("{} is opaque and encloses it", sphere(i)),
                    None => "opaque spheres seal it off".into(),
                };
                format!("{part} lights nothing{others}: {why}")
            }
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
        self.check_light().map(|_| ())
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

    /// Checks that light reaches the space that the eye is in. Returns what is to be told of lamps whose light does not, if
    /// there are any.
    ///
    /// # Errors
    /// If none does.
    pub fn check_light(&self) -> Result<Option<Flaw>, Flaw> {
        if !self.spheres.iter().any(Sphere::is_emitter) {
            return Err(Flaw::new(Part::Scene, "background", Problem::NoLight));
        }
        let [open, close] = self.camera.shutter;
        let lights = self.lights_at(open);
        self.check_lights(&lights, open)?;
        let moves = close > open && self.spheres.iter().any(|s| s.velocity != Vec3::ZERO);
        if moves {
            self.check_lights(&self.lights_at(close), close)?;
        }
        let mut shines = vec![false; self.spheres.len()];
        lights.entries.iter().for_each(|light| shines[light.sphere as usize] = true);
        let lamps = self.without_sky().iter().enumerate();
        let hidden = lamps.filter(|(i, sphere)| sphere.is_emitter() && !shines[*i]).map(|(i, _)| i);
        Ok(self.told_of(hidden, moves))
    }

    /// What is to be told of lamps that are hidden when the shutter opens. If something moves, a lamp is told only if one sphere
    /// holds it all the time.
    fn told_of(&self, mut hidden: impl Iterator<Item = usize>, moves: bool) -> Option<Flaw> {
        let [open, close] = self.camera.shutter;
        let seal = |lamp, time| self.seal(Some(lamp), time);
        // Paths are straight, so what is within a sphere at both ends is within it in between.
        let stays_held = |lamp: &usize| matches!(seal(*lamp, open), held @ Some((Seal::HoldsLamp | Seal::Coincides, _)) if held == seal(*lamp, close));
        let first = if moves { hidden.find(stays_held) } else { hidden.next() }?;
        let others = if moves { 0 } else { hidden.count() };
        let problem = Problem::Hidden { by: seal(first, open), others };
        Some(Flaw::new(Part::Sphere(first), "emission", problem))
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
        let rounded = if sphere.velocity == Vec3::ZERO { CLEARANCE * r } else { r };
        let slack = CLEARANCE * (rounded + eye.abs().max_element());
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

    fn check_lights(&self, lights: &Lights, time: f32) -> Result<(), Flaw> {
        let lamp = self.without_sky().iter().position(Sphere::is_emitter);
        let problem = if lights.entries.is_empty() {
            Problem::Sealed(self.seal(lamp, time))
        } else if !lights.power.is_normal() {
            Problem::Power
        } else {
            return Ok(());
        };
        Err(match lamp {
            Some(i) => Flaw::new(Part::Sphere(i), "emission", problem),
            None => Flaw::new(Part::Scene, "background", problem),
        })
    }

    /// The first sphere that by itself keeps the light of `lamp`, or of the sky, from the eye at `time`.
    fn seal(&self, lamp: Option<usize>, time: f32) -> Option<(Seal, usize)> {
        let at = |sphere: &Sphere| sphere.at(time);
        let eye = self.camera.eye.as_dvec3();
        let lamp = lamp.map(|i| (i, at(&self.spheres[i])));
        self.without_sky().iter().enumerate().find_map(|(i, sphere)| {
            let is_lamp = lamp.is_some_and(|(index, _)| index == i);
            if is_lamp || !self.materials[sphere.material as usize].is_opaque() {
                return None;
            }
            let (sphere, radius) = (at(sphere), f64::from(sphere.radius));
            let from = |point: DVec3| sphere.center.as_dvec3().distance(point);
            let holds_eye = from(eye) < radius;
            let Some((_, lamp)) = lamp else { return holds_eye.then_some((Seal::HoldsEye, i)) };
            let (distance, lamp_radius) = (from(lamp.center.as_dvec3()), f64::from(lamp.radius));
            if (lamp.center, lamp.radius) == (sphere.center, sphere.radius) {
                Some((Seal::Coincides, i))
            } else if holds_eye && (distance - lamp_radius).abs() >= radius {
                Some((Seal::HoldsEye, i))
            } else if !holds_eye && distance + lamp_radius <= radius {
                Some((Seal::HoldsLamp, i))
            } else {
                None
            }
        })
    }
}

/// Checks every number of a camera.
///
/// # Errors
/// The first flaw.
pub fn check_camera(camera: &Camera) -> Result<(), Flaw> {
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

/// Checks every number of a material; flaws name it `part`.
///
/// # Errors
/// The first flaw.
pub fn check_material(part: Part, material: &Material) -> Result<(), Flaw> {
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

/// Checks every number of a sphere in a scene with this many materials; flaws name it `part`.
///
/// # Errors
/// The first flaw.
pub fn check_sphere(part: Part, sphere: &Sphere, materials: usize) -> Result<(), Flaw> {
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

/// Checks a radiance, the value `key` of `part`.
///
/// # Errors
/// If a channel is out of range.
pub fn check_radiance(part: Part, key: &'static str, radiance: Rgb) -> Result<(), Flaw> {
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

#[cfg(test)]
mod tests;
