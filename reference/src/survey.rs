//! Survey: before the first iteration, where must light arrive for the eye to see it?
//!
//! Walks start at the eye, go on from the first diffuse surface as light may have come to it, and ask at every surface
//! that they meet from there on how much light arrives straight from a lamp: by a shadow ray, as direct light does. Those
//! arrivals say what photons are to be aimed at ([`Targets`]). Where nothing is aimed, the lines between diffuse surfaces say how
//! photons are guided ([`scene::guide`]). What walks find enters the image in no other way, so it does not matter that mirrors and
//! glass are asked as if they scattered.

use crate::camera_pass::ray_through;
use crate::direct_light::sample_light;
use crate::intersect::{Hit, intersect};
use crate::light_choice::Receiver;
use crate::sampling::cosine_hemisphere;
use crate::scatter::{dielectric, reflect};
use scene::aim::survey::{MOST_OF_WALK, targets};
use scene::aim::{Arrival, Targets};
use scene::camera::Frame;
use scene::guide::{Edge, Found, Lit};
use scene::rng::{Family, Stream, StreamKey, unit_float};
use scene::sobol::sobol;
use scene::still::Carried;
use scene::{Material, Ray, Scene, Settings, Still, Vec3, max_component};
use std::ops::Range;

/// What photons are to be aimed at: a function of scene, settings and seed, the same before every iteration.
pub fn survey(scene: &Scene, settings: &Settings) -> Targets {
    survey_for(scene, settings, Carried::All)
}

/// The same for photons that carry this light. Those that carry caustics are aimed at mirrors and glass alone.
pub fn survey_for(scene: &Scene, settings: &Settings, carried: Carried) -> Targets {
    let still = scene.at_for(scene.camera.shutter_time(settings.seed, 0), carried);
    targets(&still, settings, |walks, max_depth| vec![found(scene, &still, settings, walks, max_depth)])
}

/// What some walks find in the scene at one instant, each of at most `max_depth` segments after its first diffuse surface.
pub fn found(scene: &Scene, still: &Still, settings: &Settings, walks: Range<u32>, max_depth: u32) -> Found {
    let key = StreamKey::new(settings.seed, Family::Survey, 0);
    let frame = scene.camera.frame(settings.width, settings.height);
    let mut found = Found::default();
    for walk in walks {
        let mut stream = key.stream(walk);
        let ray = eye_ray(&frame, settings, walk, &mut stream);
        follow(still, (walk, ray), max_depth, &mut stream, &mut found);
    }
    found
}

/// The ray of a walk: places in the image are Sobol points.
fn eye_ray(frame: &Frame, settings: &Settings, walk: u32, stream: &mut Stream) -> Ray {
    let [x, y] = [0, 1].map(|d| unit_float(sobol(walk, d)));
    let lens = (stream.next_f32(), stream.next_f32());
    let place = (x * settings.width as f32, y * settings.height as f32);
    ray_through(frame, place, (frame.aperture_radius > 0.0).then_some(lens))
}

/// Walks as paths of the path tracer do, with roulette at every surface.
fn follow(still: &Still, (walk, ray): (u32, Ray), max_depth: u32, stream: &mut Stream, found: &mut Found) {
    let (mut ray, mut length, mut seen_diffuse) = (ray, 0, false);
    while length < max_depth {
        length += 1;
        let Some(hit) = intersect(still, &ray) else { return };
        let material = still.material(hit.sphere);
        let is_diffuse = matches!(material, Material::Diffuse { .. });
        if is_diffuse && seen_diffuse && length <= MOST_OF_WALK {
            let Hit { point, normal, .. } = hit;
            found.edges.push(Edge { walk, point, normal, direction: -ray.direction });
        }
        let [u, v, roulette] = std::array::from_fn(|_| stream.next_f32());
        let direction = match *material {
            Material::Diffuse { .. } => cosine_hemisphere(hit.normal, u, v),
            Material::Specular { .. } => reflect(ray.direction, hit.normal),
            Material::Dielectric { ior, .. } => dielectric(ray.direction, &hit, ior, u).0,
        };
        let numbers = std::array::from_fn(|_| stream.next_f32());
        // What would be absorbed where it arrives does not matter.
        if roulette >= max_component(material.albedo()) {
            return;
        }
        let is_first = is_diffuse && !seen_diffuse;
        let counts = still.carried == Carried::All || !is_diffuse;
        if (seen_diffuse || is_first)
            && counts
            && let Some(arrival) = arrival(still, &hit, direction, numbers)
        {
            found.lit.push(Lit { walk, is_seen: is_first, arrival });
        }
        if is_first {
            (seen_diffuse, length) = (true, 1);
        }
        ray = Ray { origin: hit.point, direction, leaves: hit.sphere };
    }
}

