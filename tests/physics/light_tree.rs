//! The hierarchy of lamps: where lamps are divided, and that this does not depend on the axis along which they stand.

use crate::cases::tell;
use crate::harness::{BLACK, Build, empty_scene, pinhole};
use crate::light_choice::{irradiance, probabilities};
use glam::DVec3;
use reference::light_choice::Receiver;
use scene::light_tree::{IS_LIGHT, LightTree};
use scene::ray::NO_SPHERE;
use scene::rng::{Family, Stream, StreamKey};
use scene::{Rgb, Scene, Vec3};

fn random(index: u32) -> Stream {
    StreamKey::new(23, Family::Path, 0).stream(index)
}

/// A place in a cube of side 1 around the origin.
fn place(stream: &mut Stream) -> Vec3 {
    Vec3::from_array(std::array::from_fn(|_| stream.next_f32() - 0.5))
}

/// A lamp: centre, radius, radiance.
type Lamp = (Vec3, f32, f32);

fn scene_of(lamps: impl IntoIterator<Item = Lamp>) -> Scene {
    let dark = empty_scene(pinhole(Vec3::Z * 90.0, Vec3::ZERO, 30.0));
    lamps.into_iter().fold(dark, |scene, (center, radius, radiance)| {
        scene.lamp(center, radius, BLACK, Rgb::splat(radiance))
    })
}

/// Lamps in heaps of different sizes in a long box, of powers that differ by as much as a thousand.
fn heaps(seed: u32, count: u32) -> Vec<Lamp> {
    let mut stream = random(seed);
    let centers: Vec<Vec3> = (0..5).map(|_| place(&mut stream) * Vec3::new(3.0, 12.0, 6.0)).collect();
    let lamp = |k: u32| {
        let center = centers[(k % 7 % 5) as usize] + place(&mut stream) * (0.4 + (k % 3) as f32);
        let radiance = 10_f32.powf(3.0 * (stream.next_f32() - 0.5));
        (center, 0.02 + 0.01 * (k % 4) as f32, radiance)
    };
    (0..count).map(lamp).collect()
}

/// The lamps below a node.
fn below(tree: &LightTree, link: u32) -> Vec<u32> {
    if link & IS_LIGHT != 0 {
        return vec![link & !IS_LIGHT];
    }
    tree.pairs[link as usize].iter().flat_map(|node| below(tree, node.link)).collect()
}

/// Power times the squared diagonal of the box around some lamps.
fn cost(lamps: &[Lamp], some: &[u32]) -> f64 {
    let of = |light: &u32| {
        let (center, radius, radiance) = lamps[*light as usize];
        let (center, radius) = (center.as_dvec3(), f64::from(radius));
        (center - radius, center + radius, f64::from(radiance) * radius * radius)
    };
    let around = |a: (DVec3, DVec3, f64), b: (DVec3, DVec3, f64)| (a.0.min(b.0), a.1.max(b.1), a.2 + b.2);
    some.iter().map(of).reduce(around).map_or(0.0, |(low, high, power)| power * (high - low).length_squared())
}

/// The least cost of both parts, over all planes between sixteen slabs of equal width along any axis.
fn least_cost(lamps: &[Lamp], some: &[u32]) -> f64 {
    let mut least = f64::INFINITY;
    for axis in 0..3 {
        let place = |light: u32| f64::from(lamps[light as usize].0[axis]);
        let places = || some.iter().map(|light| place(*light));
        let (low, high) =
            (places().fold(f64::INFINITY, f64::min), places().fold(f64::NEG_INFINITY, f64::max));
        for slab in 1..16 {
            let plane = low + (high - low) * f64::from(slab) / 16.0;
            let (first, second): (Vec<u32>, Vec<u32>) = some.iter().partition(|light| place(**light) < plane);
            if !first.is_empty() && !second.is_empty() {
                least = least.min(cost(lamps, &first) + cost(lamps, &second));
            }
        }
    }
    least
}

/// Three lamps and more are divided by the plane that leaves the least power times squared extent: what an estimate with a
/// lamp of either part may be off by grows with both.
#[test]
fn lamps_are_divided_where_power_times_squared_extent_is_least() {
    /// Roundings of `f64`.
    const ROUNDING: f64 = 1e-9;
    let mut divisions = 0;
    for seed in 0..40 {
        let lamps = heaps(seed, 3 + seed);
        let scene = scene_of(lamps.iter().copied());
        let still = scene.at(0.0);
        let tree = &still.lights.tree;
        for [first, second] in &tree.pairs {
            let (first, second) = (below(tree, first.link), below(tree, second.link));
            let all = [&first[..], &second[..]].concat();
            if all.len() > 2 {
                let (found, least) = (cost(&lamps, &first) + cost(&lamps, &second), least_cost(&lamps, &all));
                assert!(
                    found <= least * (1.0 + ROUNDING),
                    "{found} for {first:?} and {second:?}, not {least}"
                );
                divisions += 1;
            }
        }
    }
    assert!(divisions > 500, "{divisions} divisions");
    tell("physics", divisions, "divisions of lamps");
}

