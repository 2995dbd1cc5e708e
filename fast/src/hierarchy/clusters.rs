//! Up to about a thousand balls: rays queue before clusters of eight.
//!
//!     for each packet of rays, for each cluster:
//!         append the rays that may meet the sphere around the cluster to its queue
//!     for each cluster, for each packet of its queue, for each of its balls:
//!         append the rays that may meet the ball, and the ball, to the candidates
//!     for each packet of candidates: the reference's formula; keep the nearest hit of each ray
//!
//! How it differs from trying all balls, and why:
//!
//! 1. "May meet" is a test of 13 operations without root and division, sound for whatever the reference's rounding
//!    accepts ([`super::may_meet`]). A root and a division cost as much as all else, and few rays need them.
//! 2. Appending is a compression, not a branch: nothing is mispredicted, and lanes are full again in the next stage.
//!    A tree walked ray by ray is slower up to about a thousand balls, for its branches and its chain of latencies.
//! 3. Candidates come in no order. A hit packs distance and sphere into one integer, whose minimum is the nearest
//!    hit, and of equal distances the lower id.

use super::leaves::{Ball, Leaf, WIDTH};
use super::{Rays, key, may_meet};
use crate::intersect::meet;
use crate::lanes::{Lanes, MOST_LANES, Row};
use crate::paths::{Floats, ROOM, Words};
use crate::tables::tag;
use crate::vec3::V3;
use scene::Vec3;

/// Candidates at which they are evaluated.
const ENOUGH: usize = 1024;
/// Room for them and for what one packet may add, and for what vectors write past the end.
const CANDIDATE_ROOM: usize = ENOUGH + (WIDTH + 1) * MOST_LANES;

/// Balls in clusters.
#[derive(Debug)]
pub(crate) struct Clusters {
    leaves: Vec<Leaf>,
    /// A sphere around each: centre and squared radius.
    bounds: Vec<[f32; 4]>,
}

/// What the search writes, kept from batch to batch.
pub(crate) struct Queues {
    /// Per ray: origin, direction, the spheres that it leaves and that it passes over.
    rows: Box<[Row; ROOM]>,
    /// Per cluster, the rays that may meet it.
    waiting: Vec<Words>,
    counts: Vec<usize>,
    rays: Box<[u32; CANDIDATE_ROOM]>,
    balls: Box<[u32; CANDIDATE_ROOM]>,
    candidates: usize,
}

impl Queues {
    pub(crate) fn new() -> Self {
        Self {
            rows: Box::new([Row::default(); ROOM]),
            waiting: Vec::new(),
            counts: Vec::new(),
            rays: Box::new([0; CANDIDATE_ROOM]),
            balls: Box::new([0; CANDIDATE_ROOM]),
            candidates: 0,
        }
    }

    fn clear(&mut self, clusters: usize) {
        self.waiting.resize(clusters, [0; ROOM]);
        self.counts.clear();
        self.counts.resize(clusters, 0);
    }
}

