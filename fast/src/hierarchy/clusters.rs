//! Clusters: the search for up to about a thousand balls.
//!
//! ```text
//! for each packet of rays, for each cluster of eight balls (half a leaf):
//!     append the rays that may hit the cluster's bounding sphere to its queue
//! for each cluster, for each packet of its queue, for each of its balls:
//!     append the rays that may hit the ball, with the ball, to the candidates
//! for each packet of candidates: the exact formula; keep the nearest hit of each ray
//! ```
//!
//! How it differs from testing every ball, and why:
//!
//! 1. "May hit" is a test of 13 operations without root and division ([`super::cull`]). A root and a division cost as
//!    much as all the rest, and few rays need them.
//! 2. Appending is a compression, not a branch: nothing is mispredicted, and lanes are full again in the next stage.
//!    A tree walked ray by ray is slower up to about a thousand balls, for its branches and its chain of latencies.
//! 3. Candidates come in any order, and the minimum of their keys ([`super::keys`]) is the nearest hit.

use super::candidates::{Candidates, SurfaceRows};
use super::cull::{may_meet, trust};
use super::leaves::{Ball, GLASS, HALF, Leaf};
use super::rays::Rays;
use crate::pages::Pages;
use crate::paths::{Floats, ROOM, Words};
use lanes::{Lanes, V3};
use scene::Vec3;

/// Balls in clusters, which are the halves of leaves.
#[derive(Debug)]
pub(crate) struct Clusters {
    leaves: Pages<Leaf>,
    /// The bounding sphere of each half that has balls: centre and squared radius.
    bounding_spheres: Vec<[f32; 4]>,
}

/// Per cluster, the rays that may hit it.
#[derive(Default)]
pub(crate) struct Queues {
    waiting: Vec<Words>,
    counts: Vec<usize>,
}

impl Queues {
    fn clear(&mut self, clusters: usize) {
        self.waiting.resize(clusters, [0; ROOM]);
        self.counts.clear();
        self.counts.resize(clusters, 0);
    }
}

impl Clusters {
    /// From the leaves of [`super::leaves::arranged`].
    pub(crate) fn new(leaves: Pages<Leaf>) -> Self {
        // All leaves but the last are full, and the last is filled from the front.
        let balls: Vec<Ball> = leaves.iter().flat_map(Leaf::balls).collect();
        Self { bounding_spheres: balls.chunks(HALF).map(bounding_sphere).collect(), leaves }
    }

    pub(crate) fn leaves(&self) -> &[Leaf] {
        &self.leaves
    }

    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&self.leaves[..]) + size_of_val(&self.bounding_spheres[..])
    }

    /// Lowers the keys of the rays to those of their nearest hits. Rays with a negative `t` are skipped.
    #[inline(always)]
    pub(crate) fn search<L: Lanes>(
        &self,
        surfaces: &SurfaceRows,
        rays: &Rays,
        t: &Floats,
        queues: &mut Queues,
        candidates: &mut Candidates,
        keys: &mut [u64; ROOM],
    ) {
        queues.clear(self.bounding_spheres.len());
        for at in (0..rays.count).step_by(L::N) {
            let (origin, direction) = (rays.origin.load::<L>(at), rays.direction.load::<L>(at));
            let live = L::first(rays.count - at) & L::le(L::f(0.0), L::load(&t[at..]));
            candidates.take_rays::<L>(rays, at, origin, direction);
            self.enqueue::<L>(origin, direction, live, at, queues);
        }
        let leaves = &self.leaves[..];
        candidates.work.boxes += queues.counts.iter().sum::<usize>() as u64;
        for (cluster, (waiting, count)) in queues.waiting.iter().zip(&queues.counts).enumerate() {
            let (leaf, half) = (&leaves[cluster / 2], cluster % 2);
            for at in (0..*count).step_by(L::N) {
                cull::<L>(leaf, half, &waiting[at..], L::first(*count - at), candidates);
                if candidates.are_enough(surfaces) {
                    candidates.evaluate::<L>(surfaces, keys);
                }
            }
        }
        candidates.evaluate::<L>(surfaces, keys);
    }

    /// Appends a packet, the rays from `at` on, to the queues of the clusters that they may hit.
    #[inline(always)]
    fn enqueue<L: Lanes>(&self, origin: V3<L>, direction: V3<L>, live: L::M, at: usize, queues: &mut Queues) {
        let (ids, trust) = (L::u(at as u32) + L::iota(), trust(direction));
        let queues = queues.waiting.iter_mut().zip(&mut queues.counts);
        for ([x, y, z, r2], (waiting, count)) in self.bounding_spheres.iter().zip(queues) {
            let center = V3::new(L::f(*x), L::f(*y), L::f(*z));
            let may = live & may_meet(origin, direction, trust, center, L::f(*r2));
            L::compress_u(may, ids, &mut waiting[*count..]);
            *count += L::mask_bits(may).count_ones() as usize;
        }
    }
}

