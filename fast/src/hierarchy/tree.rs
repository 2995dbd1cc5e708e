//! Many balls: a tree of boxes, eight to a node, that each ray walks by itself, nearest box first.
//!
//!     walk from the root:
//!         inner node: test its eight boxes at once, push those hit, farthest first
//!         leaf: the reference's formula on its eight balls at once; keep the nearest hit
//!         pop until a box is nearer than the nearest hit
//!
//! How it differs from a textbook's, and why:
//!
//! 1. The tree is complete ([`super::leaves`]): levels are arrays, children follow from the index, and a ball takes
//!    20 bytes in its leaf and 3.5 in the boxes above.
//! 2. Boxes lie around what the reference's *rounding* may hit, so that the nearest hit is the same: see
//!    [`RaySlabs`].

use super::leaves::{Ball, Leaf, WIDTH};
use super::{GLASS, Rays, key, key_distance};
use crate::intersect::meet;
use crate::lanes::Lanes;
use crate::paths::{Floats, ROOM};
use crate::vec3::V3;
use rayon::prelude::*;
use scene::Vec3;

/// Levels of a tree of 2^31 balls.
const LEVELS: usize = 11;
/// Boxes that may wait: seven per level, and eight.
const STACK: usize = 7 * LEVELS + 8;
/// Low bits of a place: the index within its level.
const INDEX_BITS: u32 = 28;
/// What balls are enlarged by, relative to their radius; and what distances to boxes are trusted to.
const LOOSE: f32 = 1.0 / 512.0;

/// The boxes of eight children: per side and axis, eight numbers. A missing child's box is empty.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
struct Node {
    bounds: [[[f32; WIDTH]; 3]; 2],
}

/// A tree of balls.
#[derive(Debug)]
pub(crate) struct Tree {
    leaves: Vec<Leaf>,
    nodes: Vec<Node>,
    /// Where each level's nodes begin; level 1 stands above the leaves, level 0 are the leaves.
    offsets: [u32; LEVELS + 1],
    height: u32,
    /// The largest coordinate of all boxes.
    extent: f32,
}

/// An axis-aligned box.
#[derive(Clone, Copy, Debug)]
struct Bounds {
    low: Vec3,
    high: Vec3,
}

impl Bounds {
    const EMPTY: Self = Self { low: Vec3::INFINITY, high: Vec3::NEG_INFINITY };

    fn of(balls: &[Ball]) -> Self {
        balls.iter().fold(Self::EMPTY, |all, ball| {
            let radius = Vec3::splat(ball.radius * (1.0 + LOOSE));
            all.union(Self { low: ball.center - radius, high: ball.center + radius })
        })
    }

    fn union(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }
}

impl Node {
    fn new(children: &[Bounds]) -> Self {
        let (low, high) = ([[f32::INFINITY; WIDTH]; 3], [[f32::NEG_INFINITY; WIDTH]; 3]);
        let mut node = Self { bounds: [low, high] };
        for (k, child) in children.iter().enumerate() {
            for axis in 0..3 {
                node.bounds[0][axis][k] = child.low[axis];
                node.bounds[1][axis][k] = child.high[axis];
            }
        }
        node
    }
}

