//! A tree of bounding boxes with sixteen children per node: the search for many balls.
//!
//! All rays of a batch walk it in step, each visiting its nearest box first.
//!
//! ```text
//! each ray enters at the nearest box of the top, the others on its stack
//! until no ray walks:
//!     each ray at an inner node: test its sixteen boxes at once, go on to the nearest one hit, push the others; if none
//!                                is hit, wait
//!     each ray at a leaf:        append those of its sixteen balls that the ray may hit to the candidates, and wait
//!     test the candidates by the exact formula, keep the nearest hit of each ray
//!     each ray that waits:       pop boxes down to one that is not farther than the ray's nearest hit, and go there; if
//!                                there is none, the walk ends
//! ```
//!
//! How it differs from a textbook's tree, and why:
//!
//! 1. Rays walk in step. A ray that walks alone mispredicts a branch at nearly every box and waits for each node to come
//!    from memory. Here each stage is a loop without branches, and many rays wait for memory at the same time.
//! 2. The nearest box is not pushed: in most steps most rays go down, and those need no stack.
//! 3. In a large tree, a ray that goes down asks for the memory of its next box at once: some hundred other boxes are visited
//!    before it. Among a million balls this saves a seventh; in a small tree it would cost a twentieth, and for boxes that are
//!    popped it gained nothing.
//! 4. Nodes have sixteen children, as many as the widest vectors have lanes; narrower ones take them in two parts. With eight
//!    rays visited a third more nodes and leaves among 20,000 balls (and tested a sixth fewer balls): among a hundred thousand
//!    that took a tenth more time with vectors of sixteen lanes, and no less with vectors of eight.
//! 5. The tree is complete ([`super::leaves`]): levels are arrays, the indices of children follow from their parent's, and
//!    a ball takes 20 bytes in its leaf and 1.6 in the boxes above.
//! 6. It has no root, but a [`top`](super::top) of up to 32 boxes, of which each ray sorts those that it enters.
//! 7. A ray that waits looks at the eight upper boxes of its stack at once: after a hit most are farther.
//! 8. Boxes enclose all that the reference may hit *with its rounding*, so that the nearest hit is the same: see [`Slabs`].

use super::boxes::{BoundingBox, Children, LOOSE, Node, SlabLanes, Slabs};
use super::candidates::{Candidates, Copies};
use super::keys::key_distance;
use super::leaves::{Leaf, WIDTH};
use super::top::{Entries, MOST_TOP};
use crate::pages::Pages;
use crate::paths::{BATCH, Floats, ROOM};
use crate::rays::Rays;
use bytemuck::Pod;
use lanes::{Lanes, prefetch};
use rayon::prelude::*;

/// Levels of nodes in a tree of 2^31 balls, the leaves not counted.
const LEVELS: usize = 6;
/// Boxes on a stack: its ground, those of the top, fifteen per level, and what vectors write past the end. As the next odd
/// multiple of 8: then a stack is an odd number of lines of the cache, and those of a batch share all its sets.
const STACK: usize = (GROUND + MOST_TOP + (WIDTH - 1) * LEVELS + WIDTH).div_ceil(8) / 2 * 16 + 8;
/// Entries at the bottom of a stack that are no boxes, so that eight can be read below any box.
const GROUND: usize = 8;
/// Low bits of a place in the tree: the index within its level. The bits above hold the level.
const INDEX_BITS: u32 = 28;
/// Bytes of a tree that is small enough for the caches.
const SMALL: usize = 8 << 20;
/// Bytes of a line of the cache.
const LINE: usize = 64;
/// Levels that a place can name.
const NAMED_LEVELS: usize = 1 << (32 - INDEX_BITS);

// As many levels as nodes of sixteen need, all of which have names.
const _: () = assert!(LEVELS < NAMED_LEVELS);
const _: () = assert!(balls(LEVELS) >= 1 << 31 && balls(LEVELS - 1) < 1 << 31);
// Half a line is the least that leaves and nodes are aligned to.
const _: () =
    assert!(size_of::<Leaf>().is_multiple_of(LINE / 2) && size_of::<Node>().is_multiple_of(LINE / 2));
