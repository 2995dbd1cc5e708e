//! The renderer: [`render`] runs the passes of an iteration in order, [`engine`] offers it as a [`scene::Engine`], and
//! [`memory`] says how much memory it takes.

mod engine;
mod memory;
mod render;
#[cfg(test)]
mod tests;

pub use render::{DEPOSITS_AT_ONCE, Parts, Sppm};