impl Tree {
    /// Of balls that have been arranged.
    pub(crate) fn new(balls: &[Ball]) -> Self {
        let leaves = balls.par_chunks(WIDTH).map(Leaf::new).collect();
        let mut below: Vec<Bounds> = balls.par_chunks(WIDTH).map(Bounds::of).collect();
        let mut tree = Self { leaves, nodes: Vec::new(), offsets: [0; LEVELS + 1], height: 0, extent: 0.0 };
        while tree.height == 0 || below.len() > 1 {
            tree.height += 1;
            tree.offsets[tree.height as usize] = tree.nodes.len() as u32;
            tree.nodes.extend(below.chunks(WIDTH).map(Node::new));
            below = below.chunks(WIDTH).map(union).collect();
        }
        let all = union(&below);
        tree.extent = all.low.abs().max(all.high.abs()).max_element();
        tree
    }

    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&self.leaves[..]) + size_of_val(&self.nodes[..])
    }

    /// Lowers the keys of the rays to those of their nearest hits (if `ANY`, to that of any hit); of rays with a
    /// negative `t`, none.
    #[inline(always)]
    pub(crate) fn search<L: Lanes, const ANY: bool>(&self, rays: &Rays, t: &Floats, keys: &mut [u64; ROOM]) {
        for (k, key) in keys.iter_mut().enumerate().take(rays.count) {
            if t[k] < 0.0 {
                continue;
            }
            let ray = RaySlabs::<L::Eight>::new(rays, k, self.extent);
            *key = self.walk::<L::Eight, ANY>(&ray, *key);
        }
    }

    #[inline(always)]
    fn walk<L: Lanes, const ANY: bool>(&self, ray: &RaySlabs<L>, start: u64) -> u64 {
        let mut best = start;
        let mut stack = [(0_u32, 0.0_f32); STACK];
        let mut height = 0;
        let mut place = self.height << INDEX_BITS;
        loop {
            if place >> INDEX_BITS == 0 {
                best = ray.meet_leaf(&self.leaves[place as usize], best);
                if ANY && best != start {
                    return best;
                }
            } else {
                height = self.push_children(ray, place, key_distance(best), &mut stack, height);
            }
            loop {
                if height == 0 {
                    return best;
                }
                height -= 1;
                if stack[height].1 <= key_distance(best) * (1.0 + LOOSE) {
                    break;
                }
            }
            place = stack[height].0;
        }
    }

    /// Puts the children that the ray may meet before `t` on the stack, the nearest on top.
    #[inline(always)]
    fn push_children<L: Lanes>(
        &self,
        ray: &RaySlabs<L>,
        place: u32,
        t: f32,
        stack: &mut [(u32, f32); STACK],
        bottom: usize,
    ) -> usize {
        let (level, index) = (place >> INDEX_BITS, place & ((1 << INDEX_BITS) - 1));
        let node = &self.nodes[(self.offsets[level as usize] + index) as usize];
        let first = ((level - 1) << INDEX_BITS) + index * WIDTH as u32;
        let (near, hit) = ray.meet_boxes(node, t);
        let mut entries = [0.0; WIDTH];
        L::store(near, &mut entries);
        let (mut rest, mut top) = (L::mask_bits(hit), bottom);
        while rest != 0 {
            let k = rest.trailing_zeros();
            rest &= rest - 1;
            let entry = entries[k as usize];
            let mut place = top;
            while place > bottom && stack[place - 1].1 < entry {
                stack[place] = stack[place - 1];
                place -= 1;
            }
            stack[place] = (first + k, entry);
            top += 1;
        }
        top
    }
}

fn union(children: &[Bounds]) -> Bounds {
    children.iter().fold(Bounds::EMPTY, |all, child| all.union(*child))
}

/// One ray in all lanes.
///
/// Why no box that matters is missed. With f from the centre of a ball to the origin, u = 2^-24, and D the distance
/// of the centre from the line of the ray, the reference accepts a ball only if D <= r (1 + 4u) + 8u |f|
/// ([`super::may_meet`] derives it). So the line meets the box around the ball if the box grows by 8u |f|, which is
/// at most 8u times the sum of the largest coordinates of origin and boxes, times the root of 3, twice. `slack` is
/// 64u times that sum, and so also outweighs the rounding of this test, whose every step errs by a few u times the
/// sum over the direction's component. The distance that the reference finds, `power / (root - b)`, can be smaller
/// than that to the grown ball only by the rounding of `power`, 4u |f|^2, over |b|: less than 5e-4 |f|, in which |f|
/// is at most the distance plus the radius. Hence `LOOSE` in both.
struct RaySlabs<L: Lanes> {
    origin: V3<L>,
    direction: V3<L>,
    leaves: L::U,
    passes: L::U,
    inverse: V3<L>,
    /// Added to `bound * inverse`, they make the distance to the near and far planes of a slab.
    near: V3<L>,
    far: V3<L>,
    /// Per axis, which side is near.
    side: [usize; 3],
}

