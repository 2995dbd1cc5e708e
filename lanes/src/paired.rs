//! Two vectors as one of twice the lanes.
//!
//! An operation takes a processor several cycles, of which it could begin a few others in each. A kernel in which most
//! operations need the result of the one before, such as the descent through the lamps, leaves that room empty; and a packet
//! is longer than what a processor looks ahead, so the next packet does not fill it. Two vectors in one do: what one needs never
//! waits for the other. Kernels that have enough to do by themselves lose, as there are too few registers for both.

use crate::operations::{Kernel, Lanes};
use crate::row::Row;
use std::marker::PhantomData;
use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Sub};

/// The back end: twice the lanes of `L`, the first half in the first vector.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Paired<L>(PhantomData<L>);

/// `f32` lanes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct F<L: Lanes>(L::F, L::F);
/// `u32` lanes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct U<L: Lanes>(L::U, L::U);
/// Truth values.
#[derive(Clone, Copy, Debug)]
pub(crate) struct M<L: Lanes>(L::M, L::M);

macro_rules! binary {
    ($($op:ident $method:ident $on:ident;)*) => {$(
        impl<L: Lanes> $op for $on<L> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self($op::$method(self.0, other.0), $op::$method(self.1, other.1))
            }
        }
    )*};
}

binary! {
    Add add F;
    Sub sub F;
    Mul mul F;
    Div div F;
    Add add U;
    Mul mul U;
    BitAnd bitand U;
    BitOr bitor U;
    BitXor bitxor U;
    BitAnd bitand M;
    BitOr bitor M;
}

impl<L: Lanes> Neg for F<L> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0, -self.1)
    }
}

impl<L: Lanes> Not for M<L> {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self(!self.0, !self.1)
    }
}

/// Operations of each half by itself.
macro_rules! by_halves {
    ($(fn $name:ident($($argument:ident: $of:ident),*) -> $result:ident;)*) => {$(
        #[inline(always)]
        fn $name($($argument: $of<L>),*) -> $result<L> {
            $result(L::$name($($argument.0),*), L::$name($($argument.1),*))
        }
    )*};
}

/// A part of a kernel that is called, on two vectors.
struct OnPaired<K>(K);

impl<K: Kernel> Kernel for OnPaired<K> {
    type Output = K::Output;
    #[inline(always)]
    fn run<L: Lanes>(self) -> K::Output {
        self.0.run::<Paired<L>>()
    }
}

impl<L: Lanes> Lanes for Paired<L> {
    const N: usize = 2 * L::N;
    type Eight = L::Eight;
    type Pair = Self;
    type F = F<L>;
    type U = U<L>;
    type M = M<L>;

    by_halves! {
        fn sqrt(v: F) -> F;
        fn abs(v: F) -> F;
        fn max(a: F, b: F) -> F;
        fn min(a: F, b: F) -> F;
        fn fused(a: F, b: F, c: F) -> F;
        fn floor(v: F) -> F;
        fn lt(a: F, b: F) -> M;
        fn le(a: F, b: F) -> M;
        fn truncate(v: F) -> U;
        fn to_float(v: U) -> F;
        fn bits(v: F) -> U;
        fn from_bits(v: U) -> F;
        fn select(m: M, a: F, b: F) -> F;
        fn shr_by(v: U, by: U) -> U;
        fn eq(a: U, b: U) -> M;
        fn add_where(m: M, a: U, b: U) -> U;
        fn min_u(a: U, b: U) -> U;
        fn select_u(m: M, a: U, b: U) -> U;
    }

