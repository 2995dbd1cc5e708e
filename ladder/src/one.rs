//! Vectors of one lane, with which scalar rows use the same trait as vertical ones. A mask is a `bool`, and the test
//! whether any lane is left is an ordinary branch.

use lanes::{Emulated, Lanes, Row};
use std::num::Wrapping;

/// The lanes of scalar rows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct One;

impl Lanes for One {
    const N: usize = 1;
    type Eight = Emulated;
    type Pair = Self;
    type F = f32;
    type U = Wrapping<u32>;
    type M = bool;

    #[inline(always)]
    fn f(x: f32) -> f32 {
        x
    }
    #[inline(always)]
    fn load(from: &[f32]) -> f32 {
        from[0]
    }
    #[inline(always)]
    fn store(v: f32, to: &mut [f32]) {
        to[0] = v;
    }
    #[inline(always)]
    fn sqrt(v: f32) -> f32 {
        v.sqrt()
    }
    #[inline(always)]
    fn abs(v: f32) -> f32 {
        v.abs()
    }
    #[inline(always)]
    fn max(a: f32, b: f32) -> f32 {
        if a > b { a } else { b }
    }
    #[inline(always)]
    fn min(a: f32, b: f32) -> f32 {
        if a < b { a } else { b }
    }
    #[inline(always)]
    fn min_lane(_: f32) -> u32 {
        0
    }
    #[inline(always)]
    fn fused(a: f32, b: f32, c: f32) -> f32 {
        a * b + c
    }
    #[inline(always)]
    fn floor(v: f32) -> f32 {
        // Without the processor's instruction enabled, the standard function would be a call.
        let whole = v as i32 as f32;
        if whole > v { whole - 1.0 } else { whole }
    }
    #[inline(always)]
    fn lt(a: f32, b: f32) -> bool {
        a < b
    }
    #[inline(always)]
    fn le(a: f32, b: f32) -> bool {
        a <= b
    }
    #[inline(always)]
    fn truncate(v: f32) -> Self::U {
        Wrapping(v as i32 as u32)
    }
    #[inline(always)]
    fn to_float(v: Self::U) -> f32 {
        v.0 as i32 as f32
    }
    #[inline(always)]
    fn bits(v: f32) -> Self::U {
        Wrapping(v.to_bits())
    }
    #[inline(always)]
    fn from_bits(v: Self::U) -> f32 {
        f32::from_bits(v.0)
    }
    #[inline(always)]
    fn select(m: bool, a: f32, b: f32) -> f32 {
        if m { a } else { b }
    }
    #[inline(always)]
    fn u(x: u32) -> Self::U {
        Wrapping(x)
    }
    #[inline(always)]
    fn load_u(from: &[u32]) -> Self::U {
        Wrapping(from[0])
    }
    #[inline(always)]
    fn store_u(v: Self::U, to: &mut [u32]) {
        to[0] = v.0;
    }
    #[inline(always)]
    fn shl<const K: i32>(v: Self::U) -> Self::U {
        Wrapping(v.0 << K)
    }
    #[inline(always)]
    fn shr<const K: i32>(v: Self::U) -> Self::U {
        Wrapping(v.0 >> K)
    }
    #[inline(always)]
    fn shr_by(v: Self::U, by: Self::U) -> Self::U {
        Wrapping(v.0 >> by.0)
    }
    #[inline(always)]
    fn eq(a: Self::U, b: Self::U) -> bool {
        a == b
    }
    #[inline(always)]
    fn add_where(m: bool, a: Self::U, b: Self::U) -> Self::U {
        if m { a + b } else { a }
    }
    #[inline(always)]
    fn min_u(a: Self::U, b: Self::U) -> Self::U {
        a.min(b)
    }
    #[inline(always)]
    fn select_u(m: bool, a: Self::U, b: Self::U) -> Self::U {
        if m { a } else { b }
    }
    #[inline(always)]
    fn mask_bits(m: bool) -> u32 {
        u32::from(m)
    }
    #[inline(always)]
    fn mask_from_bits(bits: u32) -> bool {
        bits & 1 == 1
    }
    #[inline(always)]
    fn gather_u(table: &[u32], index: Self::U) -> Self::U {
        Wrapping(table[index.0 as usize & (table.len() - 1)])
    }
    #[inline(always)]
    fn gather_rows(table: &[Row], index: &[u32]) -> [f32; 8] {
        table[index[0] as usize].0
    }
    #[inline(always)]
    fn transpose(columns: [f32; 8], to: &mut [Row]) {
        to[0] = Row(columns);
    }
    #[inline(always)]
    fn load_rows(rows: &[Row]) -> [f32; 8] {
        rows[0].0
    }
    #[inline(always)]
    fn compress(m: bool, v: f32, to: &mut [f32]) {
        if m {
            to[0] = v;
        }
    }
    #[inline(always)]
    fn compress_u(m: bool, v: Self::U, to: &mut [u32]) {
        if m {
            to[0] = v.0;
        }
    }
}
