//! Photons guided by tables: their directions, their weights, and that the image stays what it is.

use crate::cases::tell;
use crate::harness::{
    BLACK, Build, assert_same_blocks, diffuse, empty_scene, glass, mean, mirror, pinhole, relative_error,
    render_aimed, render_path_fast, settings,
};
use glam::DVec3;
use reference::emission::emit;
use reference::photon_numbers::PhotonNumbers;
use reference::photon_pass::quantise;
use reference::sampling::{cosine_hemisphere, uniform_sphere};
use reference::survey::survey;
use scene::aim::{Aim, Arrival, Targets};
use scene::film::FLUX_ONE;
use scene::guide::{Edge, Found, Guide, Guided, Lit, SIDE, SURFACES, Shares};
use scene::{Rgb, Scene, Settings, Vec3};
use std::f64::consts::PI;
use std::sync::Arc;

/// Shares that differ in all cells, and are 0 in some.
fn uneven(seed: u32) -> Shares {
    let value = |u: usize, v: usize| ((u * 5 + v * 3 + seed as usize * 7) % 13 % 6).pow(3) as f64;
    let sum: f64 = (0..SIDE).flat_map(|u| (0..SIDE).map(move |v| value(u, v))).sum();
    std::array::from_fn(|u| std::array::from_fn(|v| value(u, v) / sum))
}

/// A guide that knows nothing of the scene: all its tables differ. Parts begin at -3 and are 1.5 wide.
fn senseless(seed: u32) -> Guide {
    Guide::of_shares(Vec3::splat(-3.0), 1.0 / 1.5, (seed..seed + SURFACES).map(uneven), &uneven(seed))
}

fn guided_by(guide: Guide) -> Targets {
    Targets { guide: Some(Arc::new(guide)), ..Targets::default() }
}

/// Numbers of a lattice: cells are 16 by 16 of them and more.
const LATTICE: usize = 512;

/// The lattice against the integral; a cell's border lies between two of its points.
const QUADRATURE: f64 = 4e-3;

fn lattice() -> impl Iterator<Item = (f32, f32)> {
    let number = |k: usize| (k as f32 + 0.5) / LATTICE as f32;
    (0..LATTICE * LATTICE).map(move |k| (number(k / LATTICE), number(k % LATTICE)))
}

#[test]
fn surfaces_scatter_the_power_of_the_cosine_whatever_guides_it() {
    let guide = senseless(3);
    for (k, normal) in [Vec3::X, Vec3::NEG_Z, Vec3::new(0.48, -0.6, 0.64)].into_iter().enumerate() {
        let table = guide.surface(Vec3::splat(k as f32), normal);
        let ball = Vec3::new(0.3, -0.4, 0.2) + normal;
        let (mut power, mut way, mut squares, mut to_ball) = (0.0, DVec3::ZERO, 0.0, 0.0);
        for (u, v) in lattice() {
            let Guided { u, v, weight } = guide.guided(table, u, v);
            let direction = cosine_hemisphere(normal, u, v);
            let cos = f64::from(direction.dot(normal));
            let weight = f64::from(weight) / (LATTICE * LATTICE) as f64;
            power += weight;
            way += direction.as_dvec3() * weight;
            squares += cos * cos * weight;
            if ball.normalize().dot(direction) > (1.0_f32 - 0.3 * 0.3).sqrt() {
                to_ball += weight;
            }
        }
        let n = normal.as_dvec3();
        // Moments of cos / pi, and the form factor of a ball, whose directions have a sine below 0.3.
        assert!((power - 1.0).abs() < QUADRATURE, "{power}");
        assert!(way.distance(n * (2.0 / 3.0)) < QUADRATURE, "{way}, not {n} * 2 / 3");
        assert!((squares - 0.5).abs() < QUADRATURE, "{squares}");
        let form_factor = 0.09 * f64::from(ball.normalize().dot(normal));
        assert!((to_ball / form_factor - 1.0).abs() < 0.03, "{to_ball}, not {form_factor}");
    }
    tell("physics", 3, "surfaces that guide photons");
}

/// Of 2^20 photons some parts of a sphere, an eighth each.
const OCTANT: f64 = 5e-3;

