//! The files of the page, embedded from `view/page`.

const HTML: &str = "text/html; charset=utf-8";
const STYLE: &str = "text/css; charset=utf-8";
const SCRIPT: &str = "text/javascript; charset=utf-8";
const DRAWING: &str = "image/svg+xml";

macro_rules! page {
    ($($name:literal: $kind:expr,)*) => {
        /// Each with its name, text and media type.
        const FILES: &[(&str, &str, &str)] = &[$(($name, include_str!(concat!("../page/", $name)), $kind),)*];
    };
}

page! {
    "index.html": HTML,
    "style.css": STYLE,
    "icon.svg": DRAWING,
    "main.js": SCRIPT,
    "camera.js": SCRIPT,
    "canvas.js": SCRIPT,
    "gl.js": SCRIPT,
    "panel.js": SCRIPT,
    "picture.js": SCRIPT,
    "socket.js": SCRIPT,
    "spheres.js": SCRIPT,
    "tone.js": SCRIPT,
    "viewer.js": SCRIPT,
}

/// The text and media type of the file `name`.
pub(crate) fn file(name: &str) -> Option<(&'static str, &'static str)> {
    FILES.iter().find(|(there, ..)| *there == name).map(|(_, text, kind)| (*text, *kind))
}
