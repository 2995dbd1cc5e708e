//! The random numbers of a row: either one of the paper's generators, with one state for the whole program, or the
//! keyed streams of the reference, with which a row's image can be compared bit by bit.

mod keyed;
mod rand;
pub(crate) mod timing;
pub(crate) mod words;
mod xorshift;

use keyed::Keyed;
use lanes::Lanes;
use rand::Rand;
use scene::Settings;
use xorshift::Pool;

/// The dimensions of a pixel's stratified numbers.
pub(crate) mod camera_dimension {
    pub(crate) const PIXEL: [usize; 2] = [0, 1];
    pub(crate) const LIGHT_POINT: [usize; 2] = [2, 3];
    pub(crate) const LIGHT: usize = 4;
    pub(crate) const LENS: [usize; 2] = [5, 6];
    pub(crate) const LOBES: [usize; 4] = [7, 8, 9, 10];
}

/// The dimensions of a photon's stratified numbers.
pub(crate) mod photon_dimension {
    pub(crate) const DIRECTION: [usize; 2] = [0, 1];
    pub(crate) const POSITION: [usize; 2] = [2, 3];
    pub(crate) const FIRST_BOUNCE: [usize; 3] = [4, 5, 7];
    pub(crate) const LIGHT: usize = 6;
}

/// A generator of the paper.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Generator {
    /// The C library's `rand`.
    Rand,
    /// xorshift32 in eight lanes, `unroll` vectors at a time.
    Xorshift { unroll: usize },
}

/// The random numbers of a render.
pub(crate) enum Numbers {
    Keyed(Box<Keyed>),
    Rand(Rand),
    Xorshift(Box<Pool>),
}

impl Numbers {
    /// The reference's streams.
    pub(crate) fn keyed(settings: &Settings) -> Self {
        Self::Keyed(Box::new(Keyed::new(settings)))
    }

    /// The paper's generators.
    pub(crate) fn of(generator: Generator, seed: u64) -> Self {
        match generator {
            Generator::Rand => Self::Rand(Rand::new(seed as u32)),
            Generator::Xorshift { unroll } => Self::Xorshift(Box::new(Pool::new(seed, unroll))),
        }
    }

    /// Begins the paths of pixels `at`, `at + 1`, ..., one per lane, of iteration `iteration`.
    #[inline(always)]
    pub(crate) fn begin_camera_paths<L: Lanes>(&mut self, iteration: u32, at: usize) {
        if let Self::Keyed(keyed) = self {
            keyed.begin_camera_paths(iteration, at, L::N);
        }
    }

    /// Begins the paths of photons `at`, `at + 1`, ..., one per lane, of iteration `iteration`.
    #[inline(always)]
    pub(crate) fn begin_photon_paths<L: Lanes>(&mut self, iteration: u32, at: u32) {
        if let Self::Keyed(keyed) = self {
            keyed.begin_photon_paths(iteration, at, L::N);
        }
    }

    /// Uniform numbers in [0, 1). With keyed streams they are stratified in the given dimension.
    #[inline(always)]
    pub(crate) fn stratified<L: Lanes>(&mut self, dimension: usize) -> L::F {
        match self {
            Self::Keyed(keyed) => L::load(keyed.stratified(dimension, L::N)),
            _ => self.next::<L>(),
        }
    }

    /// A pair of [`Numbers::stratified`].
    #[inline(always)]
    pub(crate) fn pair<L: Lanes>(&mut self, [a, b]: [usize; 2]) -> [L::F; 2] {
        let first = self.stratified::<L>(a);
        [first, self.stratified::<L>(b)]
    }

    /// The numbers that choose between reflection and refraction if segment `segment` of camera paths ends at glass.
    #[inline(always)]
    pub(crate) fn lobe<L: Lanes>(&mut self, segment: u32) -> L::F {
        match camera_dimension::LOBES.get(segment as usize) {
            Some(&dimension) => self.stratified::<L>(dimension),
            None => self.next::<L>(),
        }
    }

    /// Uniform numbers in [0, 1), one per lane.
    #[inline(always)]
    pub(crate) fn next<L: Lanes>(&mut self) -> L::F {
        match self {
            Self::Keyed(keyed) => L::load(keyed.next(L::N)),
            Self::Rand(rand) => {
                let mut values = [0.0; lanes::MOST_LANES];
                for lane in 0..L::N {
                    values[lane] = rand.next_f32();
                }
                L::load(&values)
            }
            Self::Xorshift(pool) => L::load(pool.take(L::N)),
        }
    }
}
