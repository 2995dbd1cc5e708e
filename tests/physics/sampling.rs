//! Sampling functions that map uniform numbers to directions: each must have the density that it documents.

use crate::cases::tell;
use crate::harness::assert_uniform_square;
use rayon::prelude::*;
use reference::sampling::{
    cosine_hemisphere, frame, sincos_turn, uniform_cone, uniform_disk, uniform_sphere, unit,
};
use scene::Vec3;
use scene::rng::{Family, StreamKey};
use std::f64::consts::TAU;

const SAMPLES: u32 = 1 << 20;
const CELLS: [usize; 2] = [32, 32];

/// Tolerance of lengths: a few rounding errors of values up to 1.
const UNIT_LENGTH: f64 = 5e-7;

/// The error bound of sine and cosine that [`sincos_turn`] documents.
const SINCOS: f64 = 1.2e-7;

/// Tolerance of the sum of their squares: twice the error of the one that is close to 1.
const SQUARES: f64 = 2.5e-7;

/// Normals that are difficult for frames: axes, both poles, close to the lower pole, and a general one.
fn normals() -> [Vec3; 7] {
    [
        Vec3::X,
        Vec3::Y,
        Vec3::Z,
        Vec3::NEG_Z,
        unit(Vec3::new(1e-4, -1e-4, -1.0)),
        unit(Vec3::new(-1.0, 1.0, -1e-7)),
        unit(Vec3::new(0.3, -0.5, 0.8)),
    ]
}

/// Pairs of independent uniform numbers.
fn pairs(index: u32) -> impl Iterator<Item = (f32, f32)> {
    let key = StreamKey::new(2, Family::Path, index);
    (0..SAMPLES).map(move |i| {
        let mut stream = key.stream(i);
        (stream.next_f32(), stream.next_f32())
    })
}

/// Pairs at the borders and in the middle of the unit square.
fn extremes() -> impl Iterator<Item = (f32, f32)> {
    let ends = [0.0, f32::EPSILON / 2.0, 0.25, 0.5, 1.0 - f32::EPSILON / 2.0];
    ends.into_iter().flat_map(move |u| ends.map(|v| (u, v)))
}

/// An angle in turns, in [0, 1).
fn turns(x: f64, y: f64) -> f64 {
    let turns = y.atan2(x) / TAU;
    if turns < 0.0 { (turns + 1.0).min(1.0 - f64::EPSILON) } else { turns }
}

/// Clamps to [0, 1) what rounding has brought slightly outside.
fn clamp(x: f64) -> f64 {
    x.clamp(0.0, 1.0 - f64::EPSILON)
}

/// Coordinates of `d` in a frame around `n`, computed in `f64` without the code under test.
fn local(n: Vec3, d: Vec3) -> [f64; 3] {
    let (n, d) = (n.as_dvec3().normalize(), d.as_dvec3());
    let s = n.any_orthonormal_vector();
    [s.dot(d), n.cross(s).dot(d), n.dot(d)]
}

#[test]
fn sine_and_cosine_are_right_for_every_float_that_streams_give() {
    (0..1_u32 << 24).into_par_iter().for_each(|top| {
        let u = scene::rng::unit_float(top << 8);
        let (s, c) = sincos_turn(u);
        let (sine, cosine) = (f64::from(u) * TAU).sin_cos();
        let (s, c) = (f64::from(s), f64::from(c));
        assert!((s - sine).abs() < SINCOS && (c - cosine).abs() < SINCOS, "u = {u}");
        assert!((s * s + c * c - 1.0).abs() < SQUARES, "u = {u}");
        assert!(s.abs() <= 1.0 && c.abs() <= 1.0, "u = {u}");
    });
    tell("physics", 1 << 24, "sines and cosines: all there are");
}

#[test]
fn sine_and_cosine_are_exact_at_quarter_turns() {
    let quarters = [0.0, 0.25, 0.5, 0.75].map(sincos_turn);
    assert_eq!(quarters, [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0)]);
}

#[test]
fn spheres_are_covered_evenly() {
    let unit_square = |d: Vec3| [clamp(f64::from(d.z) / 2.0 + 0.5), turns(f64::from(d.x), f64::from(d.y))];
    assert_uniform_square(pairs(0).map(|(u, v)| unit_square(uniform_sphere(u, v))), CELLS, "uniform_sphere");
    for (u, v) in pairs(0).chain(extremes()) {
        assert!((uniform_sphere(u, v).as_dvec3().length() - 1.0).abs() < UNIT_LENGTH, "{u}, {v}");
    }
    tell("physics", SAMPLES as usize, "points of the sphere");
}

