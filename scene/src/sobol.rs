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