/// Adds to the candidates each ball of half a leaf with each waiting ray that may hit it.
#[inline(always)]
fn cull<L: Lanes>(leaf: &Leaf, half: usize, waiting: &[u32], live: L::M, candidates: &mut Candidates) {
    let (origin, direction) = candidates.gather_rays::<L>(waiting);
    let (ids, trust) = (L::load_u(waiting), trust(direction));
    let mut count = candidates.count;
    for k in (0..HALF).map(|k| half * HALF + k) {
        let center = V3::new(L::f(leaf.x[k]), L::f(leaf.y[k]), L::f(leaf.z[k]));
        let may = live & may_meet(origin, direction, trust, center, L::f(leaf.radius_squared[k]));
        L::compress_u(may, ids, &mut candidates.pairs.rays[count..]);
        L::store_u(L::u(leaf.spheres[k] & !GLASS), &mut candidates.pairs.balls[count..]);
        count += L::mask_bits(may).count_ones() as usize;
    }
    candidates.count = count;
}

/// A small bounding sphere of some balls: centre and squared radius.
fn bounding_sphere(balls: &[Ball]) -> [f32; 4] {
    /// Steps towards the ball that sticks out most. More steps give a smaller sphere.
    const STEPS: u32 = 64;
    let middle = |ball: &Ball| Vec3::from_array(ball.center);
    let reach = |center: Vec3, ball: &Ball| center.distance(middle(ball)) + ball.radius;
    let mut center = balls.iter().map(middle).sum::<Vec3>() / balls.len() as f32;
    let mut radius = f32::INFINITY;
    let mut best = center;
    for step in 2..STEPS {
        let farthest = balls.iter().max_by(|a, b| reach(center, a).total_cmp(&reach(center, b)));
        let Some(farthest) = farthest else { break };
        if reach(center, farthest) < radius {
            (best, radius) = (center, reach(center, farthest));
        }
        center += (middle(farthest) - center) / step as f32;
    }
    // A few ulps more, for the rounding of these lines.
    let radius = radius * (1.0 + 1e-6) + best.abs().max_element() * 1e-6;
    [best.x, best.y, best.z, radius * radius]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounding_spheres_hold_their_balls_and_hardly_more() {
        // A long row, and balls far from the origin: around their mean both are far too large. A ball by itself.
        let row = |k: u32| ([(k * k) as f32, 0.0, 0.0], 0.5);
        let far = |k: u32| ([100.0 + k as f32, 50.0 * (k % 2) as f32, -30.0], 1.0 + k as f32);
        // What holds the balls at both ends of the row, and the greatest of the others with the farthest of it.
        for (places, least) in [
            ((0..8).map(row).collect::<Vec<_>>(), 25.0),
            ((0..8).map(far).collect(), 32.5),
            (vec![([0.0; 3], 1.0)], 1.0),
        ] {
            let ball = |(center, radius): ([f32; 3], f32)| Ball { center, radius, sphere: 0 };
            let balls: Vec<Ball> = places.into_iter().map(ball).collect();
            let [x, y, z, radius_squared] = bounding_sphere(&balls);
            let (center, radius) = (Vec3::new(x, y, z), radius_squared.sqrt());
            assert!(balls.iter().all(|ball| center.distance(ball.center.into()) + ball.radius <= radius));
            assert!((0.99 * least..1.03 * least).contains(&radius), "{radius}, where {least} would do");
        }
    }
}
