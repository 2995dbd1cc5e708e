//! Lanes in plain Rust: the definition of every operation, and the back end for processors without AVX2.

use crate::operations::{Kernel, Lanes};
use crate::row::Row;
use std::array::from_fn;
use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Sub};

/// The back end in plain Rust, of `N` lanes.
#[derive(Clone, Copy, Debug)]
pub struct Emulated<const N: usize = 8>;

/// `f32` lanes.
#[derive(Clone, Copy, Debug)]
pub struct F<const N: usize>([f32; N]);
/// `u32` lanes.
#[derive(Clone, Copy, Debug)]
pub struct U<const N: usize>([u32; N]);
/// Truth values.
#[derive(Clone, Copy, Debug)]
pub struct M<const N: usize>([bool; N]);

macro_rules! lanewise {
    ($($op:ident $method:ident $on:ident $lane:expr;)*) => {$(
        impl<const N: usize> $op for $on<N> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(from_fn(|k| $lane(self.0[k], other.0[k])))
            }
        }
    )*};
}

lanewise! {
    Add add F |a: f32, b: f32| a + b;
    Sub sub F |a: f32, b: f32| a - b;
    Mul mul F |a: f32, b: f32| a * b;
    Div div F |a: f32, b: f32| a / b;
    Add add U u32::wrapping_add;
    Mul mul U u32::wrapping_mul;
    BitAnd bitand U |a: u32, b: u32| a & b;
    BitOr bitor U |a: u32, b: u32| a | b;
    BitXor bitxor U |a: u32, b: u32| a ^ b;
    BitAnd bitand M |a: bool, b: bool| a & b;
    BitOr bitor M |a: bool, b: bool| a | b;
}

impl<const N: usize> Neg for F<N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(self.0.map(|a| -a))
    }
}

impl<const N: usize> Not for M<N> {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self(self.0.map(|a| !a))
    }
}

impl<const N: usize> Lanes for Emulated<N> {
    const N: usize = N;
    type Eight = Emulated<8>;
    type Pair = Self;
    type F = F<N>;
    type U = U<N>;
    type M = M<N>;