impl Clusters {
    /// Of balls that have been arranged.
    pub(crate) fn new(balls: &[Ball]) -> Self {
        let leaves = balls.chunks(WIDTH).map(Leaf::new).collect();
        Self { leaves, bounds: balls.chunks(WIDTH).map(bounding_sphere).collect() }
    }

    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&self.leaves[..]) + size_of_val(&self.bounds[..])
    }

    /// Lowers the keys of the rays to those of their nearest hits; of rays with a negative `t`, none.
    #[inline(always)]
    pub(crate) fn search<L: Lanes>(
        &self,
        surfaces: &[Row],
        rays: &Rays,
        t: &Floats,
        queues: &mut Queues,
        keys: &mut [u64; ROOM],
    ) {
        queues.clear(self.leaves.len());
        for at in (0..rays.count).step_by(L::N) {
            self.enqueue::<L>(rays, t, at, queues);
        }
        for cluster in 0..self.leaves.len() {
            for at in (0..queues.counts[cluster]).step_by(L::N) {
                self.sift::<L>(cluster, at, queues);
                if queues.candidates >= ENOUGH {
                    evaluate::<L>(surfaces, queues, keys);
                }
            }
        }
        evaluate::<L>(surfaces, queues, keys);
    }

    /// Lets a packet queue before the clusters that it may meet.
    #[inline(always)]
    fn enqueue<L: Lanes>(&self, rays: &Rays, t: &Floats, at: usize, queues: &mut Queues) {
        let (origin, direction) = (rays.origin.load::<L>(at), rays.direction.load::<L>(at));
        let (leaves, passes) = (L::load_u(&rays.leaves[at..]), L::load_u(&rays.passes[at..]));
        let [o, d] = [origin, direction];
        let columns = [o.x, o.y, o.z, d.x, d.y, d.z, L::from_bits(leaves), L::from_bits(passes)];
        L::transpose(columns, &mut queues.rows[at..]);
        let ids = L::u(at as u32) + L::iota();
        let here = L::first(rays.count - at) & L::le(L::f(0.0), L::load(&t[at..]));
        let trust = super::trust(direction);
        let queues = queues.waiting.iter_mut().zip(&mut queues.counts);
        for ([x, y, z, r2], (waiting, count)) in self.bounds.iter().zip(queues) {
            let center = V3::new(L::f(*x), L::f(*y), L::f(*z));
            let may = here & may_meet(origin, direction, trust, center, L::f(*r2));
            L::compress_u(may, ids, &mut waiting[*count..]);
            *count += L::mask_bits(may).count_ones() as usize;
        }
    }

    /// Finds which balls of a cluster a packet of its queue may meet.
    #[inline(always)]
    fn sift<L: Lanes>(&self, cluster: usize, at: usize, queues: &mut Queues) {
        let leaf = &self.leaves[cluster];
        let waiting = &queues.waiting[cluster][at..];
        let here = L::first(queues.counts[cluster] - at);
        let [ox, oy, oz, dx, dy, dz, ..] = L::gather_rows(&queues.rows[..], waiting);
        let (origin, direction) = (V3::<L>::new(ox, oy, oz), V3::new(dx, dy, dz));
        let (ids, trust) = (L::load_u(waiting), super::trust(direction));
        let mut count = queues.candidates;
        for k in 0..WIDTH {
            let center = V3::new(L::f(leaf.x[k]), L::f(leaf.y[k]), L::f(leaf.z[k]));
            let may = here & may_meet(origin, direction, trust, center, L::f(leaf.radius_squared[k]));
            L::compress_u(may, ids, &mut queues.rays[count..]);
            L::store_u(L::u(leaf.sphere(k)), &mut queues.balls[count..]);
            count += L::mask_bits(may).count_ones() as usize;
        }
        queues.candidates = count;
    }
}

/// Evaluates all candidates.
#[inline(always)]
fn evaluate<L: Lanes>(surfaces: &[Row], queues: &mut Queues, keys: &mut [u64; ROOM]) {
    for at in (0..queues.candidates).step_by(L::N) {
        let (rays, balls) = (&queues.rays[at..at + L::N], &queues.balls[at..at + L::N]);
        let [ox, oy, oz, dx, dy, dz, leaves, passes] = L::gather_rows(&queues.rows[..], rays);
        let [cx, cy, cz, radius, _, _, _, tag] = L::gather_rows(surfaces, balls);
        let sphere = L::load_u(balls);
        let is_glass = L::eq(L::bits(tag) & L::u(tag::GLASS), L::u(tag::GLASS));
        let leaves = L::eq(sphere, L::bits(leaves));
        let (origin, direction) = (V3::<L>::new(ox, oy, oz), V3::new(dx, dy, dz));
        let (t, valid) = meet(origin, direction, leaves, V3::new(cx, cy, cz), radius * radius, is_glass);
        let valid = valid & L::first(queues.candidates - at) & !L::eq(sphere, L::bits(passes));
        let mut distances = [0; MOST_LANES];
        L::store_u(L::select_u(valid, L::bits(t), L::u(u32::MAX)), &mut distances);
        for k in 0..L::N {
            let nearest = &mut keys[rays[k] as usize];
            *nearest = (*nearest).min(key(distances[k], balls[k]));
        }
    }
    queues.candidates = 0;
}

/// A small sphere around balls: centre and squared radius.
fn bounding_sphere(balls: &[Ball]) -> [f32; 4] {
    /// Steps towards the ball that sticks out most; the error falls with their number.
    const STEPS: u32 = 64;
    let reach = |center: Vec3, ball: &Ball| center.distance(ball.center) + ball.radius;
    let mut center = balls.iter().map(|ball| ball.center).sum::<Vec3>() / balls.len() as f32;
    let mut radius = f32::INFINITY;
    let mut best = center;
    for step in 2..STEPS {
        let farthest = balls.iter().max_by(|a, b| reach(center, a).total_cmp(&reach(center, b)));
        let Some(farthest) = farthest else { break };
        if reach(center, farthest) < radius {
            (best, radius) = (center, reach(center, farthest));
        }
        center += (farthest.center - center) / step as f32;
    }
    // A few ulps more, for the rounding of these lines.
    let radius = radius * (1.0 + 1e-6) + best.abs().max_element() * 1e-6;
    [best.x, best.y, best.z, radius * radius]
}
