//! Snapshot tests: each render in [`rows`] is compared with a stored text that can be reviewed, and a stored image.
//!
//! The text (`text/*.snap`, by insta) and the image (`fixtures/snapshots/*.pfm`) must match the reference's render bit
//! for bit. The fast engine is compared with the same two files on every kind of lanes. Only `scripts/bless` updates
//! them, from renders of the reference and the path tracer.
//!
//! Snapshots show what has changed, not whether it is correct; for that see the physics tests and the oracle.

#[path = "../shared/cases.rs"]
mod cases;
mod difference;
mod golden;
mod rows;
mod summary;
