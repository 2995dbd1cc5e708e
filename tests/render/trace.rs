//! Rays of any magnitude: the same answer from every engine, and one that makes sense.

use crate::cases::tell;
use render::{EngineChoice, EngineName, LanesName, available_lanes, trace};
use scene::ray::NO_SPHERE;
use scene::rng::{Family, Stream, StreamKey};
use scene::{Material, Ray, Rgb, Scene, Sphere, Vec3};

/// The most by which the length of a unit vector of `f32` is off after some roundings.
const UNIT_TOLERANCE: f64 = 1e-5;
/// Rays per magnitude.
const RAYS: usize = 60;

fn signed(numbers: &mut Stream) -> f32 {
    2.0 * numbers.next_f32() - 1.0
}

fn vector(numbers: &mut Stream) -> Vec3 {
    Vec3::new(signed(numbers), signed(numbers), signed(numbers))
}

/// Built-in scenes with few balls and with clusters; and one with a tree, and with glass under the open sky.
fn scenes() -> Vec<(&'static str, Scene)> {
    let named = ["cornell", "mirror", "random", "surgery", "motion"];
    let mut scenes: Vec<_> = named.map(|name| (name, files::builtin::scene(name).unwrap())).into();
    let mut numbers = StreamKey::new(3, Family::Path, 0).stream(0);
    let mut many = files::builtin::scene("cornell").unwrap();
    for i in 0..1500 {
        let center = Vec3::splat(50.0) + vector(&mut numbers) * 40.0;
        many.spheres.push(Sphere {
            center,
            radius: 0.3,
            material: i % 3,
            emission: Rgb::ZERO,
            velocity: Vec3::ZERO,
        });
    }
    scenes.push(("many balls", many));
    let text = "background = [1, 1, 1]\n\
        camera = { eye = [0, 0, 10], direction = [0, 0, -1], vertical_fov_degrees = 40 }\n\
        [[sphere]]\ncenter = [0, 0, 0]\nradius = 2\n\
        material = { type = \"dielectric\", albedo = [1, 1, 1], ior = 1.5 }\n";
    scenes.push(("sky", files::scene_file::parse("sky.toml", text).unwrap()));
    assert!(
        scenes
            .iter()
            .any(|(_, scene)| scene.materials.iter().any(|m| matches!(m, Material::Dielectric { .. })))
    );
    scenes
}

/// Rays from everywhere, some of them along an axis or towards the scene.
fn rays(scene: &Scene) -> Vec<Ray> {
    let mut numbers = StreamKey::new(4, Family::Path, 0).stream(0);
    let numbers = &mut numbers;
    let mut rays = Vec::new();
    for exponent in (-44..39).chain([38; 3]) {
        let magnitude = 10_f32.powi(exponent);
        for i in 0..RAYS {
            let offset = match i % 4 {
                0 => Vec3::splat(magnitude) * Vec3::new(1.0, signed(numbers).signum(), -1.0),
                1 => Vec3::ZERO.with_y(magnitude * signed(numbers)),
                _ => vector(numbers) * magnitude,
            };
            let origin = if i % 3 == 0 { offset } else { offset + scene.camera.eye };
            let towards = (scene.camera.eye - origin).as_dvec3();
            let direction = match i % 5 {
                0 => Vec3::NEG_Z,
                1 => towards.normalize_or(glam::DVec3::X).as_vec3(),
                _ => vector(numbers).as_dvec3().normalize_or(glam::DVec3::Y).as_vec3(),
            };
            if origin.is_finite() {
                rays.push(Ray { origin, direction, leaves: NO_SPHERE });
            }
        }
    }
    rays
}

#[test]
fn every_engine_answers_every_ray_alike_and_with_sense() {
    let reference = EngineChoice::new(EngineName::Reference, None).unwrap();
    let mut hits = 0;
    for (name, scene) in scenes() {
        let (still, rays) = (scene.at(scene.camera.shutter[0]), rays(&scene));
        let expected = trace(reference, &still, &rays);
        for (ray, (t, sphere, normal)) in rays.iter().zip(&expected) {
            let told = format!("{name}: t {t}, sphere {sphere}, normal {normal}, {ray:?}");
            let length = normal.as_dvec3().length();
            assert!((length - 1.0).abs() <= UNIT_TOLERANCE || *normal == Vec3::ZERO, "{told}");
            if *sphere == NO_SPHERE {
                assert!(*t == f32::INFINITY && *normal == Vec3::ZERO, "{told}");
            } else {
                assert!(t.is_finite() && *t >= 0.0 && t.is_sign_positive(), "{told}");
                hits += 1;
            }
        }
        for lanes in available_lanes() {
            let fast = EngineChoice::new(EngineName::Fast, Some(LanesName::from(lanes))).unwrap();
            let found = trace(fast, &still, &rays);
            for ((ray, found), expected) in rays.iter().zip(&found).zip(&expected) {
                let bits = |(t, sphere, normal): &(f32, u32, Vec3)| {
                    (t.to_bits(), *sphere, normal.to_array().map(f32::to_bits))
                };
                assert!(
                    bits(found) == bits(expected),
                    "{name} on {lanes:?}: {found:?} instead of {expected:?} for {ray:?}"
                );
            }
        }
    }
    tell("render", hits, "hits of rays of all magnitudes");
}
