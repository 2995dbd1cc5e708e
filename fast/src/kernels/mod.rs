//! The engine's kernels one by one, over slices: for tests and benches, not for rendering.
//!
//! Each function takes the kind of lanes, dispatches as the renderer does, and runs the renderer's own code: nothing is
//! computed here. Columns of floats may hold words; a word is then the float of the same bits, as in the engine's rows.
//!
//! This interface is not stable: it changes with the engine.

mod consolidation;
mod join;
mod maps;
pub mod operations;
mod passes;

pub use consolidation::{Consolidation, Gathered, Pixel, Seen};
pub use join::{Cells, Join, Occupancy, Photon, Point, Query, Run};
pub use maps::{
    camera_ray, choose_light, cosine_hemisphere, dielectric, dielectric_by_roots, fresnel, max_component,
    next_uniform, orthonormal_frame, quantise, quantise_aimed, reflect, sincos_turn, stream_state, survive,
    uniform_cone, uniform_disk, uniform_sphere, unit, unit_float,
};
pub use passes::{
    CameraSample, PhotonRun, Receiver, camera_pass, choose_for_points, direct_light, photon_pass, pixel_slot,
    survey, survey_for,
};
