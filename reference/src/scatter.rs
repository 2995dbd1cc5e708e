//! Where light goes from a smooth surface: mirrors and glass.

use crate::intersect::Hit;
use scene::Vec3;

/// The mirror image of direction `d` about the normal `n`.
pub fn reflect(d: Vec3, n: Vec3) -> Vec3 {
    d - n * (2.0 * d.dot(n))
}

/// Reflects or refracts direction `d` at the boundary of glass, with the probability of either given by the exact
/// Fresnel equations for unpolarised light; `u` decides. As the probability equals the share of the power, the
/// throughput changes by the tint alone, but for the factor that is returned with the direction.
///
/// That factor is for paths from the eye: the square of the relative index, `(n_i / n_t)^2`, where light refracts, 1
/// where it reflects. A beam that enters glass narrows, and its radiance grows as the square of the index (Veach
/// 1997, section 5.2); seen from the eye that is taken back. The power of photons does not change.
pub fn dielectric(d: Vec3, hit: &Hit, ior: f32, u: f32) -> (Vec3, f32) {
    let n = hit.normal;
    let eta = if hit.inside { ior } else { 1.0 / ior };
    let cos_i = -d.dot(n);
    let sin2_t = eta * eta * (1.0 - cos_i * cos_i);
    let cos2_t = 1.0 - sin2_t;
    let cos_t = if cos2_t > 0.0 { cos2_t.sqrt() } else { 0.0 };
    // NaN (grazing from inside, all zero) counts as total reflection, like every reflectance of 1.
    if u >= fresnel(eta, cos_i, cos_t) {
        (d * eta + n * (eta * cos_i - cos_t), eta * eta)
    } else {
        (reflect(d, n), 1.0)
    }
}

/// Reflectance of a boundary for unpolarised light; `eta` is the index on the incident side over that on the other.
///
/// With total internal reflection (`cos_t` = 0) it is 1 of itself.
pub fn fresnel(eta: f32, cos_i: f32, cos_t: f32) -> f32 {
    let s = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    let p = (eta * cos_t - cos_i) / (eta * cos_t + cos_i);
    0.5 * (s * s + p * p)
}
