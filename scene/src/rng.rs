//! Seeded random numbers: a separate stream for every path of every pass of every iteration.
//!
//! A stream depends only on `(seed, family, iteration, index)`. So a path draws the same numbers whichever engine,
//! thread or lane traces it, and in any order. The 32-bit state of a stream starts at a hash of the key and steps by
//! xorshift32 (Marsaglia, "Xorshift RNGs", 2003, triple 13, 17, 5).
//!
//! Quality: xorshift32 alone fails `BigCrush`, contrary to what the paper's published program says: it is linear over
//! GF(2), and its period is only 2^32 - 1. In dieharder it fails counts of ones and ranks of bit matrices, and so do the
//! first four numbers of our streams (docs/paper.md). This is good enough here: a stream gives a few dozen numbers from
//! a hashed start, and only their top bits are used. It matters more that neighbouring keys give unrelated streams. The
//! hash provides that, and tests check it. Within one family and iteration no two indices have the same start state, as
//! the hash is a bijection.

/// The purpose of a stream. Streams of different families are unrelated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Family {
    /// Camera paths; the index is `y * width + x`.
    Camera = 1,
    /// The digital shifts of one 8x8 tile of pixels; the index is the tile's, row by row. All iterations use the
    /// streams of iteration 0.
    Tile = 2,
    /// Photon paths; the index is that of the photon.
    Photon = 3,
    /// The digital shifts of the photons' Sobol points; the index is 0.
    Emission = 4,
    /// The shutter time of an iteration; the index is 0.
    Shutter = 5,
    /// The path tracer's samples; the index is `y * width + x`.
    Path = 6,
    /// Walks that find what photons are aimed at, of iteration 0; the index is the walk's.
    Survey = 7,
    /// Further rays that see lamps ([`crate::Settings::glint_samples`]); the index is `y * width + x`,
    /// and the rays of all iterations are numbered in order.
    Glint = 8,
    /// The dithering of the codes in image files; the index is `y * width + x`, the iteration 0.
    Dither = 16,
}

/// The key of one family of streams in one iteration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StreamKey {
    /// Mixed into the index before the first round of the hash.
    pub before: u32,
    /// Added between the rounds of the hash, so that no two keys give related streams.
    pub between: u32,
}

/// Multipliers of the two-round integer hash `lowbias32` (Ellis, "Prospecting for hash functions", 2018).
pub const HASH_MULTIPLIERS: [u32; 2] = [0x21f0_aaad, 0xd35a_2d97];

/// Replaces a start state of 0, which xorshift32 would never leave.
pub const STATE_FOR_ZERO: u32 = 0x9e37_79b9;

/// 2^-24: scales the top 24 bits of a word to a float in [0, 1), without rounding.
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

    /// Stream `index`, from its start.
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Seed, family, iteration, index; then the key, the start state, and the first three words.
    type KnownAnswer = (u64, Family, u32, u32, [u32; 2], u32, [u32; 3]);

    /// Computed by an independent implementation in another language, with unbounded integers.
    const KNOWN_ANSWERS: [KnownAnswer; 7] = [
        (
            0,
            Family::Camera,
            0,
            0,
            [0xeef1_5b4b, 0x2d3c_4559],
            0xa056_7fd6,
            [0x9a3d_8800, 0x4c8e_2e5e, 0xa1f0_f57c],
        ),
        (
            1,
            Family::Camera,
            0,
            0,
            [0xdce6_1845, 0x210a_ee97],
            0xc335_f79e,
            [0xc507_26dd, 0x1a4e_5053, 0xd8cf_5651],
        ),
        (
            1,
            Family::Tile,
            0,
            7,
            [0x745a_6c2a, 0x4abf_92be],
            0x1c2c_89e4,
            [0x2f19_a2ec, 0x73c1_c68e, 0x2914_43c6],
        ),
        (
            1,
            Family::Photon,
            5,
            199_999,
            [0x5942_946a, 0x6497_7274],
            0xb72d_8650,
            [0xfb17_31c3, 0xb8c4_b5d4, 0xe1ba_7f8b],
        ),
        (
            u64::MAX,
            Family::Emission,
            0,
            0,
            [0x3e6e_2228, 0x3cf7_505c],
            0x4cb8_ab71,
            [0x6302_54da, 0x1ab9_02d6, 0x6698_2b47],
        ),
        (
            0x0123_4567_89ab_cdef,
            Family::Shutter,
            0,
            0,
            [0xbf74_f4cf, 0xbe35_197f],
            0x6649_f40c,
            [0x41c3_5568, 0x46a6_5b3f, 0x35fe_463f],
        ),
        (
            42,
            Family::Path,
            (1 << 30) - 1,
            u32::MAX,
            [0xe1cb_7fc4, 0xa464_11a3],
            0x678b_2466,
            [0x63fb_5945, 0x12ac_58ac, 0xae8b_1a70],
        ),
    ];

    #[test]
    fn keys_states_and_words_are_the_known_ones() {
        for (seed, family, iteration, index, [before, between], state, words) in KNOWN_ANSWERS {
            let key = StreamKey::new(seed, family, iteration);
            assert_eq!(key, StreamKey { before, between });
            assert_eq!(key.state(index), state);
            let mut stream = key.stream(index);
            assert_eq!([(); 3].map(|()| stream.next_u32()), words);
            // The float holds exactly the top 24 bits of the first word.
            let float = key.stream(index).next_f32();
            assert_eq!(f64::from(float) * f64::from(1 << 24), f64::from(words[0] >> 8));
        }
    }

    #[test]
    fn splitmix64_gives_the_published_first_value_of_seed_1234567() {
        assert_eq!(splitmix64(1_234_567), 6_457_827_717_110_365_317);
    }

    #[test]
    fn the_one_index_that_hashes_to_zero_starts_at_the_stand_in() {
        // Found by inverting the hash step by step.
        assert_eq!(StreamKey::new(1, Family::Photon, 0).state(98_778_080), STATE_FOR_ZERO);
    }

    #[test]
    fn unit_floats_are_the_multiples_of_two_to_the_minus_24_below_one() {
        for top in 0..1_u32 << 24 {
            let expected = f64::from(top) / f64::from(1 << 24);
            assert_eq!(f64::from(unit_float(top << 8)), expected);
            assert_eq!(f64::from(unit_float(top << 8 | 0xff)), expected);
        }
        assert!(unit_float(u32::MAX) < 1.0);
    }

    #[test]
    fn streams_of_one_key_start_at_different_states() {
        let key = StreamKey::new(7, Family::Camera, 3);
        let mut states: Vec<u32> = (0..1 << 20).map(|index| key.state(index)).collect();
        states.sort_unstable();
        assert!(states.windows(2).all(|pair| pair[0] < pair[1]));
        assert_ne!(states[0], 0);
    }

    #[test]
    fn xorshift_never_reaches_zero() {
        // The step is linear over GF(2), so it suffices that its matrix has the full rank of 32.
        let mut rows: Vec<u32> = (0..32).map(|bit| Stream { state: 1 << bit }.next_u32()).collect();
        for bit in 0..32 {
            let pivot = (bit..32).find(|&i| rows[i] >> bit & 1 == 1).expect("the step is not invertible");
            rows.swap(bit, pivot);
            for i in bit + 1..32 {
                if rows[i] >> bit & 1 == 1 {
                    rows[i] ^= rows[bit];
                }
            }
        }
    }
}
