//! Light chosen for the point that receives it: its probabilities, and what many lamps give in sum.

use crate::cases::tell;
use crate::harness::{
    BLACK, Build, SIGNIFICANCE, chi_square_p_of, diffuse, empty_scene, glass, pinhole, relative_error,
};
use glam::DVec3;
use reference::direct_light::estimate_irradiance;
use reference::light_choice::{Receiver, choose, probability};
use scene::rng::{Family, Stream, StreamKey};
use scene::{Rgb, Scene, Still, Vec3};

fn random(index: u32) -> Stream {
    StreamKey::new(11, Family::Path, 0).stream(index)
}

fn place(stream: &mut Stream) -> Vec3 {
    Vec3::from_array(std::array::from_fn(|_| 2.0 * stream.next_f32() - 1.0))
}

/// Lamps of all sizes and brightnesses, some in heaps, in a cube of side 2 and a unit of length `scale` at `offset`.
fn many_lamps(lamps: u32, sky: bool, scale: f32, offset: Vec3, stream: &mut Stream) -> Scene {
    let mut scene = empty_scene(pinhole((offset + Vec3::Z * 9.0) * scale, offset * scale, 30.0));
    for lamp in 0..lamps {
        let heap = if lamp % 3 == 0 { 1.0 } else { 0.05 };
        let size = stream.next_f32();
        let emission = Rgb::new(1.0, 0.5, 0.0) * (0.01 + 10.0 * stream.next_f32());
        let center = (offset + place(stream) * heap + Vec3::Y * 2.0) * scale;
        let material = if lamp % 7 == 3 { glass(1.0, 1.0) } else { BLACK };
        scene = scene.lamp(center, (0.001 + 0.02 * size * size) * scale, material, emission);
    }
    if sky {
        scene.background = Rgb::splat(0.02);
    }
    scene
}

fn receiver(scale: f32, offset: Vec3, stream: &mut Stream) -> Receiver {
    let normal = place(stream).normalize();
    let height = if stream.next_f32() < 0.3 { 2.0 } else { 0.0 };
    let point = (offset + place(stream) + Vec3::Y * height) * scale;
    Receiver { point, normal, sphere: scene::ray::NO_SPHERE }
}

/// Sums of probabilities: a hundred roundings, of `1 - p` too.
const SUM: f64 = 1e-4;

/// Lamps, and whether there is a sky.
const SCENES: [(u32, bool); 8] =
    [(2, false), (1, true), (2, true), (3, false), (17, true), (60, false), (300, false), (300, true)];

/// The lights that may be chosen: of glass, one of both sides.
fn eligible(still: &Still) -> Vec<u32> {
    let entries = &still.lights.entries;
    let is_room = |l: u32| still.lights.tree.rooms.iter().any(|room| room.light == l);
    (0..entries.len() as u32).filter(|&l| !entries[l as usize].inside || is_room(l)).collect()
}

#[test]
fn probabilities_sum_to_one_or_nothing_is_chosen() {
    let mut cases = 0;
    for (index, (lamps, sky)) in SCENES.into_iter().enumerate() {
        let mut stream = random(index as u32);
        let scene = many_lamps(lamps, sky, 1.0, Vec3::ZERO, &mut stream).with_sky();
        let still = scene.at(0.0);
        for _ in 0..100 {
            let receiver = receiver(1.0, Vec3::ZERO, &mut stream);
            let sum: f64 =
                eligible(&still).into_iter().map(|l| f64::from(probability(&still, &receiver, l))).sum();
            match choose(&still, &receiver, stream.next_f32()) {
                // A pair below may send nothing where its parent was thought to: then nothing is what is lit.
                None => assert!(sum < 1.0 - SUM || !sky, "{lamps} lamps: nothing chosen, yet {sum}"),
                Some(_) => assert!(sum < 1.0 + SUM, "{lamps} lamps, sky {sky}: {sum}"),
            }
            cases += 1;
        }
        // Where all lamps are in full view nothing is lost.
        let below = Receiver { point: Vec3::Y * -1.0, normal: Vec3::Y, sphere: scene::ray::NO_SPHERE };
        let sum: f64 = eligible(&still).into_iter().map(|l| f64::from(probability(&still, &below, l))).sum();
        assert!((sum - 1.0).abs() < SUM, "{lamps} lamps, sky {sky}: {sum}");
    }
    tell("physics", cases, "sums of the probabilities of lights");
}

#[test]
fn lights_are_chosen_as_often_as_is_said() {
    for (index, (lamps, sky)) in SCENES.into_iter().enumerate() {
        let mut stream = random(100 + index as u32);
        let scene = many_lamps(lamps, sky, 1.0, Vec3::ZERO, &mut stream).with_sky();
        let still = scene.at(0.0);
        for _ in 0..6 {
            let receiver = receiver(1.0, Vec3::ZERO, &mut stream);
            let draws = 1 << 16;
            let mut counts = vec![0_u32; still.lights.entries.len() + 1];
            for _ in 0..draws {
                let Some(choice) = choose(&still, &receiver, stream.next_f32()) else {
                    counts[still.lights.entries.len()] += 1;
                    continue;
                };
                let stated = probability(&still, &receiver, choice.light);
                let outer = still.lights.entries[choice.light as usize].inside;
                assert!(outer || stated.to_bits() == choice.probability.to_bits(), "another probability");
                counts[choice.light as usize] += 1;
            }
            // The rare ones are counted together.
            let (mut seen, mut expected, mut rare) = (Vec::new(), Vec::new(), (0, 1.0));
            for light in eligible(&still) {
                let p = f64::from(probability(&still, &receiver, light));
                if p * f64::from(draws) > 25.0 {
                    seen.push(counts[light as usize]);
                    expected.push(p);
                    rare.1 -= p;
                }
            }
            rare.0 = draws - seen.iter().sum::<u32>();
            if rare.1 * f64::from(draws) > 25.0 {
                seen.push(rare.0);
                expected.push(rare.1);
            }
            if seen.len() > 1 {
                let p = chi_square_p_of(&seen, &expected);
                assert!(p > SIGNIFICANCE, "{lamps} lamps, sky {sky}: p = {p:.1e}");
            }
        }
    }
    tell("physics", 6 * SCENES.len(), "histograms of chosen lights");
}

