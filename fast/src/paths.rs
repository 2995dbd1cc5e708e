//! A batch of paths: a structure of arrays, small enough for the first-level cache.
//!
//! Paths run in stages over the whole batch: intersect all, then shade all. Compression moves the paths that continue to
//! the front, so that lanes stay full. A loop that took each packet through all that its paths do would be bound by the
//! latency of that chain of operations; a stage overlaps many packets.

use lanes::{Lanes, MOST_LANES, V3};
use scene::Vec3;

/// The most paths of a batch. At 14 words a path, a batch takes 15 KiB.
pub(crate) const BATCH: usize = 256;
/// The length of a batch's arrays: vectors write past the last path.
pub(crate) const ROOM: usize = BATCH + MOST_LANES;

// As above.
const _: () = assert!(ROOM * 14 * 4 <= 15 << 10);

/// A float per path of a batch.
pub(crate) type Floats = [f32; ROOM];
/// A word per path of a batch.
pub(crate) type Words = [u32; ROOM];

/// A vector per path of a batch, or of `SIZE` other things.
#[derive(Clone)]
pub(crate) struct Vectors<const SIZE: usize = ROOM> {
    pub(crate) x: [f32; SIZE],
    pub(crate) y: [f32; SIZE],
    pub(crate) z: [f32; SIZE],
}

impl<const SIZE: usize> Vectors<SIZE> {
    pub(crate) const ZERO: Self = Self { x: [0.0; SIZE], y: [0.0; SIZE], z: [0.0; SIZE] };

    #[inline(always)]
    pub(crate) fn load<L: Lanes>(&self, at: usize) -> V3<L> {
        V3::new(L::load(&self.x[at..]), L::load(&self.y[at..]), L::load(&self.z[at..]))
    }

    /// One of the vectors, in every lane.
    #[inline(always)]
    pub(crate) fn broadcast<L: Lanes>(&self, at: usize) -> V3<L> {
        V3::new(L::f(self.x[at]), L::f(self.y[at]), L::f(self.z[at]))
    }

    #[inline(always)]
    pub(crate) fn store<L: Lanes>(&mut self, at: usize, v: V3<L>) {
        L::store(v.x, &mut self.x[at..]);
        L::store(v.y, &mut self.y[at..]);
        L::store(v.z, &mut self.z[at..]);
    }

    #[inline(always)]
    pub(crate) fn add(&mut self, at: usize, v: Vec3) {
        self.x[at] += v.x;
        self.y[at] += v.y;
        self.z[at] += v.z;
    }

    #[inline(always)]
    pub(crate) fn compress<L: Lanes>(&mut self, m: L::M, v: V3<L>, at: usize) {
        L::compress(m, v.x, &mut self.x[at..]);
        L::compress(m, v.y, &mut self.y[at..]);
        L::compress(m, v.z, &mut self.z[at..]);
    }
}

/// The state of every path of a batch.
#[derive(Clone)]
pub(crate) struct Paths {
    pub(crate) origin: Vectors,
    pub(crate) direction: Vectors,
    /// Throughput of camera paths, power of photons.
    pub(crate) weight: Vectors,
    /// The sphere that the ray leaves.
    pub(crate) leaves: Words,
    /// State of the random stream.
    pub(crate) stream: Words,
    /// The index of the pixel in the batch.
    pub(crate) slot: Words,
    /// Distance of the nearest hit.
    pub(crate) t: Floats,
    /// Sphere of the nearest hit.
    pub(crate) hit: Words,
}

/// One packet of paths.
#[derive(Clone, Copy)]
pub(crate) struct Packet<L: Lanes> {
    pub(crate) origin: V3<L>,
    pub(crate) direction: V3<L>,
    pub(crate) weight: V3<L>,
    pub(crate) leaves: L::U,
    pub(crate) stream: L::U,
    pub(crate) slot: L::U,
}

impl Paths {
    pub(crate) fn new() -> Box<Self> {
        let (words, floats, vectors) = ([0; ROOM], [0.0; ROOM], Vectors::ZERO);
        Box::new(Self {
            origin: vectors.clone(),
            direction: vectors.clone(),
            weight: vectors,
            leaves: words,
            stream: words,
            slot: words,
            t: floats,
            hit: words,
        })
    }

    #[inline(always)]
    pub(crate) fn load<L: Lanes>(&self, at: usize) -> Packet<L> {
        Packet {
            origin: self.origin.load::<L>(at),
            direction: self.direction.load::<L>(at),
            weight: self.weight.load::<L>(at),
            leaves: L::load_u(&self.leaves[at..]),
            stream: L::load_u(&self.stream[at..]),
            slot: L::load_u(&self.slot[at..]),
        }
    }

    /// Writes the lanes where `m` is true from `at` on, and returns the place after them. Paths only move towards the
    /// front, so this overwrites none that is still to be read.
    #[inline(always)]
    pub(crate) fn append<L: Lanes>(&mut self, at: usize, m: L::M, p: &Packet<L>) -> usize {
        self.origin.compress(m, p.origin, at);
        self.direction.compress(m, p.direction, at);
        self.weight.compress(m, p.weight, at);
        L::compress_u(m, p.leaves, &mut self.leaves[at..]);
        L::compress_u(m, p.stream, &mut self.stream[at..]);
        L::compress_u(m, p.slot, &mut self.slot[at..]);
        at + L::mask_bits(m).count_ones() as usize
    }
}

/// The least of all lanes.
#[inline(always)]
pub(crate) fn least<L: Lanes>(v: L::F) -> f32 {
    let mut lanes = [f32::INFINITY; MOST_LANES];
    L::store(v, &mut lanes);
    let mut least = lanes[0];
    for lane in &lanes[1..L::N] {
        least = least.min(*lane);
    }
    least
}
