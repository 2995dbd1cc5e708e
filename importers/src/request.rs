//! What a caller asks of a file.

/// What to read of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Request {
    /// Which frame.
    pub frame: Frame,
    /// Which numeric columns beyond those that [`crate::Particles`] has fields for.
    pub properties: Properties,
    /// The most bytes that the particles may take in memory.
    pub memory: u64,
}

/// A frame of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Frame {
    /// By its number, from 0.
    Number(usize),
    /// The last one.
    Last,
}

/// Numeric columns to read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Properties {
    /// Only what positions, radii and so on need.
    None,
    /// All there are.
    All,
    /// Those of these names. `forces` names all components of `forces_x`, `forces_y`, `forces_z`.
    Named(Vec<String>),
}

impl Default for Request {
    /// The first frame, no further columns, 64 GiB.
    fn default() -> Self {
        Self { frame: Frame::Number(0), properties: Properties::None, memory: 64 << 30 }
    }
}