/// Irradiance of a ball of radiance 1 and radius r, above the horizon or cut by it: the solid angle projected.
fn ball_irradiance(to_center: DVec3, r: f64, normal: DVec3) -> f64 {
    let h2 = to_center.length_squared() / (r * r);
    let cos = to_center.dot(normal) / to_center.length();
    let k2 = 1.0 - h2 * cos * cos;
    if k2 <= 0.0 {
        return std::f64::consts::PI * cos.max(0.0) / h2;
    }
    let angle = (-cos * ((h2 - 1.0) / (1.0 - cos * cos)).sqrt()).clamp(-1.0, 1.0).acos();
    (cos * angle - (k2 * (h2 - 1.0)).sqrt()) / h2 + (k2 / (h2 - 1.0)).sqrt().atan()
}

/// Means of 2^18 stratified estimates: their noise is below.
const MANY: f64 = 1e-2;

/// Lamps on a hemisphere, so that none hides another, some of them cut by the horizon, and some below it.
fn dome(lamps: u32, scale: f32, offset: Vec3) -> Scene {
    let mut stream = random(7);
    let mut scene = empty_scene(pinhole((offset + Vec3::Y * 30.0) * scale, offset * scale, 30.0)).ball(
        (offset - Vec3::Y) * scale,
        scale,
        diffuse(0.5),
    );
    for lamp in 0..lamps {
        // Along a spiral from the top to below the horizon, at distances from 5 to 20.
        let t = (f64::from(lamp) + 0.5) / f64::from(lamps);
        let (y, turn) = (1.0 - 1.2 * t, 2.4 * f64::from(lamp));
        let flat = (1.0 - y * y).max(0.0).sqrt();
        let direction = DVec3::new(flat * turn.cos(), y, flat * turn.sin()).as_vec3();
        let distance = 5.0 + 15.0 * stream.next_f32() * stream.next_f32();
        let radius = 0.4 * distance / (lamps as f32).sqrt();
        let emission = Rgb::new(1.0, 0.3, 2.0) * (0.1 + stream.next_f32());
        scene = scene.lamp((offset + direction * distance) * scale, radius * scale, BLACK, emission);
    }
    scene
}

#[test]
fn many_lamps_give_the_sum_of_what_each_gives() {
    let mut cases = 0;
    for (lamps, scale, offset) in [
        (2, 1.0, Vec3::ZERO),
        (3, 1.0, Vec3::ZERO),
        (40, 1.0, Vec3::ZERO),
        (300, 1.0, Vec3::ZERO),
        (40, 1e-3, Vec3::ZERO),
        (40, 1e6, Vec3::ZERO),
        (40, 1.0, Vec3::new(3000.0, -500.0, 1000.0)),
    ] {
        let scene = dome(lamps, scale, offset);
        let still = scene.at(0.0);
        let receiver = Receiver { point: offset * scale, normal: Vec3::Y, sphere: 0 };
        let mut expected = [0.0; 3];
        for lamp in &scene.spheres[1..] {
            let to_center = lamp.center.as_dvec3() - receiver.point.as_dvec3();
            let one = ball_irradiance(to_center, f64::from(lamp.radius), DVec3::Y);
            for (sum, e) in expected.iter_mut().zip(lamp.emission.to_array()) {
                *sum += one * f64::from(e);
            }
        }
        let mut sum = DVec3::ZERO;
        let side = 1 << 6;
        let mut stream = random(3);
        let at = |i: u32, jitter: f32| (i as f32 + jitter) / side as f32;
        for (i, j, k) in
            (0..side).flat_map(|i| (0..side).flat_map(move |j| (0..side).map(move |k| (i, j, k))))
        {
            let [a, b, c] = std::array::from_fn(|_| stream.next_f32());
            sum += estimate_irradiance(&still, &receiver, at(i, a), at(j, b), at(k, c)).as_dvec3();
        }
        let mean = (sum / f64::from(side * side * side)).to_array();
        let error = relative_error(mean, expected);
        assert!(error < MANY, "{lamps} lamps at scale {scale}: {mean:?}, not {expected:?}: {error:.1e}");
        cases += 1;
    }
    tell("physics", cases, "irradiances of many lamps");
}

#[test]
fn no_lamp_above_the_horizon_is_left_out() {
    for (index, (lamps, sky)) in SCENES.into_iter().enumerate() {
        for scale in [1e-3, 1.0, 1e6] {
            let mut stream = random(200 + index as u32);
            let scene = many_lamps(lamps, sky, scale, Vec3::ZERO, &mut stream).with_sky();
            let still = scene.at(0.0);
            for _ in 0..50 {
                let receiver = receiver(scale, Vec3::ZERO, &mut stream);
                for light in eligible(&still) {
                    let entry = &still.lights.entries[light as usize];
                    let sphere = &still.spheres[entry.sphere as usize];
                    let height = receiver.normal.dot(sphere.center - receiver.point);
                    if entry.inside || height > -0.99 * sphere.radius {
                        let p = probability(&still, &receiver, light);
                        assert!(p > 0.0, "light {light} of {lamps} at scale {scale} is starved");
                    }
                }
            }
        }
    }
    tell("physics", 3 * 50 * SCENES.len(), "points at which no lamp is starved");
}
