//! Survey: how many walks are sent out to learn what photons are to be aimed at, or if they are not, how to guide them. How a
//! walk goes is the engines'.

use super::targets::Targets;
use crate::guide::{Edge, Found, Guide, Lit};
use crate::settings::Settings;
use crate::still::Still;
use std::ops::Range;
use std::sync::Arc;

/// Walks between two looks at whether there are enough arrivals.
pub const ROUND: u32 = 512;

/// Enough.
const ENOUGH: usize = 1024;

/// Most walks, however little they find.
const MOST: u32 = 16 * ROUND;

/// Photons of an iteration for each walk of a guide; and the most walks.
const PHOTONS_PER_WALK: u32 = 16;
const MOST_OF_GUIDE: u32 = 32 * ROUND;

/// A guide is learnt from one in so many of the walks first, and from all only if by then it is expected to leave less than so
/// much of the variance. It is of use only if it leaves less than the last: to guide photons takes some time, and photons that
/// are not alike are worth less. docs/guiding.md has what was measured.
const STAGES: [(u32, f64); 2] = [(4, 1.0), (1, 0.9)];

/// Lines between surfaces are of use to a guide up to this segment of a walk after its first diffuse surface, and walks that are
/// for a guide alone go no farther.
pub const MOST_OF_WALK: u32 = 8;

/// What photons are to be aimed at, or how they are guided, from the lamps of `still`, those of the first iteration. `walk` gives
/// what walks find that have at most so many segments after their first diffuse surface, in their order, in any pieces.
pub fn targets(
    still: &Still,
    settings: &Settings,
    mut walk: impl FnMut(Range<u32>, u32) -> Vec<Found>,
) -> Targets {
    let (mut found, mut walks, mut arrivals) = (Vec::new(), 0, Vec::new());
    if still.lights.entries.is_empty() {
        return Targets::default();
    }
    while walks < MOST && arrivals.len() < ENOUGH {
        let round = walk(walks..walks + ROUND, settings.max_depth);
        arrivals.extend(round.iter().flat_map(Found::arrivals).map(|lit| lit.arrival));
        found.extend(round);
        walks += ROUND;
    }
    let targets = Targets::new(still, arrivals);
    if !targets.shares.is_empty() {
        return targets;
    }
    let mut guide = None;
    for (part, limit) in STAGES {
        let end = walks_of_guide(settings.photons_per_iteration / part).max(walks);
        found.extend(walk(walks..end, settings.max_depth.min(MOST_OF_WALK)));
        walks = end;
        guide = Guide::learn(walks, &found, limit);
        if guide.is_none() {
            break;
        }
    }
    Targets { guide: guide.map(Arc::new), ..targets }
}

fn walks_of_guide(photons: u32) -> u32 {
    (photons / PHOTONS_PER_WALK).min(MOST_OF_GUIDE).next_multiple_of(ROUND)
}

/// The most bytes that a survey takes for what it finds, and for the guide, where an iteration has so many photons.
pub fn bytes_at_most(photons: u32, max_depth: u32) -> u64 {
    let (edges, lit) = (size_of::<Edge>() as u64, size_of::<Lit>() as u64);
    let per_walk = u64::from(MOST_OF_WALK.min(max_depth)) * (edges + lit);
    let last_round = u64::from(ROUND) * u64::from(max_depth) * lit;
    // Lists grow by doubling.
    2 * (u64::from(walks_of_guide(photons).max(MOST)) * per_walk + last_round) + Guide::BYTES
}
