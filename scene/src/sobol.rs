//! Stratified random numbers for the dimensions that matter most: Sobol points under random digital shifts.
//!
//! Most noise of photon mapping comes from where photons start; most noise of direct light comes from which point of
//! the light is sampled. The points of a Sobol sequence (Sobol 1967; direction numbers of Joe and Kuo 2008) are spread
//! evenly. The exclusive or with a random word per dimension (a digital shift) makes each of them uniform, so estimates
//! stay unbiased. Like a stream of [`crate::rng`], a point is a pure function of its index.
//!
//! From one iteration to the next, the points of a tile of pixels are shifted modulo 1 ([`moved_on`]). So the numbers
//! of each pixel are spread evenly over the iterations too, and those of a whole tile over both pixels and iterations.
//! After six iterations this reduces the mean square error of 8x8 pixels to a half to two thirds (docs/computed.md).
//! Where the integrand is smooth, as for most direct light, the error converges as 1/n instead of 1/sqrt(n).

/// The number of dimensions.
pub const DIMENSIONS: usize = 11;

/// Degree, coefficients and initial values of the primitive polynomials: dimensions 2..=11 of `new-joe-kuo-6.21201`.
const POLYNOMIALS: [(u32, u32, &[u32]); DIMENSIONS - 1] = [
    (1, 0, &[1]),
    (2, 1, &[1, 3]),
    (3, 1, &[1, 3, 1]),
    (3, 2, &[1, 1, 1]),
    (4, 1, &[1, 1, 3, 3]),
    (4, 4, &[1, 3, 5, 13]),
    (5, 2, &[1, 1, 5, 5, 17]),
    (5, 4, &[1, 1, 5, 5, 5]),
    (5, 7, &[1, 1, 7, 11, 19]),
    (5, 11, &[1, 1, 5, 1, 1]),
];

/// `COLUMNS[d][b]`: what bit `b` of the index contributes to dimension `d`.
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

/// Coordinate `dimension` of point `index`, without a shift, as 32 binary digits (the first is the top bit).
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

/// The first `N` points of a dimension, a power of two. Of any other index this is what the low bits contribute: its point is the
/// exclusive or of that and of the point of the index without them.
pub fn low_digits<const N: usize>(dimension: usize) -> [u32; N] {
    const { assert!(N.is_power_of_two()) };
    std::array::from_fn(|index| sobol(index as u32, dimension))
}

/// A prime per dimension; its square root is the step of that dimension from one iteration to the next.
///
/// Multiples of square roots of primes are evenly spread modulo 1, in each dimension and in all together (Richtmyer
/// 1951): these roots are irrational, and no integer combination of them is an integer. But some combinations are
/// nearly so: as 3 sqrt 5 + 2 sqrt 7 = 11.9997, a thousand points of these two dimensions lie on a few lines. The
/// primes here were found by simulated annealing over the primes below 700. It minimised the diaphony of each dimension
/// and of each pair of dimensions after 2 to 1024 iterations, with more weight on the pairs that a pass uses together.
const PRIMES: [u32; DIMENSIONS] = [211, 331, 179, 137, 109, 277, 523, 199, 563, 173, 163];

/// The fractional part of the square root of each prime, in units of 2^-32.
static STEPS: [u32; DIMENSIONS] = steps();

const fn steps() -> [u32; DIMENSIONS] {
    let mut steps = [0; DIMENSIONS];
    let mut d = 0;
    while d < DIMENSIONS {
        steps[d] = ((PRIMES[d] as u128) << 64).isqrt() as u32;
        d += 1;
    }
    steps
}

/// The shift of a tile's points in dimension `dimension` at iteration `iteration`, in units of 2^-32. It is added
/// modulo 2^32 to the result of [`sobol`] after the tile's digital shift.
///
/// # Panics
/// If `dimension >= DIMENSIONS`.
#[inline]
pub fn moved_on(iteration: u32, dimension: usize) -> u32 {
    iteration.wrapping_mul(STEPS[dimension])
}

