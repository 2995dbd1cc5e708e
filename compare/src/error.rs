//! The errors for images that cannot be compared.

use scene::Film;
use thiserror::Error;

/// Why two images cannot be compared.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum CompareError {
    /// The images differ in size.
    #[error("image A is {} x {} pixels and image B {} x {}; they must have the same size", .a[0], .a[1], .b[0], .b[1])]
    Size {
        /// Width and height of the judged image.
        a: [u32; 2],
        /// Width and height of the reference.
        b: [u32; 2],
    },
    /// An image cannot be read: one line, which names the file.
    #[error("{0}")]
    Unreadable(String),
    /// The images have no pixels.
    #[error("the images have no pixels")]
    Empty,
    /// An image has a pixel with NaN or infinity, for which no metric is defined.
    #[error(
        "image {image} has {count} pixels with a NaN or an infinity, the first at ({x}, {y}); all must be finite"
    )]
    NotFinite {
        /// `A` or `B`.
        image: char,
        /// How many pixels are not finite.
        count: usize,
        /// Column of the first, from the left, from 0.
        x: usize,
        /// Row of the first, from the top, from 0.
        y: usize,
    },
}

/// Checks that the images have the same size.
pub(crate) fn check_size(a: &Film, b: &Film) -> Result<(), CompareError> {
    if (a.width, a.height) == (b.width, b.height) {
        return Ok(());
    }
    Err(CompareError::Size { a: [a.width, a.height], b: [b.width, b.height] })
}
