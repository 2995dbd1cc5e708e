//! The input of an export, a scene at one instant, and the comments and values that both formats share.

use scene::{Camera, Filter, Still};

/// A scene at one instant, with the settings to render it.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// The name of the scene.
    pub name: &'a str,
    /// The camera.
    pub camera: &'a Camera,
    /// The spheres at that instant.
    pub still: &'a Still<'a>,
    /// The instant, in shutter time.
    pub time: f32,
    /// Width of the image in pixels.
    pub width: u32,
    /// Height of the image in pixels.
    pub height: u32,
    /// The filter of pixels.
    pub filter: Filter,
    /// Samples per pixel.
    pub samples: u32,
    /// The version of the program, for the comment at the top of the file.
    pub version: &'a str,
}

/// An exported file, and how it differs from the scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Exported {
    /// The text of the file.
    pub text: String,
    /// Small differences from the scene, one phrase each.
    pub notes: Vec<String>,
}

impl View<'_> {
    /// The comment lines at the top of every exported file.
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

    /// A point that the camera looks at. It is at least as far from the eye as the eye is from the origin, so that
    /// rounding it to 32 bits hardly changes the direction.
    pub(super) fn target(&self) -> [f64; 3] {
        let eye = self.camera.eye.as_dvec3();
        let direction = self.camera.direction.as_dvec3().normalize();
        (eye + direction * eye.length().max(1.0)).into()
    }
}

/// `text` made safe for a comment: on one line, and without `--`, which XML forbids in comments.
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
    use scene::Vec3;

    #[test]
    fn comments_keep_to_their_line() {
        assert_eq!(comment("a\nb"), "a b");
        // No XML file may hold these.
        assert_eq!(comment("a\u{fffe}b\u{ffff}c\u{1}d"), "a b c d");
        for text in ["--", "---", "a--b---->"] {
            assert!(!comment(text).contains("--"), "{text}");
        }
    }

    #[test]
    fn a_file_says_what_made_it_and_when_it_is_frozen() {
        let scene = crate::builtin::scene("cornell").unwrap();
        let still = scene.at(0.0);
        let said = |shutter| {
            let camera = Camera { shutter, ..scene.camera };
            let view = View {
                name: "box",
                camera: &camera,
                still: &still,
                time: 0.25,
                width: 4,
                height: 3,
                filter: Filter::Box,
                samples: 1,
                version: "9",
            };
            view.introduction()
        };
        let told = said([0.0, 0.0]);
        assert_eq!((told.len(), told[0].as_str()), (2, "box, exported by sppm 9"));
        assert!(told[1].contains("max_depth"), "{told:?}");
        let frozen = said([0.0, 1.0]);
        assert_eq!((&frozen[..2], frozen[2].as_str()), (&told[..], "Frozen at shutter time 0.25."));
    }

    /// As far as the eye from the origin, and at least 1.
    #[test]
    fn a_target_is_ahead_of_the_eye() {
        let scene = crate::builtin::scene("cornell").unwrap();
        let still = scene.at(0.0);
        let target = |eye: Vec3| {
            let camera = Camera { eye, direction: Vec3::NEG_Z * 7.0, ..scene.camera };
            let (name, time, width, height, samples, version) = ("a", 0.0, 4, 3, 1, "9");
            View {
                name,
                camera: &camera,
                still: &still,
                time,
                width,
                height,
                filter: Filter::Box,
                samples,
                version,
            }
            .target()
        };
        assert_eq!(target(Vec3::new(0.0, 3.0, 4.0)), [0.0, 3.0, -1.0]);
        assert_eq!(target(Vec3::new(0.25, 0.0, 0.0)), [0.25, 0.0, -1.0]);
    }
}
