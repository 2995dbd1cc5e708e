//! Reflection and refraction at smooth surfaces: mirrors and glass.

use crate::intersect::Hit;
use scene::Vec3;

/// The mirror image of direction `d` about the normal `n`.
pub fn reflect(d: Vec3, n: Vec3) -> Vec3 {
    d - n * (2.0 * d.dot(n))
}

/// Reflects or refracts direction `d` at the boundary of glass; the random number `u` decides which. The probabilities
/// are the shares of the power by the exact Fresnel equations for unpolarised light. So the throughput changes only by
/// the tint, and by the factor that is returned with the direction.
///
/// That factor applies to paths from the eye only: `(n_i / n_t)^2`, the square of the relative index, for refraction,
/// and 1 for reflection. A beam that enters glass narrows, and its radiance grows with the square of the index (Veach
/// 1997, section 5.2); a path from the eye runs against the light, so it is scaled by the inverse. The power of photons
/// does not change.
pub fn dielectric(d: Vec3, hit: &Hit, ior: f32, u: f32) -> (Vec3, f32) {
    let n = hit.normal;
    let eta = if hit.inside { ior } else { 1.0 / ior };
    let cos_i = -d.dot(n);
    let sin2_t = eta * eta * (1.0 - cos_i * cos_i);
    let cos2_t = 1.0 - sin2_t;
    let cos_t = if cos2_t > 0.0 { cos2_t.sqrt() } else { 0.0 };
    // A NaN reflectance (grazing from inside, where all terms are 0) counts as total reflection.
    if u >= fresnel(eta, cos_i, cos_t) {
        (d * eta + n * (eta * cos_i - cos_t), eta * eta)
    } else {
        (reflect(d, n), 1.0)
    }
}

/// Reflectance of a boundary for unpolarised light; `eta` is the index on the incident side over that on the other.
///
/// For total internal reflection (`cos_t` = 0) the formula gives 1.
pub fn fresnel(eta: f32, cos_i: f32, cos_t: f32) -> f32 {
    let s = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    let p = (eta * cos_t - cos_i) / (eta * cos_t + cos_i);
    0.5 * (s * s + p * p)
}
