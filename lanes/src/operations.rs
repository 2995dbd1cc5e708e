//! The trait [`Lanes`]: what a vector can do.
//!
//! It holds what the kernels need and no more. Each operation is exact or exactly rounded, so a kernel gives the same
//! bits whichever back end runs it. [`Emulated`](crate::Emulated) defines every operation; the other back ends must agree
//! with it.

use crate::row::Row;
use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Sub};

/// The most lanes of any back end: how far buffers extend beyond their last element.
pub const MOST_LANES: usize = 16;

/// Work that runs on any lanes.
pub trait Kernel {
    /// The result.
    type Output;
    /// Does the work. Mark it `#[inline(always)]`, and all that it calls on lanes: features reach operations by inlining
    /// only, or by [`Lanes::call`].
    fn run<L: Lanes>(self) -> Self::Output;
}

/// A back end: types of vectors, and operations on them.
///
/// `F`, `U` and `M` are vectors of `N` lanes. Functions that take a slice read or write its first `N` elements, and panic
/// if it is shorter. All methods are `#[inline(always)]` (see the [crate](crate)).
pub trait Lanes: Copy + Send + Sync + 'static {
    /// The number of lanes: 8 or 16 in this crate.
    const N: usize;
    /// A back end of eight lanes, for things that come in eights.
    type Eight: Lanes;
    /// For kernels whose operations wait for each other: two vectors as one, if that takes less time on this back end.
    type Pair: Lanes;
    /// `f32` lanes.
    type F: Copy
        + Add<Output = Self::F>
        + Sub<Output = Self::F>
        + Mul<Output = Self::F>
        + Div<Output = Self::F>
        + Neg<Output = Self::F>;
    /// `u32` lanes; sums and products wrap.
    type U: Copy
        + Add<Output = Self::U>
        + Mul<Output = Self::U>
        + BitAnd<Output = Self::U>
        + BitOr<Output = Self::U>
        + BitXor<Output = Self::U>;
    /// Truth values.
    type M: Copy + BitAnd<Output = Self::M> + BitOr<Output = Self::M> + Not<Output = Self::M>;

    /// Runs part of a kernel as a function of its own, with the features of this back end. Kernels that share such a part
    /// then share its code, which is built once.
    #[inline(always)]
    fn call<K: Kernel>(kernel: K) -> K::Output {
        kernel.run::<Self>()
    }

    /// The same float in every lane.
    fn f(x: f32) -> Self::F;
    /// The first `N` floats of a slice.
    fn load(from: &[f32]) -> Self::F;
    /// Writes the first `N` floats of a slice.
    fn store(v: Self::F, to: &mut [f32]);
    /// Square root.
    fn sqrt(v: Self::F) -> Self::F;
    /// Absolute value.
    fn abs(v: Self::F) -> Self::F;
    /// `if a > b { a } else { b }`.
    fn max(a: Self::F, b: Self::F) -> Self::F;
    /// `if a < b { a } else { b }`.
    fn min(a: Self::F, b: Self::F) -> Self::F;
    /// A lane with the smallest value; none may be NaN.
    fn min_lane(v: Self::F) -> u32;
    /// `a * b + c`, rounded once or twice, depending on the back end: for bounds with slack, never for the image.
    fn fused(a: Self::F, b: Self::F, c: Self::F) -> Self::F;
    /// The largest whole number that is not greater, for |v| < 2^31.
    fn floor(v: Self::F) -> Self::F;
    /// `a < b`, false for NaN.
    fn lt(a: Self::F, b: Self::F) -> Self::M;
    /// `a <= b`, false for NaN.
    fn le(a: Self::F, b: Self::F) -> Self::M;
    /// To a whole number toward zero, for values that an `i32` holds.
    fn truncate(v: Self::F) -> Self::U;
    /// To the nearest float, for words below 2^31.
    fn to_float(v: Self::U) -> Self::F;
    /// The bits of the floats.
    fn bits(v: Self::F) -> Self::U;
    /// Floats of these bits.
    fn from_bits(v: Self::U) -> Self::F;
    /// `if m { a } else { b }`.
    fn select(m: Self::M, a: Self::F, b: Self::F) -> Self::F;

    /// The same word in every lane.
    fn u(x: u32) -> Self::U;
    /// The first `N` words of a slice.
    fn load_u(from: &[u32]) -> Self::U;
    /// Writes the first `N` words of a slice.
    fn store_u(v: Self::U, to: &mut [u32]);
    /// `v << K`.
    fn shl<const K: i32>(v: Self::U) -> Self::U;
    /// `v >> K`.
    fn shr<const K: i32>(v: Self::U) -> Self::U;
    /// `v >> by`, lane by lane, for shifts below 32.
    fn shr_by(v: Self::U, by: Self::U) -> Self::U;
    /// `a == b`.
    fn eq(a: Self::U, b: Self::U) -> Self::M;
    /// `if m { a + b } else { a }`.
    fn add_where(m: Self::M, a: Self::U, b: Self::U) -> Self::U;
    /// The smaller of two unsigned words.
    fn min_u(a: Self::U, b: Self::U) -> Self::U;
    /// `if m { a } else { b }`.
    fn select_u(m: Self::M, a: Self::U, b: Self::U) -> Self::U;

    /// Bit k is lane k.
    fn mask_bits(m: Self::M) -> u32;
    /// Lane k is bit k.
    fn mask_from_bits(bits: u32) -> Self::M;

    /// Lane k is `table[index[k]]`; every index is first reduced modulo the length, a power of two.
    fn gather_u(table: &[u32], index: Self::U) -> Self::U;
    /// Eight columns of a table: lane k of result j is word j of row `index[k]`.
    fn gather_rows(table: &[Row], index: &[u32]) -> [Self::F; 8];
    /// The inverse of [`Lanes::gather_rows`]: row k of `to` is lane k of the eight vectors.
    fn transpose(columns: [Self::F; 8], to: &mut [Row]);
    /// `N` consecutive rows as eight columns.
    fn load_rows(rows: &[Row]) -> [Self::F; 8];
    /// Writes the lanes where `m` is true to the start of `to`, in order. It writes all `N` elements; those that follow
    /// the selected lanes hold anything.
    fn compress(m: Self::M, v: Self::F, to: &mut [f32]);
    /// As [`Lanes::compress`], of words.
    fn compress_u(m: Self::M, v: Self::U, to: &mut [u32]);

    /// Lane k is k.
    #[inline(always)]
    fn iota() -> Self::U {
        const COUNT: [u32; MOST_LANES] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];
        Self::load_u(&COUNT)
    }

    /// True if any lane is true.
    #[inline(always)]
    fn any(m: Self::M) -> bool {
        Self::mask_bits(m) != 0
    }

    /// True in the first `n` lanes; in all, if `n` is `N` or more.
    #[inline(always)]
    fn first(n: usize) -> Self::M {
        Self::mask_from_bits(if n >= Self::N { u32::MAX } else { (1 << n) - 1 })
    }
}

/// Panics unless each of the first `L::N` numbers is one of a table of so many rows. One check of all numbers takes fewer
/// instructions than one per row.
#[inline(always)]
pub(crate) fn assert_within<L: Lanes>(index: &[u32], rows: usize) {
    assert!(rows > 0, "a row of an empty table");
    let last = L::u(u32::try_from(rows - 1).unwrap_or(u32::MAX));
    let index = L::load_u(index);
    assert!(!L::any(!L::eq(L::min_u(index, last), index)), "a row beyond the end of a table");
}
