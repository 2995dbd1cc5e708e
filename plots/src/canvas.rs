//! The canvas that plots are drawn on, and writing it to an SVG file.

use files::atomic_file::{self, FileError};
use plotters::coord::Shift;
use plotters::prelude::*;
use std::io::Write;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Width and height of a plot, in pixels.
const SIZE: (u32, u32) = (900, 560);

/// The canvas of a plot.
pub type Canvas<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// The result of drawing.
pub type Drawn = Result<(), Box<dyn std::error::Error>>;

/// Why a plot could not be made.
#[derive(Debug, Error)]
pub enum PlotError {
    /// The plot could not be drawn, for example because a value is not finite.
    #[error("cannot draw {}: {problem}", .path.display())]
    Draw {
        /// The file to write.
        path: PathBuf,
        /// What went wrong.
        problem: String,
    },
    /// The file could not be written.
    #[error(transparent)]
    Write(#[from] FileError),
}

/// Draws on a white canvas and writes it to `path`, replacing an existing file.
///
/// # Errors
/// If `draw` fails, or the file cannot be written.
pub fn save(path: &Path, draw: impl FnOnce(&Canvas) -> Drawn) -> Result<(), PlotError> {
    let svg = render(draw)
        .map_err(|error| PlotError::Draw { path: path.to_owned(), problem: error.to_string() })?;
    Ok(atomic_file::replace(path, |out| out.write_all(svg.as_bytes()))?)
}

/// The text of the SVG file.
pub(crate) fn render(draw: impl FnOnce(&Canvas) -> Drawn) -> Result<String, Box<dyn std::error::Error>> {
    let mut svg = String::new();
    let canvas = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
    canvas.fill(&WHITE)?;
    draw(&canvas)?;
    canvas.present()?;
    // The backend finishes the text when it is dropped.
    drop(canvas);
    Ok(svg)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_whole_or_told_with_their_path() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.svg");
        save(&path, |_| Ok(())).unwrap();
        let svg = std::fs::read_to_string(&path).unwrap();
        assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"), "{svg}");
        let error = save(&path, |_| Err("no ink".into())).unwrap_err();
        assert_eq!(error.to_string(), format!("cannot draw {}: no ink", path.display()));
    }
}
