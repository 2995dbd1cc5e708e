//! Beyond the critical angle glass reflects all light that comes from within.

use super::closed_form::{
    ARRIVED, SAMPLED, SMOOTH, arriving, assert_close, average, direct_light, lit, reflectance, straight_ahead,
};
use crate::cases::tell;
use crate::harness::{
    BLACK, Build, assert_mean, diffuse, empty_scene, glass, pinhole, render_path, render_sppm, settings,
};
use scene::{Rgb, Settings, Vec3};

const IOR: f32 = 1.5;

#[test]
fn eye_sees_nothing_of_what_is_outside_beyond_the_critical_angle() {
    // From within a ball of radius 1, at a distance of `sine` from the centre, across the line to it.
    for sine in [0.3_f32, 0.6, 0.66, 0.67, 0.95] {
        let scene = straight_ahead(Vec3::X * sine, Vec3::Y).lamp(Vec3::ZERO, 3.0, BLACK, Rgb::ONE).ball(
            Vec3::ZERO,
            1.0,
            glass(1.0, IOR),
        );
        let (outside, ior) = (f64::from(sine * IOR), f64::from(IOR));
        let expected = if outside < 1.0 { ior * ior * (1.0 - reflectance(outside, ior)) } else { 0.0 };
        let settings = Settings { iterations: 64, ..settings(64, 64, 1, 2, 1.0) };
        for (engine, film) in
            [("path tracer", render_path(&scene, &settings)), ("SPPM", render_sppm(&scene, &settings))]
        {
            assert_mean(&film, [expected; 3], SAMPLED, &format!("{engine}, sine {sine}"));
        }
    }
    tell("physics", 10, "views out of glass");
}

#[test]
fn photons_beyond_the_critical_angle_stay_within() {
    // A black lamp in the middle of a glass ball. A photon that is reflected inwards returns to the lamp and ends there.
    // So what arrives outside has met one interface.
    const LAMP: f32 = 0.9;
    let scene = empty_scene(pinhole(Vec3::Z * 90.0, Vec3::ZERO, 60.0))
        .ball(Vec3::ZERO, 100.0, BLACK)
        .lamp(Vec3::ZERO, LAMP, BLACK, Rgb::ONE)
        .ball(Vec3::ZERO, 1.0, glass(0.8, IOR));
    // Emission by the cosine makes the squared distance at which photons pass the centre uniform.
    let outside = |square: f64| (square * f64::from(LAMP * LAMP)).sqrt() * f64::from(IOR);
    let escape = |sine: f64| if sine < 1.0 { 1.0 - reflectance(sine, IOR.into()) } else { 0.0 };
    let expected = f64::from(0.8_f32) * average(1.0, |square| escape(outside(square)));
    assert_close(arriving(&scene, 0, 64), [expected; 3], ARRIVED, "flux out of glass");
}

#[test]
fn direct_light_is_seen_undiminished_in_a_total_reflection() {
    // The ray goes along y, is reflected, and then passes the centre at the same distance again, at `nearest`.
    const SINE: f32 = 0.85;
    let turn = 2.0 * SINE.acos();
    let (sin, cos) = turn.sin_cos();
    let nearest = Vec3::new(cos, sin, 0.0) * SINE;
    let direction = Vec3::new(-sin, cos, 0.0);
    let to_lamp = direction * -0.3 - nearest * 0.4 + Vec3::Z * 0.2;
    let scene = straight_ahead(Vec3::X * SINE, Vec3::Y)
        .ball(Vec3::ZERO, 1.0, glass(1.0, IOR))
        .ball(nearest + direction * 0.1, 0.1, diffuse(0.5))
        .lamp(nearest + to_lamp, 0.02, BLACK, Rgb::ONE);
    let expected = 0.5 * lit(-direction, to_lamp, 0.02);
    assert_close(direct_light(&scene, 2), [expected; 3], SMOOTH, "a lit ball, totally reflected");
}