#[test]
fn hemispheres_are_covered_by_the_cosine() {
    for (index, normal) in normals().into_iter().enumerate() {
        let directions =
            || pairs(1 + index as u32).map(|(u, v)| local(normal, cosine_hemisphere(normal, u, v)));
        // With a density of cos / pi, the squared sine and the azimuth are uniform.
        let points = directions().map(|[x, y, _]| [clamp(x * x + y * y), turns(x, y)]);
        assert_uniform_square(points, CELLS, &format!("cosine_hemisphere about {normal}"));
        let below = directions().filter(|[_, _, z]| *z < 0.0).count();
        // If the uniform point is opposite to the normal within 10^-3, which has a probability of 10^-6, rounding may
        // give a direction below the horizon.
        assert!(below <= 5, "{below} directions below the horizon of {normal}");
        for (u, v) in pairs(1).take(1 << 14).chain(extremes()) {
            let length = cosine_hemisphere(normal, u, v).as_dvec3().length();
            assert!((length - 1.0).abs() < UNIT_LENGTH, "{u}, {v} about {normal}: {length}");
        }
    }
    tell("physics", 7 * SAMPLES as usize, "directions of hemispheres");
}

#[test]
fn a_cosine_hemisphere_gives_a_direction_even_opposite_to_the_sphere_point() {
    for (u, v) in pairs(9).take(1 << 16).chain(extremes()) {
        let normal = -unit(uniform_sphere(u, v));
        let direction = cosine_hemisphere(normal, u, v);
        assert!((direction.as_dvec3().length() - 1.0).abs() < UNIT_LENGTH, "{u}, {v}: {direction}");
    }
}

#[test]
fn cones_are_covered_evenly() {
    for (index, height) in [1e-6_f32, 1e-3, 0.3, 1.0, 2.0].into_iter().enumerate() {
        for (n, axis) in normals().into_iter().enumerate().skip(4) {
            let samples =
                pairs(20 + 10 * index as u32 + n as u32).map(|(u, v)| uniform_cone(axis, height, u, v));
            let points = samples.map(|(direction, h)| {
                let [x, y, z] = local(axis, direction);
                assert!((direction.as_dvec3().length() - 1.0).abs() < UNIT_LENGTH);
                assert!(
                    (1.0 - z - f64::from(h)).abs() < UNIT_LENGTH,
                    "1 - cos is {} and said to be {h}",
                    1.0 - z
                );
                assert!((0.0..=height).contains(&h));
                [clamp(f64::from(h) / f64::from(height)), turns(x, y)]
            });
            assert_uniform_square(points, CELLS, &format!("uniform_cone of height {height} about {axis}"));
        }
    }
    tell("physics", 15 * SAMPLES as usize, "directions of cones");
}

#[test]
fn disks_are_covered_evenly() {
    let points = pairs(90).map(|(u, v)| uniform_disk(u, v)).map(|(x, y)| {
        let (x, y) = (f64::from(x), f64::from(y));
        [clamp(x * x + y * y), turns(x, y)]
    });
    assert_uniform_square(points, CELLS, "uniform_disk");
    tell("physics", SAMPLES as usize, "points of the disk");
}

#[test]
fn maps_preserve_stratification() {
    // Neighbouring numbers give neighbouring directions: on a grid of 256 x 256, they differ by about a step of the
    // grid.
    let place = |i: u32| (i as f32 + 0.5) / 256.0;
    for i in 0..255 {
        for j in 0..255 {
            let (a, b) = (uniform_sphere(place(i), place(j)), uniform_sphere(place(i), place(j + 1)));
            assert!(a.distance(b) < 0.025);
        }
    }
}

#[test]
fn frames_are_orthonormal_and_right_handed() {
    let directions = pairs(91).take(1 << 16).map(|(u, v)| unit(uniform_sphere(u, v)));
    for n in directions.chain(normals()) {
        let (s, t) = frame(n);
        let [n64, s, t] = [n, s, t].map(Vec3::as_dvec3);
        for error in [s.length() - 1.0, t.length() - 1.0, s.dot(t), s.dot(n64), t.dot(n64)] {
            assert!(error.abs() < UNIT_LENGTH, "frame of {n}: {error:.1e}");
        }
        assert!(s.cross(t).distance(n64) < 2.0 * UNIT_LENGTH, "frame of {n}");
    }
    tell("physics", (1 << 16) + 7, "frames");
}
