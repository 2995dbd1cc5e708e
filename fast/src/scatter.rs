//! Mirrors and glass, as `reference::scatter` defines them, in lanes.

use crate::paths::Packet;
use crate::surface::Hit;
use lanes::{Lanes, V3};

/// Sends paths on from the mirrors and glass that they have hit: reflected, or at glass as the uniform number `lobe` chooses.
#[inline(always)]
pub(crate) fn follow<L: Lanes>(
    p: &mut Packet<L>,
    (surface, sphere): (&Hit<L>, L::U),
    (is_glass, ior): (L::M, L::F),
    lobe: L::F,
) {
    let mirrored = reflect(p.direction, surface.normal);
    let (through, scale) = dielectric(p.direction, surface.normal, surface.inside, ior, lobe);
    p.weight = p.weight.scale(L::select(is_glass, scale, L::f(1.0)));
    p.direction = V3::select(is_glass, through, mirrored);
    p.origin = surface.point;
    p.leaves = sphere;
}

#[inline(always)]
pub(crate) fn reflect<L: Lanes>(d: V3<L>, n: V3<L>) -> V3<L> {
    d - n.scale(L::f(2.0) * d.dot(n))
}

#[inline(always)]
pub(crate) fn dielectric<L: Lanes>(d: V3<L>, n: V3<L>, inside: L::M, ior: L::F, u: L::F) -> (V3<L>, L::F) {
    let one = L::f(1.0);
    let eta = L::select(inside, ior, one / ior);
    let cos_i = -d.dot(n);
    let sin2_t = eta * eta * (one - cos_i * cos_i);
    let cos2_t = one - sin2_t;
    let zero = L::f(0.0);
    let cos_t = L::select(L::lt(zero, cos2_t), L::sqrt(cos2_t), zero);
    let transmitted = d.scale(eta) + n.scale(eta * cos_i - cos_t);
    let refracts = L::le(fresnel::<L>(eta, cos_i, cos_t), u);
    (V3::select(refracts, transmitted, reflect(d, n)), L::select(refracts, eta * eta, one))
}

#[inline(always)]
pub(crate) fn fresnel<L: Lanes>(eta: L::F, cos_i: L::F, cos_t: L::F) -> L::F {
    let s = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    let p = (eta * cos_t - cos_i) / (eta * cos_t + cos_i);
    L::f(0.5) * (s * s + p * p)
}