/// A node has the power of its lamps, and the least ball around the middle of their box that holds them: importance falls
/// with the distance from the one, and light may arrive from all of the other.
#[test]
fn nodes_are_as_bright_and_as_wide_as_their_lamps() {
    /// Roundings of `f32`, and by how much radii are enlarged for them.
    const ROUNDING: f64 = 4e-6;
    let mut nodes = 0;
    for seed in 0..20 {
        let lamps = heaps(200 + seed, 2 + 3 * seed);
        let scene = scene_of(lamps.iter().copied());
        let still = scene.at(0.0);
        let tree = &still.lights.tree;
        let power = |lights: &[u32]| -> f64 {
            let of = |light: &u32| {
                f64::from(lamps[*light as usize].2) * f64::from(lamps[*light as usize].1).powi(2)
            };
            lights.iter().map(of).sum()
        };
        let all: Vec<u32> = (0..lamps.len() as u32).collect();
        let whole: f64 = tree.pairs[0].iter().map(|node| f64::from(node.intensity)).sum();
        for node in tree.pairs.iter().flatten() {
            let lights = below(tree, node.link);
            let (share, expected) = (f64::from(node.intensity) / whole, power(&lights) / power(&all));
            assert!((share / expected - 1.0).abs() < ROUNDING, "{share}, not {expected}, of {lights:?}");
            let balls = || {
                lights
                    .iter()
                    .map(|light| lamps[*light as usize])
                    .map(|(c, r, _)| (c.as_dvec3(), f64::from(r)))
            };
            let low = balls().map(|(c, r)| c - r).reduce(DVec3::min).unwrap();
            let high = balls().map(|(c, r)| c + r).reduce(DVec3::max).unwrap();
            let (center, radius) = (node.center.as_dvec3(), f64::from(node.radius));
            // Of coordinates, as far as the scene reaches.
            assert!((center - 0.5 * (low + high)).length() < ROUNDING * 8.0, "{node:?} of {lights:?}");
            let least = balls().map(|(c, r)| c.distance(center) + r).fold(0.0, f64::max);
            assert!(radius >= least && radius < least * (1.0 + ROUNDING), "{node:?}, not {least}");
            nodes += 1;
        }
    }
    tell("physics", nodes, "nodes of lamps");
}

/// How a scene is changed, and what it does to vectors.
type Turn = (&'static str, fn(Vec3) -> Vec3);

/// The squares of estimates at a receiver with the lamp that is chosen, on the average.
fn squares(scene: &Scene, receiver: &Receiver) -> f64 {
    let still = scene.at(0.0);
    let chosen = probabilities(&still, receiver).into_iter().enumerate().filter(|(_, p)| *p > 0.0);
    chosen.map(|(light, p)| irradiance(&still, receiver, light).x.powi(2) / p).sum()
}

/// Lamps that are turned together with what they light, or mirrored, give as much noise.
#[test]
fn noise_does_not_depend_on_the_axis_along_which_lamps_stand() {
    /// Roundings of `f32` in the importance of nodes.
    const ROUNDING: f64 = 1e-3;
    let turns: [Turn; 4] = [
        ("turned", |v| Vec3::new(v.z, v.x, v.y)),
        ("turned twice", |v| Vec3::new(v.y, v.z, v.x)),
        ("exchanged", |v| Vec3::new(v.y, v.x, v.z)),
        ("mirrored", |v| Vec3::new(v.x, -v.y, -v.z)),
    ];
    let mut cases = 0;
    for seed in 0..12 {
        let lamps = heaps(100 + seed, 60);
        let scene = scene_of(lamps.iter().copied());
        let mut stream = random(7 + seed);
        for _ in 0..8 {
            let (point, normal) =
                (place(&mut stream) * Vec3::new(6.0, 14.0, 9.0), place(&mut stream).normalize());
            let expected = squares(&scene, &Receiver { point, normal, sphere: NO_SPHERE });
            for (what, turn) in turns {
                let lamps =
                    lamps.iter().map(|(center, radius, radiance)| (turn(*center), *radius, *radiance));
                let receiver = Receiver { point: turn(point), normal: turn(normal), sphere: NO_SPHERE };
                let found = squares(&scene_of(lamps), &receiver);
                assert!((found - expected).abs() <= ROUNDING * expected, "{what}: {found}, not {expected}");
                cases += 1;
            }
        }
    }
    tell("physics", cases, "lamps along other axes");
}
