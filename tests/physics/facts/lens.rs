//! A thin lens blurs what is out of focus, whatever lights it.

use super::closed_form::{assert_close, direct_light, lit};
use crate::cases::tell;
use crate::distributed::{assert_converges, two_balls};
use crate::harness::{BLACK, Build, diffuse, empty_scene, pinhole, render_paths, render_photons, settings};
use scene::{Film, Rgb, Settings, Vec3};

/// Relative tolerance: the noise of about a thousand samples that hit the lamp, and second-order terms in the sizes of
/// lamp and lens.
const SMALL_LAMP: f64 = 5e-2;

/// Relative tolerance of halves: 2^18 samples of a lens that is half covered.
const HALVES: f64 = 1e-2;

const SIDE: u32 = 101;

/// All light of a picture, and its mean squared distance from the middle; at distance 1 from the eye, where a pixel has
/// the side `pixel`.
fn light_and_mean_square(film: &Film, pixel: f64) -> (f64, f64) {
    let (mut light, mut second_moment) = (0.0, 0.0);
    for (index, value) in film.pixels.iter().enumerate() {
        let place = |i: u32| (f64::from(i) - f64::from(SIDE / 2)) * pixel;
        let r2 = place(index as u32 % SIDE).powi(2) + place(index as u32 / SIDE).powi(2);
        light += f64::from(value.x) * pixel * pixel;
        second_moment += f64::from(value.x) * pixel * pixel * r2;
    }
    (light, second_moment / light)
}

#[test]
fn eye_sees_a_point_out_of_focus_as_a_disc_of_the_lens() {
    // A lens of radius A that is focused at f blurs a point at distance d to a disc of radius A |1/f - 1/d| at distance
    // 1.
    let (aperture, focus) = (0.5_f32, 4.0_f32);
    for distance in [2.5_f32, 4.0, 8.0] {
        let lamp_radius = 0.01 * distance;
        let mut scene = empty_scene(pinhole(Vec3::ZERO, Vec3::NEG_Z, 30.0));
        scene = scene.lamp(Vec3::NEG_Z * distance, lamp_radius, BLACK, Rgb::ONE);
        (scene.camera.aperture_radius, scene.camera.focus_distance) = (aperture, focus);
        let settings = Settings { iterations: 400, ..settings(SIDE, SIDE, 1, 1, 1.0) };
        for film in [render_paths(&scene, &settings), render_photons(&scene, &settings)] {
            let pixel = 2.0 * 15.0_f64.to_radians().tan() / f64::from(SIDE);
            let (light, mean_square) = light_and_mean_square(&film, pixel);
            // Blurring preserves the total light. The image is the convolution of the discs of lens and lamp, so their
            // mean squared radii add up. That of a disc is half its squared radius, that of a pixel a sixth of its
            // squared side.
            let disc = f64::from(aperture) * (1.0 / f64::from(focus) - 1.0 / f64::from(distance)).abs();
            let expected_light = std::f64::consts::PI * 0.01_f64.powi(2);
            let expected = 0.5 * disc * disc + 0.5 * 0.01_f64.powi(2) + pixel * pixel / 6.0;
            let what = format!("distance {distance}");
            assert_close([light; 3], [expected_light; 3], SMALL_LAMP, &what);
            assert_close([mean_square; 3], [expected; 3], SMALL_LAMP, &what);
        }
    }
    tell("physics", 6, "discs of a point out of focus");
}

#[test]
fn photons_are_seen_through_the_lens_as_the_path_tracer_sees_them() {
    let sharp = two_balls();
    let mut scene = sharp.clone();
    scene.camera.aperture_radius = 0.6;
    assert_converges(&scene, &sharp);
}

/// A black ball covers one half of the lens. The other half sees one point, which two lamps of different colours light
/// equally. If the choice of lamp were related to the place on the lens, one colour would be too bright.
#[test]
fn direct_light_of_every_lamp_is_seen_through_half_a_lens() {
    let expected = 0.5 * 0.5 * lit(Vec3::Z, Vec3::new(8.0, 0.0, 4.0), 0.1);
    for side in [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y] {
        let mut scene = empty_scene(pinhole(Vec3::Z * 10.0, Vec3::ZERO, 1e-3))
            .ball(Vec3::NEG_Z, 1.0, diffuse(0.5))
            .lamp(Vec3::new(8.0, 0.0, 4.0), 0.1, BLACK, Rgb::X)
            .lamp(Vec3::new(-8.0, 0.0, 4.0), 0.1, BLACK, Rgb::Y)
            .ball(side * 2.0 + Vec3::Z * 8.0, 2.0, BLACK);
        (scene.camera.aperture_radius, scene.camera.focus_distance) = (0.01, 10.0);
        let light = direct_light(&scene, 1);
        assert_close(light, [expected, expected, 0.0], HALVES, &format!("covered towards {side}"));
    }
    tell("physics", 4, "halves of a lens");
}
