//! The extension module `sppm._sppm`, below the Python package `sppm`.
//!
//! The package's own code, in Python, defines what users see: it checks and converts arguments, waits, and shows progress.
//! This module gives it scenes, renders, images and metrics of the Rust libraries. It takes C-contiguous arrays alone, and
//! everything that takes time runs without the interpreter's lock (`work.rs`).

// The macros of PyO3 generate unsafe code, so `forbid` does not go together with them.
#![deny(unsafe_code)]
// PyO3 passes arguments by value.
#![allow(clippy::needless_pass_by_value)]

mod columns;
mod errors;
mod farm;
mod images;
mod info;
mod merge;
mod metrics;
mod options;
mod particles;
mod render;
mod scene;
mod shared;
mod trace;
mod values;
mod watch;
mod work;

/// The extension module.
#[pyo3::pymodule]
mod _sppm {
    #[pymodule_export]
    use crate::farm::{Lock, Viewer, choose_settings, left_open};
    #[pymodule_export]
    use crate::images::{codes, read_image, write_image, write_plane};
    #[pymodule_export]
    use crate::info::info;
    #[pymodule_export]
    use crate::merge::merge;
    #[pymodule_export]
    use crate::metrics::{compare, difference_image};
    #[pymodule_export]
    use crate::options::{check_settings, cores, lanes};
    #[pymodule_export]
    use crate::particles::{
        add_particles, atomic_numbers, check_particles, count_frames, read_particles, stage_particles,
    };
    #[pymodule_export]
    use crate::render::Render;
    #[pymodule_export]
    use crate::scene::{Scene, builtin_scenes, check_camera, check_material};
    #[pymodule_export]
    use crate::trace::trace;
    #[cfg(debug_assertions)]
    #[pymodule_export]
    use crate::work::break_down;

    #[pymodule_export]
    const VERSION: &str = env!("CARGO_PKG_VERSION");
    #[pymodule_export]
    const TRANSPORT: u32 = scene::TRANSPORT;
    #[pymodule_export]
    const MAX_ITERATIONS: u32 = scene::settings::MAX_ITERATIONS;
}
