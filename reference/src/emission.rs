//! Where photons leave their lamps: alike from all of them, or aimed at a ball; and what a photon then weighs.
//!
//! The flux of a Lambertian lamp is carried alike by all lines that cross it (in the measure `dA cos dw`), and that of a
//! glowing shell by all lines within. Uniform emission draws lines so. Aimed emission draws them from those that cross a
//! target ball: the direction from the cone that lamp and ball allow, and then a point of a disk across it, at the
//! smaller of both. Lines that turn out to miss the other are dropped. On those kept, the density is the same for all:
//! so weights need no more than the balls that a line crosses ([`scene::aim`]).

use crate::direct_light::choose_light;
use crate::intersect::from_above;
use crate::photon_numbers::{PhotonNumbers, dimension};
use crate::sampling::{cosine_hemisphere, frame, uniform_cone, uniform_disk, uniform_sphere};
use scene::aim::Aim;
use scene::guide::Cell;
use scene::ray::NO_SPHERE;
use scene::still::{Ground, Light};
use scene::{Ray, Rgb, Sphere, Still, Vec3};

/// A photon as it leaves its lamp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Emitted {
    /// Its way.
    pub ray: Ray,
    /// Its power, in multiples of the nominal power; its brightest channel is 1 if photons are not aimed.
    pub power: Rgb,
}

/// A photon on its lamp.
struct Start {
    /// The index of the light.
    light: u32,
    /// Where on the lamp.
    origin: Vec3,
    /// Where it flies.
    direction: Vec3,
    /// The point of its line that is known best.
    point: Vec3,
}

/// Photon number `photon` of an iteration; `None` where it is dropped: its line misses lamp or ball, or it would start
/// where the lamp is sunk into another sphere.
pub fn emit(still: &Still, aim: &Aim, numbers: &PhotonNumbers, photon: u32) -> Option<Emitted> {
    let component = aim.component(photon);
    let (start, weight) = match (&aim.departures, component) {
        (Some(departures), _) => guided(still, &departures.cell(photon), numbers, photon)?,
        (None, 0) => (uniform(still, numbers, photon)?, 1.0),
        (None, k) => (aimed(still, aim, k - 1, numbers, photon)?, 1.0),
    };
    let light = &still.lights.entries[start.light as usize];
    if still.is_hidden(light, start.origin) {
        return None;
    }
    let ray = departure(still, aim, &start);
    if component > 0 && !aim.balls[component - 1].is_crossed(ray.origin, ray.direction) {
        return None;
    }
    Some(Emitted { ray, power: light.photon_power * (weight * aim.weight(ray.origin, ray.direction)) })
}

/// The ray of a photon: from its lamp, or if that is far from where all else begins.
fn departure(still: &Still, aim: &Aim, start: &Start) -> Ray {
    let &Start { light, origin, direction, point } = start;
    let sphere = still.lights.entries[light as usize].sphere;
    let core = aim.core.as_ref().filter(|core| core.is_far[light as usize]);
    let entry = core.and_then(|core| {
        let is_met = |entry: &Vec3| still.grounds.iter().any(|ground| has_met(ground, *entry, direction));
        core.entry(sphere, origin, point, direction).filter(|entry| !is_met(entry))
    });
    match entry {
        Some(origin) => Ray { origin, direction, leaves: NO_SPHERE },
        None => Ray { origin, direction, leaves: sphere },
    }
}

/// True if a ray that comes from afar has met a ground before it is at `point`, or has come through it.
fn has_met(ground: &Ground, point: Vec3, direction: Vec3) -> bool {
    let back = Ray { origin: point, direction: -direction, leaves: NO_SPHERE };
    ground.power(point) <= 0.0 || from_above(ground, &back, false) < f32::INFINITY
}

/// The light that a photon leaves, chosen by power: its index, itself, and the lamp.
fn lamp_by_power<'a>(
    still: &'a Still,
    numbers: &PhotonNumbers,
    photon: u32,
) -> Option<(u32, &'a Light, &'a Sphere)> {
    let [choice] = numbers.stratified(photon, [dimension::LIGHT]);
    let index = choose_light(&still.lights, choice)?;
    let light = &still.lights.entries[index as usize];
    Some((index, light, &still.spheres[light.sphere as usize]))
}

/// From a uniform point of a lamp chosen by power, by the cosine.
fn uniform(still: &Still, numbers: &PhotonNumbers, photon: u32) -> Option<Start> {
    let (index, light, lamp) = lamp_by_power(still, numbers, photon)?;
    let [u, v] = numbers.stratified(photon, dimension::POSITION);
    let outward = uniform_sphere(u, v);
    let normal = if light.inside { -outward } else { outward };
    let [u, v] = numbers.stratified(photon, dimension::DIRECTION);
    let origin = lamp.center + outward * lamp.radius;
    Some(Start { light: index, origin, direction: cosine_hemisphere(normal, u, v), point: origin })
}

/// From a lamp chosen by power, in a direction of a cell; and the weight.
///
/// The points of a Lambertian lamp are uniform, and directions by the cosine about the normal there. That is the same as
/// directions that are uniform and normals by the cosine about the direction: in this order it is free to be guided.
fn guided(still: &Still, cell: &Cell, numbers: &PhotonNumbers, photon: u32) -> Option<(Start, f32)> {
    let (index, light, lamp) = lamp_by_power(still, numbers, photon)?;
    let [u, v] = numbers.stratified(photon, dimension::DIRECTION);
    let (u, v) = cell.place(u, v);
    let direction = uniform_sphere(u, v);
    let [u, v] = numbers.stratified(photon, dimension::POSITION);
    let normal = cosine_hemisphere(direction, u, v);
    let outward = if light.inside { -normal } else { normal };
    let origin = lamp.center + outward * lamp.radius;
    Some((Start { light: index, origin, direction, point: origin }, cell.weight))
}

