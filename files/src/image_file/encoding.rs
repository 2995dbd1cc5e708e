//! How an image is encoded, and the note that is stored with it.

/// How an image is encoded, and the note that is stored with it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Encoding<'a> {
    /// In stops: radiance is multiplied by `2^exposure`. Applies to PNG and JPEG; other formats store radiance unchanged.
    pub exposure: f32,
    /// A note in ASCII without NUL, which [`super::read_note`] returns: a `tEXt` chunk named `sppm` in a PNG file, a text
    /// attribute named `sppm` in an EXR file. It is left out of other formats.
    pub note: Option<&'a str>,
}

/// The key of [`Encoding::note`] in files.
pub(super) const NOTE: &str = "sppm";
