//! Reflection and refraction as in `reference::scatter`, on any lanes.

use crate::vector::{F, M, Vector, callable};
use lanes::Lanes;

callable! {
    /// The mirror images of directions `d` about the normals `n`.
    pub(crate) fn reflect<V: Vector>(d: V, n: V) -> V {
        d - n.scale(V::L::f(2.0) * d.dot(n))
    }

    /// Reflects or refracts directions `d`; also returns the factor on radiance for paths from the eye.
    pub(crate) fn dielectric<V: Vector>(d: V, n: V, inside: M<V>, ior: F<V>, u: F<V>) -> (V, F<V>) {
        let one = V::L::f(1.0);
        let eta = V::L::select(inside, ior, one / ior);
        let cos_i = -d.dot(n);
        let sin2_t = eta * eta * (one - cos_i * cos_i);
        let cos2_t = one - sin2_t;
        let zero = V::L::f(0.0);
        let cos_t = V::L::select(V::L::lt(zero, cos2_t), V::L::sqrt(cos2_t), zero);
        let transmitted = d.scale(eta) + n.scale(eta * cos_i - cos_t);
        let refracts = V::L::le(fresnel::<V::L>(eta, cos_i, cos_t), u);
        (V::select(refracts, transmitted, reflect::<V>(d, n)), V::L::select(refracts, eta * eta, one))
    }
}

#[inline(always)]
fn fresnel<L: Lanes>(eta: L::F, cos_i: L::F, cos_t: L::F) -> L::F {
    let s = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    let p = (eta * cos_t - cos_i) / (eta * cos_t + cos_i);
    L::f(0.5) * (s * s + p * p)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::one::One;
    use crate::vector::Inlined;

    /// The reflectance itself is the first number that refracts, as in the reference.
    #[test]
    fn a_number_equal_to_the_reflectance_refracts() {
        type V = Inlined<One>;
        let (down, up) = (V::new(0.0, 0.0, -1.0), V::new(0.0, 0.0, 1.0));
        for ior in [1.0_f32, 1.5, 2.0] {
            let eta = 1.0 / ior;
            let reflectance = fresnel::<One>(eta, 1.0, 1.0);
            let meet = |u: f32| {
                let (direction, scale) = dielectric::<V>(down, up, false, ior, u);
                (direction.xyz()[2] < 0.0, scale)
            };
            assert_eq!(meet(reflectance), (true, eta * eta), "index {ior}");
            if reflectance > 0.0 {
                assert_eq!(meet(reflectance.next_down()), (false, 1.0), "index {ior}");
            }
        }
    }
}
