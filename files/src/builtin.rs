//! The built-in scenes, embedded from `files/scenes`.

use crate::scene_file;
use scene::{Automatic, Scene};

/// A built-in scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Builtin {
    /// Its name on the command line.
    pub name: &'static str,
    /// The text of its scene file.
    pub text: &'static str,
    /// A one-line description.
    pub about: &'static str,
}

macro_rules! builtin {
    ($name:literal, $about:literal) => {
        Builtin { name: $name, text: include_str!(concat!("../scenes/", $name, ".toml")), about: $about }
    };
}

/// All built-in scenes: the paper's five, one for depth of field, one for motion blur, and three in the open.
pub const SCENES: &[Builtin] = &[
    builtin!("cornell", "a mirror ball and a glass ball in a box, two coloured lamps"),
    builtin!("large", "a large lamp, two grey mirror balls and a glass ball in a wide, tall box"),
    builtin!("mirror", "five glass balls from small to large before a mirror wall"),
    builtin!("random", "172 mirror and glass balls on a floor"),
    builtin!("surgery", "63 small lamps above two mirror balls and a glass ball"),
    builtin!("focus", "depth of field: a lens focused on a glass ball in a row that runs into the depth"),
    builtin!(
        "motion",
        "motion blur: a flying, a rolling and a falling ball, a spark, and a caustic on the move"
    ),
    builtin!("terrace", "glass, mirror and chalk in the open, under a sky and a low sun"),
    builtin!("heap", "a heap of 2000 balls in the open, under a sky and a sun"),
    builtin!("dusk", "300 little lamps over a plain, among stones and glass"),
];

/// The built-in scene called `name`.
pub fn find(name: &str) -> Option<&'static Builtin> {
    SCENES.iter().find(|b| b.name == name)
}

/// The built-in scene called `name`, parsed.
pub fn scene(name: &str) -> Option<Scene> {
    find(name).map(Builtin::scene)
}

impl Builtin {
    /// The parsed scene. Of the settings that are left to be chosen it has the paper's.
    ///
    /// # Panics
    /// Never: a test parses every built-in scene.
    pub fn scene(&self) -> Scene {
        self.open().0
    }

    /// The parsed scene, and the settings that are left to be chosen.
    ///
    /// # Panics
    /// As [`Self::scene`].
    pub fn open(&self) -> (Scene, Automatic) {
        let parsed = scene_file::parse_with_automatic(self.name, self.text);
        parsed.unwrap_or_else(|e| panic!("built-in scene: {e}"))
    }
}