    #[inline(never)]
    fn call<K: Kernel>(kernel: K) -> K::Output {
        kernel.run::<Self>()
    }
    #[inline(always)]
    fn f(x: f32) -> F<N> {
        F([x; N])
    }
    #[inline(always)]
    fn load(from: &[f32]) -> F<N> {
        F(from_fn(|k| from[k]))
    }
    #[inline(always)]
    fn store(v: F<N>, to: &mut [f32]) {
        to[..N].copy_from_slice(&v.0);
    }
    #[inline(always)]
    fn sqrt(v: F<N>) -> F<N> {
        F(v.0.map(f32::sqrt))
    }
    #[inline(always)]
    fn abs(v: F<N>) -> F<N> {
        F(v.0.map(f32::abs))
    }
    #[inline(always)]
    fn max(a: F<N>, b: F<N>) -> F<N> {
        F(from_fn(|k| if a.0[k] > b.0[k] { a.0[k] } else { b.0[k] }))
    }
    #[inline(always)]
    fn min(a: F<N>, b: F<N>) -> F<N> {
        F(from_fn(|k| if a.0[k] < b.0[k] { a.0[k] } else { b.0[k] }))
    }
    #[inline(always)]
    fn min_lane(v: F<N>) -> u32 {
        (1..N).fold(0, |best, k| if v.0[k] < v.0[best] { k } else { best }) as u32
    }
    #[inline(always)]
    fn fused(a: F<N>, b: F<N>, c: F<N>) -> F<N> {
        a * b + c
    }
    #[inline(always)]
    fn floor(v: F<N>) -> F<N> {
        F(v.0.map(f32::floor))
    }
    #[inline(always)]
    fn lt(a: F<N>, b: F<N>) -> M<N> {
        M(from_fn(|k| a.0[k] < b.0[k]))
    }
    #[inline(always)]
    fn le(a: F<N>, b: F<N>) -> M<N> {
        M(from_fn(|k| a.0[k] <= b.0[k]))
    }
    #[inline(always)]
    fn truncate(v: F<N>) -> U<N> {
        U(v.0.map(|a| a as i32 as u32))
    }
    #[inline(always)]
    fn to_float(v: U<N>) -> F<N> {
        F(v.0.map(|a| a as i32 as f32))
    }
    #[inline(always)]
    fn bits(v: F<N>) -> U<N> {
        U(v.0.map(f32::to_bits))
    }
    #[inline(always)]
    fn from_bits(v: U<N>) -> F<N> {
        F(v.0.map(f32::from_bits))
    }
    #[inline(always)]
    fn select(m: M<N>, a: F<N>, b: F<N>) -> F<N> {
        F(from_fn(|k| if m.0[k] { a.0[k] } else { b.0[k] }))
    }
    #[inline(always)]
    fn u(x: u32) -> U<N> {
        U([x; N])
    }
    #[inline(always)]
    fn load_u(from: &[u32]) -> U<N> {
        U(from_fn(|k| from[k]))
    }
    #[inline(always)]
    fn store_u(v: U<N>, to: &mut [u32]) {
        to[..N].copy_from_slice(&v.0);
    }
    #[inline(always)]
    fn shl<const K: i32>(v: U<N>) -> U<N> {
        U(v.0.map(|a| a << K))
    }
    #[inline(always)]
    fn shr<const K: i32>(v: U<N>) -> U<N> {
        U(v.0.map(|a| a >> K))
    }
    #[inline(always)]
    fn shr_by(v: U<N>, by: U<N>) -> U<N> {
        U(from_fn(|k| v.0[k] >> by.0[k]))
    }
    #[inline(always)]
    fn eq(a: U<N>, b: U<N>) -> M<N> {
        M(from_fn(|k| a.0[k] == b.0[k]))
    }
    #[inline(always)]
    fn add_where(m: M<N>, a: U<N>, b: U<N>) -> U<N> {
        U(from_fn(|k| if m.0[k] { a.0[k].wrapping_add(b.0[k]) } else { a.0[k] }))
    }
    #[inline(always)]
    fn min_u(a: U<N>, b: U<N>) -> U<N> {
        U(from_fn(|k| a.0[k].min(b.0[k])))
    }
    #[inline(always)]
    fn select_u(m: M<N>, a: U<N>, b: U<N>) -> U<N> {
        U(from_fn(|k| if m.0[k] { a.0[k] } else { b.0[k] }))
    }
    #[inline(always)]
    fn mask_bits(m: M<N>) -> u32 {
        m.0.iter().enumerate().map(|(k, &set)| u32::from(set) << k).sum()
    }
    #[inline(always)]
    fn mask_from_bits(bits: u32) -> M<N> {
        M(from_fn(|k| (bits >> k) & 1 == 1))
    }
    #[inline(always)]
    fn gather_u(table: &[u32], index: U<N>) -> U<N> {
        assert!(table.len().is_power_of_two());
        U(index.0.map(|i| table[i as usize & (table.len() - 1)]))
    }
    #[inline(always)]
    fn gather_rows(table: &[Row], index: &[u32]) -> [F<N>; 8] {
        from_fn(|column| F(from_fn(|k| table[index[k] as usize].0[column])))
    }
    #[inline(always)]
    fn transpose(columns: [F<N>; 8], to: &mut [Row]) {
        for (k, row) in to[..N].iter_mut().enumerate() {
            *row = Row(from_fn(|column| columns[column].0[k]));
        }
    }
    #[inline(always)]
    fn load_rows(rows: &[Row]) -> [F<N>; 8] {
        from_fn(|column| F(from_fn(|k| rows[k].0[column])))
    }
    #[inline(always)]
    fn compress(m: M<N>, v: F<N>, to: &mut [f32]) {
        let mut rest = to[..N].iter_mut();
        for (value, _) in v.0.iter().zip(m.0).filter(|(_, set)| *set) {
            if let Some(place) = rest.next() {
                *place = *value;
            }
        }
    }
    #[inline(always)]
    fn compress_u(m: M<N>, v: U<N>, to: &mut [u32]) {
        let mut rest = to[..N].iter_mut();
        for (value, _) in v.0.iter().zip(m.0).filter(|(_, set)| *set) {
            if let Some(place) = rest.next() {
                *place = *value;
            }
        }
    }
}