/// The position of pixel (x, y) on the Z curve of its 8x8 tile, 0..64: the index of its Sobol point.
///
/// On this curve every aligned block of 2x2 or 4x4 pixels is an aligned run of the sequence, so each block is
/// stratified by itself.
#[inline]
pub fn morton(x: u32, y: u32) -> u32 {
    let spread = |v: u32| (v & 1) | ((v & 2) << 1) | ((v & 4) << 2);
    spread(x) | (spread(y) << 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first 16 points of each dimension in sixteenths, computed by another library from the tables of Joe and Kuo.
    /// That library gives points in Gray code order; here they are in natural order.
    const FIRST_POINTS: [[u32; 16]; DIMENSIONS] = [
        [0, 8, 4, 12, 2, 10, 6, 14, 1, 9, 5, 13, 3, 11, 7, 15],
        [0, 8, 12, 4, 10, 2, 6, 14, 15, 7, 3, 11, 5, 13, 9, 1],
        [0, 8, 12, 4, 6, 14, 10, 2, 9, 1, 5, 13, 15, 7, 3, 11],
        [0, 8, 12, 4, 2, 10, 14, 6, 5, 13, 9, 1, 7, 15, 11, 3],
        [0, 8, 4, 12, 2, 10, 6, 14, 11, 3, 15, 7, 9, 1, 13, 5],
        [0, 8, 4, 12, 6, 14, 2, 10, 3, 11, 7, 15, 5, 13, 1, 9],
        [0, 8, 12, 4, 10, 2, 6, 14, 13, 5, 1, 9, 7, 15, 11, 3],
        [0, 8, 4, 12, 10, 2, 14, 6, 5, 13, 1, 9, 15, 7, 11, 3],
        [0, 8, 4, 12, 10, 2, 14, 6, 5, 13, 1, 9, 15, 7, 11, 3],
        [0, 8, 4, 12, 14, 6, 10, 2, 11, 3, 15, 7, 5, 13, 1, 9],
        [0, 8, 4, 12, 10, 2, 14, 6, 1, 9, 5, 13, 11, 3, 15, 7],
    ];

    /// Points that use all 32 columns, computed by the same library.
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
                0x9c35_c4cb,
                0x6cb0_51bb,
                0x8627_34df,
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
                0x8435_0611,
                0x82ff_78f1,
                0x81d0_0a2d,
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
                0x87f3_05cf,
                0x812a_d7a7,
                0x8762_9643,
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
                0xd026_8000,
                0xac96_8000,
                0xb499_8000,
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

    /// True if each box of 2^-`a` by 2^-(`bits` - `a`) holds exactly one of the 2^`bits` points given by `shifted`.
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

    /// A bound on the largest gap between the first n multiples of a step, times n. By the three-distance theorem the
    /// product is little more than the largest partial quotient of the step's continued fraction, except after very few
    /// steps.
    const GAP: f64 = 12.0;

    #[test]
    fn iterations_are_spread_evenly_in_every_dimension() {
        for (d, prime) in PRIMES.into_iter().enumerate() {
            let expected = f64::from(prime).sqrt().fract() * 4_294_967_296.0;
            assert!((f64::from(moved_on(1, d)) - expected).abs() < 1.0, "dimension {d}");
            for n in [1, 2, 6, 10, 64, 1000] {
                let mut places: Vec<u64> = (0..n).map(|i| u64::from(moved_on(i, d))).collect();
                places.sort_unstable();
                places.push(places[0] + (1 << 32));
                let gap = places.windows(2).map(|pair| pair[1] - pair[0]).max().unwrap();
                let gap = gap as f64 / 4_294_967_296.0 * f64::from(n);
                assert!(gap < GAP, "dimension {d}: a gap of {gap:.1} / {n} after {n} iterations");
            }
        }
    }

    /// The squared diaphony (Zinterhof 1976) of the first `n` points of two dimensions, relative to that of independent
    /// points.
    fn diaphony(n: u32, [a, b]: [usize; 2]) -> f64 {
        let kernel = |k: u32, d| {
            let x = f64::from(moved_on(k, d)) / 4_294_967_296.0;
            2.0 * std::f64::consts::PI.powi(2) * (x * x - x + 1.0 / 6.0)
        };
        let both = |k| (1.0 + kernel(k, a)) * (1.0 + kernel(k, b)) - 1.0;
        let apart: f64 = (1..n).map(|k| 2.0 * f64::from(n - k) * both(k)).sum();
        (both(0) + apart / f64::from(n)) / both(0)
    }

    /// A bound slightly above the value of the worst pair, which occurs after few iterations.
    const WORST: f64 = 1.5;

    /// Bounds for the pairs used for pixel, light and lens, as (iterations, bound).
    const PAIR: [(u32, f64); 2] = [(64, 0.3), (1024, 0.05)];

    #[test]
    fn no_two_dimensions_move_together() {
        for (a, b) in (0..DIMENSIONS).flat_map(|b| (0..b).map(move |a| (a, b))) {
            for n in [3, 4, 6, 8, 12, 16, 32, 64, 128, 256, 512, 1024] {
                let diaphony = diaphony(n, [a, b]);
                assert!(diaphony < WORST, "dimensions {a} and {b} after {n} iterations: {diaphony:.2}");
            }
        }
        for (pair, (n, most)) in
            [[0, 1], [2, 3], [5, 6]].into_iter().flat_map(|p| PAIR.map(|limit| (p, limit)))
        {
            let diaphony = diaphony(n, pair);
            assert!(diaphony < most, "dimensions {pair:?} after {n} iterations: {diaphony:.3}");
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
