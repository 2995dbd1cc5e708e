//! Eight lanes in 256-bit registers.

use crate::operations::{Kernel, Lanes, assert_within};
use crate::paired::Paired;
use crate::row::Row;
#[allow(clippy::wildcard_imports)] // some forty intrinsics
use std::arch::x86_64::*;
use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Sub};

/// The back end. Only [`dispatch`](crate::dispatch()) names it outside of this file, after it has asked the processor for
/// AVX2, FMA, BMI, LZCNT and POPCNT: the contract that makes the intrinsics below safe to call.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Avx2;

const N: usize = 8;

/// `f32` lanes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct F(pub(crate) __m256);
/// `u32` lanes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct U(pub(crate) __m256i);
/// Truth values: a true lane has all bits set, a false one none.
#[derive(Clone, Copy, Debug)]
pub(crate) struct M(__m256);

macro_rules! binary {
    ($($op:ident $method:ident $on:ident $intrinsic:ident;)*) => {$(
        impl $op for $on {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                // SAFETY: the processor has AVX2, by the contract of the back end.
                Self(unsafe { $intrinsic(self.0, other.0) })
            }
        }
    )*};
}

binary! {
    Add add F _mm256_add_ps;
    Sub sub F _mm256_sub_ps;
    Mul mul F _mm256_mul_ps;
    Div div F _mm256_div_ps;
    Add add U _mm256_add_epi32;
    Mul mul U _mm256_mullo_epi32;
    BitAnd bitand U _mm256_and_si256;
    BitOr bitor U _mm256_or_si256;
    BitXor bitxor U _mm256_xor_si256;
    BitAnd bitand M _mm256_and_ps;
    BitOr bitor M _mm256_or_ps;
}

impl Neg for F {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        // SAFETY: the processor has AVX2, by the contract of the back end.
        Self(unsafe { _mm256_xor_ps(self.0, _mm256_set1_ps(-0.0)) })
    }
}

impl Not for M {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        // SAFETY: the processor has AVX2, by the contract of the back end.
        Self(unsafe { _mm256_xor_ps(self.0, _mm256_castsi256_ps(_mm256_set1_epi32(-1))) })
    }
}

/// For each mask of eight lanes, the permutation that moves the selected lanes to the front.
static TO_FRONT: [[u32; 8]; 256] = {
    let mut table = [[0; 8]; 256];
    let mut mask = 0;
    while mask < 256 {
        let (mut lane, mut place) = (0, 0);
        while lane < 8 {
            if (mask >> lane) & 1 == 1 {
                table[mask][place] = lane as u32;
                place += 1;
            }
            lane += 1;
        }
        mask += 1;
    }
    table
};

/// Transposes the 8x8 matrix whose rows are given: 8 + 8 + 8 shuffles within and across the 128-bit halves.
#[inline(always)]
pub(crate) fn transpose8(r: [__m256; 8]) -> [__m256; 8] {
    // SAFETY: the processor has AVX2, by the contract of the back end.
    unsafe {
        let pairs = [
            _mm256_unpacklo_ps(r[0], r[1]),
            _mm256_unpackhi_ps(r[0], r[1]),
            _mm256_unpacklo_ps(r[2], r[3]),
            _mm256_unpackhi_ps(r[2], r[3]),
            _mm256_unpacklo_ps(r[4], r[5]),
            _mm256_unpackhi_ps(r[4], r[5]),
            _mm256_unpacklo_ps(r[6], r[7]),
            _mm256_unpackhi_ps(r[6], r[7]),
        ];
        let quads = [
            _mm256_shuffle_ps::<0x44>(pairs[0], pairs[2]),
            _mm256_shuffle_ps::<0xee>(pairs[0], pairs[2]),
            _mm256_shuffle_ps::<0x44>(pairs[1], pairs[3]),
            _mm256_shuffle_ps::<0xee>(pairs[1], pairs[3]),
            _mm256_shuffle_ps::<0x44>(pairs[4], pairs[6]),
            _mm256_shuffle_ps::<0xee>(pairs[4], pairs[6]),
            _mm256_shuffle_ps::<0x44>(pairs[5], pairs[7]),
            _mm256_shuffle_ps::<0xee>(pairs[5], pairs[7]),
        ];
        [
            _mm256_permute2f128_ps::<0x20>(quads[0], quads[4]),
            _mm256_permute2f128_ps::<0x20>(quads[1], quads[5]),
            _mm256_permute2f128_ps::<0x20>(quads[2], quads[6]),
            _mm256_permute2f128_ps::<0x20>(quads[3], quads[7]),
            _mm256_permute2f128_ps::<0x31>(quads[0], quads[4]),
            _mm256_permute2f128_ps::<0x31>(quads[1], quads[5]),
            _mm256_permute2f128_ps::<0x31>(quads[2], quads[6]),
            _mm256_permute2f128_ps::<0x31>(quads[3], quads[7]),
        ]
    }
}

