//! Every row of the ladder renders the reference's physics: the same bits with keyed random numbers and integer flux,
//! within a bound with flux summed in floats, and alike in the mean with the paper's own generators.

mod alike;
#[path = "../shared/cases.rs"]
mod cases;
mod counts;
#[path = "../shared/difference.rs"]
mod difference;
#[path = "../equality/draft.rs"]
mod draft;
mod exact;
mod floats;
mod pair;
#[path = "../equality/placement.rs"]
mod placement;
mod random_scenes;
