//! Mirrors and glass: the law of reflection, Snell's law and the Fresnel equations.

use crate::cases::tell;
use crate::harness::{SIGNIFICANCE, chi_square_p_of};
use reference::intersect::Hit;
use reference::sampling::{uniform_sphere, unit};
use reference::scatter::{dielectric, dielectric_by_roots, fresnel, reflect};
use scene::Vec3;
use scene::rng::{Family, StreamKey};

/// Tolerance of a reflectance: about ten rounding errors of values around 1, and at grazing angles the error of the
/// cosine of refraction.
const REFLECTANCE: f64 = 2e-6;

/// Tolerance of components of directions: a dozen rounding errors of values up to 2.4, the largest index in these
/// tests.
const DIRECTION: f64 = 1e-6;

const INDICES: [f32; 5] = [1.0, 1.1, 1.33, 1.5, 2.4];

/// Reflectance of unpolarised light by the textbook's amplitudes, in terms of both cosines.
fn expected_fresnel(eta: f64, cos_i: f64) -> f64 {
    let sin2_t = eta * eta * (1.0 - cos_i * cos_i);
    if sin2_t >= 1.0 {
        return 1.0;
    }
    let cos_t = (1.0 - sin2_t).sqrt();
    // Only the ratio of the indices matters, so take n_i = eta and n_t = 1.
    let s = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    let p = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
    f64::midpoint(s * s, p * p)
}

/// The cosine of the angle of refraction, as the engine computes it.
fn refracted_cosine(eta: f32, cos_i: f32) -> f32 {
    (1.0 - eta * eta * (1.0 - cos_i * cos_i)).max(0.0).sqrt()
}

fn reflectance(eta: f32, cos_i: f32) -> f64 {
    f64::from(fresnel(eta, cos_i, refracted_cosine(eta, cos_i)))
}

/// Random directions that arrive on the side of the normal `n`.
fn incoming(n: Vec3) -> impl Iterator<Item = Vec3> {
    let key = StreamKey::new(3, Family::Path, 0);
    (0..20_000).map(move |i| {
        let mut stream = key.stream(i);
        let d = unit(uniform_sphere(stream.next_f32(), stream.next_f32()));
        if d.dot(n) > 0.0 { -d } else { d }
    })
}

fn hit(normal: Vec3, inside: bool) -> Hit {
    Hit { sphere: 0, t: 1.0, point: Vec3::ZERO, normal, inside }
}

fn normal() -> Vec3 {
    unit(Vec3::new(0.36, -0.48, 0.8))
}

#[test]
fn reflectance_agrees_with_f64() {
    for ior in INDICES {
        for eta in [ior, 1.0 / ior] {
            for step in 1..=1000 {
                let cos_i = step as f32 / 1000.0;
                let sin2_t = f64::from(eta).powi(2) * (1.0 - f64::from(cos_i).powi(2));
                // Near the critical angle the reflectance approaches 1 like a square root, which magnifies errors.
                let near_critical = (1.0 - sin2_t).abs() < 1e-4;
                let bound = if near_critical { 1e-2 } else { REFLECTANCE / (1.0 - sin2_t).abs().sqrt() };
                let expected = expected_fresnel(f64::from(eta), f64::from(cos_i));
                let actual = reflectance(eta, cos_i);
                assert!((actual - expected).abs() < bound, "eta {eta}, cos {cos_i}: {actual} not {expected}");
                assert!((0.0..=1.0 + REFLECTANCE).contains(&actual));
            }
        }
    }
    tell("physics", 2 * 1000 * INDICES.len(), "reflectances against f64");
}

#[test]
fn reflectance_at_normal_incidence_is_that_of_the_textbooks() {
    for (ior, expected) in [(1.5, 0.04), (1.33, 0.020_058_6), (2.4, 0.169_550_2), (1.0, 0.0)] {
        assert!((reflectance(1.0 / ior, 1.0) - expected).abs() < REFLECTANCE);
        assert!((reflectance(ior, 1.0) - expected).abs() < REFLECTANCE);
    }
}

#[test]
fn at_brewsters_angle_only_one_polarisation_is_reflected() {
    for ior in [1.33_f64, 1.5, 2.4] {
        // The tangent of the angle is ior. The result is half the reflectance of the other polarisation, which is
        // ((ior^2 - 1) / (ior^2 + 1))^2.
        let cos_i = 1.0 / (1.0 + ior * ior).sqrt();
        let expected = 0.5 * ((ior * ior - 1.0) / (ior * ior + 1.0)).powi(2);
        assert!((reflectance((1.0 / ior) as f32, cos_i as f32) - expected).abs() < REFLECTANCE);
    }
}

