//! A mirror reflects its albedo of the light, in every channel.

use super::closed_form::{
    ARRIVED, SMOOTH, a_lamp_beside, arriving, assert_close, direct_light, lit, met, straight_ahead,
};
use crate::cases::tell;
use crate::harness::{BLACK, Build, diffuse, render_path, render_sppm, settings};
use scene::{Material, Rgb, Vec3};

const ALBEDO: Rgb = Rgb::new(0.25, 0.5, 0.999);

const MIRROR: Material = Material::Specular { albedo: ALBEDO };

#[test]
fn eye_sees_the_shell_times_the_albedo() {
    let emission = Rgb::new(1.0, 3.0, 7.0);
    let scene = straight_ahead(Vec3::Z * 2.9, Vec3::NEG_Z).lamp(Vec3::ZERO, 3.0, BLACK, emission).ball(
        Vec3::ZERO,
        0.5,
        MIRROR,
    );
    for (depth, expected) in [(1, Rgb::ZERO), (2, ALBEDO * emission), (5, ALBEDO * emission)] {
        let settings = settings(16, 16, 1, depth, 1.0);
        for film in [render_sppm(&scene, &settings), render_path(&scene, &settings)] {
            assert!(film.pixels.iter().all(|&pixel| pixel == expected), "depth {depth}");
        }
    }
    tell("physics", 6, "mirrors in a furnace");
}

#[test]
fn photons_take_the_albedo_of_the_mirror() {
    let expected = ALBEDO.to_array().map(|albedo| met(|_| albedo.into()));
    assert_close(arriving(&a_lamp_beside(MIRROR), 0, 4), expected, ARRIVED, "flux from a mirror ball");
}

#[test]
fn direct_light_is_seen_in_a_mirror_times_its_albedo() {
    // The mirror turns the view by a right angle, towards the lit ball.
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let scene = straight_ahead(Vec3::Z * 5.0, Vec3::NEG_Z)
        .ball(Vec3::new(-half, 0.0, -half), 1.0, MIRROR)
        .ball(Vec3::new(6.0, 0.0, 0.0), 1.0, diffuse(0.5))
        .lamp(Vec3::new(0.0, 0.0, 9.0), 0.1, BLACK, Rgb::ONE);
    let lit = 0.5 * lit(Vec3::NEG_X, Vec3::new(-5.0, 0.0, 9.0), 0.1);
    let expected = ALBEDO.to_array().map(|albedo| lit * f64::from(albedo));
    assert_close(direct_light(&scene, 4), expected, SMOOTH, "a lit ball in a mirror");
}
