//! Sixteen lanes in 512-bit registers. Truth values are bits of mask registers.

use crate::avx2;
use crate::mask;
use crate::masked::Masked;
use crate::operations::{Kernel, Lanes, assert_within};
use crate::row::Row;
#[allow(clippy::wildcard_imports)] // some forty intrinsics
use std::arch::x86_64::*;
use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Sub};

/// The back end. Only [`dispatch`](crate::dispatch()) names it outside of this file, after it has asked the processor for
/// AVX-512 F, BW, DQ and VL, and for what AVX2 needs: the contract that makes the intrinsics below safe to call.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Avx512;

const N: usize = 16;

/// `f32` lanes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct F(__m512);
/// `u32` lanes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct U(__m512i);
/// Truth values, a bit each.
type M = mask::M<__mmask16>;

macro_rules! binary {
    ($($op:ident $method:ident $on:ident $intrinsic:ident;)*) => {$(
        impl $op for $on {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                // SAFETY: the processor has AVX-512, by the contract of the back end.
                Self(unsafe { $intrinsic(self.0, other.0) })
            }
        }
    )*};
}

binary! {
    Add add F _mm512_add_ps;
    Sub sub F _mm512_sub_ps;
    Mul mul F _mm512_mul_ps;
    Div div F _mm512_div_ps;
    Add add U _mm512_add_epi32;
    Mul mul U _mm512_mullo_epi32;
    BitAnd bitand U _mm512_and_si512;
    BitOr bitor U _mm512_or_si512;
    BitXor bitxor U _mm512_xor_si512;
}

impl Neg for F {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        // SAFETY: the processor has AVX-512, by the contract of the back end.
        Self(unsafe { _mm512_xor_ps(self.0, _mm512_set1_ps(-0.0)) })
    }
}

/// Two registers of eight lanes as one of sixteen.
#[inline(always)]
fn join(low: __m256, high: __m256) -> F {
    // SAFETY: the processor has AVX-512 DQ, by the contract of the back end.
    F(unsafe { _mm512_insertf32x8::<1>(_mm512_castps256_ps512(low), high) })
}

/// Sixteen rows as eight columns.
#[inline(always)]
fn columns(rows: [&Row; 16]) -> [F; 8] {
    let zero = avx2::load_row(&Row([0.0; 8]));
    let (mut low, mut high) = ([zero; 8], [zero; 8]);
    for k in 0..8 {
        low[k] = avx2::load_row(rows[k]);
        high[k] = avx2::load_row(rows[k + 8]);
    }
    let (low, high) = (avx2::transpose8(low), avx2::transpose8(high));
    let mut columns = [join(low[0], high[0]); 8];
    for k in 1..8 {
        columns[k] = join(low[k], high[k]);
    }
    columns
}

impl Lanes for Avx512 {
    const N: usize = N;
    type Eight = Masked;
    type Pair = Self;
    type F = F;
    type U = U;
    type M = M;

