//! Stratified random numbers for the dimensions that matter most: Sobol points under random digital shifts.
//!
//! The image of a photon map is mostly the noise of where photons start, and that of direct light the noise of
//! which point of the light is sampled. Points of a Sobol sequence (Sobol 1967; direction numbers of Joe and Kuo
//! 2008) spread evenly, and the exclusive or with a random word per dimension (a digital shift) makes each of them
//! uniform, so estimates stay unbiased. A point is a pure function of its index, like a stream of [`crate::rng`].

/// How many dimensions there are direction numbers for.
pub const DIMENSIONS: usize = 8;

/// Degree, coefficients and initial values of the primitive polynomials: dimensions 2..=8 of `new-joe-kuo-6.21201`.
const POLYNOMIALS: [(u32, u32, &[u32]); DIMENSIONS - 1] = [
    (1, 0, &[1]),
    (2, 1, &[1, 3]),
    (3, 1, &[1, 3, 1]),
    (3, 2, &[1, 1, 1]),
    (4, 1, &[1, 1, 3, 3]),
    (4, 4, &[1, 3, 5, 13]),
    (5, 2, &[1, 1, 5, 5, 17]),
];

/// Column `b` of dimension `d`: what bit `b` of the index contributes.
static COLUMNS: [[u32; 32]; DIMENSIONS] = columns();

const fn columns() -> [[u32; 32]; DIMENSIONS] {
    let mut table = [[0; 32]; DIMENSIONS];
    let mut bit = 0;
    while bit < 32 {
        table[0][bit] = 1 << (31 - bit);
        bit += 1;
    }
    let mut d = 1;
    while d < DIMENSIONS {
        let (degree, coefficients, initial) = POLYNOMIALS[d - 1];
        let s = degree as usize;
        let mut i = 0;
        while i < 32 {
            if i < s {
                table[d][i] = initial[i] << (31 - i);
            } else {
                let mut v = table[d][i - s] ^ (table[d][i - s] >> s);
                let mut k = 1;
                while k < s {
                    if (coefficients >> (s - 1 - k)) & 1 == 1 {
                        v ^= table[d][i - k];
                    }
                    k += 1;
                }
                table[d][i] = v;
            }
            i += 1;
        }
        d += 1;
    }
    table
}

/// Dimension `dimension` of point `index`, as 32 binary digits (the first is the top bit), not shifted.
///
/// # Panics
/// If `dimension >= DIMENSIONS`.
#[inline]
pub fn sobol(index: u32, dimension: usize) -> u32 {
    let columns = &COLUMNS[dimension];
    let mut rest = index;
    let mut digits = 0;
    while rest != 0 {
        digits ^= columns[rest.trailing_zeros() as usize];
        rest &= rest - 1;
    }
    digits
}