/// Uniform over lamp and directions together: each octant of normals and directions has its share of the power in closed form, and so
/// has each colour.
#[test]
fn lamps_emit_by_the_cosine_whatever_guides_it() {
    const PHOTONS: u32 = 1 << 20;
    let lamps = [(Vec3::new(4.0, 0.0, 0.0), 0.5, [1.0, 2.0, 4.0]), (Vec3::ZERO, 30.0, [0.01, 0.005, 0.002])];
    let scene = lamps.iter().fold(empty_scene(pinhole(Vec3::Z, Vec3::ZERO, 30.0)), |scene, lamp| {
        scene.lamp(lamp.0, lamp.1, BLACK, Rgb::from_array(lamp.2))
    });
    let still = scene.at(0.0);
    let aim = Aim::new(&still, &guided_by(senseless(1)), PHOTONS);
    assert!(aim.departures.is_some());
    let numbers = PhotonNumbers::new(1, 0);
    let (mut octants, mut cosines, mut power, mut heaviest) = ([0.0; 8], [0.0; 2], [DVec3::ZERO; 2], 0.0_f32);
    for photon in 0..PHOTONS {
        let emitted = emit(&still, &aim, &numbers, photon).unwrap();
        let index = usize::from(emitted.ray.leaves == still.lights.entries[1].sphere);
        let (center, radius, _) = lamps[still.lights.entries[index].sphere as usize];
        let outward = (emitted.ray.origin - center) / radius;
        assert!((outward.length() - 1.0).abs() < 1e-4, "photons start on their lamp");
        let normal = if still.lights.entries[index].inside { -outward } else { outward };
        let cos = normal.dot(emitted.ray.direction);
        assert!(cos > -1e-4, "a photon starts into its lamp");
        let weight = f64::from(emitted.power.max_element()) / f64::from(PHOTONS);
        heaviest = heaviest.max(emitted.power.max_element());
        power[index] += emitted.power.as_dvec3() / f64::from(PHOTONS);
        cosines[index] += f64::from(cos) * weight;
        let octant =
            |v: Vec3| usize::from(v.x > 0.0) + 2 * usize::from(v.y > 0.0) + 4 * usize::from(v.z > 0.0);
        octants[octant(emitted.ray.direction)] += weight;
    }
    for octant in octants {
        assert!((octant - 0.125).abs() < OCTANT * 0.125, "{octants:?}");
    }
    for (index, light) in still.lights.entries.iter().enumerate() {
        let share = f64::from(light.probability);
        let expected = light.photon_power.as_dvec3() * share;
        assert!((power[index] / expected - 1.0).abs().max_element() < OCTANT, "{power:?}");
        assert!((cosines[index] / share - 2.0 / 3.0).abs() < OCTANT, "{cosines:?}");
    }
    assert!(heaviest > 2.0, "nothing is guided: {heaviest}");
    tell("physics", PHOTONS as usize, "photons that leave guided");
}

/// Of the fewest that are guided, each cell of directions has few: all together carry what the lamp sends, to roundings.
#[test]
fn few_photons_carry_the_power_of_their_lamp_whatever_guides_it() {
    /// Roundings of weights.
    const ROUNDING: f64 = 1e-6;
    let scene = empty_scene(pinhole(Vec3::Z, Vec3::ZERO, 30.0)).lamp(Vec3::ZERO, 0.01, BLACK, Rgb::ONE);
    let still = scene.at(0.0);
    for (seed, photons) in [(1, 1 << 13), (2, 9_001), (3, 12_345)] {
        let aim = Aim::new(&still, &guided_by(senseless(seed)), photons);
        assert!(aim.departures.is_some());
        let numbers = PhotonNumbers::new(seed.into(), 0);
        let carried =
            (0..photons).map(|photon| f64::from(emit(&still, &aim, &numbers, photon).unwrap().power.x));
        let expected = f64::from(still.lights.entries[0].photon_power.x);
        let share = carried.sum::<f64>() / f64::from(photons) / expected;
        assert!((share - 1.0).abs() < ROUNDING, "{photons} photons carry {share} of the power");
    }
    tell("physics", 3, "iterations of few guided photons");
}

