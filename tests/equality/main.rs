//! The fast engine gives the reference's bits: on every kind of lanes that the processor has, on any number of
//! threads, for whatever scene and settings. Nothing is compared by a tolerance.
//!
//! `SPPM_EQUALITY_EFFORT=N` tries N times as many random scenes and seeds (1 if it is not set).

mod builtin_scenes;
mod draft;
mod kernels;
mod pair;
mod placement;
mod radii;
mod random_scenes;
mod rounds;
mod settings;
mod sizes;
