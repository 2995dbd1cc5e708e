//! A batch of paths in flight: structure of arrays, small enough for the first-level cache.
//!
//! Paths run in stages over the whole batch (intersect all, shade all), and those that go on are moved to the front
//! by compression, so that lanes stay full. One loop over everything a path does would be bound by the latency of
//! its chain of operations; a stage overlaps many packets.

use lanes::{Lanes, MOST_LANES, V3};

/// Paths of a batch. At 14 words a path, a batch takes 15 KiB with its room.
pub(crate) const BATCH: usize = 256;
/// Room for what vectors write past the end.
pub(crate) const ROOM: usize = BATCH + MOST_LANES;

// As above.
const _: () = assert!(ROOM * 14 * 4 <= 15 << 10);

/// An array of the batch.
pub(crate) type Floats = [f32; ROOM];
/// An array of the batch.
pub(crate) type Words = [u32; ROOM];

/// Three arrays, of the batch unless another size is given.
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

    #[inline(always)]
    pub(crate) fn store<L: Lanes>(&mut self, at: usize, v: V3<L>) {
        L::store(v.x, &mut self.x[at..]);
        L::store(v.y, &mut self.y[at..]);
        L::store(v.z, &mut self.z[at..]);
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
    /// Which pixel or photon of the batch this is.
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

    /// Appends the named lanes at `at`, and gives the place behind them. As paths only ever move to the front, this
    /// overwrites none that is yet to be read.
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
