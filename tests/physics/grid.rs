//! The reference's spatial grid, compared with brute force.

use crate::cases::tell;
use crate::harness::{Build, coloured, diffuse, empty_scene, glass, mirror, pinhole, run, settings};
use proptest::prelude::*;
use proptest::test_runner::{RngAlgorithm, RngSeed};
use reference::Sppm;
use reference::camera_pass::{CameraNumbers, VisiblePoint, camera_ray, trace};
use reference::consolidate::ALPHA;
use reference::grid::Grid;
use reference::photon_pass::photon_pass;
use scene::aim::Aim;
use scene::{Engine, Rgb, Scene, Settings, Stats, Vec3};

const CELL_SIZES: [f32; 7] = [0.5, 0.75, 1.0, 2.0, 3.3, 5.0, 8.0];

fn visible_at(point: Vec3) -> VisiblePoint {
    VisiblePoint { point, normal: Vec3::Z, sphere: 0, beta: Rgb::ONE }
}

/// Asserts that for each photon, the grid finds every point within whose radius it lies, and no point twice.
fn check(
    points: &[VisiblePoint],
    radii: &[f32],
    photons: &[Vec3],
    multiple: f32,
) -> Result<(), TestCaseError> {
    let grid = Grid::build(points, |i| radii[i], multiple);
    for photon in photons {
        let within = |&i: &usize| {
            let d = *photon - points[i].point;
            d.dot(d) < radii[i] * radii[i]
        };
        let expected: Vec<usize> = (0..points.len()).filter(within).collect();
        let mut all: Vec<usize> = grid.candidates(*photon).collect();
        all.sort_unstable();
        let mut once = all.clone();
        once.dedup();
        prop_assert_eq!(&all, &once, "a point is found twice from {}", photon);
        let found: Vec<usize> = all.into_iter().filter(within).collect();
        prop_assert_eq!(found, expected, "from {}, cells of {} radii", photon, multiple);
    }
    Ok(())
}

/// Coordinates on cell borders (multiples of a half), just below them, anywhere, and far away.
fn coordinate() -> impl Strategy<Value = f32> {
    prop_oneof![
        (-8_i32..8).prop_map(|i| i as f32 * 0.5),
        (-8_i32..8).prop_map(|i| (i as f32 * 0.5).next_down()),
        -4.0_f32..4.0,
        -1e3_f32..1e3,
    ]
}

fn position() -> impl Strategy<Value = Vec3> {
    (coordinate(), coordinate(), coordinate()).prop_map(|(x, y, z)| Vec3::new(x, y, z))
}

/// Radii up to 1, including exactly 1.
fn search_radius() -> impl Strategy<Value = f32> {
    prop_oneof![Just(1.0_f32), Just(0.5), 0.01_f32..1.0]
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 200,
        rng_seed: RngSeed::Fixed(1),
        // The alternatives of `prop_oneof!` draw seeds of their own, which is slow with ChaCha.
        rng_algorithm: RngAlgorithm::XorShift,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn candidates_are_what_brute_force_finds_each_once(
        points in prop::collection::vec((position(), search_radius()), 0..80),
        strangers in prop::collection::vec(position(), 1..40),
        multiple in prop::sample::select(&CELL_SIZES[..]),
    ) {
        let (points, radii): (Vec<_>, Vec<_>) = points.into_iter().map(|(p, r)| (visible_at(p), r)).unzip();
        // Photons at the points, at a distance of their radius along each axis, and anywhere.
        let mut photons = strangers;
        for (visible, radius) in points.iter().zip(&radii) {
            photons.push(visible.point);
            photons.extend(Vec3::AXES.into_iter().flat_map(|a| [visible.point + a * *radius, visible.point - a * *radius]));
        }
        check(&points, &radii, &photons, multiple)?;
    }
}

#[test]
fn one_point_and_no_point() {
    for multiple in CELL_SIZES {
        let photons = [Vec3::ZERO, Vec3::splat(0.5), Vec3::splat(1e9), Vec3::splat(-1e30)];
        check(&[], &[], &photons, multiple).unwrap();
        check(&[visible_at(Vec3::ZERO)], &[1.0], &photons, multiple).unwrap();
        check(&[visible_at(Vec3::splat(1e4))], &[1e-3], &photons, multiple).unwrap();
    }
}

