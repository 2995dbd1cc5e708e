//! How an image is encoded, and the note that is stored with it.

use super::tone::Tone;

/// How an image is encoded, and the note that is stored with it. Exposure, tone and seed apply to PNG and JPEG; other
/// formats store radiance unchanged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Encoding<'a> {
    /// In stops: radiance is multiplied by `2^exposure`.
    pub exposure: f32,
    /// The curve from radiance to what a screen shows.
    pub tone: Tone,
    /// The seed of the dithering, so that the same image always has the same bytes.
    pub seed: u64,
    /// A note in ASCII without NUL, which [`super::read_note`] returns: a `tEXt` chunk named `sppm` in a PNG file, a text
    /// attribute named `sppm` in an EXR file. It is left out of other formats.
    pub note: Option<&'a str>,
}

impl Default for Encoding<'_> {
    /// As it is, for measurements: no exposure, clamped, not dithered, no note.
    fn default() -> Self {
        Self { exposure: 0.0, tone: Tone::Clamp, seed: 0, note: None }
    }
}

/// The key of [`Encoding::note`] in files.
pub(super) const NOTE: &str = "sppm";
