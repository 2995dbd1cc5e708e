//! A tree of bounding boxes with eight children per node: the search for many balls.
//!
//! All rays of a batch walk it in step, each visiting its nearest box first.
//!
//! ```text
//! push the root on every ray's stack
//! until all stacks are empty:
//!     pop a box from each stack; drop it if it is farther than the ray's nearest hit
//!     for each inner node popped: test its eight boxes at once, push those hit, the nearest on top
//!     for each leaf popped: append those of its eight balls that the ray may hit to the candidates
//!     test the candidates by the exact formula, keep the nearest hit of each ray
//! ```
//!
//! How it differs from a textbook's tree, and why:
//!
//! 1. Rays walk in step. A ray that walks alone mispredicts a branch at nearly every box and waits for each node to come
//!    from memory. Here each stage is a loop without branches, and many rays wait for memory at the same time.
//! 2. The tree is complete ([`super::leaves`]): levels are arrays, the indices of children follow from their parent's, and
//!    a ball takes 20 bytes in its leaf and 3.5 in the boxes above.
//! 3. Boxes enclose all that the reference may hit *with its rounding*, so that the nearest hit is the same: see [`Slabs`].

use super::candidates::{Candidates, Copies};
use super::cull::{may_meet, trust};
use super::keys::key_distance;
use super::leaves::{Leaf, WIDTH};
use super::rays::Rays;
use crate::pages::Pages;
use crate::paths::{Floats, ROOM};
use bytemuck::{Pod, Zeroable};
use lanes::{Lanes, MOST_LANES, Row, V3};
use rayon::prelude::*;
use scene::Vec3;

/// Rays that walk in step: few enough for their stacks to stay in the first-level cache.
const IN_STEP: usize = 64;
/// Levels of a tree of 2^31 balls.
const LEVELS: usize = 11;
/// Boxes on a stack: seven per level, and what vectors write past the end.
const STACK: usize = 7 * LEVELS + MOST_LANES;
/// Low bits of a place in the tree: the index within its level. The bits above hold the level.
const INDEX_BITS: u32 = 28;
/// Relative slack: of the radii of balls in boxes, and of distances to boxes. See [`Slabs`].
const LOOSE: f32 = 1.0 / 512.0;

// As many levels as nodes of eight need, and stacks that stay in a first-level cache of 48 KiB.
const _: () = assert!(1_u64 << (3 * LEVELS) >= 1 << 31 && 1_u64 << (3 * (LEVELS - 1)) < 1 << 31);
const _: () = assert!(STACK >= (WIDTH - 1) * LEVELS + 1 + WIDTH && IN_STEP * STACK * 8 <= 48 << 10);

/// The boxes of eight children: low x y z, high x y z. A missing child's box is empty.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, align(64))]
struct Node {
    planes: [[f32; WIDTH]; 6],
}

/// A tree of balls.
#[derive(Debug)]
pub(crate) struct Tree {
    leaves: Pages<Leaf>,
    nodes: Pages<Node>,
    /// Where each level's nodes begin; level 1 is just above the leaves.
    offsets: [u32; LEVELS + 1],
    height: u32,
    /// The largest coordinate of all boxes.
    extent: f32,
}

/// The state of the rays of a batch while they walk.
pub(crate) struct Wave {
    /// Per ray of the batch, its [`Slabs`].
    slabs: [[Row; 2]; ROOM],
    /// Per ray in step, its stack: places of boxes, and their distances.
    places: [[u32; STACK]; IN_STEP],
    entries: [[f32; STACK]; IN_STEP],
    heights: [u32; IN_STEP],
    /// The number in the batch of the first ray in step.
    first: usize,
    /// Rays whose stack is not empty.
    live: [u32; IN_STEP],
    /// Rays that have popped an inner node or a leaf, with its place.
    at_nodes: [(u32, u32); IN_STEP],
    at_leaves: [(u32, u32); IN_STEP],
}

