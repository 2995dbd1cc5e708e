//! The names of all faults, by number. `scripts/faults` writes this file in its copy.

/// The names.
pub(crate) const NAMES: &[&str] = &[];
