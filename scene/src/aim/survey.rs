//! Survey: how many walks are sent out to learn what photons are to be aimed at, or if they are not, how to guide them. How a
//! walk goes is the engines'.

use super::targets::Targets;
use crate::guide::{Found, Guide};
use crate::still::Still;
use std::ops::Range;
use std::sync::Arc;

/// Walks between two looks at whether there are enough arrivals.
pub const ROUND: u32 = 512;

/// Enough.
const ENOUGH: usize = 1024;

/// Most walks, however little they find.
const MOST: u32 = 16 * ROUND;

/// Walks of a guide for each photon of an iteration; and the most.
const PHOTONS_PER_WALK: u32 = 16;
const MOST_OF_GUIDE: u32 = 64 * ROUND;

/// What photons are to be aimed at, or how they are guided, from the lamps of `still`, those of the first iteration. `walk` gives
/// what walks find, in their order, in any pieces.
pub fn targets(still: &Still, photons: u32, mut walk: impl FnMut(Range<u32>) -> Vec<Found>) -> Targets {
    let (mut found, mut walks, mut arrivals) = (Vec::new(), 0, Vec::new());
    if still.lights.entries.is_empty() {
        return Targets::default();
    }
    while walks < MOST && arrivals.len() < ENOUGH {
        let round = walk(walks..walks + ROUND);
        arrivals.extend(round.iter().flat_map(Found::arrivals).map(|lit| lit.arrival));
        found.extend(round);
        walks += ROUND;
    }
    let targets = Targets::new(still, arrivals);
    if !targets.shares.is_empty() {
        return targets;
    }
    let all = (photons / PHOTONS_PER_WALK).min(MOST_OF_GUIDE).next_multiple_of(ROUND).max(walks);
    found.extend(walk(walks..all));
    Targets { guide: Guide::learn(all, &found).map(Arc::new), ..targets }
}
