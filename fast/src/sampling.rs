//! Random numbers, and the sampling maps of `reference::sampling`, in lanes. Functions without a comment are the
//! reference's of the same name.

use lanes::{Lanes, V3};
use scene::rng::{HASH_MULTIPLIERS, STATE_FOR_ZERO, StreamKey, UNIT};
use std::f32::consts::FRAC_PI_2;

/// The start states of streams `index`.
#[inline(always)]
pub(crate) fn stream_state<L: Lanes>(key: StreamKey, index: L::U) -> L::U {
    let x = index ^ L::u(key.before);
    let x = (x ^ L::shr::<16>(x)) * L::u(HASH_MULTIPLIERS[0]);
    let x = x + L::u(key.between);
    let x = (x ^ L::shr::<15>(x)) * L::u(HASH_MULTIPLIERS[1]);
    let x = x ^ L::shr::<15>(x);
    L::select_u(L::eq(x, L::u(0)), L::u(STATE_FOR_ZERO), x)
}

/// Steps the streams and returns their next uniform numbers.
#[inline(always)]
pub(crate) fn next_uniform<L: Lanes>(state: &mut L::U) -> L::F {
    let x = *state;
    let x = x ^ L::shl::<13>(x);
    let x = x ^ L::shr::<17>(x);
    let x = x ^ L::shl::<5>(x);
    *state = x;
    unit_float::<L>(x)
}

/// Steps the streams where `m` is true, and returns their next uniform numbers; elsewhere anything.
#[inline(always)]
pub(crate) fn next_where<L: Lanes>(m: L::M, stream: &mut L::U) -> L::F {
    let mut next = *stream;
    let number = next_uniform::<L>(&mut next);
    *stream = L::select_u(m, next, *stream);
    number
}

/// The top 24 bits as floats in [0, 1).
#[inline(always)]
pub(crate) fn unit_float<L: Lanes>(bits: L::U) -> L::F {
    L::to_float(L::shr::<8>(bits)) * L::f(UNIT)
}

#[inline(always)]
pub(crate) fn sincos_turn<L: Lanes>(u: L::F) -> (L::F, L::F) {
    let quarters = u * L::f(4.0);
    let quadrant = L::truncate(quarters + L::f(0.5));
    let x = (quarters - L::to_float(quadrant)) * L::f(FRAC_PI_2);
    let x2 = x * x;
    let sine = x + x * x2 * (L::f(-1.666_665_5e-1) + x2 * (L::f(8.332_161e-3) + x2 * L::f(-1.951_529_6e-4)));
    let cosine = L::f(1.0) - L::f(0.5) * x2
        + x2 * x2 * (L::f(4.166_664_6e-2) + x2 * (L::f(-1.388_731_6e-3) + x2 * L::f(2.443_315_7e-5)));
    let odd = L::eq(quadrant & L::u(1), L::u(1));
    let s = L::select(odd, cosine, sine);
    let c = L::select(odd, sine, cosine);
    // Bit 1 of the quadrant, moved to the sign.
    let negate_s = L::shl::<30>(quadrant & L::u(2));
    let negate_c = L::shl::<30>((quadrant + L::u(1)) & L::u(2));
    (L::from_bits(L::bits(s) ^ negate_s), L::from_bits(L::bits(c) ^ negate_c))
}

#[inline(always)]
pub(crate) fn uniform_sphere<L: Lanes>(u: L::F, v: L::F) -> V3<L> {
    let (sin, cos) = sincos_turn::<L>(v);
    let r = L::f(2.0) * L::sqrt(u * (L::f(1.0) - u));
    V3::new(r * cos, r * sin, L::f(1.0) - L::f(2.0) * u)
}

#[inline(always)]
pub(crate) fn cosine_hemisphere<L: Lanes>(n: V3<L>, u: L::F, v: L::F) -> V3<L> {
    let w = n + uniform_sphere::<L>(u, v);
    let length_squared = w.dot(w);
    let direction = w.scale(L::f(1.0) / L::sqrt(length_squared));
    V3::select(L::lt(length_squared, L::f(1e-10)), n, direction)
}

#[inline(always)]
pub(crate) fn uniform_cone<L: Lanes>(axis: V3<L>, height: L::F, u: L::F, v: L::F) -> (V3<L>, L::F) {
    let (sin, cos) = sincos_turn::<L>(v);
    let h = u * height;
    let r = L::sqrt(h * (L::f(2.0) - h));
    let (s, t) = frame(axis);
    (s.scale(r * cos) + t.scale(r * sin) + axis.scale(L::f(1.0) - h), h)
}

#[inline(always)]
pub(crate) fn uniform_disk<L: Lanes>(u: L::F, v: L::F) -> (L::F, L::F) {
    let (sin, cos) = sincos_turn::<L>(v);
    let r = L::sqrt(u);
    (r * cos, r * sin)
}

#[inline(always)]
pub(crate) fn frame<L: Lanes>(n: V3<L>) -> (V3<L>, V3<L>) {
    let one = L::f(1.0);
    let sign = L::from_bits(L::bits(one) | (L::bits(n.z) & L::u(0x8000_0000)));
    let a = L::f(-1.0) / (sign + n.z);
    let b = n.x * n.y * a;
    (V3::new(one + sign * (n.x * n.x * a), sign * b, -sign * n.x), V3::new(b, sign + n.y * n.y * a, -n.y))
}

#[inline(always)]
pub(crate) fn unit<L: Lanes>(v: V3<L>) -> V3<L> {
    v.scale(L::f(1.0) / L::sqrt(v.dot(v)))
}