// Numbers of rays are reduced modulo the size of a batch, which tells the compiler that they are in bounds.
const _: () = assert!(BATCH.is_power_of_two() && BATCH <= ROOM);

/// The most balls of a tree of so many levels.
const fn balls(levels: usize) -> u64 {
    MOST_TOP as u64 * (WIDTH as u64).pow(levels as u32 + 1)
}

/// A tree of balls.
#[derive(Debug)]
pub(crate) struct Tree {
    leaves: Pages<Leaf>,
    nodes: Pages<Node>,
    /// Where each level's nodes begin; level 1 is just above the leaves.
    offsets: [u32; NAMED_LEVELS],
    /// The boxes of the topmost level, one per node, or per leaf if there are no nodes.
    top: Vec<BoundingBox>,
    /// The number of the topmost level.
    height: u32,
    /// The largest coordinate of all boxes.
    extent: f32,
    /// Whether it is too large for the caches.
    is_large: bool,
}

/// Boxes that a ray has yet to visit: their places and distances. Those of the ground are nowhere: NaN is not nearer than anything.
#[derive(Clone, Copy)]
#[repr(align(64))]
struct Stack {
    places: [u32; STACK],
    entries: [f32; STACK],
}

/// A ray and the place where it is, in one word: it is written to three lists, of which one keeps it.
#[derive(Clone, Copy)]
struct Walker(u64);

impl Walker {
    #[inline(always)]
    fn new(ray: u32, place: u32) -> Self {
        Self(u64::from(place) << 32 | u64::from(ray))
    }

    #[inline(always)]
    fn ray(self) -> u32 {
        self.0 as u32
    }

    #[inline(always)]
    fn place(self) -> u32 {
        (self.0 >> 32) as u32
    }
}

type Walkers = [Walker; BATCH];

/// Writes a walker to the end of a list, which becomes longer if the walker `is_there`: without a branch.
/// While this is called the ray is on no list, so at most all others are on this one and there is room.
#[inline(always)]
fn push_if(is_there: bool, walker: Walker, list: &mut Walkers, count: &mut usize) {
    list[*count % BATCH] = walker;
    *count += usize::from(is_there);
}

/// The lengths of the lists of walkers.
#[derive(Clone, Copy, Default)]
struct Counts {
    nodes: usize,
    leaves: usize,
    waiting: usize,
}

/// The state of the rays of a batch while they walk.
pub(crate) struct Wave {
    entries: Entries,
    slabs: Slabs,
    stacks: [Stack; BATCH],
    /// The number of boxes on each stack.
    heights: [u32; BATCH],
    at_nodes: Walkers,
    at_leaves: Walkers,
    /// Rays that pop a box next; the place means nothing.
    waiting: Walkers,
    counts: Counts,
}

impl Wave {
    #[allow(clippy::large_stack_arrays)] // On their way into the box, once per thread.
    #[cold]
    #[inline(never)]
    pub(crate) fn new() -> Box<Self> {
        Box::new(Self {
            entries: Entries::EMPTY,
            slabs: Slabs::ZERO,
            stacks: [Stack { places: [0; STACK], entries: [f32::NAN; STACK] }; BATCH],
            heights: [0; BATCH],
            at_nodes: [Walker(0); BATCH],
            at_leaves: [Walker(0); BATCH],
            waiting: [Walker(0); BATCH],
            counts: Counts::default(),
        })
    }
}

