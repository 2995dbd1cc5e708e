//! Pairs of random numbers as they appear in pictures, against closed forms: where an image depends on both, numbers
//! that are related make it too bright or too dark. (A lens and the choice of a lamp: `facts::lens`.)

use super::camera::half_mirror;
use crate::cases::tell;
use crate::facts::{assert_close, direct_light, lit};
use crate::harness::{
    BLACK, Build, diffuse, empty_scene, glass, mean, pinhole, render_paths, render_photons, settings,
};
use scene::{Rgb, Scene, Settings, Vec3};

/// Relative tolerance: of 2^14 samples a quarter brings light, in proportion to a cosine. That of independent ones has a
/// standard error of 1.7 %.
const QUARTERS: f64 = 0.08;

/// Relative tolerance: of 2^18 samples a quarter brings light. That of independent ones has a standard error of 0.3 %.
const MANY_QUARTERS: f64 = 0.015;

/// Pixels in a row along the edge of a black ball.
const PIXELS: u32 = 16;

/// The height of a pixel: so small that the edge is straight, and deviates by a hundredth of a pixel.
const DEGREES: f32 = 1.0 / 64.0;

/// Only one half of the pixel shows the lit ball, and only one half of the lamp lights it.
#[test]
fn half_a_pixel_shows_half_a_lamp() {
    let (albedo, radius, distance) = (0.5, 0.1_f32, 4.0_f32);
    let whole = |sine: f64| albedo * sine * sine;
    let overhead = whole((radius / distance).into());
    // A black ball that covers the inner half of a lamp overhead, as seen from the origin.
    let inner_half = radius / distance * 0.5_f32.sqrt();
    // The horizon halves a lamp at its height.
    let sine = f64::from(radius / distance);
    let at_horizon = albedo * (sine.asin() - sine * (1.0 - sine * sine).sqrt()) / std::f64::consts::PI;
    let lamps = [
        ("the outer half of a lamp", Vec3::Z * distance, Some(inner_half), 0.5 * overhead),
        ("the upper half of a lamp along x", Vec3::X * distance, None, at_horizon),
        ("the upper half of a lamp along y", Vec3::Y * distance, None, at_horizon),
    ];
    let mut pictures = 0;
    let eye = Vec3::new(1.0, 1.0, 2.0);
    let frame = pinhole(eye, Vec3::ZERO, 1.0).frame(1, 1);
    for (side, width, height) in
        [(frame.right, 1, PIXELS), (-frame.right, 1, PIXELS), (frame.up, PIXELS, 1), (-frame.up, PIXELS, 1)]
    {
        let camera = pinhole(eye, Vec3::ZERO, DEGREES * height as f32);
        for (what, lamp, blocked, expected) in lamps {
            let mut scene = empty_scene(camera).ball(Vec3::NEG_Z, 1.0, diffuse(albedo as f32)).lamp(
                lamp,
                radius,
                BLACK,
                Rgb::ONE,
            );
            scene = scene.ball(eye * 0.85 + side * 0.3, 0.3, BLACK);
            if let Some(half) = blocked {
                scene = scene.ball(Vec3::Z * 3.0, half * 3.0, BLACK);
            }
            let many = Settings { iterations: 1 << 10, ..settings(width, height, 1, 1, 1.0) };
            for (engine, film) in
                [("SPPM", render_photons(&scene, &many)), ("paths", render_paths(&scene, &many))]
            {
                let what = format!("{engine}, {what}, covered towards {side}");
                assert_close(mean(&film), [0.5 * expected; 3], QUARTERS, &what);
                pictures += 1;
            }
        }
    }
    tell("physics", pictures, "pixels that show half of a lamp's light");
}

/// The last of some interfaces of glass lets half of the paths through, to a ball that two lamps of different colours
/// light equally.
#[test]
fn behind_glass_all_lamps_are_equally_bright() {
    for segment in 0..6 {
        let eye = Vec3::Z * 40.0;
        let panes = (0..segment).fold(scene_of_two_lamps(eye), |scene: Scene, i| {
            scene.ball(eye, 0.01 * (1.0 + i as f32), glass(1.0, 1.0))
        });
        let scene = panes.ball(eye, 0.1, glass(1.0, half_mirror()));
        let squared_index = f64::from(half_mirror()).powi(2);
        let expected = 0.5 * squared_index * 0.5 * lit(Vec3::Z, Vec3::new(8.0, 0.0, 4.0), 0.1);
        let light = direct_light(&scene, segment + 2);
        assert_close(light, [expected, expected, 0.0], MANY_QUARTERS, &format!("behind {segment} panes"));
    }
    tell("physics", 6, "numbers of interfaces before two lamps");
}

fn scene_of_two_lamps(eye: Vec3) -> Scene {
    empty_scene(pinhole(eye, Vec3::ZERO, 1e-3))
        .ball(Vec3::NEG_Z, 1.0, diffuse(0.5))
        .lamp(Vec3::new(8.0, 0.0, 4.0), 0.1, BLACK, Rgb::X)
        .lamp(Vec3::new(-8.0, 0.0, 4.0), 0.1, BLACK, Rgb::Y)
}
