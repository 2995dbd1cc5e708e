//! The choice of a light for a point: its probabilities, what estimates with it give in the mean, and that no light is
//! left out.

use crate::cases::tell;
use crate::harness::{BLACK, Build, diffuse, empty_scene, glass, pinhole, relative_error};
use glam::DVec3;
use reference::direct_light::estimate_irradiance;
use reference::light_choice::{Receiver, ambient_probability, choose, first_probability, importance};
use scene::light_tree::IS_LIGHT;
use scene::ray::NO_SPHERE;
use scene::rng::{Family, Stream, StreamKey};
use scene::still::Role;
use scene::{Rgb, Scene, Still, Vec3};
use std::f64::consts::PI;

fn random(index: u32) -> Stream {
    StreamKey::new(11, Family::Path, 0).stream(index)
}

/// A point in a cube of side 2.
fn place(stream: &mut Stream) -> Vec3 {
    Vec3::from_array(std::array::from_fn(|_| 2.0 * stream.next_f32() - 1.0))
}

/// Between 10^-`decades` and 10^`decades`.
fn magnitude(decades: f32, stream: &mut Stream) -> f32 {
    10_f32.powf(decades * (2.0 * stream.next_f32() - 1.0))
}

/// Lamps, and perhaps a sky, to choose from.
struct Case {
    name: &'static str,
    scene: Scene,
}

/// A case of `lamps` lamps, each by its index: centre, radius, is it glass, and emission.
fn case(
    name: &'static str,
    lamps: u32,
    sky: f32,
    mut lamp: impl FnMut(u32) -> (Vec3, f32, bool, f32),
) -> Case {
    let mut scene = empty_scene(pinhole(Vec3::Z * 9.0, Vec3::ZERO, 30.0));
    scene.background = Rgb::splat(sky);
    scene.materials = vec![BLACK, glass(1.0, 1.0)];
    for index in 0..lamps {
        let (center, radius, is_glass, emission) = lamp(index);
        let emission = Rgb::new(1.0, 0.5, 0.0) * emission;
        let material = u32::from(is_glass);
        scene.spheres.push(scene::Sphere { center, velocity: Vec3::ZERO, radius, material, emission });
    }
    Case { name, scene: scene.with_sky() }
}

/// Lamps of all sizes, some in heaps, some of glass. The more there are, the smaller, so that few overlap.
fn mixed(name: &'static str, lamps: u32, sky: f32) -> Case {
    let mut stream = random(lamps);
    let scale = (10.0 / lamps as f32).min(1.0);
    case(name, lamps, sky, |index| {
        let size = stream.next_f32();
        let heap = if index % 3 == 0 { 1.0 } else { 0.05 };
        let center = place(&mut stream) * heap + Vec3::Y * 2.0;
        (center, (0.001 + 0.05 * size * size) * scale, index % 7 == 3, 0.01 + 10.0 * stream.next_f32())
    })
}

fn cases() -> Vec<Case> {
    let mut stream = random(0);
    vec![
        case("one lamp", 1, 0.0, |_| (Vec3::Y, 0.2, false, 1.0)),
        case("one lamp and a sky", 1, 0.5, |_| (Vec3::Y, 0.2, false, 1.0)),
        case("one lamp of glass", 1, 0.0, |_| (Vec3::Y, 0.9, true, 1.0)),
        case("two lamps that touch", 2, 0.0, |i| (Vec3::new(0.25 * i as f32, 1.0, 0.0), 0.125, false, 1.0)),
        case("lamps at one place", 50, 0.1, |i| {
            (Vec3::Y, 0.2 + 0.001 * (i % 2) as f32, i % 3 == 1, 1.0 + i as f32)
        }),
        case("lamps in a row, each touching the next", 40, 0.0, |i| {
            (Vec3::new(0.25 * i as f32 - 5.0, 1.0, 0.0), 0.125, false, 1.0)
        }),
        case("all powers", 200, 1e-3, |i| {
            (place(&mut stream) + Vec3::Y * 2.0, 0.01, i % 5 == 0, magnitude(6.0, &mut stream))
        }),
        case("a far sun and tiny lamps", 30, 1e-3, |i| match i {
            0 => (Vec3::new(3e5, 9e5, 0.0), 1e4, false, 1e4),
            _ => (place(&mut stream) + Vec3::Y * 2.0, 1e-3, i % 5 == 0, 1e4 * magnitude(3.0, &mut stream)),
        }),
        case("all distances", 200, 1e-3, |i| {
            let center = place(&mut stream) * magnitude(1.5, &mut stream);
            (center, 0.1 * center.length(), i % 5 == 0, 1.0)
        }),
        case("two glowing shells, and lamps", 22, 0.0, |i| match i {
            0 | 1 => (Vec3::X * (40.0 * i as f32 - 20.0), 50.0, false, 0.01 * (1 + i) as f32),
            _ => (place(&mut stream) + Vec3::Y * 2.0, 0.05, i % 5 == 0, 1.0),
        }),
        mixed("two lamps", 2, 0.0),
        mixed("two lamps and a sky", 2, 0.02),
        mixed("17 lamps and a sky", 17, 0.02),
        mixed("300 lamps", 300, 0.0),
        mixed("300 lamps and a dark sky", 300, 1e-4),
        mixed("100,000 lamps", 100_000, 1e-7),
    ]
}

