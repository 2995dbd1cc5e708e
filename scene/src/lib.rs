//! The types that both engines share: vectors, rays, spheres, materials, camera, scene, seeded random streams,
//! settings, film, statistics, and the trait of engines.
//!
//! There is no light transport here. The `reference` crate defines what a ray hits, how light scatters and how photons
//! are gathered; the `fast` crate must give the same bits.
//!
//! A [`Scene`] is what a scene file states; [`Still`] is the scene at one instant, prepared for tracing. An [`Engine`]
//! turns a scene and [`Settings`] into a [`Film`]. The crate `files` reads and writes files. The random numbers that
//! engines must share are in [`rng`] and [`sobol`].
//!
//! Units: lengths are in scene units; radiance is in W sr^-1 m^-2 per linear RGB channel; times are in shutter
//! units. Every float of the light transport is an `f32`, and every operation on it is one of `+ - * / sqrt`,
//! which IEEE 754 rounds exactly, so that the same expression gives the same bits on every machine.

#![forbid(unsafe_code)]

pub mod aim;
mod anchored;
pub mod camera;
pub mod check;
pub mod clearance;
mod color;
pub mod engine;
pub mod exact;
pub mod film;
pub mod filter;
pub mod first_radii;
pub mod guide;
pub mod hybrid;
mod import;
pub mod iterations;
pub mod light_tree;
pub mod material;
pub mod meter;
mod neighbours;
pub mod quality;
pub mod radius_schedule;
mod ranks;
pub mod ray;
pub mod rims;
pub mod rng;
mod roles;
pub mod settings;
pub mod sobol;
pub mod sphere;
pub mod spheres;
pub mod srgb;
pub mod state;
pub mod still;
pub mod stop;
#[cfg(test)]
mod test_scenes;
pub mod text;
pub mod world;

pub use camera::Camera;
pub use check::Flaw;
pub use clearance::Clearance;
pub use color::{Rgb, Rgba, max_component};
pub use engine::{Engine, Pass, Probe, Progress, Stats};
pub use film::{Film, FilmRows, Picture, Plane, RowReader};
pub use filter::Filter;
pub use first_radii::FirstRadii;
pub use glam::Vec3;
pub use hybrid::Hybrid;
pub use import::Import;
pub use iterations::Iterations;
pub use material::Material;
pub use meter::Meter;
pub use quality::{Automatic, Quality};
pub use radius_schedule::RadiusSchedule;
pub use ray::Ray;
pub use rims::Rims;
pub use settings::Settings;
pub use sphere::Sphere;
pub use spheres::Spheres;
pub use state::{ExactSums, PhotonSums, Resumable, Sums, TRANSPORT};
pub use still::Still;
pub use stop::Stop;
pub use world::Scene;
