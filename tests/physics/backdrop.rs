//! The background alone, of which alpha is made: where the eye sees it, and how much of it.

use crate::harness::{
    BLACK, Build, assert_mean, diffuse, empty_scene, mirror, pinhole, render_path, render_sppm, settings,
};
use scene::{Material, Rgb, Scene, Settings, Vec3};
use std::f64::consts::PI;

/// A ball of radius 1 at a distance of 4, in the middle of an image as high as it is far, under a sky.
fn before_the_sky(material: Material, emission: f32) -> Scene {
    let fov = 2.0 * 0.5_f32.atan().to_degrees();
    let scene =
        Scene { background: Rgb::new(0.2, 0.5, 3.0), ..empty_scene(pinhole(Vec3::ZERO, Vec3::Z, fov)) };
    scene.lamp(Vec3::Z * 4.0, 1.0, material, Rgb::splat(emission)).with_sky()
}

/// The share of a square image in which the ball is seen: its cone has the sine 1/4, and the image the side 1 at distance 1.
const DISC: f64 = PI / 15.0;

/// Whatever a ball is made of but glass, it hides the background, also where it mirrors it. Glass of index 1 bends no ray and
/// reflects none, and tints what is seen through it at both interfaces.
#[test]
fn the_background_is_seen_past_surfaces_and_through_glass_alone() {
    /// The edge of the disc crosses some 40 of 576 pixels, each sampled by 16 stratified points.
    const EDGE: f64 = 2e-3;
    let tint = Rgb::new(1.0, 0.5, 0.1);
    let cases = [
        (diffuse(0.9), 0.0, [0.0; 3]),
        (BLACK, 7.0, [0.0; 3]),
        (mirror(1.0), 0.0, [0.0; 3]),
        (Material::Dielectric { albedo: tint, ior: 1.0 }, 2.0, [1.0, 0.25, 0.01]),
    ];
    let settings = Settings { iterations: 16, ..settings(24, 24, 1, 8, 0.1) };
    for (material, emission, through) in cases {
        let behind = before_the_sky(material, emission).background_alone();
        let expected = through.map(|through| 1.0 - DISC + DISC * through);
        for (film, method) in
            [(render_sppm(&behind, &settings), "photons"), (render_path(&behind, &settings), "paths")]
        {
            assert_mean(&film, expected, EDGE, &format!("{material:?} by {method}"));
        }
    }
}

/// Behind glass a mirror still hides it.
#[test]
fn a_mirror_behind_glass_hides_the_background() {
    let clear = Material::Dielectric { albedo: Rgb::ONE, ior: 1.0 };
    let glass = before_the_sky(clear, 0.0);
    // Its surface is beyond the glass, and fills the image.
    let own = Scene { spheres: glass.own_spheres().to_vec().into(), ..glass.clone() };
    let with_mirror = own.ball(Vec3::Z * 40.0, 30.0, mirror(1.0)).with_sky();
    let settings = Settings { iterations: 4, ..settings(8, 8, 1, 8, 0.1) };
    let behind = |scene: &Scene| render_path(&scene.background_alone(), &settings);
    assert_mean(&behind(&glass), [1.0; 3], 1e-6, "glass alone");
    assert_mean(&behind(&with_mirror), [0.0; 3], 0.0, "with a mirror");
}

/// What moves hides the background where it is at that instant.
#[test]
fn the_background_is_hidden_by_what_moves_where_it_is() {
    let settings = Settings { iterations: 2, ..settings(24, 24, 1, 8, 0.1) };
    let (scene, velocity) = (before_the_sky(mirror(1.0), 0.0), Vec3::new(0.5, -0.25, 1.0));
    let behind = |scene: &Scene| render_path(&scene.background_alone(), &settings);
    for time in [1.0_f32, -2.0] {
        let (mut moving, mut placed) = (scene.clone(), scene.clone());
        moving.camera.shutter = [time; 2];
        moving.spheres[0].velocity = velocity;
        placed.spheres[0].center += velocity * time;
        assert!(behind(&moving) == behind(&placed) && behind(&moving) != behind(&scene), "at {time}");
    }
    // While the shutter is open, a ball whose disc has a radius of 6.2 pixels moves by 7.2: 7 pixels beside its middle it is not
    // at first, and then for four fifths of the time.
    let mut moving = scene.clone();
    moving.camera.shutter = [0.0, 1.0];
    moving.spheres[0].velocity = Vec3::X * 1.2;
    let beside = |scene: &Scene| {
        let film = render_path(&scene.background_alone(), &Settings { iterations: 24, ..settings });
        [4, 19].map(|x| film.pixels[12 * 24 + x].x)
    };
    assert_eq!(beside(&scene), [1.0; 2]);
    let [ahead, behind] = beside(&moving);
    assert!(ahead.max(behind) == 1.0 && ahead.min(behind) < 0.4, "{ahead}, {behind}");
}
