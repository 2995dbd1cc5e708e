//! How scenes render today: a reviewable text and an image for each row of [`rows`].
//!
//! The reference renders a row, and both its text (`text/*.snap`, by insta) and its pixels
//! (`fixtures/snapshots/*.pfm`) must be the blessed ones, bit for bit. The fast engine is held to the same two files
//! on every kind of lanes, but there is no way for it to write them: only `scripts/bless` does, from the reference.
//!
//! These files say what changed, not what is right; for that see the physics tests and the oracle.

#[path = "../shared/cases.rs"]
mod cases;
mod difference;
mod golden;
mod rows;
mod summary;