#[test]
fn reflectance_is_the_same_from_both_sides() {
    for ior in INDICES {
        for step in 1..=1000 {
            let outside = step as f32 / 1000.0;
            let within = refracted_cosine(1.0 / ior, outside);
            let (there, back) = (fresnel(1.0 / ior, outside, within), fresnel(ior, within, outside));
            assert!(f64::from(there - back).abs() < REFLECTANCE, "ior {ior}, cos {outside}: {there}, {back}");
        }
    }
    tell("physics", 1000 * INDICES.len(), "reflectances from both sides");
}

#[test]
fn mirrors_reflect_by_the_law() {
    let n = normal();
    for d in incoming(n) {
        let r = reflect(d, n);
        assert!((f64::from(r.length()) - 1.0).abs() < DIRECTION);
        assert!(f64::from((r.dot(n) + d.dot(n)).abs()) < DIRECTION);
        assert!(f64::from((r - d).cross(n).length()) < DIRECTION, "out of the plane of incidence");
        assert!(f64::from(reflect(r, n).distance(d)) < 2.0 * DIRECTION, "not its own inverse");
    }
    tell("physics", 20_000, "mirrored directions");
}

#[test]
fn glass_refracts_by_snells_law_or_reflects_with_fresnels_probability() {
    let n = normal();
    for ior in INDICES {
        for inside in [false, true] {
            let eta = f64::from(if inside { ior } else { 1.0 / ior });
            for d in incoming(n) {
                let share = expected_fresnel(eta, -d.as_dvec3().dot(n.as_dvec3()));
                let sine = d.as_dvec3().cross(n.as_dvec3());
                let sin2_t = eta * eta * sine.length_squared();
                if (1.0 - sin2_t).abs() < 1e-3 {
                    continue; // near the critical angle, see `reflectance_agrees_with_f64`
                }
                let out = |u: f64| dielectric(d, &hit(n, inside), ior, u as f32).0.as_dvec3();
                let mirrored = reflect(d, n).as_dvec3();
                // Random numbers just below and just above the reflectance. Its error is below 10^-4 this close to the
                // critical angle, by the bound of that test.
                assert!(share < 2e-4 || out(share - 1e-4).distance(mirrored) < DIRECTION);
                if share < 0.9998 {
                    let refracted = out(share + 1e-4);
                    // The cosine of refraction is the square root of a difference, which magnifies errors.
                    let bound = 2.0 * DIRECTION / (1.0 - sin2_t).sqrt();
                    assert!((refracted.length() - 1.0).abs() < bound);
                    assert!(refracted.dot(n.as_dvec3()) < 0.0, "does not cross");
                    // Snell's law for the sines as vectors, which also tests that they are in the same plane.
                    let snell = refracted.cross(n.as_dvec3()).distance(sine * eta);
                    assert!(snell < bound, "ior {ior}, inside {inside}: off by {snell:.1e}");
                } else {
                    assert!(
                        sin2_t < 1.0 || out(0.999_999).distance(mirrored) < DIRECTION,
                        "no total reflection"
                    );
                }
            }
        }
    }
    tell("physics", 2 * 20_000 * INDICES.len(), "directions into and out of glass");
}

/// Reflected and refracted into the same directions; by a histogram, with the probabilities that are stated; and with factors that times
/// these are the shares of the power.
#[test]
fn by_roots_glass_reflects_and_refracts_what_it_should_on_average() {
    /// Of factors up to 2.4^2: some ten rounding errors, and at grazing angles the root of the error of the share.
    const FACTOR: f64 = 2e-3;
    let (n, count) = (normal(), 1_u32 << 18);
    let tangent = n.any_orthonormal_vector();
    for (index, (ior, inside, angle)) in [
        (1.5, false, 0.0_f32),
        (1.5, false, 1.2),
        (1.5, true, 0.6),
        (2.4, false, 1.5),
        (1.1, true, 1.1),
        (1.5, true, 1.0),
        (1.0, false, 0.7),
    ]
    .into_iter()
    .enumerate()
    {
        let d = -n * angle.cos() + tangent * angle.sin();
        let eta = f64::from(if inside { ior } else { 1.0 / ior });
        let share = expected_fresnel(eta, -d.as_dvec3().dot(n.as_dvec3()));
        let (reflected, refracted) = (share.sqrt(), (1.0 - share).sqrt());
        let p = reflected / (reflected + refracted);
        let mut stream = StreamKey::new(4, Family::Glint, 0).stream(index as u32);
        let mut reflections = 0;
        for _ in 0..count {
            let (direction, factor) = dielectric_by_roots(d, &hit(n, inside), ior, stream.next_f32());
            let is_reflected = direction.dot(n) > 0.0;
            // Numbers that lead `dielectric` the same way.
            let (same, usual) =
                dielectric(d, &hit(n, inside), ior, if is_reflected { 0.0 } else { 0.999_999 });
            assert_eq!(direction, same, "ior {ior}, angle {angle}");
            let expected = if is_reflected { share / p } else { (1.0 - share) / (1.0 - p) };
            let found = f64::from(factor / usual);
            assert!(
                (found / expected - 1.0).abs() < FACTOR,
                "ior {ior}, angle {angle}: {found}, not {expected}"
            );
            reflections += u32::from(is_reflected);
        }
        let is_as_stated = if p == 0.0 || p == 1.0 {
            f64::from(reflections) == p * f64::from(count)
        } else {
            chi_square_p_of(&[reflections, count - reflections], &[p, 1.0 - p]) > SIGNIFICANCE
        };
        assert!(is_as_stated, "ior {ior}, angle {angle}: {reflections} of {count}, not {p}");
    }
    tell("physics", 7, "shares of reflection by roots");
}

