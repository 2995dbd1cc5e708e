//! Finds the place in the text of a flaw of the scene as a whole ([`Scene::check`]).

use super::error::{Fault, Position};
use super::pieces::Head;
use super::reader::{Section, Subject};
use super::spheres::Spheres;
use scene::Scene;
use scene::check::{Flaw, Part, Problem};

/// What a flaw is searched in.
pub(super) struct Parsed<'a> {
    pub(super) text: &'a str,
    pub(super) head: &'a Head,
    pub(super) root: Section<'a>,
    pub(super) camera: Section<'a>,
    pub(super) spheres: &'a Spheres<'a>,
}

impl Parsed<'_> {
    /// Checks what concerns several parts of the scene: motion, the lens, and whether light reaches the eye. Returns what is to
    /// be told of a scene that can be rendered.
    pub(super) fn check(&self, scene: &Scene) -> Result<Option<Fault>, Fault> {
        self.check_shutter(scene)?;
        let checked = scene.check_places().and_then(|()| scene.check_light());
        match checked {
            Ok(flaw) => flaw.map(|flaw| self.fault(&flaw)).transpose(),
            Err(flaw) => Err(self.fault(&flaw).unwrap_or_else(|fault| fault)),
        }
    }

    /// A camera whose shutter is not mentioned was not meant for spheres that move.
    fn check_shutter(&self, scene: &Scene) -> Result<(), Fault> {
        let moving = scene.spheres.iter().position(|sphere| sphere.velocity != scene::Vec3::ZERO);
        let Some(i) = moving.filter(|_| self.camera.get("shutter").is_none()) else { return Ok(()) };
        let subject = self.name(i)?;
        let message = match self.camera.subject {
            Subject::Camera => {
                format!("{subject} moves, but [camera] has no shutter; add shutter = [0, 1] there")
            }
            other => {
                format!("{subject} moves, but {other} has no shutter; give the scene a [camera] with one")
            }
        };
        Err(Fault::new(self.sphere(i, "velocity")?, message))
    }

    /// The fault for `flaw`. Fails only if the text cannot be read again.
    fn fault(&self, flaw: &Flaw) -> Result<Fault, Fault> {
        let at = match flaw.part {
            Part::Sphere(i) => self.sphere(i, flaw.key)?,
            Part::Camera => self.head.place(place(&self.camera, flaw.key)),
            _ => match self.root.get(flaw.key) {
                Some(field) => self.head.place(field.at),
                None => self.sphere(0, "")?,
            },
        };
        // Of a sphere that is not at fault itself, the line helps to find it.
        let other = match flaw.problem {
            Problem::LensCuts(_, i)
            | Problem::EyeOn(i)
            | Problem::Sealed(Some((_, i)))
            | Problem::Hidden { by: Some((_, i)), .. } => Some(i),
            Problem::PassesEye => match flaw.part {
                Part::Sphere(i) => Some(i),
                _ => None,
            },
            _ => None,
        };
        let name = |part| match part {
            Part::Sphere(i) => {
                let name = self.name(i).unwrap_or_else(|_| part.to_string());
                match other.filter(|other| *other == i).and_then(|_| self.sphere(i, "").ok()) {
                    Some(at) => format!("{name} (line {})", Position::of(self.text, at).line),
                    None => name,
                }
            }
            Part::Camera => Subject::Camera.to_string(),
            _ => part.to_string(),
        };
        Ok(Fault::new(at, flaw.say(name)))
    }

    /// The place of the value `key` of sphere `i`, or of the sphere if it does not have that.
    fn sphere(&self, i: usize, key: &'static str) -> Result<usize, Fault> {
        if i >= self.spheres.len() {
            return Ok(self.root.get("particles").map_or(0, |field| self.head.place(field.at)));
        }
        self.spheres.nth(self.text, self.head, i, |section| Ok(place(section, key)))
    }

    /// The name of sphere `i` in messages.
    fn name(&self, i: usize) -> Result<String, Fault> {
        if i >= self.spheres.len() {
            return Ok(format!("ball {} of the particles", i - self.spheres.len() + 1));
        }
        let mut name = String::new();
        self.spheres.nth(self.text, self.head, i, |section| {
            name = section.subject.to_string();
            Ok(section.at)
        })?;
        Ok(name)
    }
}

/// The position of the field `key`, or of the section if it does not have that field.
fn place(section: &Section<'_>, key: &'static str) -> usize {
    section.get(key).map_or(section.at, |field| field.at)
}
