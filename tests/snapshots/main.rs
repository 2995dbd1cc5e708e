//! Snapshot tests: each render in [`rows`] is compared with a stored text that can be reviewed, and a stored image.
//!
//! The text (`text/*.snap`, by insta) and the image (`fixtures/snapshots/*.pfm`) must match the reference's render bit
//! for bit. The fast engine is compared with the same two files on every kind of lanes. Only `scripts/bless` updates
//! them, from renders of the reference and the path tracer.
//!
//! [`corpus`] holds a line each of many small random scenes, without images.
//!
//! Snapshots show what has changed, not whether it is correct; for that see the physics tests and the oracle.

#[path = "../shared/cases.rs"]
mod cases;
mod corpus;
mod difference;
#[path = "../equality/draft.rs"]
mod draft;
mod golden;
#[path = "../equality/open.rs"]
mod open;
#[path = "../equality/placement.rs"]
mod placement;
#[path = "../equality/room.rs"]
mod room;
mod rows;
mod summary;
