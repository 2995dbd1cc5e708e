//! A boundary reflects the share of light that Fresnel's equations say, and refracts the rest.

use super::closed_form::{
    ARRIVED, SAMPLED, a_lamp_beside, arriving, assert_close, direct_light, lit, met, reflectance,
    straight_ahead,
};
use crate::cases::tell;
use crate::harness::{BLACK, Build, assert_mean, diffuse, glass, render_path, render_sppm, settings};
use scene::{Rgb, Settings, Vec3};

const IOR: f32 = 2.5;

/// What a ray brings through a ball of clear glass within `depth` segments: what is reflected at once takes 2, what is
/// refracted twice takes 3.
fn within(depth: u32, r: f64) -> f64 {
    if depth == 2 { r } else { r + (1.0 - r).powi(2) }
}

#[test]
fn eye_sees_the_share_that_is_reflected() {
    for (depth, sine) in [(2, 0.0_f32), (2, 0.9), (3, 0.0), (3, 0.9)] {
        let scene = straight_ahead(Vec3::Z * 2.9, Vec3::NEG_Z).lamp(Vec3::ZERO, 3.0, BLACK, Rgb::ONE).ball(
            Vec3::new(sine, 0.0, 0.0),
            1.0,
            glass(1.0, IOR),
        );
        let expected = within(depth, reflectance(sine.into(), IOR.into()));
        let settings = Settings { iterations: 64, ..settings(64, 64, 1, depth, 1.0) };
        for (engine, film) in
            [("path tracer", render_path(&scene, &settings)), ("SPPM", render_sppm(&scene, &settings))]
        {
            assert_mean(&film, [expected; 3], SAMPLED, &format!("{engine}, sine {sine}, depth {depth}"));
        }
    }
    tell("physics", 8, "shares that glass reflects to the eye");
}

#[test]
fn photons_are_reflected_as_often_as_light_is() {
    let scene = a_lamp_beside(glass(1.0, IOR));
    for depth in [2, 3] {
        let expected = met(|sine| within(depth, reflectance(sine, IOR.into())));
        assert_close(arriving(&scene, 0, depth), [expected; 3], ARRIVED, &format!("flux at depth {depth}"));
    }
    tell("physics", 2, "shares of photons that glass reflects");
}

#[test]
fn direct_light_is_seen_in_glass_as_much_as_glass_reflects() {
    // A lit ball, seen in the reflection of a glass ball at an angle of 45 degrees.
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let scene = straight_ahead(Vec3::Z * 5.0, Vec3::NEG_Z)
        .ball(Vec3::new(-half, 0.0, -half), 1.0, glass(1.0, IOR))
        .ball(Vec3::new(6.0, 0.0, 0.0), 1.0, diffuse(0.5))
        .lamp(Vec3::new(0.0, 0.0, 9.0), 0.1, BLACK, Rgb::ONE);
    let lit = 0.5 * lit(Vec3::NEG_X, Vec3::new(-5.0, 0.0, 9.0), 0.1);
    let expected = lit * reflectance(half.into(), IOR.into());
    assert_close(direct_light(&scene, 2), [expected; 3], SAMPLED, "a lit ball reflected in glass");
}
