//! Exports scenes to other renderers.

mod mitsuba;
mod pbrt;
mod view;

pub use view::{Exported, View};

/// A renderer to export to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Renderer {
    /// Mitsuba 3: XML.
    Mitsuba,
    /// pbrt-v4.
    Pbrt,
}

/// `view` as a file for `renderer`.
///
/// # Errors
/// If the renderer cannot represent the scene: one sentence that says why.
pub fn write(renderer: Renderer, view: &View) -> Result<Exported, String> {
    match renderer {
        Renderer::Mitsuba => mitsuba::write(view),
        Renderer::Pbrt => Ok(pbrt::write(view)),
    }
}
