//! Light that comes straight from a lamp: one shadow ray.

use crate::intersect::{distance, occluded};
use crate::light_choice::{Receiver, choose};
use crate::sampling::{cosine_hemisphere, uniform_cone};
use scene::still::{Light, Lights};
use scene::{Ray, Rgb, Still, Vec3};
use std::f32::consts::PI;

/// The index of the light that `u` in [0, 1) chooses by power, with its [`Light::probability`].
pub fn choose_light(lights: &Lights, u: f32) -> Option<u32> {
    let index = lights.cumulative.partition_point(|&c| c <= u);
    (index < lights.entries.len()).then_some(index as u32)
}

/// An unbiased estimate of the irradiance that reaches `receiver` straight from the lights, from three uniform
/// numbers: one to choose the light, two for the direction.
pub fn estimate_irradiance(still: &Still, receiver: &Receiver, choice: f32, u: f32, v: f32) -> Rgb {
    sample_light(still, receiver, choice, u, v).map_or(Rgb::ZERO, |(_, irradiance)| irradiance)
}

/// The same, with the point of the light that it comes from; `None` if none comes.
pub fn sample_light(still: &Still, receiver: &Receiver, choice: f32, u: f32, v: f32) -> Option<(Vec3, Rgb)> {
    let chosen = choose(still, receiver, choice)?;
    let light = &still.lights.entries[chosen.light as usize];
    let sample = if light.inside {
        from_inside(still, receiver, light, u, v)
    } else {
        from_outside(still, receiver, light, u, v)
    };
    let (ray, t, weight) = sample.filter(|(ray, t, _)| !occluded(still, ray, *t, light.sphere))?;
    let irradiance = still.spheres[light.sphere as usize].emission * (weight / chosen.probability);
    Some((ray.origin + ray.direction * t, irradiance))
}

/// A shadow ray with its length, and the cosine at the receiver over the density of the direction.
type Sample = Option<(Ray, f32, f32)>;

/// Samples the cone under which a lamp appears (Shirley, Wang and Zimmerman 1996).
fn from_outside(still: &Still, receiver: &Receiver, light: &Light, u: f32, v: f32) -> Sample {
    let lamp = &still.spheres[light.sphere as usize];
    let to_center = lamp.center - receiver.point;
    let d2 = to_center.dot(to_center);
    let r2 = lamp.radius * lamp.radius;
    // A ball does not light itself, nor from its outside what lies within.
    if receiver.sphere == light.sphere || d2 <= r2 {
        return None;
    }
    let d = d2.sqrt();
    let sin2_max = r2 / d2;
    let height = sin2_max / (1.0 + (1.0 - sin2_max).sqrt());
    let (direction, h) = uniform_cone(to_center * (1.0 / d), height, u, v);
    let cos = receiver.normal.dot(direction);
    let half_chord2 = r2 - d2 * (h * (2.0 - h));
    let half_chord = if half_chord2 > 0.0 { half_chord2.sqrt() } else { 0.0 };
    let t = d * (1.0 - h) - half_chord;
    let ray = Ray { origin: receiver.point, direction, leaves: receiver.sphere };
    (cos > 0.0).then_some((ray, t, cos * (2.0 * PI * height)))
}

/// Samples the half space by the cosine: a glowing shell fills it as seen from within.
fn from_inside(still: &Still, receiver: &Receiver, light: &Light, u: f32, v: f32) -> Sample {
    let direction = cosine_hemisphere(receiver.normal, u, v);
    let ray = Ray { origin: receiver.point, direction, leaves: receiver.sphere };
    let t = distance(still, light.sphere, &ray);
    let shell = &still.spheres[light.sphere as usize];
    let from_center = receiver.point - shell.center;
    let is_within = still.material(light.sphere).is_opaque()
        || from_center.dot(from_center) < shell.radius * shell.radius;
    (is_within && t < f32::INFINITY).then_some((ray, t, PI))
}
