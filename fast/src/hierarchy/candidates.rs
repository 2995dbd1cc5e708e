//! Pairs of a ray and a ball that it may meet, gathered until they fill the lanes.

use super::leaves::WIDTH;
use super::{Rays, Work, key};
use crate::intersect::meet;
use crate::lanes::{Lanes, MOST_LANES, Row};
use crate::paths::ROOM;
use crate::tables::tag;
use crate::vec3::V3;

/// Candidates at which they are to be evaluated.
const ENOUGH: usize = 1024;
/// Room for them, for what is added at once, and for what vectors write past the end.
const CANDIDATE_ROOM: usize = ENOUGH + (WIDTH + 1) * MOST_LANES;

// A packet adds a pair per lane and ball of a leaf at most; and the two lists take no more than a third of a first-level
// cache of 32 KiB.
const _: () =
    assert!(ENOUGH - 1 + WIDTH * MOST_LANES <= CANDIDATE_ROOM && 2 * 4 * CANDIDATE_ROOM <= (32 << 10) / 3);

/// The rays of a batch as rows, and the balls that they may meet.
pub(crate) struct Candidates {
    /// Per ray: origin, direction, the spheres that it leaves and that it passes over.
    pub(crate) rows: Box<[Row; ROOM]>,
    pub(crate) rays: Box<[u32; CANDIDATE_ROOM]>,
    pub(crate) balls: Box<[u32; CANDIDATE_ROOM]>,
    pub(crate) count: usize,
    /// All that has been done.
    pub(crate) work: Work,
}

impl Candidates {
    pub(crate) fn new() -> Self {
        Self {
            rows: Box::new([Row::default(); ROOM]),
            rays: Box::new([0; CANDIDATE_ROOM]),
            balls: Box::new([0; CANDIDATE_ROOM]),
            count: 0,
            work: Work::default(),
        }
    }

    /// Takes a packet of rays.
    #[inline(always)]
    pub(crate) fn take_rays<L: Lanes>(&mut self, rays: &Rays, at: usize, origin: V3<L>, direction: V3<L>) {
        let (leaves, passes) = (L::load_u(&rays.leaves[at..]), L::load_u(&rays.passes[at..]));
        let [o, d] = [origin, direction];
        let columns = [o.x, o.y, o.z, d.x, d.y, d.z, L::from_bits(leaves), L::from_bits(passes)];
        L::transpose(columns, &mut self.rows[at..]);
    }

    /// True if they are to be evaluated before more are added.
    #[inline(always)]
    pub(crate) fn are_enough(&self) -> bool {
        self.count >= ENOUGH
    }

    /// Lowers the keys of the rays to those of the hits among the candidates, and forgets these.
    #[inline(always)]
    pub(crate) fn evaluate<L: Lanes>(&mut self, surfaces: &[Row], keys: &mut [u64; ROOM]) {
        self.work.balls += self.count as u64;
        for at in (0..self.count).step_by(L::N) {
            let (rays, balls) = (&self.rays[at..at + L::N], &self.balls[at..at + L::N]);
            let [ox, oy, oz, dx, dy, dz, leaves, passes] = L::gather_rows(&self.rows[..], rays);
            let [cx, cy, cz, radius, _, _, _, tag] = L::gather_rows(surfaces, balls);
            let sphere = L::load_u(balls);
            let is_glass = L::eq(L::bits(tag) & L::u(tag::GLASS), L::u(tag::GLASS));
            let leaves = L::eq(sphere, L::bits(leaves));
            let (origin, direction) = (V3::<L>::new(ox, oy, oz), V3::new(dx, dy, dz));
            let center = V3::new(cx, cy, cz);
            let (t, valid) = meet(origin, direction, leaves, center, radius * radius, is_glass);
            let valid = valid & L::first(self.count - at) & !L::eq(sphere, L::bits(passes));
            let mut distances = [0; MOST_LANES];
            L::store_u(L::select_u(valid, L::bits(t), L::u(u32::MAX)), &mut distances);
            for k in 0..L::N {
                let nearest = &mut keys[rays[k] as usize];
                *nearest = (*nearest).min(key(distances[k], balls[k]));
            }
        }
        self.count = 0;
    }
}
