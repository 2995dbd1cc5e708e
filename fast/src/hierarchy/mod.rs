//! The nearest of many balls.
//!
//! Balls are the spheres met from outside: solid ones and glass. Walls around the eye are few, and are tried one by
//! one elsewhere. Few balls are tried one by one as well; more stand in [`clusters`], many in a [`tree`]. The limits
//! ([`Parameters::search`]) are measured (`benches/intersection.rs`), and the hits the same, bit for bit.
//!
//! Every search works on *keys*: distance in the high half, sphere in the low. As distances are not negative, keys
//! order as the contract demands: by distance, and of equal distances the lower sphere first.

mod candidates;
mod clusters;
mod leaves;
mod tree;

use crate::lanes::{Lanes, Row};
use crate::parameters::Parameters;
use crate::paths::{Floats, ROOM, Vectors, Words};
use crate::vec3::V3;
use candidates::Candidates;
use clusters::{Clusters, Queues};
use leaves::{Ball, arrange};
use scene::Still;
use scene::ray::{NO_SPHERE, SphereId};
use scene::still::Role;
use tree::{Tree, Wave};

/// Rays of a batch, as a search reads them.
pub(crate) struct Rays<'a> {
    pub(crate) origin: &'a Vectors,
    pub(crate) direction: &'a Vectors,
    /// The sphere that each leaves.
    pub(crate) leaves: &'a Words,
    /// A sphere that each passes over, such as the lamp that a shadow ray is sent to; or [`NO_SPHERE`].
    pub(crate) passes: &'a Words,
    pub(crate) count: usize,
}

/// For rays that meet whatever is there.
pub(crate) static PASSES_NONE: Words = [NO_SPHERE; ROOM];

/// The distance left to a shadow ray that meets something.
pub(crate) const BLOCKED: f32 = f32::NEG_INFINITY;

/// How balls can be searched.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Search {
    /// One by one: for few.
    InTurn,
    /// In clusters of eight, before which rays queue: up to about a thousand.
    Clusters,
    /// In a tree of boxes: for many.
    Tree,
}

/// What searches write, kept from batch to batch.
pub(crate) struct Scratch {
    queues: Queues,
    wave: Box<Wave>,
    candidates: Candidates,
}

impl Scratch {
    pub(crate) fn new() -> Self {
        Self { queues: Queues::default(), wave: Wave::new(), candidates: Candidates::new() }
    }

    /// All that searches have done on it.
    pub(crate) fn work(&self) -> Work {
        self.candidates.work
    }
}

/// What searches have done. No image depends on it, but the time does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Boxes of a tree, or clusters, that rays have entered.
    pub boxes: u64,
    /// Balls that were tried by the whole formula.
    pub balls: u64,
}

/// How many balls there are: spheres that are met from outside, solid or glass.
pub fn ball_count(still: &Still) -> usize {
    still.roles.iter().filter(|role| !matches!(role, Role::Enclosure(_))).count()
}

/// Balls, and how they are searched.
#[derive(Debug)]
pub(crate) enum Hierarchy {
    /// They are tried one by one, as the walls are.
    InTurn,
    Clusters(Clusters),
    Tree(Tree),
}

impl Hierarchy {
    /// The search that is usually fastest for so many balls.
    pub(crate) fn new(still: &Still) -> Self {
        Self::with_search(still, Parameters::default().search(ball_count(still)))
    }

    /// The given search, whatever the number of balls.
    pub(crate) fn with_search(still: &Still, search: Search) -> Self {
        let mut balls = if search == Search::InTurn { Vec::new() } else { balls(still) };
        if balls.is_empty() {
            return Self::InTurn;
        }
        arrange(&mut balls);
        if search == Search::Clusters {
            Self::Clusters(Clusters::new(&balls))
        } else {
            Self::Tree(Tree::new(&balls))
        }
    }

    /// True if this finds the balls; else they are to be tried one by one.
    pub(crate) fn holds_balls(&self) -> bool {
        !matches!(self, Self::InTurn)
    }

    /// Bytes of memory held.
    pub(crate) fn bytes(&self) -> usize {
        match self {
            Self::InTurn => 0,
            Self::Clusters(clusters) => clusters.bytes(),
            Self::Tree(tree) => tree.bytes(),
        }
    }

    /// Given the nearest hits among all but balls, the nearest hits.
    #[inline(always)]
    pub(crate) fn nearest<L: Lanes>(
        &self,
        surfaces: &[Row],
        rays: &Rays,
        scratch: &mut Scratch,
        t: &mut Floats,
        hit: &mut Words,
    ) {
        if !self.holds_balls() {
            return;
        }
        let Scratch { queues, wave, candidates } = scratch;
        let mut keys = [0; ROOM];
        for k in 0..rays.count {
            keys[k] = hit_key(t[k], hit[k]);
        }
        match self {
            Self::InTurn => {}
            Self::Clusters(clusters) => {
                clusters.search::<L>(surfaces, rays, t, queues, candidates, &mut keys);
            }
            Self::Tree(tree) => tree.search::<L, false>(surfaces, rays, t, wave, candidates, &mut keys),
        }
        for k in 0..rays.count {
            // Where nothing is nearer, the distance stays as it is, be it minus zero.
            let is_nearer = keys[k] != hit_key(t[k], hit[k]);
            t[k] = if is_nearer { key_distance(keys[k]) } else { t[k] };
            hit[k] = keys[k] as u32;
        }
    }