/// Points among the lamps and elsewhere.
fn receivers(count: usize) -> Vec<Receiver> {
    let mut stream = random(1);
    let receiver = |index| {
        let normal = place(&mut stream).normalize();
        let spread = if index % 4 == 3 { 100.0 } else { 1.0 };
        let point = place(&mut stream) * spread + Vec3::Y * if index % 3 == 0 { 2.0 } else { 0.0 };
        Receiver { point, normal, sphere: NO_SPHERE }
    };
    // Below all lamps of most cases, in full view of them.
    let below = Receiver { point: Vec3::Y * -1.0, normal: Vec3::Y, sphere: NO_SPHERE };
    std::iter::once(below).chain((1..count).map(receiver)).collect()
}

/// The probability of each light, by the definition: the product of those on the way from the root. For a lamp of glass,
/// it is noted for the side that the receiver sees.
pub(crate) fn probabilities(still: &Still, receiver: &Receiver) -> Vec<f64> {
    let mut all = vec![0.0; still.lights.entries.len()];
    if all.len() == 1 {
        return vec![1.0];
    }
    let tree = &still.lights.tree;
    let Some(of_ambient) = ambient_probability(tree, receiver).map(f64::from) else {
        return all;
    };
    for ambient in &tree.ambient {
        all[ambient.light as usize] = of_ambient * f64::from(ambient.share);
    }
    let mut todo = vec![(0, 1.0 - of_ambient)];
    while let Some((pair, probability)) = todo.pop() {
        let Some(pair) = tree.pairs.get(pair as usize) else {
            continue;
        };
        let Some(first) = first_probability(pair, receiver).map(f64::from) else {
            continue;
        };
        for (node, of_node) in pair.iter().zip([first, 1.0 - first]) {
            let probability = probability * of_node;
            if node.link & IS_LIGHT == 0 {
                todo.push((node.link, probability));
                continue;
            }
            let light = (node.link & !IS_LIGHT) as usize;
            let inner = usize::from(is_glass(still, light) && is_within(still, receiver, light));
            all[light + inner] += probability;
        }
    }
    all
}

fn is_glass(still: &Still, light: usize) -> bool {
    still.roles[still.lights.entries[light].sphere as usize] == Role::Glass
}

/// Is the receiver within the lamp?
fn is_within(still: &Still, receiver: &Receiver, light: usize) -> bool {
    let lamp = &still.spheres[still.lights.entries[light].sphere as usize];
    receiver.point.distance_squared(lamp.center) < lamp.radius * lamp.radius
}

/// The irradiance that a light gives a receiver if nothing is in between, in closed form.
pub(crate) fn irradiance(still: &Still, receiver: &Receiver, light: usize) -> DVec3 {
    let entry = &still.lights.entries[light];
    let lamp = &still.spheres[entry.sphere as usize];
    let is_enclosure = matches!(still.roles[entry.sphere as usize], Role::Enclosure(_));
    let factor = match (entry.inside, is_enclosure || is_within(still, receiver, light)) {
        (true, true) => PI,
        (false, false) => {
            let to_center = lamp.center.as_dvec3() - receiver.point.as_dvec3();
            ball_irradiance(to_center, f64::from(lamp.radius), receiver.normal.as_dvec3().normalize())
        }
        _ => 0.0,
    };
    factor * lamp.emission.as_dvec3()
}

/// Irradiance by a ball of radiance 1 and radius r, above the horizon or cut by it: the solid angle projected.
fn ball_irradiance(to_center: DVec3, r: f64, normal: DVec3) -> f64 {
    let h2 = to_center.length_squared() / (r * r);
    let cos = to_center.dot(normal) / to_center.length();
    let k2 = 1.0 - h2 * cos * cos;
    if k2 <= 0.0 {
        return PI * cos.max(0.0) / h2;
    }
    let angle = (-cos * ((h2 - 1.0) / (1.0 - cos * cos)).sqrt()).clamp(-1.0, 1.0).acos();
    (cos * angle - (k2 * (h2 - 1.0)).sqrt()) / h2 + (k2 / (h2 - 1.0)).sqrt().atan()
}

/// Random numbers tried for each receiver, equally spaced.
const NUMBERS: u32 = 1 << 17;