#[test]
fn many_points_in_one_place_are_each_found_once() {
    let points = vec![visible_at(Vec3::splat(2.0)); 1000];
    check(&points, &vec![1.0; 1000], &[Vec3::splat(2.0), Vec3::new(2.9, 2.0, 2.0)], 2.0).unwrap();
}

/// A closed room of huge walls with a lamp, a mirror and glass.
pub(crate) fn room() -> Scene {
    let mut scene = empty_scene(pinhole(Vec3::new(0.0, 0.0, 9.0), Vec3::new(0.0, -1.0, 0.0), 60.0));
    for (axis, albedo) in [(Vec3::X, [0.7, 0.2, 0.2]), (Vec3::Y, [0.7, 0.7, 0.7]), (Vec3::Z, [0.3, 0.6, 0.8])]
    {
        for side in [-1.0, 1.0] {
            scene = scene.ball(axis * (side * (10.0 - 1e4)), 1e4, coloured(albedo));
        }
    }
    scene
        .lamp(Vec3::new(0.0, 7.0, 0.0), 1.5, diffuse(0.3), Rgb::new(30.0, 20.0, 10.0))
        .ball(Vec3::new(-4.0, -7.0, -2.0), 3.0, mirror(0.9))
        .ball(Vec3::new(4.0, -7.0, 1.0), 3.0, glass(0.95, 1.5))
}

#[test]
fn images_radii_and_counts_do_not_depend_on_the_cell_size() {
    let scene = room();
    let settings = Settings { iterations: 3, ..settings(48, 27, 5000, 6, 1.0) };
    let render = |cell_size| {
        let mut engine = Sppm::with_cell_size(&scene, &settings, cell_size);
        (0..settings.iterations).for_each(|_| engine.iterate());
        (engine.develop(), engine.radius(), engine.count(), engine.stats().contributions)
    };
    let expected = render(1.0);
    for cell_size in CELL_SIZES {
        assert!(render(cell_size) == expected, "cells of {cell_size} radii give another image");
    }
    assert!(
        run(Sppm::new(&scene, &settings), &settings) == expected.0,
        "the default cells give another image"
    );
    tell("physics", CELL_SIZES.len(), "sizes of cells");
}

#[test]
fn photon_counts_are_those_of_brute_force() {
    let scene = room();
    // 48 x 27 = 1296 divides the table size of the published program, which then counts points twice.
    for (width, height) in [(48, 27), (36, 30), (7, 3)] {
        let settings = settings(width, height, 3000, 6, 1.5);
        let mut engine = Sppm::new(&scene, &settings);
        engine.iterate();
        let counts = engine.count().unwrap().values;

        let still = scene.at(0.0);
        let mut stats = Stats::default();
        let mut deposits = Vec::new();
        photon_pass(
            &still,
            &Aim::default(),
            &settings,
            0,
            0..settings.photons_per_iteration,
            &mut stats,
            |deposit, _| {
                deposits.push(*deposit);
            },
        );
        let frame = scene.camera.frame(width, height);
        let mut total = 0;
        for (index, count) in counts.into_iter().enumerate() {
            let (x, y) = (index as u32 % width, index as u32 / width);
            let mut numbers = CameraNumbers::new(&settings, 0, x, y);
            let ray = camera_ray(&frame, None, x, y, &numbers);
            let visible = trace(&still, ray, settings.max_depth, &mut numbers, &mut stats).visible;
            let m = visible.map_or(0, |v| {
                let near = deposits.iter().filter(|d| (d.point - v.point).length_squared() < 2.25);
                near.filter(|d| d.wi.dot(v.normal) > 0.0).count()
            });
            assert_eq!(count, ALPHA * m as f32, "pixel ({x}, {y})");
            total += m;
        }
        assert_eq!(engine.stats().contributions, total as u64);
        assert!(total > 100, "too few photons for a test");
    }
    tell("physics", 48 * 27 + 36 * 30 + 7 * 3, "pixels whose photons are those of brute force");
}
