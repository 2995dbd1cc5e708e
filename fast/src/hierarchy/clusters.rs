//! Clusters: the search for up to about a thousand balls.
//!
//! ```text
//! for each packet of rays:
//!     for each cluster of sixteen balls (a leaf): append the rays that may hit its bounding sphere to its queue
//!     for each large ball: append those that may hit it, with the ball, to the candidates
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
//! 5. A few balls that are much larger than most stand by themselves. In a cluster they would stretch its bounding sphere: of the
//!    66 balls of `surgery` three do, and without them rays meet two thirds as many clusters.
//! 6. Shadow rays end at a lamp, often before a cluster, and the test of the cluster knows where. Those that leave a ball are
//!    followed beyond: whatever their origin, the reference takes it to be on that ball.

use super::candidates::{Balls, Candidates, RAYS_AT_ONCE, SurfaceRows};
use super::cull::{may_meet, may_meet_before, trust, trust_before};
use super::leaves::{Ball, GLASS, Leaf, WIDTH, arrange};
use crate::paths::{BATCH, Floats, ROOM, Words, least};
use crate::rays::Rays;
use crate::shapes::BallShape;
use crate::surface::are_anchored;
use lanes::{Lanes, MOST_LANES, V3};
use scene::Vec3;
use scene::ray::NO_SPHERE;

/// Balls of more than so many times the median radius stand by themselves.
const LARGE: f32 = 1.5;
/// The most balls that stand by themselves: each costs every packet of rays a test.
const MOST_LARGE: usize = 4;

// All rays of a batch may be candidates for each.
const _: () = assert!(MOST_LARGE * BATCH <= SurfaceRows::ENOUGH);

/// Balls in clusters, which are leaves.
#[derive(Debug)]
pub(crate) struct Clusters {
    /// The clusters, then a leaf for each large ball.
    leaves: Vec<Leaf>,
    /// The bounding sphere of each cluster: centre and squared radius.
    bounding_spheres: Vec<[f32; 4]>,
    /// The balls that stand by themselves.
    large: Vec<BallShape>,
}

/// Per cluster, the rays that may hit it.
pub(crate) struct Queues {
    waiting: Vec<Words>,
    counts: Vec<usize>,
}

impl Queues {
    pub(crate) fn new() -> Self {
        Self { waiting: Vec::new(), counts: Vec::new() }
    }

    fn clear(&mut self, clusters: usize) {
        self.waiting.resize(clusters, [0; ROOM]);
        self.counts.clear();
        self.counts.resize(clusters, 0);
    }
}

impl Clusters {
    pub(crate) fn new(balls: Vec<Ball>) -> Self {
        let (mut others, large) = apart(balls);
        arrange(&mut others);
        let leaves = others.chunks(WIDTH).map(Leaf::new);
        Self {
            leaves: leaves.chain(large.iter().map(|ball| Leaf::new(&[*ball]))).collect(),
            bounding_spheres: others.chunks(WIDTH).map(bounding_sphere).collect(),
            large: large.iter().map(shape).collect(),
        }
    }

