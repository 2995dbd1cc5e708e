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
    let boundary = Boundary::of(d, hit, ior);
    // A NaN reflectance (grazing from inside, where all terms are 0) counts as total reflection.
    if u >= boundary.reflectance {
        (boundary.refract(d, hit.normal), boundary.eta * boundary.eta)
    } else {
        (reflect(d, hit.normal), 1.0)
    }
}

/// The same with probabilities in proportion to the roots of the shares of the power: with the reflectance R and T = 1 - R, the
/// direction is reflected with probability `sqrt(R) / (sqrt(R) + sqrt(T))`. So the factor is also multiplied by the share over
/// its probability, which is `sqrt(R) (sqrt(R) + sqrt(T))` for reflection and `sqrt(T) (sqrt(R) + sqrt(T))` for refraction.
///
/// A weak reflection of something bright, which [`dielectric`] follows rarely and at full weight, is followed more often, at less.
pub fn dielectric_by_roots(d: Vec3, hit: &Hit, ior: f32, u: f32) -> (Vec3, f32) {
    let boundary = Boundary::of(d, hit, ior);
    let share = if boundary.reflectance < 1.0 { boundary.reflectance } else { 1.0 };
    let (reflected, refracted) = (share.sqrt(), (1.0 - share).sqrt());
    let sum = reflected + refracted;
    if u * sum >= reflected {
        (boundary.refract(d, hit.normal), boundary.eta * boundary.eta * (refracted * sum))
    } else {
        (reflect(d, hit.normal), reflected * sum)
    }
}

/// How a direction meets a boundary of glass.
struct Boundary {
    /// The index on the incident side over that on the other.
    eta: f32,
    /// The cosine of the angle of incidence.
    cos_i: f32,
    /// The cosine of the angle of refraction; 0 if all is reflected.
    cos_t: f32,
    /// The share of the power that is reflected.
    reflectance: f32,
}

impl Boundary {
    fn of(d: Vec3, hit: &Hit, ior: f32) -> Self {
        let eta = if hit.inside { ior } else { 1.0 / ior };
        let cos_i = -d.dot(hit.normal);
        let sin2_t = eta * eta * (1.0 - cos_i * cos_i);
        let cos2_t = 1.0 - sin2_t;
        let cos_t = if cos2_t > 0.0 { cos2_t.sqrt() } else { 0.0 };
        Self { eta, cos_i, cos_t, reflectance: fresnel(eta, cos_i, cos_t) }
    }

    fn refract(&self, d: Vec3, n: Vec3) -> Vec3 {
        d * self.eta + n * (self.eta * self.cos_i - self.cos_t)
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

#[cfg(test)]
mod tests {
    use super::*;

    fn hit(normal: Vec3, inside: bool) -> Hit {
        Hit { sphere: 0, t: 1.0, point: Vec3::ZERO, normal, inside }
    }

    #[test]
    fn reflection_turns_the_part_along_the_normal() {
        assert_eq!(reflect(Vec3::new(0.6, 0.0, -0.8), Vec3::Z), Vec3::new(0.6, 0.0, 0.8));
        assert_eq!(reflect(Vec3::NEG_Z, Vec3::Z), Vec3::Z);
    }

    /// Sines are as the indices, and radiance as their squares.
    #[test]
    fn refraction_follows_the_law_of_snell() {
        let d = Vec3::new(0.6, 0.0, -0.8);
        let (entering, scale) = dielectric(d, &hit(Vec3::Z, false), 1.5, 1.0);
        assert!((entering - Vec3::new(0.4, 0.0, -(1.0 - 0.16_f32).sqrt())).length() < 1e-6, "{entering}");
        assert!((scale - 1.0 / 2.25).abs() < 1e-6, "{scale}");
        // The way back.
        let (leaving, scale) = dielectric(-entering, &hit(Vec3::NEG_Z, true), 1.5, 1.0);
        assert!((leaving + d).length() < 1e-6 && (scale - 2.25).abs() < 1e-6, "{leaving}, {scale}");
        // Beyond the critical angle all is reflected.
        assert_eq!(dielectric(d, &hit(Vec3::Z, true), 1.7, 0.999_999), (reflect(d, Vec3::Z), 1.0));
    }

    /// Head on `((n - 1) / (n + 1))^2`, at Brewster's angle half of what one polarisation has, and all at grazing angles.
    #[test]
    fn reflectance_is_that_of_fresnel() {
        assert!((fresnel(1.0 / 1.5, 1.0, 1.0) - 0.04).abs() < 1e-7);
        assert!((fresnel(1.5, 1.0, 1.0) - 0.04).abs() < 1e-7);
        let cos = 1.0 / (1.0_f32 + 2.25).sqrt();
        let sin_t = (1.0 - cos * cos).sqrt() / 1.5;
        let s = (1.0 - 2.25_f32) / (1.0 + 2.25);
        let found = fresnel(1.0 / 1.5, cos, (1.0 - sin_t * sin_t).sqrt());
        assert!((found - 0.5 * s * s).abs() < 1e-6, "{found}");
        assert_eq!(fresnel(1.5, 0.3, 0.0), 1.0);
        // The number decides at the reflectance.
        let d = Vec3::NEG_Z;
        let is_reflected = |u| dielectric(d, &hit(Vec3::Z, false), 1.5, u).0.z > 0.0;
        assert!(is_reflected(0.0) && is_reflected(0.0399) && !is_reflected(0.0401) && !is_reflected(0.99));
    }

    /// Head on, the root of 0.04 is 0.2 and that of 0.96 is 0.98: the number decides at 0.2 / 1.18, and weights are shares over
    /// probabilities. Beyond the critical angle, and where the reflectance is no number, all is reflected at full weight.
    #[test]
    fn by_roots_weak_reflections_are_followed_more_often_at_less_weight() {
        let (d, border) = (Vec3::NEG_Z, 0.2 / (0.2 + 0.96_f32.sqrt()));
        let of = |u| dielectric_by_roots(d, &hit(Vec3::Z, false), 1.5, u);
        for (u, direction, weight) in [
            (0.0, Vec3::Z, 0.04 / border),
            (border - 1e-5, Vec3::Z, 0.04 / border),
            (border + 1e-5, d, 0.96 / (1.0 - border) / 2.25),
            (0.999_999, d, 0.96 / (1.0 - border) / 2.25),
        ] {
            let (found, scale) = of(u);
            assert!(
                (found - direction).length() < 1e-6 && (scale - weight).abs() < 1e-6,
                "{u}: {found}, {scale}"
            );
        }
        let (d, grazing) = (Vec3::new(0.6, 0.0, -0.8), Vec3::X);
        assert_eq!(dielectric_by_roots(d, &hit(Vec3::Z, true), 1.7, 0.999_999), (reflect(d, Vec3::Z), 1.0));
        let (_, scale) = dielectric_by_roots(grazing, &hit(Vec3::Z, true), 1.0, 0.999_999);
        assert_eq!(scale, 1.0);
        assert_eq!(dielectric_by_roots(Vec3::NEG_Z, &hit(Vec3::Z, true), 1.0, 0.0), (Vec3::NEG_Z, 1.0));
    }
}