impl Wave {
    #[allow(clippy::large_stack_arrays)] // On their way into the box, once per thread.
    pub(crate) fn new() -> Box<Self> {
        Box::new(Self {
            slabs: [[Row::default(); 2]; ROOM],
            places: [[0; STACK]; IN_STEP],
            entries: [[0.0; STACK]; IN_STEP],
            heights: [0; IN_STEP],
            first: 0,
            live: [0; IN_STEP],
            at_nodes: [(0, 0); IN_STEP],
            at_leaves: [(0, 0); IN_STEP],
        })
    }
}

/// An axis-aligned box.
#[derive(Clone, Copy, Debug)]
struct BoundingBox {
    low: Vec3,
    high: Vec3,
}

impl BoundingBox {
    const EMPTY: Self = Self { low: Vec3::INFINITY, high: Vec3::NEG_INFINITY };

    fn of(leaf: &Leaf) -> Self {
        leaf.balls().fold(Self::EMPTY, |all, ball| {
            let (center, radius) = (Vec3::from(ball.center), Vec3::splat(ball.radius * (1.0 + LOOSE)));
            all.union(Self { low: center - radius, high: center + radius })
        })
    }

    fn union(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }
}

impl Node {
    fn new(children: &[BoundingBox]) -> Self {
        let mut planes = [[f32::INFINITY; WIDTH]; 6];
        for side in &mut planes[3..] {
            *side = [f32::NEG_INFINITY; WIDTH];
        }
        for (k, child) in children.iter().enumerate() {
            for axis in 0..3 {
                planes[axis][k] = child.low[axis];
                planes[3 + axis][k] = child.high[axis];
            }
        }
        Self { planes }
    }
}