impl Tree {
    /// From the leaves of [`super::leaves::arranged`].
    pub(crate) fn new(leaves: Pages<Leaf>) -> Self {
        let (mut offsets, mut height) = ([0; NAMED_LEVELS], 0);
        let (mut count, mut width) = (0, leaves.len());
        while width > MOST_TOP {
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
            below = below.par_chunks(WIDTH).map(BoundingBox::around).collect();
        }
        let all = BoundingBox::around(&below);
        let extent = all.low.abs().max(all.high.abs()).max_element();
        let is_large = size_of_val(&leaves[..]) + size_of_val(&nodes[..]) > SMALL;
        Self { leaves, nodes, offsets, top: below, height: height as u32, extent, is_large }
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
        wave.counts = Counts::default();
        for at in (0..rays.count).step_by(L::N) {
            let (origin, direction) = (rays.origin.load::<L>(at), rays.direction.load::<L>(at));
            candidates.take_rays::<L>(rays, at, origin, direction);
            let slabs = SlabLanes::<L>::new(origin, direction, self.extent);
            slabs.store(at, &mut wave.slabs);
            wave.entries.test(&self.top, &slabs, L::load(&t[at..]));
            for lane in 0..L::N.min(rays.count - at) {
                wave.enter::<L::Eight>(at + lane, lane, self.height << INDEX_BITS, t[at + lane] >= 0.0);
            }
        }
        let levels = Levels { nodes: &self.nodes, leaves: &self.leaves, offsets: &self.offsets };
        while wave.counts.nodes + wave.counts.leaves + wave.counts.waiting > 0 {
            candidates.work.boxes += wave.counts.nodes as u64;
            levels.visit_nodes::<L>(wave, keys, self.is_large);
            candidates.work.boxes += wave.counts.leaves as u64;
            levels.visit_leaves::<L>(wave, candidates, keys);
            candidates.evaluate::<L>(&Copies, keys);
            wave.pop::<L::Eight, ANY>(keys, t);
        }
    }
}

/// The levels of a tree as slices: [`Pages`] would be dereferenced in every step.
#[derive(Clone, Copy)]
struct Levels<'a> {
    nodes: &'a [Node],
    leaves: &'a [Leaf],
    offsets: &'a [u32; NAMED_LEVELS],
}

impl Levels<'_> {
    /// Tests the boxes of the nodes where rays are. Each ray goes on to the nearest box that it enters before its nearest
    /// hit, and pushes the others.
    #[allow(clippy::needless_bitwise_bool)] // Lazy operators would be branches, which this stage avoids.
    #[inline(always)]
    fn visit_nodes<L: Lanes>(&self, wave: &mut Wave, keys: &[u64; ROOM], is_large: bool) {
        let Self { nodes, leaves, offsets } = *self;
        // Each ray goes on to one node at most, so the list is written no sooner than read.
        let mut counts = Counts { nodes: 0, ..wave.counts };
        for k in 0..wave.counts.nodes {
            let walker = wave.at_nodes[k % BATCH];
            let (place, ray) = (walker.place(), walker.ray() as usize % BATCH);
            let (level, index) = (place >> INDEX_BITS, place & ((1 << INDEX_BITS) - 1));
            let node = &nodes[(offsets[level as usize] + index) as usize];
            let first = ((level - 1) << INDEX_BITS) + index * WIDTH as u32;
            let children = wave.slabs.children::<L>(ray, node, key_distance(keys[ray]));
            let nearest = children.nearest();
            wave.push_others(ray, &children, nearest, first);
            let (goes_on, is_above_leaves) = (children.is_any_hit(), level == 1);
            if is_large && is_above_leaves {
                prefetch_all(leaves, (index * WIDTH as u32 + nearest) as usize);
            } else if is_large {
                let next = offsets[(level - 1) as usize] + index * WIDTH as u32 + nearest;
                prefetch_all(nodes, next as usize);
            }
            let next = Walker::new(walker.ray(), first + nearest);
            push_if(goes_on & !is_above_leaves, next, &mut wave.at_nodes, &mut counts.nodes);
            push_if(goes_on & is_above_leaves, next, &mut wave.at_leaves, &mut counts.leaves);
            push_if(!goes_on, next, &mut wave.waiting, &mut counts.waiting);
        }
        wave.counts = counts;
    }

    /// Adds the balls that rays may hit, of the leaves where they are, to the candidates.
    #[inline(always)]
    fn visit_leaves<L: Lanes>(&self, wave: &mut Wave, candidates: &mut Candidates, keys: &mut [u64; ROOM]) {
        for k in 0..std::mem::take(&mut wave.counts.leaves) {
            let walker = wave.at_leaves[k % BATCH];
            let trust = wave.slabs.trust(walker.ray() as usize % BATCH);
            let parts = self.leaves[walker.place() as usize].parts::<L>();
            candidates.add::<L, Copies>(&parts, &[walker.ray()], trust);
            if candidates.are_enough(&Copies) {
                candidates.evaluate::<L>(&Copies, keys);
            }
            push_if(true, walker, &mut wave.waiting, &mut wave.counts.waiting);
        }
    }
}