/// The numbers that choose a light are an interval as long as its probability, so of equally spaced ones at most one
/// more or less; and two more for the roundings of as many as 17 choices.
const OFF: f64 = 3.0;

/// Roundings of as many as 17 factors, one of which may be 1 - p for a p that is almost 1.
const PRODUCT: f64 = 1e-3;

#[test]
fn lights_are_chosen_as_often_as_is_said() {
    let mut histograms = 0;
    for Case { name, scene } in cases() {
        let still = scene.at(0.0);
        for receiver in receivers(if still.lights.entries.len() > 1000 { 2 } else { 12 }) {
            let expected = probabilities(&still, &receiver);
            let mut counts = vec![0_u32; expected.len()];
            for k in 0..NUMBERS {
                let Some(choice) = choose(&still, &receiver, (k as f32 + 0.5) / NUMBERS as f32) else {
                    continue;
                };
                let expected = expected[choice.light as usize];
                let stated = f64::from(choice.probability);
                assert!((stated / expected - 1.0).abs() < PRODUCT, "{name}: {stated} is not {expected}");
                counts[choice.light as usize] += 1;
            }
            for (light, (count, p)) in counts.into_iter().zip(expected).enumerate() {
                let expected = p * f64::from(NUMBERS);
                let off = (f64::from(count) - expected).abs();
                assert!(off <= OFF, "{name}: light {light} is chosen {count} times, not {expected}");
            }
            histograms += 1;
        }
    }
    tell("physics", histograms, "histograms of chosen lights");
}

/// What the mean of [`NUMBERS`] estimates is off by: each light is chosen once too often or too rarely.
const MEAN: f64 = 1e-3;

/// The largest variance of an estimate, relative to the square of the mean, for the cases above. Twice what is measured,
/// where the light of a lamp close by is underestimated in a group of many.
const VARIANCE: f64 = 40.0;

#[test]
fn estimates_with_the_chosen_light_have_the_right_mean() {
    let mut means = 0;
    for Case { name, scene } in cases() {
        let still = scene.at(0.0);
        for receiver in receivers(if still.lights.entries.len() > 1000 { 4 } else { 24 }) {
            let lights: Vec<f64> =
                (0..still.lights.entries.len()).map(|light| irradiance(&still, &receiver, light).x).collect();
            let expected: f64 = lights.iter().sum();
            let (mut sum, mut squares) = (0.0, 0.0);
            for k in 0..NUMBERS {
                if let Some(choice) = choose(&still, &receiver, (k as f32 + 0.5) / NUMBERS as f32) {
                    let estimate = lights[choice.light as usize] / f64::from(choice.probability);
                    (sum, squares) = (sum + estimate, squares + estimate * estimate);
                }
            }
            let mean = sum / f64::from(NUMBERS);
            if expected == 0.0 {
                assert_eq!(mean, 0.0, "{name}");
                continue;
            }
            let (off, variance) =
                (mean / expected - 1.0, squares / f64::from(NUMBERS) / expected.powi(2) - 1.0);
            assert!(off.abs() < MEAN, "{name}: {mean} instead of {expected}, off by {off:.1e}");
            assert!(variance < VARIANCE, "{name}: relative variance {variance}");
            means += 1;
        }
    }
    tell("physics", means, "means of estimates with a chosen light");
}

#[test]
fn no_light_that_can_arrive_is_left_out() {
    let mut points = 0;
    for Case { name, scene } in cases() {
        let still = scene.at(0.0);
        for receiver in receivers(if still.lights.entries.len() > 1000 { 4 } else { 200 }) {
            for (light, p) in probabilities(&still, &receiver).into_iter().enumerate() {
                let irradiance = irradiance(&still, &receiver, light);
                assert!(p > 0.0 || irradiance == DVec3::ZERO, "{name}: light {light} is left out");
            }
            points += 1;
        }
    }
    tell("physics", points, "points at which no light is left out");
}

/// Some roundings of `f32`, and the enlarged radii.
const ROUNDINGS: f64 = 1e-5;

#[test]
fn the_importance_of_a_lamp_in_full_view_is_its_irradiance() {
    let mut lamps = 0;
    for Case { name, scene } in cases() {
        let still = scene.at(0.0);
        let tree = &still.lights.tree;
        if tree.ambient.is_empty() {
            continue;
        }
        let receivers = receivers(8);
        let by_light = |light: u32| irradiance(&still, &receivers[0], light as usize).x;
        let ambient: f64 = tree.ambient.iter().map(|ambient| by_light(ambient.light)).sum();
        let unit = f64::from(tree.ambient_irradiance) / ambient;
        for node in tree.pairs.as_flattened().iter().filter(|node| node.link & IS_LIGHT != 0) {
            for receiver in &receivers {
                let light = (node.link & !IS_LIGHT) as usize;
                let to_center = node.center - receiver.point;
                let height = receiver.normal.dot(to_center);
                // Just above the horizon, heights are wrong by roundings of the distance.
                if height < 1.01 * node.radius + 0.1 * to_center.length() || node.intensity == 0.0 {
                    continue;
                }
                let expected = unit * irradiance(&still, receiver, light).x;
                let actual = f64::from(importance(node, receiver));
                assert!(
                    (actual / expected - 1.0).abs() < ROUNDINGS,
                    "{name}: {actual} instead of {expected}"
                );
                lamps += 1;
            }
        }
    }
    assert!(lamps > 1000);
    tell("physics", lamps, "importances in closed form");
}

