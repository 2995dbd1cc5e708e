//! The maps of `reference::sampling` from random numbers to directions and points, on any lanes.

use crate::vector::{F, Vector, callable};
use lanes::Lanes;
use std::f32::consts::FRAC_PI_2;

/// `(sin, cos)` of `2 pi u`.
#[inline(always)]
fn sincos_turn<L: Lanes>(u: L::F) -> (L::F, L::F) {
    let quarters = u * L::f(4.0);
    let quadrant = L::truncate(quarters + L::f(0.5));
    let x = (quarters - L::to_float(quadrant)) * L::f(FRAC_PI_2);
    let x2 = x * x;
    let sine = x + x * x2 * (L::f(-1.666_665_5e-1) + x2 * (L::f(8.332_161e-3) + x2 * L::f(-1.951_529_6e-4)));
    let cosine = L::f(1.0) - L::f(0.5) * x2
        + x2 * x2 * (L::f(4.166_664_6e-2) + x2 * (L::f(-1.388_731_6e-3) + x2 * L::f(2.443_315_7e-5)));
    let odd = L::eq(quadrant & L::u(1), L::u(1));
    let (s, c) = (L::select(odd, cosine, sine), L::select(odd, sine, cosine));
    // Bit 1 of the quadrant, moved to the sign.
    let negate_s = L::shl::<30>(quadrant & L::u(2));
    let negate_c = L::shl::<30>((quadrant + L::u(1)) & L::u(2));
    (L::from_bits(L::bits(s) ^ negate_s), L::from_bits(L::bits(c) ^ negate_c))
}

callable! {
    /// Points of the unit sphere.
    pub(crate) fn uniform_sphere<V: Vector>(u: F<V>, v: F<V>) -> V {
        let (sin, cos) = sincos_turn::<V::L>(v);
        let r = V::L::f(2.0) * V::L::sqrt(u * (V::L::f(1.0) - u));
        V::new(r * cos, r * sin, V::L::f(1.0) - V::L::f(2.0) * u)
    }

    /// Unit directions about the unit normals `n`, with a density proportional to the cosine.
    pub(crate) fn cosine_hemisphere<V: Vector>(n: V, u: F<V>, v: F<V>) -> V {
        let w = n + uniform_sphere::<V>(u, v);
        let length_squared = w.dot(w);
        let direction = w.scale(V::L::f(1.0) / V::L::sqrt(length_squared));
        V::select(V::L::lt(length_squared, V::L::f(1e-10)), n, direction)
    }

    /// Unit directions in the cones about the unit `axis`, and `1 - cos` of their angles to it.
    pub(crate) fn uniform_cone<V: Vector>(axis: V, height: F<V>, u: F<V>, v: F<V>) -> (V, F<V>) {
        let (sin, cos) = sincos_turn::<V::L>(v);
        let h = u * height;
        let r = V::L::sqrt(h * (V::L::f(2.0) - h));
        let (s, t) = frame::<V>(axis);
        (s.scale(r * cos) + t.scale(r * sin) + axis.scale(V::L::f(1.0) - h), h)
    }

    /// Points of the unit disk.
    pub(crate) fn uniform_disk<V: Vector>(u: F<V>, v: F<V>) -> (F<V>, F<V>) {
        let (sin, cos) = sincos_turn::<V::L>(v);
        let r = V::L::sqrt(u);
        (r * cos, r * sin)
    }

    /// Two unit vectors that form a right-handed frame with the unit vectors `n`.
    pub(crate) fn frame<V: Vector>(n: V) -> (V, V) {
        let one = V::L::f(1.0);
        let [x, y, z] = n.xyz();
        let sign = V::L::from_bits(V::L::bits(one) | (V::L::bits(z) & V::L::u(0x8000_0000)));
        let a = V::L::f(-1.0) / (sign + z);
        let b = x * y * a;
        (V::new(one + sign * (x * x * a), sign * b, -sign * x), V::new(b, sign + y * y * a, -y))
    }

    /// Vectors scaled to unit length.
    pub(crate) fn unit<V: Vector>(v: V) -> V {
        v.scale(V::L::f(1.0) / V::L::sqrt(v.dot(v)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::one::One;
    use crate::vector::Inlined;

    /// Where the point of the sphere and the normal cancel out, nothing is left to be scaled to unit length.
    #[test]
    fn a_point_opposite_to_the_normal_gives_the_normal() {
        type V = Inlined<One>;
        let normal = V::new(0.0, 0.0, 1.0);
        assert_eq!(uniform_sphere::<V>(1.0, 0.0).xyz(), [0.0, 0.0, -1.0]);
        assert_eq!(cosine_hemisphere::<V>(normal, 1.0, 0.0).xyz(), [0.0, 0.0, 1.0]);
    }
}