impl Wave {
    /// Pushes the boxes of the top that a ray enters, if it `walks`, and goes on to the nearest.
    #[allow(clippy::needless_bitwise_bool)] // Lazy operators would be branches, which this stage avoids.
    #[inline(always)]
    fn enter<L: Lanes>(&mut self, ray: usize, lane: usize, first: u32, walks: bool) {
        let Stack { places, entries } = &mut self.stacks[ray % BATCH];
        let (places, entries) = (&mut places[GROUND..], &mut entries[GROUND..]);
        let count = self.entries.push::<L>(lane, first, places, entries);
        let last = count.saturating_sub(1);
        let next = Walker::new(ray as u32, places[last]);
        self.heights[ray % BATCH] = last as u32;
        let (walks, is_leaf) = (walks & (count > 0), first == 0);
        push_if(walks & !is_leaf, next, &mut self.at_nodes, &mut self.counts.nodes);
        push_if(walks & is_leaf, next, &mut self.at_leaves, &mut self.counts.leaves);
    }

    /// Pushes the children that a ray hits, but for the nearest. `first` is the place of the first child.
    #[inline(always)]
    fn push_others<L: Lanes>(&mut self, ray: usize, children: &Children<L>, nearest: u32, first: u32) {
        let (mut height, stack) = (self.heights[ray] as usize, &mut self.stacks[ray]);
        for part in 0..Children::<L>::PARTS {
            let (entries, hit) = children.0[part];
            let child = L::u((part * L::N) as u32) + L::iota();
            let others = hit & !L::eq(child, L::u(nearest));
            L::compress_u(others, L::u(first) + child, &mut stack.places[GROUND + height..]);
            L::compress(others, entries, &mut stack.entries[GROUND + height..]);
            height += L::mask_bits(others).count_ones() as usize;
        }
        self.heights[ray] = height as u32;
    }

    /// Pops a box for each ray that waits: the uppermost of its eight upper ones that is not farther than its nearest hit.
    /// If all eight are, these are popped, and the ray waits on.
    #[allow(clippy::needless_bitwise_bool)] // Lazy operators would be branches, which this stage avoids.
    #[inline(always)]
    fn pop<L: Lanes, const ANY: bool>(&mut self, keys: &[u64; ROOM], t: &Floats) {
        let mut counts = Counts { waiting: 0, ..self.counts };
        for k in 0..self.counts.waiting {
            let walker = self.waiting[k % BATCH];
            let ray = walker.ray() as usize % BATCH;
            let (nearest, height) = (key_distance(keys[ray]), self.heights[ray]);
            let stack = &self.stacks[ray];
            let upper = L::load(&stack.entries[height as usize..]);
            let near = L::mask_bits(L::le(upper, L::f(nearest * (1.0 + LOOSE))));
            // From above, the first that is near: 0 if none is.
            let from_ground = near.checked_ilog2().unwrap_or(0) + height;
            let place = stack.places[from_ground as usize];
            self.heights[ray] = from_ground.saturating_sub(GROUND as u32);
            let walks = (height != 0) & !(ANY & (nearest < t[ray]));
            let is_near = walks & (near != 0);
            let waits_on = walks & (near == 0) & (height > GROUND as u32);
            let is_leaf = place >> INDEX_BITS == 0;
            let next = Walker::new(walker.ray(), place);
            push_if(is_near & !is_leaf, next, &mut self.at_nodes, &mut counts.nodes);
            push_if(is_near & is_leaf, next, &mut self.at_leaves, &mut counts.leaves);
            push_if(waits_on, next, &mut self.waiting, &mut counts.waiting);
        }
        self.counts = counts;
    }
}

/// Prefetches all lines of the cache that `from[at]` touches.
#[inline(always)]
fn prefetch_all<T: Pod>(from: &[T], at: usize) {
    let halves: &[[u8; LINE / 2]] = bytemuck::cast_slice(from);
    let size = size_of::<T>() / (LINE / 2);
    for half in (0..size).step_by(2) {
        prefetch(halves, at * size + half);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hierarchy::leaves::arranged;
    use crate::search::ball_count;
    use rayon::ThreadPoolBuilder;
    use scene::{Rgb, Sphere, Vec3};

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