/// Light that arrives at a hit on the side where the walk goes on.
fn arrival(still: &Still, hit: &Hit, direction: Vec3, [choice, u, v]: [f32; 3]) -> Option<Arrival> {
    let normal = if hit.normal.dot(direction) > 0.0 { hit.normal } else { -hit.normal };
    let receiver = Receiver { point: hit.point, normal, sphere: hit.sphere };
    let (source, irradiance) = sample_light(still, &receiver, choice, u, v)?;
    let flux = max_component(irradiance);
    (flux > 0.0).then_some(Arrival { point: hit.point, source, flux })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Walks start all over the image, and within it.
    #[test]
    fn walks_start_at_places_of_the_image() {
        let scene = files::builtin::scene("cornell").unwrap();
        let settings = Settings { width: 40, height: 30, ..scene.settings };
        let frame = scene.camera.frame(40, 30);
        let key = StreamKey::new(settings.seed, Family::Survey, 0);
        let mut places: Vec<(i32, i32)> = (0..64)
            .map(|walk| {
                let ray = eye_ray(&frame, &settings, walk, &mut key.stream(walk));
                assert_eq!(ray.origin, frame.eye);
                let [x, y, z] = [frame.right, frame.up, frame.forward].map(|axis| ray.direction.dot(axis));
                let (x, y) = (x / z / frame.pixel + frame.half[0], frame.half[1] - y / z / frame.pixel);
                assert!((-1e-3..40.001).contains(&x) && (-1e-3..30.001).contains(&y), "{x}, {y}");
                ((x * 0.2 + 1e-3) as i32, (y * 0.8 / 3.0 + 1e-3) as i32)
            })
            .collect();
        places.sort_unstable();
        places.dedup();
        assert_eq!(places.len(), 64);
    }

    /// Light arrives on the side where the walk goes on, from a lamp, and not in the dark.
    #[test]
    fn arrivals_are_of_light_that_was_seen_from_a_surface() {
        let scene = files::builtin::scene("cornell").unwrap();
        let still = scene.at(0.0);
        let settings = Settings { seed: 1, ..scene.settings };
        let found = |max_depth| found(&scene, &still, &settings, 0..200, max_depth);
        let arrivals = |max_depth| found(max_depth).arrivals().map(|lit| lit.arrival).collect::<Vec<_>>();
        // Of one segment from the first surface on, none but that surface is met.
        assert!(arrivals(1).is_empty());
        let (two, five) = (arrivals(2).len(), arrivals(5));
        assert!(two > 20 && two <= 200 && five.len() > two, "{two}, {}", five.len());
        let is_lit = |point: Vec3| {
            still.lights.entries.iter().any(|light| {
                let lamp = still.spheres[light.sphere as usize];
                ((point - lamp.center).length() / lamp.radius - 1.0).abs() < 1e-2
            })
        };
        assert!(five.iter().all(|arrival| arrival.flux > 0.0 && is_lit(arrival.source)), "{five:?}");
        // What the eye sees itself is lit too, and no walk goes on from there more often than it comes there.
        let one = found(1);
        assert!(one.edges.is_empty() && one.lit.iter().all(|lit| lit.is_seen) && one.lit.len() > 20);
        // A line ends at one diffuse surface and leads to another, on the side that it leaves.
        let found = found(5);
        assert!(found.edges.len() > 100 && found.edges.is_sorted_by_key(|edge| edge.walk));
        assert!(found.edges.iter().all(|edge| edge.direction.dot(edge.normal) > 0.0), "{:?}", found.edges);
    }
}