#[test]
fn refraction_is_reversible() {
    let n = normal();
    for ior in INDICES {
        for d in incoming(n).filter(|d| d.dot(n) < -0.05) {
            let (within, narrowed) = dielectric(d, &hit(n, false), ior, 0.999_999);
            let (back, widened) = dielectric(-within, &hit(-n, true), ior, 0.999_999);
            // The way back magnifies errors by the index and, at slanted angles, by the ratio of the cosines: by less
            // than 30.
            assert!(f64::from(back.distance(-d)) < 30.0 * DIRECTION, "ior {ior}, d {d}: {back}");
            approx::assert_relative_eq!(narrowed, 1.0 / (ior * ior), max_relative = 4.0 * f32::EPSILON);
            approx::assert_relative_eq!(narrowed * widened, 1.0, max_relative = 4.0 * f32::EPSILON);
        }
    }
}

#[test]
fn glass_of_index_one_is_invisible() {
    let n = normal();
    for d in incoming(n).filter(|d| d.dot(n) < -0.01) {
        for inside in [false, true] {
            let (direction, scale) = dielectric(d, &hit(n, inside), 1.0, 1e-6);
            assert!(f64::from(direction.distance(d)) < 100.0 * DIRECTION);
            assert_eq!(scale, 1.0);
        }
    }
}

#[test]
fn total_reflection_begins_beyond_the_critical_angle() {
    let n = normal();
    for ior in [1.1_f32, 1.5, 2.4] {
        let critical = (1.0 / f64::from(ior)).asin();
        let tangent = n.any_orthonormal_vector();
        for (angle, is_total) in [(critical - 1e-2, false), (critical + 1e-3, true), (1.57, true)] {
            let d = -n * angle.cos() as f32 + tangent * angle.sin() as f32;
            let (direction, scale) = dielectric(d, &hit(n, true), ior, 0.999_999);
            assert_eq!(direction.dot(n) < 0.0, !is_total, "ior {ior}, angle {angle}");
            assert_eq!(scale, if is_total { 1.0 } else { ior * ior });
        }
    }
}

#[test]
fn a_boundary_reflects_as_often_as_fresnel_says() {
    let (n, count) = (normal(), 1_u32 << 20);
    let tangent = n.any_orthonormal_vector();
    for (index, (ior, inside, angle)) in
        [(1.5, false, 0.0_f32), (1.5, false, 1.2), (1.5, true, 0.6), (2.4, false, 1.5), (1.1, true, 1.1)]
            .into_iter()
            .enumerate()
    {
        let d = -n * angle.cos() + tangent * angle.sin();
        let eta = f64::from(if inside { ior } else { 1.0 / ior });
        let share = expected_fresnel(eta, -d.as_dvec3().dot(n.as_dvec3()));
        let mut stream = StreamKey::new(4, Family::Path, 0).stream(index as u32);
        let reflects = |_: &u32| dielectric(d, &hit(n, inside), ior, stream.next_f32()).0.dot(n) > 0.0;
        let reflected = (0..count).filter(reflects).count();
        let p = chi_square_p_of(&[reflected as u32, count - reflected as u32], &[share, 1.0 - share]);
        assert!(p > SIGNIFICANCE, "ior {ior}, angle {angle}: {reflected} of {count}, p = {p:.1e}");
    }
    tell("physics", 5, "shares of reflection");
}
