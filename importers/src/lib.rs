//! Readers of molecules and particles: spheres in the file formats of chemistry, materials science and data analysis.
//!
//! ```no_run
//! use importers::{Frame, Request, read};
//! use std::path::Path;
//!
//! let request = Request { frame: Frame::Last, ..Request::default() };
//! let particles = read(Path::new("melt.dump.gz"), &request)?;
//! println!("{} particles of {:?}", particles.len(), particles.format);
//! # Ok::<(), importers::Error>(())
//! ```
//!
//! | module | what |
//! |---|---|
//! | [`elements`] | symbols, radii and colours of the elements, with their sources |
//! | [`bonds`] | bonds by distance |
//!
//! What is read of each format: `docs/particles-formats.md`.

#![forbid(unsafe_code)]

mod altloc;
mod binary;
pub mod bonds;
mod cell;
mod changes;
mod check;
mod columns;
mod delimited;
mod detect;
mod dump;
pub mod elements;
mod error;
mod format;
mod gro;
mod gsd;
mod interner;
mod layout;
mod mmcif;
mod names;
mod npy;
mod npz;
mod particles;
mod pdb;
mod ply;
mod read;
mod request;
mod rows;
mod star;
mod symmetry;
mod table;
mod text;
mod unit;
mod values;
mod xyz;

pub use error::{Error, Place};
pub use format::Format;
pub use particles::{Cell, Labels, Particles, Property};
pub use read::{Trajectory, frames, read, read_from};
pub use request::{Frame, Properties, Request};
pub use unit::Unit;