    #[inline(always)]
    fn call<K: Kernel>(kernel: K) -> K::Output {
        L::call(OnPaired(kernel))
    }
    #[inline(always)]
    fn f(x: f32) -> F<L> {
        F(L::f(x), L::f(x))
    }
    #[inline(always)]
    fn load(from: &[f32]) -> F<L> {
        let from = &from[..Self::N];
        F(L::load(from), L::load(&from[L::N..]))
    }
    #[inline(always)]
    fn store(v: F<L>, to: &mut [f32]) {
        let to = &mut to[..Self::N];
        L::store(v.0, to);
        L::store(v.1, &mut to[L::N..]);
    }
    #[inline(always)]
    fn min_lane(v: F<L>) -> u32 {
        let lane = L::min_lane(L::min(v.0, v.1));
        let is_first = L::mask_bits(L::le(v.0, v.1)) >> lane & 1 == 1;
        if is_first { lane } else { lane + L::N as u32 }
    }
    #[inline(always)]
    fn u(x: u32) -> U<L> {
        U(L::u(x), L::u(x))
    }
    #[inline(always)]
    fn load_u(from: &[u32]) -> U<L> {
        let from = &from[..Self::N];
        U(L::load_u(from), L::load_u(&from[L::N..]))
    }
    #[inline(always)]
    fn store_u(v: U<L>, to: &mut [u32]) {
        let to = &mut to[..Self::N];
        L::store_u(v.0, to);
        L::store_u(v.1, &mut to[L::N..]);
    }
    #[inline(always)]
    fn shl<const K: i32>(v: U<L>) -> U<L> {
        U(L::shl::<K>(v.0), L::shl::<K>(v.1))
    }
    #[inline(always)]
    fn shr<const K: i32>(v: U<L>) -> U<L> {
        U(L::shr::<K>(v.0), L::shr::<K>(v.1))
    }
    #[inline(always)]
    fn mask_bits(m: M<L>) -> u32 {
        L::mask_bits(m.0) | L::mask_bits(m.1) << L::N
    }
    #[inline(always)]
    fn mask_from_bits(bits: u32) -> M<L> {
        M(L::mask_from_bits(bits), L::mask_from_bits(bits >> L::N))
    }
    #[inline(always)]
    fn first(n: usize) -> M<L> {
        M(L::first(n), L::first(n.saturating_sub(L::N)))
    }
    #[inline(always)]
    fn any(m: M<L>) -> bool {
        L::any(m.0 | m.1)
    }
    #[inline(always)]
    fn gather_u(table: &[u32], index: U<L>) -> U<L> {
        U(L::gather_u(table, index.0), L::gather_u(table, index.1))
    }
    #[inline(always)]
    fn gather_rows(table: &[Row], index: &[u32]) -> [F<L>; 8] {
        let index = &index[..Self::N];
        beside::<L>(L::gather_rows(table, index), L::gather_rows(table, &index[L::N..]))
    }
    #[inline(always)]
    fn transpose(columns: [F<L>; 8], to: &mut [Row]) {
        let to = &mut to[..Self::N];
        let [a, b, c, d, e, f, g, h] = columns;
        L::transpose([a.0, b.0, c.0, d.0, e.0, f.0, g.0, h.0], to);
        L::transpose([a.1, b.1, c.1, d.1, e.1, f.1, g.1, h.1], &mut to[L::N..]);
    }
    #[inline(always)]
    fn load_rows(rows: &[Row]) -> [F<L>; 8] {
        let rows = &rows[..Self::N];
        beside::<L>(L::load_rows(rows), L::load_rows(&rows[L::N..]))
    }
    #[inline(always)]
    fn compress(m: M<L>, v: F<L>, to: &mut [f32]) {
        L::compress(m.0, v.0, to);
        L::compress(m.1, v.1, &mut to[L::mask_bits(m.0).count_ones() as usize..]);
    }
    #[inline(always)]
    fn compress_u(m: M<L>, v: U<L>, to: &mut [u32]) {
        L::compress_u(m.0, v.0, to);
        L::compress_u(m.1, v.1, &mut to[L::mask_bits(m.0).count_ones() as usize..]);
    }
}

