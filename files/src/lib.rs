//! All file formats that sppm reads and writes.
//!
//! | module | what |
//! |---|---|
//! | [`scene_file`] | scenes in TOML; every error is one line with its position in the file |
//! | [`builtin`] | the built-in scenes |
//! | [`named`] | finds a scene by its built-in name or its file |
//! | [`image_file`] | images: PNG, JPEG, EXR, PFM, HDR, TIFF, WebP, QOI |
//! | [`checkpoint`] | renders that can be resumed |
//! | [`export`] | scenes for Mitsuba 3 and pbrt-v4 |
//! | [`particles`] | files of particles as parts of scenes |
//! | [`npy`] | rays and hits as `NumPy` arrays |
//! | [`input`] | opening files to read, and nothing but files
//! | [`paths`] | where paths lead, and the names of files beside others |
//! | [`lock`] | locks on files that are going to be replaced |
//! | [`atomic_file`] | atomic file replacement, by which all of these files are written |
//!
//! ```
//! use files::{builtin, scene_file};
//! use scene::Settings;
//!
//! let text = r#"
//!     [camera]
//!     eye = [0, 0, 9]
//!     target = [0, 0, 0]
//!     vertical_fov_degrees = 30
//!
//!     [[sphere]]
//!     center = [0, 0, 0]
//!     radius = 1
//!     material = { type = "diffuse", albedo = [0, 0, 0] }
//!     emission = [1, 1, 1]
//! "#;
//! let scene = scene_file::parse("lamp.toml", text)?;
//! assert_eq!(scene.name, "lamp");
//! assert_eq!(scene.settings, Settings::default());
//! assert_eq!(builtin::scene("cornell").unwrap().spheres.len(), 9);
//! # Ok::<(), scene_file::FileError>(())
//! ```

#![forbid(unsafe_code)]

pub mod atomic_file;
pub mod builtin;
pub mod checkpoint;
pub mod export;
pub mod image_file;
pub mod input;
pub mod lock;
pub mod named;
pub mod npy;
pub mod particles;
pub mod paths;
pub mod scene_file;
