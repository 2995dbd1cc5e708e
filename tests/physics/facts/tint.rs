//! Glass tints light at every interface that it meets, whether it is reflected or refracted there.

use super::closed_form::{
    ARRIVED, SAMPLED, SMOOTH, a_lamp_beside, arriving, assert_close, direct_light, lit, met, reflectance,
    straight_ahead,
};
use crate::cases::tell;
use crate::harness::{BLACK, Build, assert_mean, diffuse, glass, render_path, render_sppm, settings};
use scene::{Material, Rgb, Scene, Settings, Vec3};

const TINT: [f32; 3] = [0.9, 0.5, 0.2];

/// Large, so that much is reflected within.
const IOR: f32 = 2.5;

fn tinted() -> Material {
    Material::Dielectric { albedo: Rgb::from_array(TINT), ior: IOR }
}

/// What of a ray leaves a ball of tinted glass. The angle is the same at each interface, so it is a series in the number
/// of inner reflections.
fn leaves(tint: f64, r: f64) -> f64 {
    r * tint + (1.0 - r).powi(2) * tint * tint / (1.0 - r * tint)
}

#[test]
fn eye_sees_the_series_of_inner_reflections() {
    let (tint, ior) = (0.8, 1.5);
    for sine in [0.3_f32, 0.8, 0.95] {
        // The ray passes the centre at a distance of `sine` radii.
        let scene = straight_ahead(Vec3::Z * 2.9, Vec3::NEG_Z).lamp(Vec3::ZERO, 3.0, BLACK, Rgb::ONE).ball(
            Vec3::new(sine, 0.0, 0.0),
            1.0,
            glass(tint, ior),
        );
        let expected = leaves(f64::from(tint), reflectance(f64::from(sine), f64::from(ior)));
        // Samples differ by at most `t - t^2`, so half a million of them have a standard error below 0.03 %.
        let settings = Settings { iterations: 128, ..settings(64, 64, 1, 64, 1.0) };
        for (engine, film) in
            [("path tracer", render_path(&scene, &settings)), ("SPPM", render_sppm(&scene, &settings))]
        {
            assert_mean(&film, [expected; 3], SMOOTH, &format!("{engine}, sine {sine}"));
        }
    }
    tell("physics", 6, "series of inner reflections");
}

#[test]
fn photons_are_tinted_at_every_interface_that_they_meet() {
    let expected = TINT.map(|tint| met(|sine| leaves(tint.into(), reflectance(sine, IOR.into()))));
    assert_close(arriving(&a_lamp_beside(tinted()), 0, 64), expected, ARRIVED, "flux from a tinted ball");
}

/// A ball lit by a small lamp, seen straight through the middle of `glass`.
fn lit_behind(glass: Material) -> Scene {
    straight_ahead(Vec3::Z * 5.0, Vec3::NEG_Z)
        .ball(Vec3::Z * 2.0, 1.0, glass)
        .ball(Vec3::NEG_Z * 2.0, 1.0, diffuse(0.5))
        .lamp(Vec3::new(9.0, 0.0, 8.0), 0.1, BLACK, Rgb::ONE)
}

#[test]
fn direct_light_seen_through_glass_is_tinted_at_every_interface() {
    let r = reflectance(0.0, IOR.into());
    let expected = TINT.map(|tint| {
        // Only paths with an even number of inner reflections go on forwards.
        let tint = f64::from(tint);
        let through = (1.0 - r).powi(2) * tint * tint / (1.0 - (r * tint).powi(2));
        0.5 * through * lit(Vec3::Z, Vec3::new(9.0, 0.0, 9.0), 0.1)
    });
    assert_close(
        direct_light(&lit_behind(tinted()), 64),
        expected,
        SAMPLED,
        "a lit ball behind tinted glass",
    );
}
