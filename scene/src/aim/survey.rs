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
    let mut guide: Option<Guide> = None;
    for (part, limit) in STAGES {
        let end = walks_of_guide(settings.photons_per_iteration / part).max(walks);
        if end == walks
            && let Some(learnt) = guide.take()
        {
            // Few photons are worth no further walks: what has been learnt is all there is.
            guide = Some(learnt).filter(|guide| guide.expected < limit);
            break;
        }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::guide::Arrival;
    use crate::test_scenes::balls;
    use glam::Vec3;
    use std::f32::consts::TAU;

    fn settings(photons_per_iteration: u32, max_depth: u32) -> Settings {
        Settings { photons_per_iteration, max_depth, ..Settings::default() }
    }

    /// What walks find that each go `length` segments: as many lines in directions around one way, and light that comes to all sides.
    fn one_way(walks: &Range<u32>, length: u32, is_lit: bool) -> Found {
        let mut found = Found::default();
        for (walk, step) in walks.clone().flat_map(|walk| (0..length).map(move |step| (walk, step))) {
            let [x, z] = [walk % 64, walk / 64 % 64].map(|k| k as f32 - 32.0);
            let point = Vec3::new(x, step as f32, z);
            let direction = Vec3::new(x * 1e-3, 1.0, z * 1e-3).normalize();
            found.edges.push(Edge { walk, point, normal: Vec3::Y, direction });
            let height = ((walk * 37 + step * 11) % 64) as f32 / 32.0 - 1.0;
            let (sin, cos) = (((walk * 13 + step * 7) % 101) as f32 / 101.0 * TAU).sin_cos();
            let radius = (1.0 - height * height).sqrt();
            let outward = Vec3::new(radius * cos, height, radius * sin);
            let arrival = Arrival { point: outward * 10.0, source: outward * 0.1, flux: 1.0 };
            found.lit.extend(is_lit.then_some(Lit { walk, is_seen: false, arrival }));
        }
        found
    }

    /// Which walks are sent out, and how far.
    fn walks(photons: u32, depth: u32, length: u32, is_lit: bool) -> (Vec<(Range<u32>, u32)>, Targets) {
        // A lamp amid all that it shines on: to aim at it gains nothing.
        let scene = balls(&[(Vec3::ZERO, 0.1, 1.0)]);
        let mut asked = Vec::new();
        let targets = targets(&scene.at(0.0), &settings(photons, depth), |walks, max_depth| {
            asked.push((walks.clone(), max_depth));
            vec![one_way(&walks, length, is_lit)]
        });
        (asked, targets)
    }

    /// Rounds until there are enough arrivals; then as many as a quarter of the photons asks for, and if these are worth it, all.
    #[test]
    fn as_many_walks_are_sent_out_as_photons_are_worth() {
        let (asked, targets) = walks(200_000, 20, 1, true);
        assert!(targets.shares.is_empty() && targets.guide.is_some(), "{}", targets.expected);
        assert_eq!(asked, [(0..512, 20), (512..1024, 20), (1024..3584, 8), (3584..12_800, 8)]);
        // No further than the render's own depth, and no more than the most.
        let (asked, _) = walks(u32::MAX, 5, 4, true);
        assert_eq!(asked, [(0..512, 5), (512..16_384, 5)]);
        // Few photons are worth none beyond those that are there.
        let (asked, _) = walks(1000, 5, 4, true);
        assert_eq!(asked, [(0..512, 5), (512..512, 5)]);
    }

    #[test]
    fn walks_end_where_nothing_is_found() {
        let (asked, targets) = walks(1_000_000, 7, 0, false);
        assert_eq!(asked.len(), 17, "{asked:?}");
        assert_eq!((asked[15].clone(), asked[16].clone()), ((7680..8192, 7), (8192..15_872, 7)));
        assert_eq!(targets, Targets::default());
        let dark = targets_of_no_lamp();
        assert_eq!(dark, Targets::default());
    }

    fn targets_of_no_lamp() -> Targets {
        let scene = balls(&[(Vec3::ZERO, 1.0, 0.0)]);
        targets(&scene.at(0.0), &settings(1000, 5), |_, _| panic!("there is no light to look for"))
    }

    /// Lists that grow by doubling have room for twice what is in them; the bound is no more than some megabytes above that.
    #[test]
    fn bytes_are_those_of_all_that_walks_may_find() {
        for (photons, depth) in [(1000, 3), (200_000, 5), (200_000, 40), (4_000_000, 8)] {
            let scene = balls(&[(Vec3::ZERO, 0.1, 1.0)]);
            let mut held = 0;
            let _ = targets(&scene.at(0.0), &settings(photons, depth), |walks, max_depth| {
                let found = one_way(&walks, max_depth.min(MOST_OF_WALK), true);
                held += size_of_val(&found.edges[..]) + size_of_val(&found.lit[..]);
                vec![found]
            });
            let most = bytes_at_most(photons, depth);
            assert!(most >= 2 * held as u64, "{photons}, {depth}: {held} of {most}");
            let all = MOST.max(walks_of_guide(photons));
            let all =
                u64::from(all * depth.min(MOST_OF_WALK)) * (size_of::<Edge>() + size_of::<Lit>()) as u64;
            assert!(most <= 2 * all + (4 << 20), "{photons}, {depth}: {most}, for {all} twice");
        }
    }

    /// Those of the round after which there are enough arrivals may each find light at every segment of a deep path.
    #[test]
    fn bytes_are_those_of_a_round_of_long_walks_too() {
        let (photons, depth) = (1000, 400);
        let scene = balls(&[(Vec3::ZERO, 0.1, 1.0)]);
        let mut held = 0;
        let _ = targets(&scene.at(0.0), &settings(photons, depth), |walks, max_depth| {
            let edges = one_way(&walks, max_depth.min(MOST_OF_WALK), false).edges;
            let found = Found { edges, ..one_way(&walks, max_depth, true) };
            held += size_of_val(&found.edges[..]) + size_of_val(&found.lit[..]);
            vec![found]
        });
        let most = bytes_at_most(photons, depth);
        assert!(most >= 2 * held as u64, "{held} of {most}");
    }
}
