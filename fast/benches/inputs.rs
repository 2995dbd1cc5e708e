//! Inputs for benches and tests of the kernels: functions of their size and seed alone.

// Each test and bench takes what it needs.
#![allow(dead_code)]

use fast::kernels::{Gathered, Photon, Pixel, Point, Seen};
use scene::film::FLUX_ONE;
use scene::ray::NO_SPHERE;
use scene::rng::{Family, Stream, StreamKey};
use scene::{Camera, Material, Ray, Rgb, Scene, Settings, Sphere, Vec3};

/// A stream of numbers, another for each `index`.
pub(crate) fn numbers(index: u32) -> Stream {
    StreamKey::new(11, Family::Path, 0).stream(index)
}

/// A point of the cube from `-side / 2` to `side / 2`.
pub(crate) fn place(stream: &mut Stream, side: f32) -> Vec3 {
    Vec3::from_array([(); 3].map(|()| (stream.next_f32() - 0.5) * side))
}

/// A unit vector.
pub(crate) fn direction(stream: &mut Stream) -> Vec3 {
    loop {
        let v = place(stream, 2.0);
        if (0.01..1.0).contains(&v.length_squared()) {
            return v * (1.0 / v.dot(v).sqrt());
        }
    }
}

/// Columns of uniform numbers.
pub(crate) fn uniforms<const A: usize>(count: usize) -> [Vec<f32>; A] {
    let mut stream = numbers(1);
    std::array::from_fn(|_| (0..count).map(|_| stream.next_f32()).collect())
}

/// A scene of these spheres, whose materials are diffuse, mirror and glass.
pub(crate) fn scene_of(spheres: Vec<Sphere>, eye: Vec3) -> Scene {
    Scene {
        name: "of spheres".into(),
        camera: Camera {
            eye,
            direction: Vec3::NEG_Z,
            up: Vec3::Y,
            vertical_fov_degrees: 60.0,
            aperture_radius: 0.0,
            focus_distance: 1.0,
            shutter: [0.0, 0.0],
        },
        materials: vec![
            Material::Diffuse { albedo: Rgb::new(0.2, 0.4, 0.8) },
            Material::Specular { albedo: Rgb::new(0.9, 0.7, 0.5) },
            Material::Dielectric { albedo: Rgb::new(1.0, 0.9, 0.95), ior: 1.5 },
        ],
        spheres: spheres.into(),
        background: Rgb::ZERO,
        transparent_background: false,
        imports: Vec::new(),
        settings: Settings::default(),
    }
}

/// As many spheres as unit cubes scattered in a cube, each so many times and copies far apart in order; and rays
/// among them, a quarter of them from outside.
pub(crate) fn scattered(count: usize, copies: usize, rays: usize, index: u32) -> (Vec<Sphere>, Vec<Ray>) {
    let side = (count as f32).cbrt();
    let mut stream = numbers(index);
    let mut spheres = Vec::with_capacity(count);
    for k in 0..count / copies {
        let material = if k % 3 == 0 { 2 } else { 0 };
        let radius = 0.05 + 0.6 * stream.next_f32();
        let center = place(&mut stream, side);
        let sphere = Sphere { center, velocity: Vec3::ZERO, radius, material, emission: Rgb::ZERO };
        spheres.extend(std::iter::repeat_n(sphere, copies));
    }
    let stride = (7919..9000).find(|stride| gcd(*stride, spheres.len()) == 1).unwrap();
    let shuffled = (0..spheres.len()).map(|k| spheres[k * stride % spheres.len()]).collect();
    let ray = |k| {
        let origin = place(&mut stream, if k % 4 == 0 { 3.0 * side } else { side });
        Ray { origin, direction: direction(&mut stream), leaves: NO_SPHERE }
    };
    (shuffled, (0..rays).map(ray).collect())
}

fn gcd(a: usize, b: usize) -> usize {
    if b == 0 { a } else { gcd(b, a % b) }
}

/// Photons on a square of a plane, `density` to the disk of radius 1, and visible points on it that lie together in
/// groups of 16, as neighbouring pixels do. Of one photon in ten the side is in doubt.
pub(crate) fn crowd(points: usize, density: f32, index: u32) -> (Vec<Photon>, Vec<Option<Point>>) {
    const SIDE: f32 = 60.0;
    let mut stream = numbers(index);
    let count = (density * SIDE * SIDE / std::f32::consts::PI) as u32;
    let on_plane = |stream: &mut Stream, side: f32| Vec3 { y: 0.0, ..place(stream, side) };
    let photon = |k: u32| Photon {
        point: on_plane(&mut stream, SIDE),
        wi: direction(&mut stream),
        sphere: 0,
        is_safe: !k.is_multiple_of(10),
        flux: [FLUX_ONE, k % FLUX_ONE, FLUX_ONE / 2],
        shift: 0,
    };
    let photons = (0..count).map(photon).collect();
    let mut corner = Vec3::ZERO;
    let point = |k: usize| {
        if k.is_multiple_of(16) {
            corner = on_plane(&mut stream, SIDE);
        }
        let point = corner + on_plane(&mut stream, 0.5);
        Some(Point { point, normal: Vec3::Y, sphere: 0, radius_squared: 1.0 - 0.3 * stream.next_f32() })
    };
    (photons, (0..points).map(point).collect())
}

/// Pixels in the middle of a render, with what an iteration brings; a quarter gather nothing.
pub(crate) fn pixels(count: usize) -> (Vec<Pixel>, Vec<Seen>, Vec<Gathered>) {
    let mut stream = numbers(2);
    let mut color = || Rgb::from_array([(); 3].map(|()| stream.next_f32()));
    let pixel =
        |_| Pixel { direct: color(), tau: color() * 1e3, n: 100.0 * color().x, radius_squared: color().y };
    let pixels = (0..count).map(pixel).collect();
    let seen =
        (0..count).map(|_| Seen { direct: color(), beta: color(), radius_squared: color().y }).collect();
    let gathered = |k: usize| {
        let m = if k.is_multiple_of(4) { 0 } else { 1 + k as u32 % 50 };
        Gathered { m, flux: color().to_array().map(|x| (x * m as f32 * FLUX_ONE as f32) as u128) }
    };
    let gathered = (0..count).map(gathered).collect();
    (pixels, seen, gathered)
}