/// Columns whose lanes follow those of others.
#[inline(always)]
fn beside<L: Lanes>(first: [L::F; 8], second: [L::F; 8]) -> [F<L>; 8] {
    let ([a, b, c, d, e, f, g, h], [i, j, k, l, m, n, o, p]) = (first, second);
    [F(a, i), F(b, j), F(c, k), F(d, l), F(e, m), F(f, n), F(g, o), F(h, p)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::emulated::Emulated;

    const N: usize = 16;

    /// What every operation makes of these words, which are floats as well.
    fn results<L: Lanes>(a: &[u32; N], b: &[u32; N], bits: u32) -> Vec<u32> {
        let mut words = Vec::new();
        let mut tell = |v: L::U| {
            let mut lanes = [0; N];
            L::store_u(v, &mut lanes);
            words.extend(lanes);
        };
        let (u, v, m) = (L::load_u(a), L::load_u(b), L::mask_from_bits(bits));
        let [p, q] = [a, b].map(|words| L::load(&words.map(|word| f32::from_bits(word & 0x4fff_ffff))));
        for x in [p + q, p - q, p * q, p / q, -p, L::sqrt(p), L::abs(-p), L::max(p, q), L::min(p, q)] {
            tell(L::bits(x));
        }
        for x in [L::fused(p, q, p), L::floor(p), L::select(m, p, q), L::f(1.5), L::from_bits(u)] {
            tell(L::bits(x));
        }
        let small = L::min(p, L::f(1e9));
        for x in [u + v, u * v, u & v, u | v, u ^ v, L::shl::<3>(u), L::shr::<5>(u), L::truncate(small)] {
            tell(x);
        }
        tell(L::bits(L::to_float(L::shr::<1>(u))));
        tell(L::shr_by(u, v & L::u(31)));
        for x in [L::add_where(m, u, v), L::min_u(u, v), L::select_u(m, u, v), L::u(7), L::iota()] {
            tell(x);
        }
        tell(L::gather_u(b, u));
        for m in
            [m, !m, m & L::lt(p, q), m | L::le(p, q), L::eq(u, v), L::first(5), L::first(11), L::first(99)]
        {
            words.extend([L::mask_bits(m), u32::from(L::any(m))]);
        }
        words.push(L::min_lane(p));
        words.extend(in_memory::<L>(p, u, m));
        words
    }

    /// The same of operations that read and write rows, and that compress.
    fn in_memory<L: Lanes>(p: L::F, u: L::U, m: L::M) -> Vec<u32> {
        let rows: [Row; N] =
            std::array::from_fn(|k| Row(std::array::from_fn(|column| (k * 8 + column) as f32)));
        let index: [u32; N] = std::array::from_fn(|k| (k * 5 % N) as u32);
        let mut turned = [Row::default(); N];
        L::transpose(L::gather_rows(&rows, &index), &mut turned);
        let mut floats: Vec<f32> = turned.iter().flat_map(|row| row.0).collect();
        for column in L::load_rows(&rows) {
            let mut lanes = [0.0; N];
            L::store(column, &mut lanes);
            floats.extend(lanes);
        }
        let (mut compressed, mut compressed_words) = ([0.0; N], [0; N]);
        L::compress(m, p, &mut compressed);
        L::compress_u(m, u, &mut compressed_words);
        let count = L::mask_bits(m).count_ones() as usize;
        floats.extend(&compressed[..count]);
        floats.into_iter().map(f32::to_bits).chain(compressed_words[..count].iter().copied()).collect()
    }

    #[test]
    fn pairs_are_vectors_of_twice_the_lanes() {
        assert_eq!(Paired::<Emulated<8>>::N, N);
        for round in 0..500_u32 {
            let word = |k: u32| (round * 97 + k).wrapping_mul(0x9e37_79b9) ^ round.wrapping_mul(0x85eb_ca6b);
            let (a, mut b) =
                (std::array::from_fn(|k| word(k as u32)), std::array::from_fn(|k| word(k as u32 + 16)));
            b[round as usize % N] = a[round as usize % N];
            let bits = word(40) >> 16;
            assert_eq!(results::<Paired<Emulated<8>>>(&a, &b, bits), results::<Emulated<16>>(&a, &b, bits));
        }
    }

    /// A part that is called has the lanes of its kernel.
    #[test]
    fn parts_of_pairs_run_on_pairs() {
        struct Count;
        impl Kernel for Count {
            type Output = usize;
            #[inline(always)]
            fn run<L: Lanes>(self) -> usize {
                L::N
            }
        }
        assert_eq!(Paired::<Emulated<8>>::call(Count), N);
    }
}
