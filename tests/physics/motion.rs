//! Spheres that move: where they are at an instant, and that the sky is around them as long as the shutter is open.

use crate::harness::{
    Build, assert_mean, diffuse, empty_scene, glass, mirror, pinhole, render_path, render_sppm, settings,
};
use scene::{Camera, Rgb, Scene, Settings, Spheres, Vec3};

fn moved(spheres: &Spheres, velocities: &[Vec3]) -> Spheres {
    let with = |(sphere, velocity): (&scene::Sphere, &Vec3)| scene::Sphere { velocity: *velocity, ..*sphere };
    spheres.iter().zip(velocities).map(with).collect()
}

/// A shutter may open for no time, at any time: then spheres that move are where they are at that instant, as if they were
/// there from the beginning. Bit by bit, as all numbers are exact: lamps, glass and the sky among them.
#[test]
fn at_one_instant_spheres_are_where_their_velocities_have_taken_them() {
    let room = |camera: Camera, at: &dyn Fn(Vec3, Vec3) -> Vec3, velocities: &[Vec3; 4]| {
        let [a, b, c, d] = *velocities;
        let scene = Scene { background: Rgb::splat(0.25), ..empty_scene(camera) };
        scene
            .ball(at(Vec3::new(0.0, -101.0, -8.0), a), 100.0, diffuse(0.75))
            .lamp(at(Vec3::new(2.0, 3.0, -8.0), b), 0.5, diffuse(0.5), Rgb::splat(9.0))
            .ball(at(Vec3::new(-1.0, 0.0, -8.0), c), 1.0, glass(1.0, 1.5))
            .ball(at(Vec3::new(1.5, 0.0, -9.0), d), 1.0, mirror(0.75))
    };
    let velocities =
        [Vec3::ZERO, Vec3::new(-4.0, 0.0, 2.0), Vec3::new(2.0, 2.0, 0.0), Vec3::new(0.0, 1.0, 4.0)];
    let camera = pinhole(Vec3::ZERO, Vec3::NEG_Z, 40.0);
    for time in [0.5_f32, -2.0] {
        let placed = room(camera, &|center, velocity| center + velocity * time, &velocities).with_sky();
        let moving = room(Camera { shutter: [time; 2], ..camera }, &|center, _| center, &velocities);
        let moving = Scene { spheres: moved(&moving.spheres, &velocities), ..moving }.with_sky();
        let settings = Settings { iterations: 2, ..settings(16, 12, 500, 6, 0.5) };
        assert!(render_sppm(&moving, &settings) == render_sppm(&placed, &settings), "by photons at {time}");
        assert!(render_path(&moving, &settings) == render_path(&placed, &settings), "by paths at {time}");
    }
}

/// A convex ball under a uniform sky has the radiance of its albedo times the sky's, wherever it flies while the shutter is
/// open. It fills the image at all times, as it comes from afar or goes there. Directions are drawn by the cosine, so every
/// sample is exact.
#[test]
fn the_sky_lights_a_ball_that_flies_from_afar() {
    /// Roundings of `f32`.
    const ROUNDING: f64 = 1e-5;
    let camera = Camera { shutter: [0.0, 1.0], ..pinhole(Vec3::ZERO, Vec3::NEG_Z, 2.0) };
    for (begin, end) in [(-10.0_f32, -190.0_f32), (-190.0, -10.0)] {
        let scene = Scene { background: Rgb::new(1.0, 2.0, 0.5), ..empty_scene(camera) };
        let scene = scene.ball(Vec3::Z * begin, 8.0, diffuse(0.5));
        let spheres = moved(&scene.spheres, &[Vec3::Z * (end - begin)]);
        let scene = Scene { spheres, ..scene }.with_sky();
        let settings = Settings { iterations: 16, ..settings(4, 4, 16, 4, 0.5) };
        let what = format!("from {begin} to {end}");
        assert_mean(&render_sppm(&scene, &settings), [0.5, 1.0, 0.25], ROUNDING, &what);
        assert_mean(&render_path(&scene, &settings), [0.5, 1.0, 0.25], ROUNDING, &what);
    }
}
