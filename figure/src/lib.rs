//! Pictures of particles: which spheres a file of particles becomes, and a stage to show them on.
//!
//! | module | what |
//! |---|---|
//! | [`recipe`] | what makes spheres of particles: radius, colour and material by rules, cuts, bonds; as texts of scene files and of the command line |
//! | [`selection`] | which particles a rule is for |
//! | [`columns`] | columns of particles by name |
//! | [`mod@balls`] | particles and a recipe become spheres of a scene |
//! | [`units`] | units of length |
//! | [`stage`] | camera, lamps, ground, background and settings that follow from the spheres |
//!
//! Spheres do not depend on the order of the particles in their file. `docs/particles.md` is the user's view.

#![forbid(unsafe_code)]

pub mod balls;
pub mod color;
pub mod columns;
mod fit;
mod neighbours;
mod overlap;
mod paint;
mod principal;
pub mod recipe;
mod rods;
pub mod rule;
pub mod selection;
pub mod stage;
mod table;
pub mod units;
mod vector;

pub use balls::{Balls, Refusal, balls};
pub use importers::Frame;
pub use recipe::Recipe;
pub use rule::Rule;
pub use selection::Selection;
pub use stage::{Set, Stage};
