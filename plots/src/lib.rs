//! Plots as SVG files, in one style: a canvas, its axes, and lines with a legend.

#![forbid(unsafe_code)]

mod axis;
mod canvas;
mod lines;

pub use axis::label;
pub use canvas::{Canvas, Drawn, PlotError, save};
pub use lines::{LinePlot, Scale, Series};
