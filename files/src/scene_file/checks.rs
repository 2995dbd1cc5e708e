//! Checks that concern the scene as a whole: motion, the lens among the spheres, and whether there is light.

use super::error::{Fault, Position};
use super::reader::{LIMIT, Section};
use super::sphere;
use glam::DVec3;
use scene::still::Lights;
use scene::{Rgb, Scene, Sphere, Vec3};
use toml::de::DeArray;

/// Least distance of the eye from an opaque surface, relative to the coordinates and radius involved. Any closer, and
/// rounding to `f32` would decide on which side of the surface the eye is.
const CLEARANCE: f64 = 1e-6;

/// The parts of the parsed file, to find the position of a fault.
pub(super) struct Checks<'a> {
    pub(super) text: &'a str,
    pub(super) root: Section<'a>,
    pub(super) camera: Section<'a>,
    pub(super) spheres: &'a DeArray<'a>,
}

impl<'a> Checks<'a> {
    /// Checks the scene as the file states it.
    pub(super) fn before_sky(&self, scene: &Scene) -> Result<(), Fault> {
        for (i, s) in scene.spheres.iter().enumerate() {
            self.check_motion(scene, i, s)?;
            self.check_lens(scene, i, s)?;
        }
        if scene.background == Rgb::ZERO && !scene.spheres.iter().any(Sphere::is_emitter) {
            let at = self.root.get("background").map_or(self.section(0)?.at, |field| field.at);
            let message =
                "there is no light; give a sphere an emission = [r, g, b], or the scene a background";
            return Err(Fault::new(at, message));
        }
        Ok(())
    }

    /// Checks the scene after [`Scene::with_sky`] has turned the background into a light.
    pub(super) fn after_sky(&self, scene: &Scene) -> Result<(), Fault> {
        let [open, close] = scene.camera.shutter;
        self.check_lights(scene, &scene.at(open).lights)?;
        if close > open && scene.spheres.iter().any(|s| s.velocity != Vec3::ZERO) {
            self.check_lights(scene, &scene.at(close).lights)?;
        }
        Ok(())
    }

    fn check_motion(&self, scene: &Scene, i: usize, s: &Sphere) -> Result<(), Fault> {
        if s.velocity == Vec3::ZERO {
            return Ok(());
        }
        let (section, velocity) = self.field(i, "velocity")?;
        let subject = section.subject;
        if self.camera.get("shutter").is_none() {
            let message = format!("{subject} moves, but [camera] has no shutter; add shutter = [0, 1] there");
            return Err(Fault::new(velocity, message));
        }
        let away = |time| f64::from(s.at(time).center.abs().max_element()) > LIMIT;
        if scene.camera.shutter.into_iter().any(away) {
            let message =
                format!("velocity of {subject} takes it beyond {LIMIT:e} while the shutter is open");
            return Err(Fault::new(velocity, message));
        }
        Ok(())
    }

    /// Checks that the whole lens stays on one side of each opaque surface while the shutter is open.
    fn check_lens(&self, scene: &Scene, i: usize, s: &Sphere) -> Result<(), Fault> {
        let camera = &scene.camera;
        if !scene.materials[s.material as usize].is_opaque() {
            return Ok(());
        }
        let eye = camera.eye.as_dvec3();
        let [open, close] = camera.shutter.map(|time| s.at(time).center.as_dvec3() - eye);
        let (lens, r) = (f64::from(camera.aperture_radius), f64::from(s.radius));
        let slack = CLEARANCE * (r + eye.abs().max_element());
        let clear = |from: DVec3, to: DVec3, lens: f64| {
            let farthest = from.length().max(to.length());
            nearest(from, to) - lens > r + slack || farthest + lens < r - slack
        };
        if clear(open, close, lens) {
            return Ok(());
        }
        let section = self.section(i)?;
        let line = Position::of(self.text, section.at).line;
        let (sphere, eye) = (format!("{} (line {line})", section.subject), place(&self.camera, "eye"));
        let choice = "it must lie clearly inside or outside of an opaque sphere";
        Err(if clear(open, close, 0.0) {
            let lens = camera.aperture_radius;
            let message = format!("the lens, {lens} around eye, cuts through {sphere}; {choice}");
            Fault::new(place(&self.camera, "aperture_radius"), message)
        } else if s.velocity != Vec3::ZERO && clear(open, open, 0.0) {
            let message =
                format!("{sphere} passes over the eye while the shutter is open; keep it clear of the eye");
            Fault::new(place(&section, "velocity"), message)
        } else {
            Fault::new(eye, format!("eye of [camera] lies on the surface of {sphere}; {choice}"))
        })
    }

    fn check_lights(&self, scene: &Scene, lights: &Lights) -> Result<(), Fault> {
        // Leave out the sky, which follows the spheres of the file.
        let emitter = scene.spheres[..self.spheres.len()].iter().position(Sphere::is_emitter);
        let at = match emitter {
            Some(i) => self.field(i, "emission")?.1,
            None => place(&self.root, "background"),
        };
        if lights.entries.is_empty() {
            let message = "no light reaches the eye: opaque spheres seal every light off; \
                 put a light into the space that the eye is in";
            return Err(Fault::new(at, message));
        }
        if !lights.power.is_normal() {
            let message = "the power of all lights, the sum of 4 (pi radius)^2 emission, is beyond the range of \
                 a 32-bit float; take another unit for emission or for length";
            return Err(Fault::new(at, message));
        }
        Ok(())
    }

    fn section(&self, i: usize) -> Result<Section<'a>, Fault> {
        sphere::section(i, &self.spheres[i])
    }

    /// The section of sphere `i` and the position of its field `key`.
    fn field(&self, i: usize, key: &'static str) -> Result<(Section<'a>, usize), Fault> {
        let section = self.section(i)?;
        Ok((section, place(&section, key)))
    }
}

/// The position of the field `key`, or of the section if it does not have that field.
fn place(section: &Section<'_>, key: &'static str) -> usize {
    section.get(key).map_or(section.at, |field| field.at)
}

/// Distance of the origin from the segment between two points.
fn nearest(from: DVec3, to: DVec3) -> f64 {
    let along = to - from;
    let length_squared = along.length_squared();
    let t = if length_squared > 0.0 { (-from.dot(along) / length_squared).clamp(0.0, 1.0) } else { 0.0 };
    (from + along * t).length()
}
