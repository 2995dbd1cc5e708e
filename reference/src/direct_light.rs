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

#[cfg(test)]
mod tests {
    use super::*;

    /// A shell of this material, which glows, around the eye.
    fn shell(kind: &str) -> scene::Scene {
        let material = format!("material = {{ type = {kind} }}");
        let text = format!(
            "background = [0, 0, 0]\ncamera = {{ eye = [0, 0, 0], direction = [0, 0, -1], vertical_fov_degrees = 40 }}\n\
             [[sphere]]\ncenter = [4, 0, 0]\nradius = 10\nemission = [2, 2, 2]\n{material}\n"
        );
        files::scene_file::parse("a.toml", &text).unwrap()
    }

    /// Within a shell that glows, every direction brings its radiance: pi of it. What lies outside of glass gets none from its
    /// inner side.
    #[test]
    fn a_shell_fills_the_half_space_of_what_is_within() {
        let glass = "\"dielectric\", albedo = [1, 1, 1], ior = 1.5";
        for kind in ["\"diffuse\", albedo = [0, 0, 0]", glass] {
            let scene = shell(kind);
            let still = scene.at(0.0);
            let inner = still.lights.entries.iter().find(|light| light.inside).unwrap();
            let at = |x: f32| {
                let receiver = Receiver { point: Vec3::X * (4.0 + x), normal: Vec3::NEG_X, sphere: u32::MAX };
                from_inside(&still, &receiver, inner, 0.3, 0.7).map(|(_, t, weight)| (t.is_finite(), weight))
            };
            assert_eq!([at(0.0), at(-9.99), at(9.99)], [Some((true, PI)); 3], "{kind}");
            let is_glass = kind == glass;
            assert!(at(10.5).is_none() || !is_glass, "{kind}");
        }
    }

    /// Of a lamp, whatever the numbers, the weight is the cosine over the density of the cone, and the way ends on it.
    #[test]
    fn a_lamp_is_seen_under_its_cone() {
        let text = "background = [0, 0, 0]\n\
            camera = { eye = [0, 0, 0], direction = [0, 0, -1], vertical_fov_degrees = 40 }\n\
            [[sphere]]\ncenter = [0, 0, 5]\nradius = 3\nemission = [2, 2, 2]\n\
            material = { type = \"diffuse\", albedo = [1, 1, 1] }\n";
        let scene = files::scene_file::parse("a.toml", text).unwrap();
        let still = scene.at(0.0);
        let lamp = &still.lights.entries[0];
        let from = |point: Vec3, sphere| {
            let receiver = Receiver { point, normal: Vec3::Z, sphere };
            from_outside(&still, &receiver, lamp, 0.4, 0.2)
        };
        let (ray, t, weight) = from(Vec3::ZERO, u32::MAX).unwrap();
        let end = ray.origin + ray.direction * t - Vec3::Z * 5.0;
        assert!((end.length() - 3.0).abs() < 1e-5 && end.z < 0.0, "{end}");
        // 1 - cos of the half angle, whose sine is 3 / 5.
        assert!((weight - ray.direction.z * 2.0 * PI * 0.2).abs() < 1e-6, "{weight}");
        // It lights neither itself, nor what is within or behind the horizon.
        assert!(from(Vec3::ZERO, 0).is_none() && from(Vec3::Z * 3.0, u32::MAX).is_none());
        assert!(from(Vec3::Z * 2.0, u32::MAX).is_none() && from(Vec3::Z * 9.0, u32::MAX).is_none());
    }

    #[test]
    fn numbers_choose_lights_by_their_power() {
        let lights =
            Lights { entries: Vec::new(), ..shell("\"diffuse\", albedo = [0, 0, 0]").at(0.0).lights };
        assert_eq!(choose_light(&lights, 0.0), None);
        let one = shell("\"diffuse\", albedo = [0, 0, 0]").at(0.0).lights;
        assert_eq!(choose_light(&one, 0.0), Some(0));
        assert_eq!(choose_light(&one, 1.0 - f32::EPSILON / 2.0), Some(0));
    }
}
