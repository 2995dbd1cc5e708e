//! Clusters: the search for up to about a thousand balls.
//!
//! ```text
//! for each packet of rays, for each cluster of sixteen balls (a leaf):
//!     append the rays that may hit the cluster's bounding sphere to its queue
//! for each cluster, for each ray of its queue, for each packet of its balls:
//!     append those that the ray may hit, with the ray, to the candidates
//! for each packet of candidates: the exact formula; keep the nearest hit of each ray
//! ```
//!
//! How it differs from testing every ball, and why:
//!
//! 1. "May hit" is a test of 13 operations without root and division ([`super::cull`]). A root and a division cost as
//!    much as all the rest, and few rays need them.
//! 2. Appending is a compression, not a branch: nothing is mispredicted, and lanes are full again in the next stage.
//!    A tree walked ray by ray is slower up to about a thousand balls, for its branches and its chain of latencies.
//! 3. Clusters are tested with rays in lanes, balls with balls in lanes: each ray of a queue is then broadcast from where it
//!    is, and no packet of rays is gathered. Clusters of eight balls took as many instructions with eight lanes, and would
//!    leave half of sixteen empty.
//! 4. Candidates come in any order, and the minimum of their keys ([`super::keys`]) is the nearest hit.

use super::candidates::{Candidates, RAYS_AT_ONCE, SurfaceRows};
use super::cull::{may_meet, trust};
use super::leaves::{Ball, Leaf, WIDTH};
use crate::pages::Pages;
use crate::paths::{Floats, ROOM, Words};
use crate::rays::Rays;
use lanes::{Lanes, V3};
use scene::Vec3;

/// Balls in clusters, which are leaves.
#[derive(Debug)]
pub(crate) struct Clusters {
    leaves: Pages<Leaf>,
    /// The bounding sphere of each: centre and squared radius.
    bounding_spheres: Vec<[f32; 4]>,
}

/// Per cluster, the rays that may hit it.
pub(crate) struct Queues {
    waiting: Vec<Words>,
    counts: Vec<usize>,
    /// Per ray, its [`trust`].
    trusts: Box<Floats>,
}

impl Queues {
    pub(crate) fn new() -> Self {
        Self { waiting: Vec::new(), counts: Vec::new(), trusts: Box::new([0.0; ROOM]) }
    }

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
        Self { bounding_spheres: balls.chunks(WIDTH).map(bounding_sphere).collect(), leaves }
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
            let parts = leaves[cluster].parts::<L>();
            for rays in waiting[..*count].chunks(RAYS_AT_ONCE) {
                candidates.add::<L, SurfaceRows>(&parts, rays, |ray| queues.trusts[ray as usize]);
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
        L::store(trust, &mut queues.trusts[at..]);
        let queues = queues.waiting.iter_mut().zip(&mut queues.counts);
        for ([x, y, z, r2], (waiting, count)) in self.bounding_spheres.iter().zip(queues) {
            let center = V3::new(L::f(*x), L::f(*y), L::f(*z));
            let may = live & may_meet(origin, direction, trust, center, L::f(*r2));
            L::compress_u(may, ids, &mut waiting[*count..]);
            *count += L::mask_bits(may).count_ones() as usize;
        }
    }
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