/// The place of pixel (x, y) in its 8x8 tile along the Z curve, 0..64: the index of its Sobol point.
///
/// Along this curve every aligned 2x2 or 4x4 block is a run of the sequence, so it is stratified in itself.
#[inline]
pub fn morton(x: u32, y: u32) -> u32 {
    let spread = |v: u32| (v & 1) | ((v & 2) << 1) | ((v & 4) << 2);
    spread(x) | (spread(y) << 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first 16 points of each dimension in sixteenths, as another library computes them from the tables of
    /// Joe and Kuo (its points come in Gray code order, and are put in natural order here).
    const FIRST_POINTS: [[u32; 16]; DIMENSIONS] = [
        [0, 8, 4, 12, 2, 10, 6, 14, 1, 9, 5, 13, 3, 11, 7, 15],
        [0, 8, 12, 4, 10, 2, 6, 14, 15, 7, 3, 11, 5, 13, 9, 1],
        [0, 8, 12, 4, 6, 14, 10, 2, 9, 1, 5, 13, 15, 7, 3, 11],
        [0, 8, 12, 4, 2, 10, 14, 6, 5, 13, 9, 1, 7, 15, 11, 3],
        [0, 8, 4, 12, 2, 10, 6, 14, 11, 3, 15, 7, 9, 1, 13, 5],
        [0, 8, 4, 12, 6, 14, 2, 10, 3, 11, 7, 15, 5, 13, 1, 9],
        [0, 8, 12, 4, 10, 2, 6, 14, 13, 5, 1, 9, 7, 15, 11, 3],
        [0, 8, 4, 12, 10, 2, 14, 6, 5, 13, 1, 9, 15, 7, 11, 3],
    ];

    /// Points that take all 32 columns, of the same origin.
    const FAR_POINTS: [(u32, [u32; DIMENSIONS]); 4] = [
        (
            0xdead_beef,
            [
                0xf77d_b57b,
                0x0c66_ae4d,
                0xa928_2de3,
                0x2027_a979,
                0x00af_e2cf,
                0x29cb_b0b5,
                0x5634_3c19,
                0x7e1a_011b,
            ],
        ),
        (
            0x8000_0000,
            [
                0x0000_0001,
                0xffff_ffff,
                0xc500_5555,
                0x5005_0093,
                0xb00d_db9d,
                0x40bb_bbbb,
                0xc010_4477,
                0x8763_9641,
            ],
        ),
        (
            0xffff_ffff,
            [
                0xffff_ffff,
                0x0000_0001,
                0x4f00_ffff,
                0x300c_ff8d,
                0x5005_0093,
                0xc011_1111,
                0x4070_ccdd,
                0x84f0_027f,
            ],
        ),
        (
            0x0001_2345,
            [
                0xa2c4_8000,
                0x868c_8000,
                0xb25c_8000,
                0x6b43_8000,
                0xe203_8000,
                0xb1e4_8000,
                0x22bc_8000,
                0xbdf0_8000,
            ],
        ),
    ];

    #[test]
    fn points_are_those_of_joe_and_kuo() {
        for (dimension, points) in FIRST_POINTS.iter().enumerate() {
            for (index, sixteenths) in points.iter().enumerate() {
                assert_eq!(
                    sobol(index as u32, dimension),
                    sixteenths << 28,
                    "point {index}, dimension {dimension}"
                );
            }
        }
        for (index, point) in FAR_POINTS {
            assert_eq!(std::array::from_fn(|dimension| sobol(index, dimension)), point, "point {index}");
        }
    }

    /// True if of the 2^`bits` points that `shifted` gives, each box of 2^-`a` by 2^-(`bits` - `a`) holds one.
    fn is_stratified(bits: u32, shifted: impl Fn(u32) -> [u32; 2]) -> bool {
        (0..=bits).all(|a| {
            let mut boxes: Vec<u64> = (0..1 << bits)
                .map(|index| {
                    let [x, y] = shifted(index).map(u64::from);
                    let (column, row) = (x << a >> 32, y << (bits - a) >> 32);
                    column << (bits - a) | row
                })
                .collect();
            boxes.sort_unstable();
            boxes.iter().copied().eq(0..1 << bits)
        })
    }

    #[test]
    fn dimensions_0_and_1_are_a_net_in_every_aligned_run_under_any_shift() {
        for bits in 0..=10 {
            for run in [0, 1, 5, 1000] {
                let point = |i: u32| [0, 1].map(|d| sobol((run << bits) + i, d));
                assert!(is_stratified(bits, point), "run {run} of 2^{bits}");
                let shifted = |i: u32| [point(i)[0] ^ 0x9e37_79b9, point(i)[1] ^ 0x1234_5678];
                assert!(is_stratified(bits, shifted), "shifted run {run} of 2^{bits}");
            }
        }
    }

    #[test]
    fn each_dimension_is_stratified_in_every_aligned_run() {
        for dimension in 0..DIMENSIONS {
            for run in [0, 3, 77] {
                let mut cells: Vec<u32> = (0..256).map(|i| sobol((run << 8) + i, dimension) >> 24).collect();
                cells.sort_unstable();
                assert!(cells.iter().copied().eq(0..256), "dimension {dimension}, run {run}");
            }
        }
    }

    #[test]
    fn morton_numbers_the_tile_so_that_every_aligned_block_is_a_run() {
        for side in [1, 2, 4, 8] {
            for (by, bx) in (0..8 / side).flat_map(|by| (0..8 / side).map(move |bx| (by, bx))) {
                let block = (0..side).flat_map(|y| (0..side).map(move |x| (x, y)));
                let mut places: Vec<u32> = block.map(|(x, y)| morton(bx * side + x, by * side + y)).collect();
                places.sort_unstable();
                let first = places[0];
                assert_eq!(first % (side * side), 0);
                assert!(places.iter().copied().eq(first..first + side * side));
            }
        }
        // Z: x is the lower bit.
        assert_eq!([morton(1, 0), morton(0, 1), morton(1, 1), morton(2, 0)], [1, 2, 3, 4]);
    }
}