/// The part of a lamp's photons that meet a ball, over the power that is guided anywhere.
#[test]
fn a_ball_gets_what_lamps_send_it_whatever_guides_it() {
    const PHOTONS: u32 = 1 << 20;
    let scene = empty_scene(pinhole(Vec3::Z, Vec3::ZERO, 30.0)).lamp(Vec3::ZERO, 0.01, BLACK, Rgb::ONE);
    let still = scene.at(0.0);
    for seed in 0..3 {
        let aim = Aim::new(&still, &guided_by(senseless(seed)), PHOTONS);
        let numbers = PhotonNumbers::new(seed.into(), 0);
        for center in [Vec3::new(3.0, 0.0, 0.0), Vec3::new(0.0, -3.0, 0.1), Vec3::new(-1.0, 2.0, -2.0)] {
            let ball = scene::aim::Target::ball(center, 0.8);
            let emitted = (0..PHOTONS).filter_map(|photon| emit(&still, &aim, &numbers, photon));
            let crossing = emitted.filter(|e| ball.is_crossed(e.ray.origin, e.ray.direction));
            let power: f64 = crossing.map(|e| f64::from(e.power.x)).sum::<f64>() / f64::from(PHOTONS);
            // Of a point, the solid angle over 4 pi.
            let sin2 = 0.64 / f64::from(center.length_squared());
            let expected = 2.0 * PI * (1.0 - (1.0 - sin2).sqrt()) / (4.0 * PI);
            assert!((power / expected - 1.0).abs() < 0.02, "{center}, {seed}: {power}, not {expected}");
        }
    }
    tell("physics", 9, "balls that receive guided photons");
}

/// What is learnt of a line is the cell from which the cosine's map, or that of a lamp, draws it.
#[test]
fn lines_are_learnt_in_the_cells_that_draw_them() {
    const WALKS: u32 = 512;
    for normal in [Vec3::Z, Vec3::NEG_X, Vec3::new(0.6, -0.64, 0.48)] {
        for (row, column) in (0..SIDE).flat_map(|row| (0..SIDE).map(move |column| (row, column))) {
            let mut found = Found::default();
            for walk in 0..WALKS {
                // Not at the borders, where roundings decide.
                let inner =
                    |k: u32, cell: usize| (cell as f32 + 0.02 + 0.96 * (k as f32 / 31.0)) / SIDE as f32;
                let (u, v) = (inner(walk % 32, row), inner(walk / 16 % 32, column));
                let edge =
                    Edge { walk, point: Vec3::ZERO, normal, direction: cosine_hemisphere(normal, u, v) };
                found.edges.push(edge);
                let arrival = Arrival { point: Vec3::ZERO, source: -2.0 * uniform_sphere(u, v), flux: 1.0 };
                found.lit.push(Lit { walk, is_seen: false, arrival });
            }
            let guide = Guide::learn(WALKS, &[found], 0.9).unwrap();
            let table = guide.surface(Vec3::ZERO, normal);
            let counts = |u: f32, v: f32| {
                let Guided { u, v, .. } = guide.guided(table, u, v);
                [u, v].map(|x| ((x * SIDE as f32) as usize).min(SIDE - 1)) == [row, column]
            };
            let numbers = |k: u32| (k as f32 + 0.5) / 32.0;
            let hits = (0..1024).filter(|k| counts(numbers(k / 32), numbers(k % 32))).count();
            assert!(hits > 400, "{row}, {column} at {normal}: {hits} of 1024");
            let share = guide.departures[row][column];
            assert!(share > 0.4, "{row}, {column}: {share} of photons leave there");
        }
    }
    tell("physics", 3 * SIDE * SIDE, "cells of lines");
}

/// Units of flux over the nominal power: a light channel is rounded by half a unit of 2^-18, and a photon that counts in multiples of
/// the unit by 2^-14 of its brightest channel.
const FINEST: f64 = 1.0 / (1 << 19) as f64;
const COARSEST: f64 = 1.0 / (1 << 14) as f64;

/// A flux, divided by the scale by which sums are divided in the end, is the power.
#[test]
fn fluxes_of_guided_photons_are_counted_in_the_unit_they_are_rounded_to() {
    let aim = Aim { guide: Some(Arc::new(senseless(0))), ..Aim::default() };
    let mut count = 0;
    for weight in [1.0 / 64.0, 0.37, 1.0, 2.9, 7.99, 8.0, 19.0, 127.0] {
        for color in [[1.0, 1.0, 1.0], [1.0, 0.5, 0.003], [0.0, 1.0, 0.2], [0.01, 0.0, 1.0]] {
            let power = Rgb::from_array(color) * weight;
            let (values, brightest) = (quantise(&aim, power).values(), f64::from(power.max_element()));
            for (value, exact) in values.into_iter().zip(power.to_array()) {
                let found = value as f64 / f64::from(FLUX_ONE) / f64::from(aim.scale());
                let error = (found - f64::from(exact)).abs();
                assert!(error <= FINEST.max(COARSEST * brightest), "{power} counts as {values:?}: {found}");
                // Lighter than 8 is the finest unit.
                assert!(brightest >= 8.0 || error <= FINEST, "{power} counts as {values:?}: {found}");
                count += 1;
            }
        }
    }
    tell("physics", count, "fluxes of guided photons");
}

