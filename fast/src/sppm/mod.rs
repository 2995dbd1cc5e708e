//! The renderer: [`render`] runs the passes of an iteration in order, [`engine`] offers it as a [`scene::Engine`], [`first_radii`]
//! chooses the radii with which pixels begin, and [`memory`] says how much memory it takes.

mod engine;
mod first_radii;
mod memory;
mod render;

pub use first_radii::{first_radii, first_radii_for};
pub use memory::DEPOSITS_OF_PILOTS;
pub use render::{DEPOSITS_AT_ONCE, Parts, Sppm};