    pub(crate) fn leaves(&self) -> &[Leaf] {
        &self.leaves
    }

    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&self.leaves[..]) + size_of_val(&self.bounding_spheres[..]) + size_of_val(&self.large[..])
    }

    /// Lowers the keys of the rays to those of their nearest hits. Rays with a negative `t` are skipped; with `ENDS`, the others end
    /// there, and farther hits may be missed.
    #[inline(always)]
    pub(crate) fn search<L: Lanes, const ENDS: bool>(
        &self,
        surfaces: &SurfaceRows,
        rays: &Rays,
        t: &Floats,
        queues: &mut Queues,
        candidates: &mut Candidates,
        keys: &mut [u64; ROOM],
    ) {
        queues.clear(self.bounding_spheres.len());
        let mut least_trust = L::f(1.0);
        for at in (0..rays.count).step_by(L::N) {
            let (origin, direction) = (rays.origin.load::<L>(at), rays.direction.load::<L>(at));
            let t = L::load(&t[at..]);
            let live = L::first(rays.count - at) & L::le(L::f(0.0), t);
            candidates.take_rays::<L>(rays, at, origin, direction);
            let t = if ENDS { Self::end::<L>(surfaces, rays, at, t) } else { t };
            let packet = RayLanes { origin, direction, trust: trust(direction), t, live };
            // In this order what is no number is left out.
            least_trust = L::min(L::select(live, packet.trust, least_trust), least_trust);
            self.enqueue::<L, ENDS>(&packet, at, queues);
            self.add_large::<L, ENDS>(&packet, at, candidates);
        }
        let (leaves, trust) = (&self.leaves[..], least::<L>(least_trust));
        candidates.work.boxes += queues.counts.iter().sum::<usize>() as u64;
        for (cluster, (waiting, count)) in queues.waiting.iter().zip(&queues.counts).enumerate() {
            let parts = leaves[cluster].parts::<L>();
            for rays in waiting[..*count].chunks(RAYS_AT_ONCE) {
                candidates.add::<L, SurfaceRows>(&parts, rays, trust);
                if candidates.are_enough(surfaces) {
                    candidates.evaluate::<L>(surfaces, keys);
                }
            }
        }
        candidates.evaluate::<L>(surfaces, keys);
    }

    /// Where the rays from `at` on end, which were to end at `t`.
    #[inline(always)]
    fn end<L: Lanes>(surfaces: &SurfaceRows, rays: &Rays, at: usize, t: L::F) -> L::F {
        let leaves = L::load_u(&rays.leaves[at..]);
        let leaves_any = !L::eq(leaves, L::u(NO_SPHERE)) & L::first(rays.count - at);
        let mut ids = [0; MOST_LANES];
        L::store_u(L::select_u(leaves_any, leaves, L::u(0)), &mut ids);
        let is_free = !leaves_any | are_anchored::<L>(surfaces.0, &ids);
        L::select(is_free, t, L::f(f32::INFINITY))
    }

    /// Appends a packet, the rays from `at` on, to the queues of the clusters that they may hit.
    #[inline(always)]
    fn enqueue<L: Lanes, const ENDS: bool>(&self, rays: &RayLanes<L>, at: usize, queues: &mut Queues) {
        let ids = L::u(at as u32) + L::iota();
        let queues = queues.waiting.iter_mut().zip(&mut queues.counts);
        for ([x, y, z, r2], (waiting, count)) in self.bounding_spheres.iter().zip(queues) {
            let may = rays.may_meet::<ENDS>(V3::new(L::f(*x), L::f(*y), L::f(*z)), L::f(*r2));
            L::compress_u(may, ids, &mut waiting[*count..]);
            *count += L::mask_bits(may).count_ones() as usize;
        }
    }

    /// Appends those of a packet, the rays from `at` on, to the candidates that may hit a large ball.
    #[inline(always)]
    fn add_large<L: Lanes, const ENDS: bool>(&self, rays: &RayLanes<L>, at: usize, to: &mut Candidates) {
        for ball in &self.large {
            let may = rays.may_meet::<ENDS>(V3::splat(ball.center), L::f(ball.radius_squared));
            to.add_ball::<L>(may, at, ball.sphere);
        }
    }
}

/// A packet of rays.
struct RayLanes<L: Lanes> {
    origin: V3<L>,
    direction: V3<L>,
    trust: L::F,
    /// Where the rays end.
    t: L::F,
    live: L::M,
}

impl<L: Lanes> RayLanes<L> {
    /// The rays that may hit balls within a sphere, with `ENDS` before they end.
    #[inline(always)]
    fn may_meet<const ENDS: bool>(&self, center: V3<L>, r2: L::F) -> L::M {
        let Self { origin, direction, trust, t, live } = *self;
        live & if ENDS {
            may_meet_before(origin, direction, trust_before::<L>(trust), center, r2, t)
        } else {
            may_meet(origin, direction, trust, center, r2)
        }
    }
}

/// As it is tested by itself.
fn shape(ball: &Ball) -> BallShape {
    let Ball { center, radius, sphere } = *ball;
    BallShape { sphere: sphere & !GLASS, center: center.into(), radius_squared: radius * radius }
}

/// The balls that go into clusters, and the largest ones, which stand by themselves.
fn apart(mut balls: Vec<Ball>) -> (Vec<Ball>, Vec<Ball>) {
    balls.sort_by(|a, b| a.radius.total_cmp(&b.radius));
    let median = balls.get(balls.len() / 2).map_or(0.0, |ball| ball.radius);
    let ordinary = balls.partition_point(|ball| ball.radius <= LARGE * median);
    let large = balls.split_off(ordinary.max(balls.len().saturating_sub(MOST_LARGE)));
    (balls, large)
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
    use scene::ray::SphereId;

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

    /// But no more than a few, and none if all are alike.
    #[test]
    fn balls_much_larger_than_most_stand_by_themselves() {
        let large_of = |radii: &[f32]| {
            let ball = |(k, radius): (u32, &f32)| Ball { center: [k as f32; 3], radius: *radius, sphere: k };
            let clusters = Clusters::new((0..).zip(radii).map(ball).collect());
            let mut spheres: Vec<SphereId> =
                clusters.leaves.iter().flat_map(Leaf::balls).map(|b| b.sphere).collect();
            spheres.sort_unstable();
            assert!(spheres.into_iter().eq(0..radii.len() as u32), "a ball is lost");
            assert_eq!(clusters.leaves.len(), clusters.bounding_spheres.len() + clusters.large.len());
            let mut large: Vec<f32> = clusters.large.iter().map(|ball| ball.radius_squared.sqrt()).collect();
            large.sort_by(f32::total_cmp);
            large
        };
        let with = |large: &[f32]| [&[1.0; 40], large].concat();
        assert_eq!(large_of(&with(&[1.4, 2.0, 3.0])), [2.0, 3.0]);
        assert_eq!(large_of(&with(&[1.4])), [0.0; 0]);
        assert_eq!(large_of(&with(&[6.0, 2.0, 3.0, 5.0, 4.0])), [3.0, 4.0, 5.0, 6.0]);
        assert_eq!(large_of(&[]), [0.0; 0]);
    }
}
