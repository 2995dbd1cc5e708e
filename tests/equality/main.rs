//! Tests that the fast engine gives the same bits as the reference, for any scene and settings, on every kind of lanes
//! and any number of threads. All comparisons are exact, without tolerances.
//!
//! `SPPM_EQUALITY_EFFORT=X` runs X times as many random cases (default 1; 0.1 runs a tenth).

mod aiming;
mod builtin_scenes;
#[path = "../shared/cases.rs"]
mod cases;
#[path = "../shared/difference.rs"]
mod difference;
mod draft;
mod engines;
mod global;
mod guiding;
mod hybrid;
mod kernels;
mod open;
mod pair;
mod parameters;
mod paths;
mod placement;
mod radii;
mod random_scenes;
mod room;
mod rounds;
mod settings;
mod sizes;
mod ties;
