//! Compares every row of the ladder with the reference. With keyed random numbers and integer flux they must give the
//! same bits; with flux summed in floats they may differ within a bound; with the paper's own generators they must
//! agree statistically. What rows tell of themselves is tested as well.

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
mod told;