/// Noise of two renders with the same camera paths.
const SAME_MEAN: f64 = 1e-2;

#[test]
fn whatever_guides_photons_a_closed_room_looks_the_same() {
    let scene = empty_scene(pinhole(Vec3::new(0.0, 0.0, 2.9), Vec3::ZERO, 90.0))
        .ball(Vec3::ZERO, 3.0, diffuse(0.6))
        .ball(Vec3::new(-1.0, -1.0, 0.5), 0.6, glass(1.0, 1.5))
        .ball(Vec3::new(1.2, -1.0, -0.5), 0.6, mirror(0.9))
        .lamp(Vec3::new(0.5, 1.0, 0.0), 0.3, BLACK, Rgb::splat(10.0))
        .lamp(Vec3::new(-1.0, 0.0, -1.0), 0.05, BLACK, Rgb::splat(100.0));
    let settings = Settings { iterations: 8, ..settings(32, 32, 100_000, 5, 0.2) };
    let expected = mean(&render_aimed(&scene, &settings, &Targets::default()));
    for seed in 0..3 {
        let actual = mean(&render_aimed(&scene, &settings, &guided_by(senseless(seed))));
        let error = relative_error(actual, expected);
        assert!(error < SAME_MEAN, "{seed}: {actual:?} and {expected:?}");
    }
    tell("physics", 3, "closed rooms with photons guided anywhere");
}

/// A room 60 high, of which the eye sees a corner with balls of chalk and glass.
fn tower() -> Scene {
    let wall = |scene: Scene, axis: Vec3| scene.ball(axis * (1000.0 + 4.0), 1000.0, diffuse(0.6));
    let scene = empty_scene(pinhole(Vec3::new(0.0, 0.0, 3.8), Vec3::new(0.0, -2.5, 0.0), 45.0))
        .ball(Vec3::Y * 26.0, 60.0, diffuse(0.6))
        .ball(Vec3::new(-1.2, -3.2, -0.5), 0.8, diffuse(0.8))
        .ball(Vec3::new(1.2, -3.2, 0.0), 0.8, glass(1.0, 1.5))
        .lamp(Vec3::new(0.5, 3.0, -0.5), 0.4, BLACK, Rgb::new(60.0, 50.0, 40.0));
    [Vec3::X, Vec3::NEG_X, Vec3::Z, Vec3::NEG_Z, Vec3::NEG_Y].into_iter().fold(scene, wall)
}

/// Noise of both methods in blocks of 8x8, and the radius' blur of the caustic.
const SAME_BLOCK: f64 = 0.12;

#[test]
fn a_guided_room_is_the_path_tracers_block_by_block() {
    let scene = tower();
    let settings = Settings { iterations: 64, ..settings(64, 48, 50_000, 8, 0.15) };
    let targets = survey(&scene, &settings);
    assert!(targets.shares.is_empty() && targets.guide.is_some(), "nothing is guided");
    let guided = render_aimed(&scene, &settings, &targets);
    let path = render_path_fast(&scene, &Settings { iterations: 2048, ..settings });
    let error = relative_error(mean(&guided), mean(&path));
    assert!(error < SAME_MEAN, "{:?} and {:?}", mean(&guided), mean(&path));
    assert_same_blocks(&guided, &path, SAME_BLOCK);
    tell("physics", 48, "blocks of a guided room");
}

#[test]
fn photons_are_guided_where_the_eye_sees_a_part_of_the_room() {
    for (name, is_guided) in
        [("large", true), ("surgery", true), ("cornell", false), ("mirror", false), ("terrace", false)]
    {
        let scene = files::builtin::scene(name).unwrap();
        let settings = Settings { photons_per_iteration: 200_000, ..scene.settings };
        let targets = survey(&scene, &settings);
        assert_eq!(targets.guide.is_some(), is_guided, "{name}");
        assert!(targets.guide.is_none() || targets.shares.is_empty());
    }
}