/// Eight registers as eight vectors of lanes.
#[inline(always)]
fn columns([a, b, c, d, e, f, g, h]: [__m256; 8]) -> [F; 8] {
    [F(a), F(b), F(c), F(d), F(e), F(f), F(g), F(h)]
}

/// Eight registers to as many rows.
#[inline(always)]
pub(crate) fn store_rows(from: [__m256; 8], to: &mut [Row]) {
    let to = &mut to[..8];
    for k in 0..8 {
        // SAFETY: a row is 32 bytes, aligned to 32.
        unsafe { _mm256_store_ps(to[k].0.as_mut_ptr(), from[k]) }
    }
}

/// A row as one register.
#[inline(always)]
pub(crate) fn load_row(row: &Row) -> __m256 {
    // SAFETY: a row is 32 bytes, aligned to 32; the processor has AVX2, by the contract.
    unsafe { _mm256_load_ps(row.0.as_ptr()) }
}

impl Lanes for Avx2 {
    const N: usize = N;
    type Eight = Self;
    type Pair = Paired<Self>;
    type F = F;
    type U = U;
    type M = M;

    #[inline(always)]
    fn call<K: Kernel>(kernel: K) -> K::Output {
        /// The features of `dispatch`.
        #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
        #[inline(never)]
        fn apart<K: Kernel>(kernel: K) -> K::Output {
            kernel.run::<Avx2>()
        }
        // SAFETY: the processor has these features, by the contract of the back end.
        unsafe { apart(kernel) }
    }
    #[inline(always)]
    fn f(x: f32) -> F {
        // SAFETY: the processor has AVX2 and FMA, by the contract of the back end (also for all methods below).
        F(unsafe { _mm256_set1_ps(x) })
    }
    #[inline(always)]
    fn load(from: &[f32]) -> F {
        let from = &from[..N];
        // SAFETY: the slice holds N floats.
        F(unsafe { _mm256_loadu_ps(from.as_ptr()) })
    }
    #[inline(always)]
    fn store(v: F, to: &mut [f32]) {
        let to = &mut to[..N];
        // SAFETY: the slice holds N floats.
        unsafe { _mm256_storeu_ps(to.as_mut_ptr(), v.0) }
    }
    #[inline(always)]
    fn sqrt(v: F) -> F {
        F(unsafe { _mm256_sqrt_ps(v.0) })
    }
    #[inline(always)]
    fn abs(v: F) -> F {
        F(unsafe { _mm256_andnot_ps(_mm256_set1_ps(-0.0), v.0) })
    }
    #[inline(always)]
    fn max(a: F, b: F) -> F {
        F(unsafe { _mm256_max_ps(a.0, b.0) })
    }
    #[inline(always)]
    fn min(a: F, b: F) -> F {
        F(unsafe { _mm256_min_ps(a.0, b.0) })
    }
    #[inline(always)]
    fn min_lane(v: F) -> u32 {
        // SAFETY: as above.
        let least = unsafe {
            let pairs = _mm256_min_ps(v.0, _mm256_permute_ps::<0b10_11_00_01>(v.0));
            let quads = _mm256_min_ps(pairs, _mm256_permute_ps::<0b01_00_11_10>(pairs));
            F(_mm256_min_ps(quads, _mm256_permute2f128_ps::<1>(quads, quads)))
        };
        Self::mask_bits(Self::le(v, least)).trailing_zeros()
    }
    #[inline(always)]
    fn fused(a: F, b: F, c: F) -> F {
        F(unsafe { _mm256_fmadd_ps(a.0, b.0, c.0) })
    }
    #[inline(always)]
    fn floor(v: F) -> F {
        F(unsafe { _mm256_floor_ps(v.0) })
    }
    #[inline(always)]
    fn lt(a: F, b: F) -> M {
        M(unsafe { _mm256_cmp_ps::<_CMP_LT_OQ>(a.0, b.0) })
    }
    #[inline(always)]
    fn le(a: F, b: F) -> M {
        M(unsafe { _mm256_cmp_ps::<_CMP_LE_OQ>(a.0, b.0) })
    }
    #[inline(always)]
    fn truncate(v: F) -> U {
        U(unsafe { _mm256_cvttps_epi32(v.0) })
    }
    #[inline(always)]
    fn to_float(v: U) -> F {
        F(unsafe { _mm256_cvtepi32_ps(v.0) })
    }
    #[inline(always)]
    fn bits(v: F) -> U {
        U(unsafe { _mm256_castps_si256(v.0) })
    }
    #[inline(always)]
    fn from_bits(v: U) -> F {
        F(unsafe { _mm256_castsi256_ps(v.0) })
    }
    #[inline(always)]
    fn select(m: M, a: F, b: F) -> F {
        F(unsafe { _mm256_blendv_ps(b.0, a.0, m.0) })
    }
    #[inline(always)]
    fn u(x: u32) -> U {
        U(unsafe { _mm256_set1_epi32(x as i32) })
    }
    #[inline(always)]
    fn load_u(from: &[u32]) -> U {
        let from = &from[..N];
        // SAFETY: the slice holds N words.
        U(unsafe { _mm256_loadu_si256(from.as_ptr().cast()) })
    }
    #[inline(always)]
    fn store_u(v: U, to: &mut [u32]) {
        let to = &mut to[..N];
        // SAFETY: the slice holds N words.
        unsafe { _mm256_storeu_si256(to.as_mut_ptr().cast(), v.0) }
    }
    #[inline(always)]
    fn shl<const K: i32>(v: U) -> U {
        U(unsafe { _mm256_slli_epi32::<K>(v.0) })
    }
    #[inline(always)]
    fn shr<const K: i32>(v: U) -> U {
        U(unsafe { _mm256_srli_epi32::<K>(v.0) })
    }
    #[inline(always)]
    fn shr_by(v: U, by: U) -> U {
        U(unsafe { _mm256_srlv_epi32(v.0, by.0) })
    }
    #[inline(always)]
    fn eq(a: U, b: U) -> M {
        M(unsafe { _mm256_castsi256_ps(_mm256_cmpeq_epi32(a.0, b.0)) })
    }
    #[inline(always)]
    fn add_where(m: M, a: U, b: U) -> U {
        U(unsafe { _mm256_add_epi32(a.0, _mm256_and_si256(_mm256_castps_si256(m.0), b.0)) })
    }
    #[inline(always)]
    fn min_u(a: U, b: U) -> U {
        U(unsafe { _mm256_min_epu32(a.0, b.0) })
    }
    #[inline(always)]
    fn select_u(m: M, a: U, b: U) -> U {
        U(unsafe { _mm256_blendv_epi8(b.0, a.0, _mm256_castps_si256(m.0)) })
    }
    #[inline(always)]
    fn mask_bits(m: M) -> u32 {
        (unsafe { _mm256_movemask_ps(m.0) }) as u32
    }
    #[inline(always)]
    fn mask_from_bits(bits: u32) -> M {
        M(unsafe {
            let lane_bit = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
            let chosen = _mm256_and_si256(_mm256_set1_epi32(bits as i32), lane_bit);
            _mm256_castsi256_ps(_mm256_cmpeq_epi32(chosen, lane_bit))
        })
    }
    #[inline(always)]
    fn first(n: usize) -> M {
        // Four operations less than by bits.
        M(unsafe {
            let end = _mm256_set1_epi32(n.min(N) as i32);
            _mm256_castsi256_ps(_mm256_cmpgt_epi32(end, _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7)))
        })
    }
    #[inline(always)]
    fn gather_u(table: &[u32], index: U) -> U {
        assert!(table.len().is_power_of_two() && table.len() <= 1 << 30);
        let index = index & Self::u(table.len() as u32 - 1);
        // SAFETY: every index is below the length, and as a signed number not negative.
        U(unsafe { _mm256_i32gather_epi32::<4>(table.as_ptr().cast(), index.0) })
    }
    #[inline(always)]
    fn gather_rows(table: &[Row], index: &[u32]) -> [F; 8] {
        let index = &index[..N];
        assert_within::<Self>(index, table.len());
        let mut rows = [Self::f(0.0).0; 8];
        for k in 0..8 {
            // SAFETY: the index is one of the table, as was asserted.
            rows[k] = load_row(unsafe { table.get_unchecked(index[k] as usize) });
        }
        columns(transpose8(rows))
    }
    #[inline(always)]
    fn transpose(columns: [F; 8], to: &mut [Row]) {
        let [a, b, c, d, e, f, g, h] = columns;
        store_rows(transpose8([a.0, b.0, c.0, d.0, e.0, f.0, g.0, h.0]), to);
    }
    #[inline(always)]
    fn load_rows(rows: &[Row]) -> [F; 8] {
        let rows = &rows[..N];
        let mut loaded = [Self::f(0.0).0; 8];
        for k in 0..8 {
            loaded[k] = load_row(&rows[k]);
        }
        columns(transpose8(loaded))
    }
    #[inline(always)]
    fn compress(m: M, v: F, to: &mut [f32]) {
        let order = Self::load_u(&TO_FRONT[(Self::mask_bits(m) & 0xff) as usize]);
        Self::store(F(unsafe { _mm256_permutevar8x32_ps(v.0, order.0) }), to);
    }
    #[inline(always)]
    fn compress_u(m: M, v: U, to: &mut [u32]) {
        let order = Self::load_u(&TO_FRONT[(Self::mask_bits(m) & 0xff) as usize]);
        Self::store_u(U(unsafe { _mm256_permutevar8x32_epi32(v.0, order.0) }), to);
    }
}