impl Tree {
    /// From the leaves of [`super::leaves::arranged`].
    pub(crate) fn new(leaves: Pages<Leaf>) -> Self {
        let (mut offsets, mut height) = ([0; LEVELS + 1], 0);
        let (mut count, mut width) = (0, leaves.len());
        while height == 0 || width > 1 {
            height += 1;
            offsets[height] = count as u32;
            width = width.div_ceil(WIDTH);
            count += width;
        }
        let mut nodes = Pages::<Node>::zeros(count);
        let mut below: Vec<BoundingBox> = leaves.par_iter().map(BoundingBox::of).collect();
        for offset in &offsets[1..=height] {
            let level = nodes[*offset as usize..].iter_mut();
            level.zip(below.chunks(WIDTH)).for_each(|(node, children)| *node = Node::new(children));
            below = below.par_chunks(WIDTH).map(union).collect();
        }
        let all = union(&below);
        let extent = all.low.abs().max(all.high.abs()).max_element();
        Self { leaves, nodes, offsets, height: height as u32, extent }
    }

    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&self.leaves[..]) + size_of_val(&self.nodes[..])
    }

    pub(crate) fn leaves(&self) -> &[Leaf] {
        &self.leaves
    }

    /// Lowers the keys of the rays to those of their nearest hits; if `ANY`, of any hit. Rays with a negative `t` are
    /// skipped.
    #[inline(always)]
    pub(crate) fn search<L: Lanes, const ANY: bool>(
        &self,
        rays: &Rays,
        t: &Floats,
        wave: &mut Wave,
        candidates: &mut Candidates,
        keys: &mut [u64; ROOM],
    ) {
        for at in (0..rays.count).step_by(L::N) {
            let (origin, direction) = (rays.origin.load::<L>(at), rays.direction.load::<L>(at));
            candidates.take_rays::<L>(rays, at, origin, direction);
            Slabs::store::<L>(origin, direction, self.extent, &mut wave.slabs[at..]);
        }
        for first in (0..rays.count).step_by(IN_STEP) {
            wave.first = first;
            let count = IN_STEP.min(rays.count - first);
            let mut live = wave.start(t, count, self.height << INDEX_BITS);
            while live > 0 {
                live = self.step::<L, ANY>(t, live, wave, candidates, keys);
            }
        }
    }

    /// One step of the first `live` rays; returns the number of rays that still have boxes on their stacks.
    #[inline(always)]
    fn step<L: Lanes, const ANY: bool>(
        &self,
        t: &Floats,
        live: usize,
        wave: &mut Wave,
        candidates: &mut Candidates,
        keys: &mut [u64; ROOM],
    ) -> usize {
        let popped = wave.pop::<ANY>(live, keys, t);
        candidates.work.boxes += (popped.nodes + popped.leaves) as u64;
        for k in 0..popped.nodes {
            let (ray, place) = wave.at_nodes[k];
            self.visit_node::<L::Eight>(wave, ray as usize, place, keys);
        }
        for k in 0..popped.leaves {
            let (ray, leaf) = wave.at_leaves[k];
            visit_leaf::<L::Eight>(&self.leaves[leaf as usize], wave.first as u32 + ray, candidates);
            if candidates.are_enough(&Copies) {
                candidates.evaluate::<L>(&Copies, keys);
            }
        }
        candidates.evaluate::<L>(&Copies, keys);
        popped.live
    }

    /// Pushes the boxes of a node that the ray may enter before its nearest hit, the nearest box on top.
    #[inline(always)]
    fn visit_node<L: Lanes>(&self, wave: &mut Wave, ray: usize, place: u32, keys: &[u64; ROOM]) {
        let t = key_distance(keys[wave.first + ray]);
        let (level, index) = (place >> INDEX_BITS, place & ((1 << INDEX_BITS) - 1));
        let node = &self.nodes[(self.offsets[level as usize] + index) as usize];
        let first = ((level - 1) << INDEX_BITS) + index * WIDTH as u32;
        let (entries, hit) = Slabs::meet::<L>(&wave.slabs[wave.first + ray], node, t);
        let nearest = L::min_lane(L::select(hit, entries, L::f(f32::INFINITY)));
        let bits = L::mask_bits(hit);
        let others = bits & !(1 << nearest);
        let bottom = wave.heights[ray] as usize;
        let places = &mut wave.places[ray][bottom..bottom + WIDTH];
        let mut distances = [0.0; WIDTH];
        L::store(entries, &mut distances);
        let top = others.count_ones() as usize;
        L::compress_u(L::mask_from_bits(others), L::u(first) + L::iota(), places);
        places[top] = first + nearest;
        let waiting = &mut wave.entries[ray][bottom..bottom + WIDTH];
        L::compress(L::mask_from_bits(others), entries, waiting);
        waiting[top] = distances[nearest as usize];
        wave.heights[ray] += bits.count_ones();
    }
}

/// The numbers of rays after a pop: still live, at an inner node, at a leaf.
struct Popped {
    live: usize,
    nodes: usize,
    leaves: usize,
}

impl Wave {
    /// Puts the root on the stacks of the rays with `t >= 0`; returns their number.
    #[inline(always)]
    fn start(&mut self, t: &Floats, count: usize, root: u32) -> usize {
        let mut live = 0;
        for ray in 0..count {
            self.heights[ray] = 1;
            self.places[ray][0] = root;
            self.entries[ray][0] = 0.0;
            self.live[live] = ray as u32;
            live += usize::from(t[self.first + ray] >= 0.0);
        }
        live
    }

    /// Pops a box from each stack.
    #[allow(clippy::needless_bitwise_bool)] // Lazy operators would be branches, which this stage avoids.
    #[inline(always)]
    fn pop<const ANY: bool>(&mut self, live: usize, keys: &[u64; ROOM], t: &Floats) -> Popped {
        let mut popped = Popped { live: 0, nodes: 0, leaves: 0 };
        for k in 0..live {
            let id = self.live[k];
            let ray = id as usize;
            let nearest = key_distance(keys[self.first + ray]);
            let is_done = (self.heights[ray] == 0) | (ANY & (nearest < t[self.first + ray]));
            let top = self.heights[ray].saturating_sub(1) as usize;
            let (place, entry) = (self.places[ray][top], self.entries[ray][top]);
            let counts = !is_done & (entry <= nearest * (1.0 + LOOSE));
            let is_leaf = place >> INDEX_BITS == 0;
            self.heights[ray] = top as u32;
            self.live[popped.live] = id;
            self.at_nodes[popped.nodes] = (id, place);
            self.at_leaves[popped.leaves] = (id, place);
            popped.live += usize::from(!is_done);
            popped.nodes += usize::from(counts & !is_leaf);
            popped.leaves += usize::from(counts & is_leaf);
        }
        popped
    }
}

