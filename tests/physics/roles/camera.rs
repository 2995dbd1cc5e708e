//! The roles of the random numbers of SPPM's camera paths: a scene for each that shows its number.

use super::Role;
use crate::harness::{BLACK, Build, diffuse, empty_scene, glass, pinhole, settings};
use reference::camera_pass::{CameraNumbers, CameraSample, camera_ray, trace};
use scene::{Camera, Rgb, Scene, Settings, Stats, Vec3};

/// The side of the image, and so how its tiles are numbered.
const SIDE: u32 = 16;

/// The last segment whose lobe is tested: two beyond those that are stratified.
const LAST_LOBE: u32 = 5;

/// The index at which glass reflects half of what meets it at right angles.
pub(super) fn half_mirror() -> f32 {
    3.0 + 8.0_f32.sqrt()
}

fn numbers(seed: u64, iteration: u32, [x, y]: [u32; 2]) -> CameraNumbers {
    CameraNumbers::new(&Settings { seed, ..settings(SIDE, SIDE, 1, 1, 1.0) }, iteration, x, y)
}

/// The shutter time.
pub(super) fn time(iteration: u32) -> Role {
    let camera = Camera { shutter: [0.0, 1.0], ..Camera::default() };
    Role::of_many("time", |seed| Some(camera.shutter_time(seed, iteration).into()))
}

/// The roles of the path of a pixel.
pub(super) fn roles(iteration: u32, pixel: [u32; 2]) -> Vec<Role> {
    let mut roles = Vec::new();
    let numbers = |seed| numbers(seed, iteration, pixel);
    let pinhole_frame = pinhole(Vec3::ZERO, Vec3::NEG_Z, 40.0).frame(SIDE, SIDE);
    let in_pixel = |seed, axis: usize| {
        let (ray, _) = camera_ray(&pinhole_frame, None, pixel[0], pixel[1], &numbers(seed));
        Some(f64::from(ray.direction[axis] / ray.direction.z))
    };
    roles.push(Role::of_many("place in the pixel, x", |seed| in_pixel(seed, 0)));
    roles.push(Role::of_many("place in the pixel, y", |seed| in_pixel(seed, 1)));
    let lens = Camera { aperture_radius: 1.0, focus_distance: 5.0, ..pinhole(Vec3::ZERO, Vec3::NEG_Z, 40.0) };
    let lens_frame = lens.frame(SIDE, SIDE);
    let on_lens = |seed| camera_ray(&lens_frame, None, pixel[0], pixel[1], &numbers(seed)).0.origin;
    roles.push(Role::of_many("place on the lens, radius", |seed| Some(on_lens(seed).length().into())));
    let angle = |at: Vec3| f64::from(at.y).atan2(at.x.into()) + std::f64::consts::PI;
    // Angles begin at the right.
    let turned = |at: Vec3| angle(-at);
    roles.push(Role::of_many("place on the lens, angle", |seed| Some(turned(on_lens(seed)))));
    for segment in 0..=LAST_LOBE {
        let (scene, depth) = shells(segment);
        let passes = |seed| sample(&scene, depth, &mut numbers(seed)).direct != Rgb::ZERO;
        roles.push(Role::of_two(format!("lobe of segment {segment}"), passes));
    }
    let lamps = two_lamps();
    roles.push(Role::of_two("choice of lamp", |seed| {
        let light = sample(&lamps, 1, &mut numbers(seed)).direct;
        light.x > light.y
    }));
    let overhead = lamp_at(Vec3::Z * 3.0, 2.0);
    roles.push(Role::of_many("place on the lamp, height", |seed| {
        Some(sample(&overhead, 1, &mut numbers(seed)).direct.x.into())
    }));
    let at_horizon = lamp_at(Vec3::X * 3.0, 1.0);
    roles.push(Role::of_two("place on the lamp, angle", |seed| {
        sample(&at_horizon, 1, &mut numbers(seed)).direct != Rgb::ZERO
    }));
    roles
}

/// The eye in the middle of `segment` shells of glass that does nothing, then one that reflects half, then a lamp; and
/// the depth at which only a path that is refracted by the last shell sees the lamp.
pub(super) fn shells(segment: u32) -> (Scene, u32) {
    let scene = empty_scene(pinhole(Vec3::ZERO, Vec3::X, 1e-3)).lamp(Vec3::ZERO, 100.0, BLACK, Rgb::ONE);
    let scene = (0..segment).fold(scene, |scene, i| scene.ball(Vec3::ZERO, 1.0 + i as f32, glass(1.0, 1.0)));
    (scene.ball(Vec3::ZERO, 1.0 + segment as f32, glass(1.0, half_mirror())), segment + 2)
}

/// A lit ball below the origin, whose top the eye sees.
fn lit_ball() -> Scene {
    empty_scene(pinhole(Vec3::Z * 9.0, Vec3::ZERO, 1e-3)).ball(Vec3::NEG_Z, 1.0, diffuse(0.5))
}

/// Lamps of two colours that light the ball equally.
pub(super) fn two_lamps() -> Scene {
    lit_ball().lamp(Vec3::new(5.0, 0.0, 4.0), 0.5, BLACK, Rgb::X).lamp(
        Vec3::new(-5.0, 0.0, 4.0),
        0.5,
        BLACK,
        Rgb::Y,
    )
}

/// One lamp over the ball. The eye is aside, so that the lamp does not hide the ball.
pub(super) fn lamp_at(center: Vec3, radius: f32) -> Scene {
    let aside = pinhole(Vec3::new(0.0, 9.0, 0.5), Vec3::ZERO, 1e-3);
    Scene { camera: aside, ..lit_ball() }.lamp(center, radius, BLACK, Rgb::ONE)
}

/// The path of the pixel in the middle of `scene`.
fn sample(scene: &Scene, depth: u32, numbers: &mut CameraNumbers) -> CameraSample {
    let frame = scene.camera.frame(1, 1);
    let ray = camera_ray(&frame, None, 0, 0, numbers);
    trace(&scene.at(0.0), ray, depth, numbers, &mut Stats::default())
}
