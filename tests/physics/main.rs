//! Tests that the reference is physically correct, by closed forms, computation in `f64`, statistics, and comparison
//! with a path tracer.
//!
//! All seeds are fixed, so that every run gives the same result. Every tolerance is a named constant with its reason.

mod aiming;
mod backdrop;
mod camera;
#[path = "../shared/cases.rs"]
mod cases;
mod clearance;
mod convergence;
mod departures;
mod determinism;
mod distributed;
mod efficiency;
mod emission;
mod facts;
mod filters;
mod first_radii;
mod furnace;
mod glints;
mod grid;
mod grounds;
mod guiding;
mod harness;
mod hybrid;
mod intersection;
mod iterations;
mod learning;
mod light_choice;
mod light_samples;
mod light_tree;
mod lights;
mod motion;
mod roles;
mod sampling;
mod scattering;
mod sky;
mod streams;
mod survey;
mod targets;
mod ties;
mod units;
mod validity;
