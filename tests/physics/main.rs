//! The tests that prove the reference right: closed forms, `f64`, statistics and an independent algorithm.
//!
//! One file per concern. All seeds are fixed, so every test gives the same verdict each time; every tolerance is a
//! named constant with its reason.

mod camera;
#[path = "../shared/cases.rs"]
mod cases;
mod convergence;
mod determinism;
mod distributed;
mod emission;
mod furnace;
mod grid;
mod harness;
mod intersection;
mod lights;
mod sampling;
mod scattering;
mod sky;
mod streams;
mod ties;
