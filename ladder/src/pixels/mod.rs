//! The memory layouts of pixels and visible points in the paper's stages.

mod columns;
mod gathered;
mod layout;
mod lines;
mod scalar;

pub(crate) use columns::Columns;
pub(crate) use layout::{PixelState, Pixels, Seen};
pub(crate) use lines::{Line8, Line16, Lines};
pub(crate) use scalar::{Objects, ScalarPixels, TypedArrays};