    /// Sets `t` to [`BLOCKED`] where a ball is nearer than `t`.
    #[inline(always)]
    pub(crate) fn occlude<L: Lanes>(
        &self,
        surfaces: &[Row],
        rays: &Rays,
        scratch: &mut Scratch,
        t: &mut Floats,
    ) {
        if !self.holds_balls() {
            return;
        }
        let Scratch { queues, wave, candidates } = scratch;
        let mut keys = [0; ROOM];
        for k in 0..rays.count {
            keys[k] = limit_key(t[k]);
        }
        match self {
            Self::InTurn => {}
            Self::Clusters(clusters) => {
                clusters.search::<L>(surfaces, rays, t, queues, candidates, &mut keys);
            }
            Self::Tree(tree) => tree.search::<L, true>(surfaces, rays, t, wave, candidates, &mut keys),
        }
        for k in 0..rays.count {
            t[k] = if keys[k] == limit_key(t[k]) { t[k] } else { BLOCKED };
        }
    }
}

/// The balls of a still, in order of their ids.
fn balls(still: &Still) -> Vec<Ball> {
    let ball = |(id, role): (usize, &Role)| {
        let s = &still.spheres[id];
        let ball = Ball { center: s.center, radius: s.radius, sphere: id as SphereId };
        (!matches!(role, Role::Enclosure(_))).then_some(ball)
    };
    still.roles.iter().enumerate().filter_map(ball).collect()
}

/// The key of a hit on `sphere` at the distance with these bits.
#[inline(always)]
fn key(distance: u32, sphere: SphereId) -> u64 {
    u64::from(distance) << 32 | u64::from(sphere)
}

/// The key of a hit; minus zero counts as zero.
#[inline(always)]
fn hit_key(t: f32, sphere: SphereId) -> u64 {
    key((t + 0.0).to_bits(), sphere)
}

/// The key below which all hits nearer than `t` lie, and none else.
#[inline(always)]
fn limit_key(t: f32) -> u64 {
    key(if t > 0.0 { t.to_bits() } else { 0 }, 0)
}

/// The distance that a key holds.
#[inline(always)]
fn key_distance(key: u64) -> f32 {
    f32::from_bits((key >> 32) as u32)
}

/// How far [`may_meet`] trusts the squared distance from an origin to a centre, along these directions.
#[inline(always)]
fn trust<L: Lanes>(direction: V3<L>) -> L::F {
    let length_error = L::abs(direction.dot(direction) - L::f(1.0));
    L::f(1.0 - 1.0 / (1 << 17) as f32) - L::f(4.0) * length_error
}

/// False only where the reference meets no ball that lies within the sphere of this centre and squared radius.
///
/// With f from the centre of a ball to the origin, b = f . d, u = 2^-24, and D the distance of the centre from the
/// line of the ray, what does the reference accept? Its `f` errs by u |f|, its `b` by 4u |f|, so its `nearest` by
/// 8u |f| from `f - d b`, whose length is at least D whatever the length of d. It accepts if the square of `nearest`
/// is at most r^2, so if D <= r (1 + 4u) + 8u |f|; and moreover only if b <= 4u |f| or (glass) the origin lies
/// within the ball but for rounding. Hence the ray, t >= 0, comes as near as r + 13u |f| (1).
///
/// Let the ball lie within a sphere with centre C and radius R, and F go from C to the origin. If |F| <= R, the test
/// below passes. Else |f| <= 2 |F|, so by (1) the ray comes as near to C as R + 26u |F|, whose square is at most
/// R^2 + 53u |F|^2. The squared distance of C from the ray is |F|^2 - max(-F . d, 0)^2 / |d|^2. Rounding F, its
/// square, and F . d squared errs by less than 20u |F|^2 in sum; leaving out the division by at most
/// 4 | |d|^2 - 1 | |F|^2. The trust is 1 less 128u and the latter: enough. A ball is the sphere around itself.
#[inline(always)]
fn may_meet<L: Lanes>(origin: V3<L>, direction: V3<L>, trust: L::F, center: V3<L>, r2: L::F) -> L::M {
    let f = center - origin;
    let ahead = L::fused(f.x, direction.x, L::fused(f.y, direction.y, f.z * direction.z));
    let square = L::fused(f.x, f.x, L::fused(f.y, f.y, f.z * f.z));
    let ahead = L::max(ahead, L::f(0.0));
    L::le(L::fused(square, trust, -r2), ahead * ahead)
}
