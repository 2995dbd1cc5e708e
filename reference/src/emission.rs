//! Where photons leave their lamps: alike from all of them, or aimed at a ball; and what a photon then weighs.
//!
//! The flux of a Lambertian lamp is carried alike by all lines that cross it (in the measure `dA cos dw`), and that of a
//! glowing shell by all lines within. Uniform emission draws lines so. Aimed emission draws them from those that cross a
//! target ball: the direction from the cone that lamp and ball allow, and then a point of a disk across it, at the
//! smaller of both. Lines that turn out to miss the other are dropped. On those kept, the density is the same for all:
//! so weights need no more than the balls that a line crosses ([`scene::aim`]).

use crate::direct_light::choose_light;
use crate::photon_numbers::{PhotonNumbers, dimension};
use crate::sampling::{cosine_hemisphere, frame, uniform_cone, uniform_disk, uniform_sphere};
use scene::aim::Aim;
use scene::guide::Cell;
use scene::ray::NO_SPHERE;
use scene::still::{Light, Role};
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
    if is_blocked(still, light, start.origin) {
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
    match core.and_then(|core| core.entry(sphere, origin, point, direction)) {
        Some(origin) => Ray { origin, direction, leaves: NO_SPHERE },
        None => Ray { origin, direction, leaves: sphere },
    }
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

/// True if `point` of the lamp lies within an opaque ball, or outside of a shell around the eye.
fn is_blocked(still: &Still, light: &Light, point: Vec3) -> bool {
    let blockers = light.blockers.start as usize..light.blockers.end as usize;
    still.lights.blockers[blockers].iter().any(|&id| {
        let sphere = &still.spheres[id as usize];
        let from_center = point - sphere.center;
        let within = from_center.dot(from_center) < sphere.radius * sphere.radius;
        within == (still.roles[id as usize] == Role::Solid)
    })
}