/// Means of 2^18 stratified estimates: their noise is below.
const NOISE: f64 = 1e-2;

/// Lamps on a hemisphere, so that none hides another, some of them cut by the horizon, and some below it.
fn dome(lamps: u32, sky: f32, scale: f32, offset: Vec3) -> Scene {
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
    scene.background = Rgb::new(0.3, 0.2, 0.1) * sky;
    scene.with_sky()
}

#[test]
fn many_lamps_give_the_sum_of_what_each_gives() {
    let mut cases = 0;
    for (lamps, sky, scale, offset) in [
        (1, 0.0, 1.0, Vec3::ZERO),
        (1, 0.3, 1.0, Vec3::ZERO),
        (2, 0.0, 1.0, Vec3::ZERO),
        (3, 0.1, 1.0, Vec3::ZERO),
        (40, 0.0, 1.0, Vec3::ZERO),
        (300, 0.1, 1.0, Vec3::ZERO),
        (40, 0.1, 1e-3, Vec3::ZERO),
        (40, 0.0, 1e6, Vec3::ZERO),
        (40, 0.1, 1.0, Vec3::new(3000.0, -500.0, 1000.0)),
    ] {
        let scene = dome(lamps, sky, scale, offset);
        let still = scene.at(0.0);
        let receiver = Receiver { point: offset * scale, normal: Vec3::Y, sphere: 0 };
        let lights = 0..still.lights.entries.len();
        let of_lamps: DVec3 = lights.clone().map(|light| irradiance(&still, &receiver, light)).sum();
        // The lamps hide some of the sky.
        let is_sky = |light: &usize| still.lights.entries[*light].inside;
        let sky: DVec3 =
            lights.clone().filter(is_sky).map(|light| irradiance(&still, &receiver, light)).sum();
        let radiance = sky / PI;
        let hidden: DVec3 = lights
            .filter(|light| !is_sky(light))
            .map(|light| {
                let lamp = &still.spheres[still.lights.entries[light].sphere as usize];
                let to_center = lamp.center.as_dvec3() - receiver.point.as_dvec3();
                radiance * ball_irradiance(to_center, f64::from(lamp.radius), DVec3::Y)
            })
            .sum();
        let expected = (of_lamps - hidden).to_array();
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
        assert!(error < NOISE, "{lamps} lamps at scale {scale}: {mean:?}, not {expected:?}: {error:.1e}");
        cases += 1;
    }
    tell("physics", cases, "irradiances of many lamps");
}

/// Where paths meet glowing rooms by themselves, lamps are chosen as if no room glowed.
#[test]
fn among_lamps_alone_they_are_chosen_as_if_no_room_glowed() {
    const NUMBERS: u32 = 1024;
    let with_rooms = |glow: Rgb| {
        let mut scene = empty_scene(pinhole(Vec3::Z * 5.0, Vec3::ZERO, 30.0));
        for k in 0..5 {
            let center = Vec3::new(k as f32 - 2.0, 3.0 - 0.5 * k as f32, 0.3 * k as f32);
            scene = scene.lamp(center, 0.1 + 0.05 * k as f32, BLACK, Rgb::splat(1.0 + k as f32));
        }
        scene.lamp(Vec3::ZERO, 50.0, diffuse(0.5), glow).lamp(Vec3::X, 60.0, BLACK, 2.0 * glow)
    };
    let (dark, bright) = (with_rooms(Rgb::ZERO), with_rooms(Rgb::splat(3.0)));
    let (dark, bright) = (dark.at(0.0), bright.at(0.0).with_choice_of_lamps());
    let mut cases = 0;
    for k in 0..16 {
        let point = Vec3::new((k % 4) as f32 - 1.5, 0.2 * k as f32 - 1.0, (k / 4) as f32);
        let receiver = Receiver { point, normal: Vec3::new(0.1, 1.0, 0.2).normalize(), sphere: NO_SPHERE };
        for u in (0..NUMBERS).map(|u| u as f32 / NUMBERS as f32) {
            assert_eq!(choose(&bright, &receiver, u), choose(&dark, &receiver, u), "{u} at {point}");
            cases += 1;
        }
    }
    tell("physics", cases, "choices among lamps alone");
}
