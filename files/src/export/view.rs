//! What is exported: a scene at one instant, and what both formats say of it.

use scene::{Camera, Still};

/// A scene at one instant, and how it is to be rendered.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// What people call the scene.
    pub name: &'a str,
    /// Where it is seen from.
    pub camera: &'a Camera,
    /// The spheres at that instant.
    pub still: &'a Still<'a>,
    /// The instant, in shutter time.
    pub time: f32,
    /// Width of the image in pixels.
    pub width: u32,
    /// Height of the image in pixels.
    pub height: u32,
    /// Samples per pixel.
    pub samples: u32,
    /// The version of the program that writes, which the file names.
    pub version: &'a str,
}

/// The text of a file, and what in it differs a little from the scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Exported {
    /// The file.
    pub text: String,
    /// Differences, a phrase each.
    pub notes: Vec<String>,
}

impl View<'_> {
    /// What every exported file says of itself.
    pub(super) fn introduction(&self) -> Vec<String> {
        let mut lines = vec![
            format!("{}, exported by sppm {}", self.name, self.version),
            "Paths are of any length here; sppm ends them at max_depth: compare with a large one.".into(),
        ];
        if self.camera.shutter[0] < self.camera.shutter[1] {
            lines.push(format!("Frozen at shutter time {}.", self.time));
        }
        lines
    }

    /// A point that the camera looks at: as far away as the eye is from the origin, so that rounding it to 32 bits
    /// leaves the direction.
    pub(super) fn target(&self) -> [f64; 3] {
        let eye = self.camera.eye.as_dvec3();
        let direction = self.camera.direction.as_dvec3().normalize();
        (eye + direction * eye.length().max(1.0)).into()
    }
}

/// `text` fit for a comment: one line, and none of the pairs of dashes that XML forbids there.
pub(super) fn comment(text: &str) -> String {
    let is_odd = |c: char| c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}');
    let mut line: String = text.chars().map(|c| if is_odd(c) { ' ' } else { c }).collect();
    while line.contains("--") {
        line = line.replace("--", "- -");
    }
    line
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_keep_to_their_line() {
        assert_eq!(comment("a\nb"), "a b");
        for text in ["--", "---", "a--b---->"] {
            assert!(!comment(text).contains("--"), "{text}");
        }
    }
}
