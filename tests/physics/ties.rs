//! Random choices in edge cases: random numbers that are zero, just below one, or on the border between two outcomes.
//!
//! Streams give multiples of 2^-24 below 1, all with the same probability, including zero. An outcome of probability p
//! must get exactly p 2^24 of them, so a number on the border belongs to the next outcome. In particular, a black
//! surface must not keep a photon for the number zero: its power would be zero divided by zero.

use crate::cases::tell;
use crate::harness::{BLACK, Build, empty_scene, pinhole};
use reference::direct_light::choose_light;
use reference::intersect::Hit;
use reference::photon_pass::survive;
use reference::scatter::dielectric;
use scene::rng::UNIT;
use scene::{Rgb, Scene, Vec3};

/// The largest random number, just below 1.
const LAST: f32 = 1.0 - UNIT;

#[test]
fn black_keeps_no_photon_and_white_loses_none() {
    for power in [Rgb::ONE, Rgb::new(1.0, 0.5, 0.0), Rgb::new(0.0, 0.0, 1.0)] {
        assert_eq!(survive(power, Rgb::ZERO, 0.0), None, "{power} on black");
        assert_eq!(survive(power, Rgb::ONE, LAST), Some(power), "{power} on white");
        assert_eq!(survive(power, Rgb::ONE, 0.0), Some(power), "{power} on white");
    }
    // A surface is black for a photon that has no power in the channels that it reflects.
    assert_eq!(survive(Rgb::X, Rgb::new(0.0, 1.0, 1.0), 0.0), None);
    tell("physics", 10, "photons on black and white");
}

#[test]
fn as_many_numbers_survive_as_the_albedo_says() {
    for albedo in [UNIT, 0.125, 0.5, 0.75, LAST] {
        let on = |roulette| survive(Rgb::ONE, Rgb::splat(albedo), roulette);
        assert_eq!(on(albedo), None, "albedo {albedo} at its border");
        assert_eq!(on(albedo - UNIT), Some(Rgb::ONE), "albedo {albedo} below its border");
    }
    tell("physics", 10, "borders of roulette");
}

#[test]
fn boundaries_without_reflection_and_with_total_reflection() {
    let hit = |inside| Hit { sphere: 0, t: 1.0, point: Vec3::ZERO, normal: Vec3::Z, inside };
    let straight = Vec3::new(0.6, 0.0, -0.8);
    for (inside, u) in [(false, 0.0), (false, LAST), (true, 0.0), (true, LAST)] {
        let (direction, scale) = dielectric(straight, &hit(inside), 1.0, u);
        assert!((direction - straight).length() < ROUNDING, "glass of index 1 turns to {direction}");
        assert_eq!(scale, 1.0);
    }
    for u in [0.0, 0.5, LAST] {
        // The sine of 0.6 is beyond the critical angle's 0.5.
        let (direction, scale) = dielectric(straight, &hit(true), 2.0, u);
        assert!(
            (direction - Vec3::new(0.6, 0.0, 0.8)).length() < ROUNDING,
            "{u}: light leaves to {direction}"
        );
        assert_eq!(scale, 1.0, "{u}: total reflection");
    }
    tell("physics", 7, "boundaries that choose one way alone");
}

/// Tolerance of directions: a few rounding errors.
const ROUNDING: f32 = 1e-6;

/// `count` lamps side by side, with powers that are not round numbers.
fn lamps(count: usize) -> Scene {
    let scene = empty_scene(pinhole(Vec3::Z * 9.0, Vec3::ZERO, 60.0));
    (0..count).fold(scene, |scene, k| {
        let emission = Rgb::splat(1.0 + 0.1 * (k * k % 7) as f32);
        scene.lamp(Vec3::X * (3.0 * k as f32), 1.0, BLACK, emission)
    })
}

#[test]
fn every_number_chooses_a_light() {
    for count in 1..=300 {
        let scene = lamps(count);
        let lights = scene.at(0.0).lights;
        let chosen = |u| choose_light(&lights, u).map(|light| lights.entries[light as usize].sphere as usize);
        assert_eq!(chosen(0.0), Some(0), "{count} lights");
        assert_eq!(chosen(LAST), Some(count - 1), "{count} lights");
        // The interval of each light ends where that of the next begins.
        for (k, &end) in lights.cumulative.iter().enumerate() {
            assert_eq!(
                (chosen(end.next_down()), chosen(end)),
                (Some(k), Some(k + 1)),
                "{count} lights, {end}"
            );
        }
    }
    tell("physics", 300, "choices of lights at their borders");
}
