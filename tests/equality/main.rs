//! The fast engine gives the reference's bits: on every kind of lanes that the processor has, on any number of
//! threads, for whatever scene and settings. Nothing is compared by a tolerance.
//!
//! `SPPM_EQUALITY_EFFORT=X` tries X times as many random cases (1 if it is not set; 0.1 is a tenth).

mod builtin_scenes;
#[path = "../shared/cases.rs"]
mod cases;
#[path = "../shared/difference.rs"]
mod difference;
mod draft;
mod engines;
mod kernels;
mod pair;
mod parameters;
mod placement;
mod radii;
mod random_scenes;
mod rounds;
mod settings;
mod sizes;
mod ties;
