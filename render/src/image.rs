//! Everything that a render shows after an iteration, in memory.

use crate::metadata::Metadata;
use scene::{Film, Plane, Rgba};

/// The image after a complete iteration, with what belongs to it.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// The image. It shows the background, even if that is transparent.
    pub film: Film,
    /// The image with alpha, if the background is transparent: the pixels in the order of [`Film::pixels`].
    pub transparent: Option<Vec<Rgba>>,
    /// The search radius of every pixel, in scene units; `None` for methods without photons.
    pub radius: Option<Plane>,
    /// `N` of every pixel: the photons counted so far, weighted by alpha; `None` for methods without photons.
    pub count: Option<Plane>,
    /// How the image was made. Its settings have the number of iterations in the image.
    pub metadata: Metadata,
}
