//! Mirrors and glass, as `reference::scatter` defines them, in lanes.

use crate::paths::Packet;
use crate::surface::Hit;
use lanes::{Lanes, V3};

/// Sends paths on from the mirrors and glass that they have hit: reflected, or where `is_glass` is true in a direction, and with a
/// factor of radiance, by [`dielectric`] or [`dielectric_by_roots`].
#[inline(always)]
pub(crate) fn follow<L: Lanes>(
    p: &mut Packet<L>,
    (surface, sphere): (&Hit<L>, L::U),
    is_glass: L::M,
    (through, scale): (V3<L>, L::F),
) {
    let mirrored = reflect(p.direction, surface.normal);
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
    let Boundary { eta, refracted, reflectance } = Boundary::<L>::of(d, n, inside, ior);
    let refracts = L::le(reflectance, u);
    (V3::select(refracts, refracted, reflect(d, n)), L::select(refracts, eta * eta, L::f(1.0)))
}

#[inline(always)]
pub(crate) fn dielectric_by_roots<L: Lanes>(
    d: V3<L>,
    n: V3<L>,
    inside: L::M,
    ior: L::F,
    u: L::F,
) -> (V3<L>, L::F) {
    let Boundary { eta, refracted, reflectance } = Boundary::<L>::of(d, n, inside, ior);
    let one = L::f(1.0);
    let share = L::select(L::lt(reflectance, one), reflectance, one);
    let [root, other] = [L::sqrt(share), L::sqrt(one - share)];
    let sum = root + other;
    let refracts = L::le(root, u * sum);
    let scale = L::select(refracts, eta * eta * (other * sum), root * sum);
    (V3::select(refracts, refracted, reflect(d, n)), scale)
}

/// How directions meet boundaries of glass.
struct Boundary<L: Lanes> {
    eta: L::F,
    refracted: V3<L>,
    reflectance: L::F,
}

impl<L: Lanes> Boundary<L> {
    #[inline(always)]
    fn of(d: V3<L>, n: V3<L>, inside: L::M, ior: L::F) -> Self {
        let one = L::f(1.0);
        let eta = L::select(inside, ior, one / ior);
        let cos_i = -d.dot(n);
        let sin2_t = eta * eta * (one - cos_i * cos_i);
        let cos2_t = one - sin2_t;
        let zero = L::f(0.0);
        let cos_t = L::select(L::lt(zero, cos2_t), L::sqrt(cos2_t), zero);
        let refracted = d.scale(eta) + n.scale(eta * cos_i - cos_t);
        Self { eta, refracted, reflectance: fresnel::<L>(eta, cos_i, cos_t) }
    }
}

#[inline(always)]
pub(crate) fn fresnel<L: Lanes>(eta: L::F, cos_i: L::F, cos_t: L::F) -> L::F {
    let s = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    let p = (eta * cos_t - cos_i) / (eta * cos_t + cos_i);
    L::f(0.5) * (s * s + p * p)
}