/// Along a line that crosses a lamp, and most likely ball number `ball`.
fn aimed(still: &Still, aim: &Aim, ball: usize, numbers: &PhotonNumbers, photon: u32) -> Option<Start> {
    let target = &aim.balls[ball];
    let [choice] = numbers.stratified(photon, [dimension::LIGHT]);
    let number = aim.cumulative[ball].partition_point(|&c| c <= choice);
    let (group, index) = (aim.groups.get(number)?, aim.light_of(ball, number, choice));
    let light = &still.lights.entries[index as usize];
    let lamp = &still.spheres[light.sphere as usize];
    let (axis, height) = target.directions(group.center, group.radius);
    let [u, v] = numbers.stratified(photon, dimension::DIRECTION);
    let (direction, _) = uniform_cone(axis, height, u, v);
    let [u, v] = numbers.stratified(photon, dimension::POSITION);
    let (center, radius) = if group.is_aimed_by_disk(target) {
        (target.center, target.radius)
    } else {
        (lamp.center, lamp.radius)
    };
    let point = on_disk(center, radius, direction, u, v);
    let origin = end_of_chord(lamp.center, lamp.radius, light.inside, point, direction)?;
    Some(Start { light: index, origin, direction, point })
}

/// A uniform point of the disk across `direction`.
fn on_disk(center: Vec3, radius: f32, direction: Vec3, u: f32, v: f32) -> Vec3 {
    let (x, y) = uniform_disk(u, v);
    let (s, t) = frame(direction);
    center + (s * (x * radius) + t * (y * radius))
}

/// Where the line through `point` leaves a lamp, or where it enters a shell; `None` if it misses it.
fn end_of_chord(center: Vec3, radius: f32, inside: bool, point: Vec3, direction: Vec3) -> Option<Vec3> {
    let f = point - center;
    let b = f.dot(direction);
    let nearest = f - direction * b;
    let half_chord2 = radius * radius - nearest.dot(nearest);
    if half_chord2 < 0.0 {
        return None;
    }
    let half_chord = half_chord2.sqrt();
    let from_center = nearest + direction * if inside { -half_chord } else { half_chord };
    let outward = from_center * (1.0 / from_center.dot(from_center).sqrt());
    Some(center + outward * radius)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of a lamp photons leave where their line does, of a shell where it enters the room.
    #[test]
    fn photons_start_at_an_end_of_the_chord() {
        let (center, radius) = (Vec3::new(1.0, 2.0, 3.0), 5.0);
        let point = center + Vec3::new(3.0, 0.0, -9.0);
        let end = |inside| end_of_chord(center, radius, inside, point, Vec3::Z).unwrap();
        assert!((end(false) - (center + Vec3::new(3.0, 0.0, 4.0))).length() < 1e-5);
        assert!((end(true) - (center + Vec3::new(3.0, 0.0, -4.0))).length() < 1e-5);
        let at = |x: f32| end_of_chord(center, radius, false, center + Vec3::X * x, Vec3::Z);
        assert_eq!(at(5.0), Some(center + Vec3::X * 5.0));
        assert!(at(5.001).is_none() && at(-4.999).is_some());
    }

    /// Evenly over the disk, and no farther from the middle than its radius.
    #[test]
    fn points_of_a_disk_lie_across_the_direction() {
        let (center, direction) = (Vec3::new(1.0, -2.0, 0.5), Vec3::new(0.6, 0.0, 0.8));
        for (u, v) in [(0.0, 0.3), (0.25, 0.0), (0.25, 0.25), (0.81, 0.6), (0.999, 0.9)] {
            let from = on_disk(center, 2.0, direction, u, v) - center;
            assert!(
                from.dot(direction).abs() < 1e-6 && (from.length() - 2.0 * u.sqrt()).abs() < 1e-5,
                "{u}, {v}"
            );
        }
        let quarter = |v| on_disk(center, 2.0, direction, 0.25, v) - center;
        assert!(
            quarter(0.0).dot(quarter(0.25)).abs() < 1e-6 && (quarter(0.0) + quarter(0.5)).length() < 1e-6
        );
    }

    fn scene_of(spheres: &[&str]) -> scene::Scene {
        let camera = "camera = { eye = [0, 0, 0], direction = [0, 0, -1], vertical_fov_degrees = 40 }";
        let mut text = format!("background = [0, 0, 0]\n{camera}\n");
        for sphere in spheres {
            let material = "material = { type = \"diffuse\", albedo = [1, 1, 1] }";
            text.extend(["[[sphere]]\n", &sphere.replace("; ", "\n"), "\n", material, "\n"]);
        }
        files::scene_file::parse("a.toml", &text).unwrap()
    }

    /// Nothing leaves a lamp where it is sunk into a ball, or stands out of the room.
    #[test]
    fn sunken_parts_of_lamps_send_nothing() {
        let scene = scene_of(&[
            "center = [0, 0, 0]; radius = 10",
            "center = [9.5, 0, 0]; radius = 1; emission = [1, 1, 1]",
            "center = [8.5, 0, 0]; radius = 0.5",
        ]);
        let still = scene.at(0.0);
        let lamp = still.lights.entries.iter().find(|light| light.sphere == 1).unwrap();
        let blocked = |x: f32, y: f32| still.is_hidden(lamp, Vec3::new(9.5 + x, y, 0.0));
        assert!(blocked(-1.0, 0.0), "within the small ball");
        assert!(blocked(1.0, 0.0), "outside of the room");
        assert!(!blocked(0.0, 1.0) && !blocked(-0.6, 0.8));
    }
}