/// Adds the balls of a leaf that a ray may hit to the candidates.
#[inline(always)]
fn visit_leaf<L: Lanes>(leaf: &Leaf, ray: u32, candidates: &mut Candidates) {
    let (origin, direction) = candidates.broadcast_ray::<L>(ray as usize);
    let center = V3::new(L::load(&leaf.x), L::load(&leaf.y), L::load(&leaf.z));
    let radius_squared = L::load(&leaf.radius_squared);
    let may = may_meet(origin, direction, trust(direction), center, radius_squared);
    let (count, pairs) = (candidates.count, &mut candidates.pairs);
    pairs.centers.compress(may, center, count);
    L::compress(may, radius_squared, &mut pairs.radii_squared[count..]);
    L::compress_u(may, L::load_u(&leaf.spheres), &mut pairs.balls[count..]);
    L::store_u(L::u(ray), &mut pairs.rays[count..]);
    candidates.count = count + L::mask_bits(may).count_ones() as usize;
}

fn union(children: &[BoundingBox]) -> BoundingBox {
    children.iter().fold(BoundingBox::EMPTY, |all, child| all.union(*child))
}

/// What the test of a ray against boxes needs to know of the ray, in two rows: the inverse direction, the offsets that
/// added to `plane * inverse` give the distances to the near and far planes of each axis, and which planes are near.
///
/// Why it misses no box that matters. With f from the centre of a ball to the origin, u = 2^-24, and D the distance
/// of the centre from the line of the ray, the reference accepts a ball only if D <= r (1 + 4u) + 8u |f|
/// ([`may_meet`] derives it). So the line meets the box around the ball if the box grows by 8u |f|, and |f| is at
/// most 4 times the sum of the largest coordinates of origin and boxes. `slack` is 64u times that sum, and so also
/// outweighs the rounding of this test, whose every step errs by a few u times the sum over the direction's
/// component. The distance that the reference finds, `power / (root - b)`, can be smaller than that to the grown
/// ball only by the rounding of `power`, 4u |f|^2, over |b|: less than 5e-4 |f|, in which |f| is at most the
/// distance plus the radius. Hence `LOOSE` in both.
struct Slabs;

impl Slabs {
    /// Computes the rows of a packet of rays, for boxes with coordinates up to `extent`.
    #[inline(always)]
    fn store<L: Lanes>(origin: V3<L>, direction: V3<L>, extent: f32, to: &mut [[Row; 2]]) {
        let largest = L::max(L::abs(origin.x), L::max(L::abs(origin.y), L::abs(origin.z)));
        let slack = (largest + L::f(extent)) * L::f(1.0 / (1 << 18) as f32);
        let (ix, nx, fx, sx) = slab::<L>(origin.x, direction.x, slack, 0);
        let (iy, ny, fy, sy) = slab::<L>(origin.y, direction.y, slack, 1);
        let (iz, nz, fz, sz) = slab::<L>(origin.z, direction.z, slack, 2);
        let side = sx + L::shl::<4>(sy) + L::shl::<8>(sz);
        let zero = L::f(0.0);
        let mut rows = [[Row::default(); MOST_LANES]; 2];
        L::transpose([ix, iy, iz, nx, ny, nz, zero, L::from_bits(side)], &mut rows[0]);
        L::transpose([fx, fy, fz, zero, zero, zero, zero, zero], &mut rows[1]);
        for k in 0..L::N {
            to[k] = [rows[0][k], rows[1][k]];
        }
    }