impl<L: Lanes> RaySlabs<L> {
    #[inline(always)]
    fn new(rays: &Rays, k: usize, extent: f32) -> Self {
        let origin = Vec3::new(rays.origin.x[k], rays.origin.y[k], rays.origin.z[k]);
        let direction = Vec3::new(rays.direction.x[k], rays.direction.y[k], rays.direction.z[k]);
        let slack = (origin.abs().max_element() + extent) * (1.0 / (1 << 18) as f32);
        let inverse = Vec3::new(invert(direction.x), invert(direction.y), invert(direction.z));
        let (middle, slack) = (-origin * inverse, inverse.abs() * slack);
        let side = |inverse: f32| usize::from(inverse < 0.0);
        Self {
            origin: V3::splat(origin),
            direction: V3::splat(direction),
            leaves: L::u(rays.leaves[k]),
            passes: L::u(rays.passes[k]),
            inverse: V3::splat(inverse),
            near: V3::splat(middle - slack),
            far: V3::splat(middle + slack),
            side: [side(inverse.x), side(inverse.y), side(inverse.z)],
        }
    }

    /// Distances to the boxes of a node, and which are met before `t`.
    #[inline(always)]
    fn meet_boxes(&self, node: &Node, t: f32) -> (L::F, L::M) {
        let [x, y, z] = self.side;
        let near = [&node.bounds[x][0], &node.bounds[y][1], &node.bounds[z][2]];
        let far = [&node.bounds[1 - x][0], &node.bounds[1 - y][1], &node.bounds[1 - z][2]];
        let near_x = L::fused(L::load(near[0]), self.inverse.x, self.near.x);
        let near_y = L::fused(L::load(near[1]), self.inverse.y, self.near.y);
        let near_z = L::fused(L::load(near[2]), self.inverse.z, self.near.z);
        let far_x = L::fused(L::load(far[0]), self.inverse.x, self.far.x);
        let far_y = L::fused(L::load(far[1]), self.inverse.y, self.far.y);
        let far_z = L::fused(L::load(far[2]), self.inverse.z, self.far.z);
        let enters = L::max(L::max(near_x, near_y), L::max(near_z, L::f(0.0)));
        let exits = L::min(L::min(far_x, far_y), L::min(far_z, L::f(t * (1.0 + LOOSE))));
        (enters, L::le(enters, exits))
    }

    /// The key of the nearest hit, when those of a leaf are added.
    #[inline(always)]
    fn meet_leaf(&self, leaf: &Leaf, best: u64) -> u64 {
        let center = V3::new(L::load(&leaf.x), L::load(&leaf.y), L::load(&leaf.z));
        let words = L::load_u(&leaf.words);
        let sphere = words & L::u(!GLASS);
        let is_glass = !L::eq(words, sphere);
        let leaves = L::eq(sphere, self.leaves);
        let radius_squared = L::load(&leaf.radius_squared);
        let (t, valid) = meet(self.origin, self.direction, leaves, center, radius_squared, is_glass);
        let mut rest = L::mask_bits(valid & !L::eq(sphere, self.passes));
        if rest == 0 {
            return best;
        }
        let (mut distances, mut best) = ([0; WIDTH], best);
        L::store_u(L::bits(t), &mut distances);
        while rest != 0 {
            let k = rest.trailing_zeros() as usize;
            rest &= rest - 1;
            best = best.min(key(distances[k], leaf.sphere(k)));
        }
        best
    }
}

/// The inverse, for zero that of a number too small to matter.
#[inline(always)]
fn invert(x: f32) -> f32 {
    const TINY: f32 = 1e-18;
    1.0 / if x.abs() < TINY { TINY.copysign(x) } else { x }
}