    #[inline(always)]
    fn call<K: Kernel>(kernel: K) -> K::Output {
        /// The features of `dispatch`.
        #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512bw,avx512dq,avx512vl")]
        #[inline(never)]
        fn apart<K: Kernel>(kernel: K) -> K::Output {
            kernel.run::<Avx512>()
        }
        // SAFETY: the processor has these features, by the contract of the back end.
        unsafe { apart(kernel) }
    }
    #[inline(always)]
    fn f(x: f32) -> F {
        // SAFETY: the processor has AVX-512, by the contract of the back end (also for all methods below).
        F(unsafe { _mm512_set1_ps(x) })
    }
    #[inline(always)]
    fn load(from: &[f32]) -> F {
        let from = &from[..N];
        // SAFETY: the slice holds N floats.
        F(unsafe { _mm512_loadu_ps(from.as_ptr()) })
    }
    #[inline(always)]
    fn store(v: F, to: &mut [f32]) {
        let to = &mut to[..N];
        // SAFETY: the slice holds N floats.
        unsafe { _mm512_storeu_ps(to.as_mut_ptr(), v.0) }
    }
    #[inline(always)]
    fn sqrt(v: F) -> F {
        F(unsafe { _mm512_sqrt_ps(v.0) })
    }
    #[inline(always)]
    fn abs(v: F) -> F {
        F(unsafe { _mm512_abs_ps(v.0) })
    }
    #[inline(always)]
    fn max(a: F, b: F) -> F {
        F(unsafe { _mm512_max_ps(a.0, b.0) })
    }
    #[inline(always)]
    fn min(a: F, b: F) -> F {
        F(unsafe { _mm512_min_ps(a.0, b.0) })
    }
    #[inline(always)]
    fn min_lane(v: F) -> u32 {
        // SAFETY: as above.
        let least = Self::f(unsafe { _mm512_reduce_min_ps(v.0) });
        Self::mask_bits(Self::le(v, least)).trailing_zeros()
    }
    #[inline(always)]
    fn fused(a: F, b: F, c: F) -> F {
        F(unsafe { _mm512_fmadd_ps(a.0, b.0, c.0) })
    }
    #[inline(always)]
    fn floor(v: F) -> F {
        F(unsafe { _mm512_roundscale_ps::<{ _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC }>(v.0) })
    }
    #[inline(always)]
    fn lt(a: F, b: F) -> M {
        mask::M(unsafe { _mm512_cmp_ps_mask::<_CMP_LT_OQ>(a.0, b.0) })
    }
    #[inline(always)]
    fn le(a: F, b: F) -> M {
        mask::M(unsafe { _mm512_cmp_ps_mask::<_CMP_LE_OQ>(a.0, b.0) })
    }
    #[inline(always)]
    fn truncate(v: F) -> U {
        U(unsafe { _mm512_cvttps_epi32(v.0) })
    }
    #[inline(always)]
    fn to_float(v: U) -> F {
        F(unsafe { _mm512_cvtepi32_ps(v.0) })
    }
    #[inline(always)]
    fn bits(v: F) -> U {
        U(unsafe { _mm512_castps_si512(v.0) })
    }
    #[inline(always)]
    fn from_bits(v: U) -> F {
        F(unsafe { _mm512_castsi512_ps(v.0) })
    }
    #[inline(always)]
    fn select(m: M, a: F, b: F) -> F {
        F(unsafe { _mm512_mask_blend_ps(m.0, b.0, a.0) })
    }
    #[inline(always)]
    fn u(x: u32) -> U {
        U(unsafe { _mm512_set1_epi32(x as i32) })
    }
    #[inline(always)]
    fn load_u(from: &[u32]) -> U {
        let from = &from[..N];
        // SAFETY: the slice holds N words.
        U(unsafe { _mm512_loadu_si512(from.as_ptr().cast()) })
    }
    #[inline(always)]
    fn store_u(v: U, to: &mut [u32]) {
        let to = &mut to[..N];
        // SAFETY: the slice holds N words.
        unsafe { _mm512_storeu_si512(to.as_mut_ptr().cast(), v.0) }
    }
    #[inline(always)]
    fn shl<const K: i32>(v: U) -> U {
        // The intrinsic takes its count as another type than its 256-bit sister; this one is the same instruction.
        U(unsafe { _mm512_sllv_epi32(v.0, _mm512_set1_epi32(K)) })
    }
    #[inline(always)]
    fn shr<const K: i32>(v: U) -> U {
        U(unsafe { _mm512_srlv_epi32(v.0, _mm512_set1_epi32(K)) })
    }
    #[inline(always)]
    fn shr_by(v: U, by: U) -> U {
        U(unsafe { _mm512_srlv_epi32(v.0, by.0) })
    }
    #[inline(always)]
    fn eq(a: U, b: U) -> M {
        mask::M(unsafe { _mm512_cmpeq_epi32_mask(a.0, b.0) })
    }
    #[inline(always)]
    fn add_where(m: M, a: U, b: U) -> U {
        U(unsafe { _mm512_mask_add_epi32(a.0, m.0, a.0, b.0) })
    }
    #[inline(always)]
    fn min_u(a: U, b: U) -> U {
        U(unsafe { _mm512_min_epu32(a.0, b.0) })
    }
    #[inline(always)]
    fn select_u(m: M, a: U, b: U) -> U {
        U(unsafe { _mm512_mask_blend_epi32(m.0, b.0, a.0) })
    }
    #[inline(always)]
    fn mask_bits(m: M) -> u32 {
        u32::from(m.0)
    }
    #[inline(always)]
    fn mask_from_bits(bits: u32) -> M {
        mask::M(bits as __mmask16)
    }
    #[inline(always)]
    fn gather_u(table: &[u32], index: U) -> U {
        assert!(table.len().is_power_of_two() && table.len() <= 1 << 30);
        let index = index & Self::u(table.len() as u32 - 1);
        // SAFETY: every index is below the length, and as a signed number not negative.
        U(unsafe { _mm512_i32gather_epi32::<4>(index.0, table.as_ptr().cast()) })
    }
    #[inline(always)]
    fn gather_rows(table: &[Row], index: &[u32]) -> [F; 8] {
        let index = &index[..N];
        assert_within::<Self>(index, table.len());
        let mut rows = [&table[0]; 16];
        for k in 0..16 {
            // SAFETY: the index is one of the table, as was asserted.
            rows[k] = unsafe { table.get_unchecked(index[k] as usize) };
        }
        columns(rows)
    }
    #[inline(always)]
    fn transpose(columns: [F; 8], to: &mut [Row]) {
        let (low, high) = to[..N].split_at_mut(8);
        let zero = avx2::load_row(&Row([0.0; 8]));
        let (mut first, mut second) = ([zero; 8], [zero; 8]);
        for k in 0..8 {
            // SAFETY: as above.
            unsafe {
                first[k] = _mm512_castps512_ps256(columns[k].0);
                second[k] = _mm512_extractf32x8_ps::<1>(columns[k].0);
            }
        }
        avx2::store_rows(avx2::transpose8(first), low);
        avx2::store_rows(avx2::transpose8(second), high);
    }
    #[inline(always)]
    fn load_rows(rows: &[Row]) -> [F; 8] {
        let rows = &rows[..N];
        let mut all = [&rows[0]; 16];
        for k in 1..16 {
            all[k] = &rows[k];
        }
        columns(all)
    }
    #[inline(always)]
    fn compress(m: M, v: F, to: &mut [f32]) {
        // Compressed in a register: compressing stores are microcoded on some processors.
        Self::store(F(unsafe { _mm512_maskz_compress_ps(m.0, v.0) }), to);
    }
    #[inline(always)]
    fn compress_u(m: M, v: U, to: &mut [u32]) {
        Self::store_u(U(unsafe { _mm512_maskz_compress_epi32(m.0, v.0) }), to);
    }
}
