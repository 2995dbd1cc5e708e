//! Radiance within glass is n^2 times that outside: beams narrow where light enters, and the power of photons stays.

use super::closed_form::{
    ARRIVED, SAMPLED, arriving, assert_close, average, direct_light, lit, reflectance, straight_ahead,
};
use crate::harness::{
    BLACK, Build, assert_mean, deposits, diffuse, empty_scene, glass, pinhole, render_path, render_sppm,
    settings,
};
use reference::photon_pass::Flux;
use scene::film::FLUX_ONE;
use scene::{Rgb, Settings, Vec3};

const IOR: f32 = 1.5;

/// Relative tolerance of furnaces without noise: about a hundred rounding errors of 2^-24.
const ROUNDING: f64 = 1e-5;

/// Relative tolerance of a mean by paths of which some reflect at the glass and leave it: four standard errors.
const PATHS: f64 = 0.05;

#[test]
fn eye_within_glass_sees_a_furnace_brighter_by_the_square_of_the_index() {
    let eye = Vec3::Z * 2.9;
    let scene = empty_scene(pinhole(eye, Vec3::ZERO, 90.0)).lamp(Vec3::ZERO, 3.0, BLACK, Rgb::ONE).ball(
        eye,
        0.05,
        glass(1.0, IOR),
    );
    let settings = settings(32, 32, 1, 64, 1.0);
    for film in [render_sppm(&scene, &settings), render_path(&scene, &settings)] {
        assert_mean(&film, [f64::from(IOR * IOR); 3], ROUNDING, "from within glass");
    }
}

#[test]
fn photons_reach_what_is_within_glass_by_the_square_of_the_index_and_keep_their_power() {
    // A black ball in the middle of a glass ball, in a glowing shell. The shell's photons meet the glass with a squared
    // sine that is uniform, and those below n times the ratio of the radii meet the ball.
    const BALL: f32 = 0.5;
    let scene = empty_scene(pinhole(Vec3::Z * 2.9, Vec3::ZERO, 90.0))
        .lamp(Vec3::ZERO, 3.0, BLACK, Rgb::ONE)
        .ball(Vec3::ZERO, 1.0, glass(1.0, IOR))
        .ball(Vec3::ZERO, BALL, BLACK);
    let most = f64::from(IOR * BALL).powi(2);
    let met = 1.0 / 9.0;
    let expected = met * most * average(most, |square| 1.0 - reflectance(square.sqrt(), IOR.into()));
    assert_close(arriving(&scene, 2, 3), [expected; 3], ARRIVED, "flux into glass");
    let (deposits, _) = deposits(&scene, &settings(1, 1, 4096, 64, 1.0));
    assert!(
        !deposits.is_empty() && deposits.iter().all(|d| d.flux == Flux { units: [FLUX_ONE; 3], shift: 0 })
    );
}

#[test]
fn direct_light_within_glass_is_seen_from_outside_by_the_inverse_of_the_square() {
    // Lamp and lit ball are both within the glass, and the eye looks straight in.
    let to_lamp = Vec3::new(0.5, 0.0, 0.3);
    let scene = straight_ahead(Vec3::Z * 5.0, Vec3::NEG_Z)
        .ball(Vec3::ZERO, 1.0, glass(0.8, IOR))
        .ball(Vec3::NEG_Z * 0.1, 0.1, diffuse(0.5))
        .lamp(to_lamp, 0.02, BLACK, Rgb::ONE);
    let ior = f64::from(IOR);
    let expected = 0.5 * f64::from(0.8_f32) * (1.0 - reflectance(0.0, ior)) / (ior * ior);
    let expected = expected * lit(Vec3::Z, to_lamp, 0.02);
    assert_close(direct_light(&scene, 2), [expected; 3], SAMPLED, "a lit ball within glass");
    let settings = Settings { iterations: 4096, ..settings(1, 1, 1, 2, 1.0) };
    assert_mean(&render_path(&scene, &settings), [expected; 3], PATHS, "a lit ball within glass, by paths");
}
