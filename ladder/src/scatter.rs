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
