//! Seeded random numbers: a stream of its own for every path of every pass of every iteration.
//!
//! A stream is a function of `(seed, family, iteration, index)` and of nothing else, so a path draws the same
//! numbers whichever engine, thread or lane traces it, and in whatever order. Its 32-bit state starts at a hash of
//! the key and steps by xorshift32 (Marsaglia, "Xorshift RNGs", 2003, triple 13, 17, 5).
//!
//! Quality: xorshift32 alone fails `BigCrush` (it is linear over GF(2), and its period is only 2^32 - 1), whatever
//! the published program says. Here a stream gives some dozens of numbers from a hashed start, for which it is
//! good enough; what matters more is that neighbouring keys are unrelated, which the hash provides and the tests
//! check. Within one family and iteration the start states of any two indices differ, as the hash is a bijection.

/// What a family of streams is for. Families never share streams.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Family {
    /// Camera paths; the index is `y * width + x`.
    Camera = 1,
    /// The digital shifts of one 8x8 tile of pixels; the index is the tile's, row by row.
    Tile = 2,
    /// Photon paths; the index is the photon's.
    Photon = 3,
    /// The digital shifts of the photons' Sobol points; the index is 0.
    Emission = 4,
    /// The shutter time of an iteration; the index is 0.
    Shutter = 5,
    /// The path tracer's samples; the index is `y * width + x`.
    Path = 6,
}

/// The key of one family of streams in one iteration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StreamKey {
    /// Enters the hash before its first round.
    pub before: u32,
    /// Enters the hash between its rounds, so that no two keys give related streams.
    pub between: u32,
}

/// Multipliers of the two-round integer hash `lowbias32` (Ellis, "Prospecting for hash functions", 2018).
pub const HASH_MULTIPLIERS: [u32; 2] = [0x21f0_aaad, 0xd35a_2d97];

/// The state that stands in for 0, which xorshift32 would never leave.
pub const STATE_FOR_ZERO: u32 = 0x9e37_79b9;

/// 2^-24: what turns the top 24 bits of a word into a float in [0, 1), without rounding.
pub const UNIT: f32 = 1.0 / 16_777_216.0;

impl StreamKey {
    /// The key of `family` in iteration `iteration` (from 0) of the render seeded with `seed`.
    pub fn new(seed: u64, family: Family, iteration: u32) -> Self {
        let tag = (u64::from(family as u32) << 32) | u64::from(iteration);
        let key = splitmix64(splitmix64(seed) ^ tag);
        Self { before: key as u32, between: (key >> 32) as u32 }
    }

    /// The start state of stream `index`: never 0.
    #[inline]
    pub fn state(self, index: u32) -> u32 {
        let mut x = index ^ self.before;
        x = (x ^ (x >> 16)).wrapping_mul(HASH_MULTIPLIERS[0]);
        x = x.wrapping_add(self.between);
        x = (x ^ (x >> 15)).wrapping_mul(HASH_MULTIPLIERS[1]);
        x ^= x >> 15;
        if x == 0 { STATE_FOR_ZERO } else { x }
    }

    /// Stream `index` at its start.
    #[inline]
    pub fn stream(self, index: u32) -> Stream {
        Stream { state: self.state(index) }
    }
}

/// One step of the finaliser of `SplitMix64` (Steele, Lea and Flood 2014), with its increment.
fn splitmix64(x: u64) -> u64 {
    let mut z = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// A stream of uniform numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stream {
    state: u32,
}

impl Stream {
    /// The next 32 bits (never 0).
    #[inline]
    pub fn next_u32(&mut self) -> u32 {
        let mut x = self.state;
        x ^= x << 13;
        x ^= x >> 17;
        x ^= x << 5;
        self.state = x;
        x
    }

    /// The next uniform float in [0, 1): a multiple of 2^-24, so never rounded up to 1.
    #[inline]
    pub fn next_f32(&mut self) -> f32 {
        unit_float(self.next_u32())
    }
}

/// The top 24 bits of `bits` as a float in [0, 1).
#[inline]
pub fn unit_float(bits: u32) -> f32 {
    (bits >> 8) as f32 * UNIT
}