    /// Distances to the boxes of a node, and which of them the ray enters before `t`.
    #[inline(always)]
    fn meet<L: Lanes>(rows: &[Row; 2], node: &Node, t: f32) -> (L::F, L::M) {
        let [Row([ix, iy, iz, nx, ny, nz, _, side]), Row([fx, fy, fz, ..])] = rows;
        let side = side.to_bits() as usize;
        let (x, y, z) = (side & 15, (side >> 4) & 15, side >> 8);
        let [ix, iy, iz] = [L::f(*ix), L::f(*iy), L::f(*iz)];
        let near_x = L::fused(L::load(&node.planes[x]), ix, L::f(*nx));
        let near_y = L::fused(L::load(&node.planes[y]), iy, L::f(*ny));
        let near_z = L::fused(L::load(&node.planes[z]), iz, L::f(*nz));
        let far_x = L::fused(L::load(&node.planes[3 - x]), ix, L::f(*fx));
        let far_y = L::fused(L::load(&node.planes[5 - y]), iy, L::f(*fy));
        let far_z = L::fused(L::load(&node.planes[7 - z]), iz, L::f(*fz));
        let enters = L::max(L::max(near_x, near_y), L::max(near_z, L::f(0.0)));
        let exits = L::min(L::min(far_x, far_y), L::min(far_z, L::f(t * (1.0 + LOOSE))));
        (enters, L::le(enters, exits))
    }
}

/// Along one axis: the inverse direction, offsets to the near and far planes, and which plane is near.
#[inline(always)]
fn slab<L: Lanes>(origin: L::F, direction: L::F, slack: L::F, axis: u32) -> (L::F, L::F, L::F, L::U) {
    // Zero is replaced by a number too small to matter.
    let tiny = L::f(1e-18);
    let is_tiny = L::lt(L::abs(direction), tiny);
    let inverse = L::f(1.0) / L::select(is_tiny, tiny, direction);
    let (middle, slack) = (-(origin * inverse), L::abs(inverse) * slack);
    let side = L::select_u(L::lt(inverse, L::f(0.0)), L::u(3 + axis), L::u(axis));
    (inverse, middle - slack, middle + slack, side)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hierarchy::leaves::arranged;
    use crate::search::ball_count;
    use rayon::ThreadPoolBuilder;
    use scene::{Rgb, Sphere};

    /// More than are worth a thread on either side of the first splits, many of them at equal coordinates.
    const BALLS: u32 = 40_000;

    #[test]
    fn the_tree_is_the_same_on_any_number_of_threads() {
        let mut scene = files::builtin::scene("cornell").unwrap();
        let glass = scene.materials.iter().position(|material| !material.is_opaque()).unwrap() as u32;
        scene.spheres.extend((0..BALLS).map(|i| Sphere {
            center: Vec3::from([i * 7919 % 31, i * 1009 % 37, i * 997 % 41].map(|c| c as f32)),
            velocity: Vec3::ZERO,
            radius: 0.2 + (i % 5) as f32 * 0.1,
            material: if i % 3 == 0 { glass } else { 0 },
            emission: Rgb::ZERO,
        }));
        let still = scene.at(0.0);
        let on = |threads: usize| {
            let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| Tree::new(arranged(&still, ball_count(&still))))
        };
        let bits = |tree: &Tree| {
            let words = [bytemuck::cast_slice(&tree.leaves), bytemuck::cast_slice::<Node, u32>(&tree.nodes)];
            words.concat()
        };
        let one = on(1);
        assert_eq!(one.leaves.iter().map(|leaf| leaf.balls().count()).sum::<usize>(), ball_count(&still));
        for threads in [2, 3, 8] {
            let tree = on(threads);
            assert!(bits(&tree) == bits(&one), "{threads} threads");
            assert_eq!((tree.height, tree.offsets, tree.extent), (one.height, one.offsets, one.extent));
        }
    }
}
