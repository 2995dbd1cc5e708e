//! Survey: how many walks are sent out to learn what photons are to be aimed at. How a walk goes is the engines'.

use super::{Arrival, Targets};
use crate::still::Still;
use std::ops::Range;

/// Walks between two looks at whether there are enough arrivals.
pub const ROUND: u32 = 1024;

/// Enough.
const ENOUGH: usize = 2048;

/// Most walks, however little they find.
const MOST: u32 = 16 * ROUND;

/// What photons are to be aimed at, from the lamps of `still`, those of the first iteration. `walk` gives the arrivals that
/// a round of walks finds, in order of the walks.
pub fn targets(still: &Still, mut walk: impl FnMut(Range<u32>) -> Vec<Arrival>) -> Targets {
    let mut arrivals = Vec::new();
    for first in (0..MOST).step_by(ROUND as usize) {
        if arrivals.len() >= ENOUGH {
            break;
        }
        arrivals.extend(walk(first..first + ROUND));
    }
    Targets::new(still, arrivals)
}
