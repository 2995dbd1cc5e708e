//! Survey: how many walks are sent out to learn what photons are to be aimed at. How a walk goes is the engines'.

use super::targets::{Arrival, Targets};
use crate::still::Still;
use std::ops::Range;

/// Walks between two looks at whether there are enough arrivals.
pub const ROUND: u32 = 512;

/// Enough.
const ENOUGH: usize = 1024;

/// Most walks, however little they find.
const MOST: u32 = 8 * ROUND;

/// What photons are to be aimed at, from the lamps of `still`, those of the first iteration. `walk` gives the arrivals that
/// a round of walks finds, in order of the walks.
pub fn targets(still: &Still, mut walk: impl FnMut(Range<u32>) -> Vec<Arrival>) -> Targets {
    let mut arrivals = Vec::new();
    if still.lights.entries.is_empty() {
        return Targets::default();
    }
    for first in (0..MOST).step_by(ROUND as usize) {
        if arrivals.len() >= ENOUGH {
            break;
        }
        arrivals.extend(walk(first..first + ROUND));
    }
    Targets::new(still, arrivals)
}
