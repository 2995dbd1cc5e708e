//! Candidates: pairs of a ray and a ball that it may hit, collected and then tested by the exact formula in full packets.
//!
//! The ball is copied from its leaf, which is in the cache. A table of all spheres would have to come from memory.

use super::keys::key;
use super::leaves::{GLASS, WIDTH};
use super::rays::Rays;
use crate::intersect::meet;
use crate::paths::{ROOM, Vectors};
use crate::search::Work;
use lanes::{Lanes, MOST_LANES, Row, V3};

/// The list is evaluated once it has this many candidates.
const ENOUGH: usize = 256;
/// Room for them, for those that are added at once, and for what vectors write past the end.
const CANDIDATE_ROOM: usize = ENOUGH + (WIDTH + 1) * MOST_LANES;

// A packet adds a pair per lane and ball of a leaf at most; and the pairs take no more than a third of a first-level cache of
// 32 KiB.
const _: () =
    assert!(ENOUGH - 1 + WIDTH * MOST_LANES <= CANDIDATE_ROOM && size_of::<Pairs>() <= (32 << 10) / 3);

/// Pairs of a ray and a ball, as a structure of arrays.
pub(crate) struct Pairs {
    /// The number of the ray in the batch.
    pub(crate) rays: [u32; CANDIDATE_ROOM],
    /// The sphere, and perhaps [`GLASS`].
    pub(crate) balls: [u32; CANDIDATE_ROOM],
    pub(crate) centers: Vectors<CANDIDATE_ROOM>,
    pub(crate) radii_squared: [f32; CANDIDATE_ROOM],
}

/// The rays of a batch as rows, and the balls that they may hit.
pub(crate) struct Candidates {
    /// A row per ray of the batch, see [`RayLanes`].
    rows: Box<[Row; ROOM]>,
    pub(crate) pairs: Box<Pairs>,
    /// The number of pairs.
    pub(crate) count: usize,
    /// Counted work so far.
    pub(crate) work: Work,
}

/// Rays in lanes. Their rows hold the words origin x y z, direction x y z, the sphere that the ray leaves, and the
/// sphere that it ignores.
struct RayLanes<L: Lanes> {
    origin: V3<L>,
    direction: V3<L>,
    leaves: L::U,
    ignores: L::U,
}

impl<L: Lanes> RayLanes<L> {
    #[inline(always)]
    fn gather(rows: &[Row], index: &[u32]) -> Self {
        let [ox, oy, oz, dx, dy, dz, leaves, ignores] = L::gather_rows(rows, index);
        let (origin, direction) = (V3::new(ox, oy, oz), V3::new(dx, dy, dz));
        Self { origin, direction, leaves: L::bits(leaves), ignores: L::bits(ignores) }
    }

    #[inline(always)]
    fn store(self, to: &mut [Row]) {
        let Self { origin: o, direction: d, leaves, ignores } = self;
        L::transpose([o.x, o.y, o.z, d.x, d.y, d.z, L::from_bits(leaves), L::from_bits(ignores)], to);
    }
}

impl Candidates {
    pub(crate) fn new() -> Self {
        let pairs = Pairs {
            rays: [0; CANDIDATE_ROOM],
            balls: [0; CANDIDATE_ROOM],
            centers: Vectors::ZERO,
            radii_squared: [0.0; CANDIDATE_ROOM],
        };
        let rows = Box::new([Row::default(); ROOM]);
        Self { rows, pairs: Box::new(pairs), count: 0, work: Work::default() }
    }

    /// Stores a packet of rays, those from `at` on.
    #[inline(always)]
    pub(crate) fn take_rays<L: Lanes>(&mut self, rays: &Rays, at: usize, origin: V3<L>, direction: V3<L>) {
        let (leaves, ignores) = (L::load_u(&rays.leaves[at..]), L::load_u(&rays.ignores[at..]));
        RayLanes { origin, direction, leaves, ignores }.store(&mut self.rows[at..]);
    }

    /// Origins and directions of the rays with these indices.
    #[inline(always)]
    pub(crate) fn gather_rays<L: Lanes>(&self, index: &[u32]) -> (V3<L>, V3<L>) {
        let RayLanes { origin, direction, .. } = RayLanes::<L>::gather(&self.rows[..], index);
        (origin, direction)
    }

    /// Origin and direction of one ray, in every lane.
    #[inline(always)]
    pub(crate) fn broadcast_ray<L: Lanes>(&self, ray: usize) -> (V3<L>, V3<L>) {
        let Row([ox, oy, oz, dx, dy, dz, ..]) = self.rows[ray];
        (V3::new(L::f(ox), L::f(oy), L::f(oz)), V3::new(L::f(dx), L::f(dy), L::f(dz)))
    }

    /// True if the candidates must be evaluated before more are added.
    #[inline(always)]
    pub(crate) fn are_enough(&self) -> bool {
        self.count >= ENOUGH
    }

    /// Tests all candidates by the exact formula, lowers the keys of the rays to those of the hits, and empties the list.
    #[inline(always)]
    pub(crate) fn evaluate<L: Lanes>(&mut self, keys: &mut [u64; ROOM]) {
        self.work.balls += self.count as u64;
        for at in (0..self.count).step_by(L::N) {
            let (pairs, rays) = (&self.pairs, &self.pairs.rays[at..at + L::N]);
            let RayLanes { origin, direction, leaves, ignores } = RayLanes::<L>::gather(&self.rows[..], rays);
            let balls = L::load_u(&pairs.balls[at..]);
            let (glass, sphere) = (L::u(GLASS), balls & L::u(!GLASS));
            let is_glass = L::eq(balls & glass, glass);
            let (center, radius_squared) = (pairs.centers.load::<L>(at), L::load(&pairs.radii_squared[at..]));
            let leaves = L::eq(sphere, leaves);
            let (t, valid) = meet(origin, direction, leaves, center, radius_squared, is_glass);
            let valid = valid & L::first(self.count - at) & !L::eq(sphere, ignores);
            let mut distances = [0; MOST_LANES];
            L::store_u(L::select_u(valid, L::bits(t), L::u(u32::MAX)), &mut distances);
            for k in 0..L::N {
                let nearest = &mut keys[rays[k] as usize];
                *nearest = (*nearest).min(key(distances[k], pairs.balls[at + k] & !GLASS));
            }
        }
        self.count = 0;
    }
}
