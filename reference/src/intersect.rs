//! Which sphere a ray hits first, robustly and without an epsilon.
//!
//! Three rules make intersections exact where renderers otherwise shift ray origins by a small distance:
//!
//! 1. A ray knows the sphere it leaves. The power of its origin with respect to that sphere
//!    (`|o - c|^2 - r^2`, the product of both roots) is zero by definition, so it is set to zero.
//! 2. An opaque sphere is met from one side only (see [`scene::still`]). An origin computed to lie behind it does so
//!    by rounding, where surfaces meet; its power is clamped to zero, and the ray hits at distance 0 or not at all.
//! 3. Of equal distances the lower sphere id counts.
//!
//! The formulas: for spheres seen from outside, those of Haines, Gunther and Akenine-Moller, "Precision improvements
//! for ray/sphere intersection" (Ray Tracing Gems, 2019, chapter 7); seen from inside, the power is measured from an
//! anchor on the surface ([`Enclosure`]), as that chapter's form loses the distance to a wall of radius 10^4 in the
//! rounding of its squared radius.

use scene::ray::SphereId;
use scene::still::{Enclosure, Role};
use scene::{Ray, Sphere, Still, Vec3};

/// Where a ray meets a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The sphere that is met.
    pub sphere: SphereId,
    /// Distance along the ray, at least 0; the ray's direction has unit length.
    pub t: f32,
    /// The point, moved onto the sphere.
    pub point: Vec3,
    /// Unit normal on the side that the ray comes from.
    pub normal: Vec3,
    /// True if the ray comes from the inside.
    pub inside: bool,
}

/// The nearest hit of `ray`, or `None` if it escapes.
pub fn intersect(still: &Still, ray: &Ray) -> Option<Hit> {
    let (mut t, mut sphere) = (f32::INFINITY, None);
    for id in 0..still.spheres.len() as SphereId {
        let candidate = distance(still, id, ray);
        if candidate < t {
            (t, sphere) = (candidate, Some(id));
        }
    }
    sphere.map(|id| surface_at(still, id, ray, t))
}

/// True if a surface other than that of `light` lies on `ray` nearer than `t`.
pub fn occluded(still: &Still, ray: &Ray, t: f32, light: SphereId) -> bool {
    let casts_shadow = |id: SphereId| match still.roles[id as usize] {
        Role::Enclosure(e) => still.enclosures[e as usize].casts_shadow,
        Role::Solid | Role::Glass => true,
    };
    (0..still.spheres.len() as SphereId)
        .any(|id| id != light && casts_shadow(id) && distance(still, id, ray) < t)
}

/// The distance at which `ray` meets sphere `id`, or infinity.
pub fn distance(still: &Still, id: SphereId, ray: &Ray) -> f32 {
    let (sphere, leaves) = (&still.spheres[id as usize], ray.leaves == id);
    match still.roles[id as usize] {
        Role::Solid => from_outside(sphere, ray, leaves),
        Role::Glass => from_either_side(sphere, ray, leaves),
        Role::Enclosure(e) => from_inside(&still.enclosures[e as usize], ray, leaves),
    }
}

/// Distance to an opaque sphere that is met from outside: the near root.
pub fn from_outside(sphere: &Sphere, ray: &Ray, leaves: bool) -> f32 {
    let Chord { b, power, discriminant } = Chord::new(sphere, ray);
    if !(b < 0.0 && discriminant >= 0.0) {
        return f32::INFINITY;
    }
    let power = if power > 0.0 && !leaves { power } else { 0.0 };
    power / (discriminant.sqrt() - b)
}

/// Distance to a transparent sphere: the smaller positive root.
pub fn from_either_side(sphere: &Sphere, ray: &Ray, leaves: bool) -> f32 {
    let Chord { b, power, discriminant } = Chord::new(sphere, ray);
    let power = if leaves { 0.0 } else { power };
    let q = b.abs() + discriminant.sqrt(); // NaN where the ray passes by, and then so is t
    let t = if b > 0.0 {
        -power / q
    } else if power > 0.0 {
        power / q
    } else {
        q
    };
    if t > 0.0 { t } else { f32::INFINITY }
}

/// Distance to an opaque sphere that is met from inside: the far root, which always exists.
pub fn from_inside(enclosure: &Enclosure, ray: &Ray, leaves: bool) -> f32 {
    let g = ray.origin - enclosure.anchor;
    let b = (g + enclosure.offset).dot(ray.direction);
    let power = g.dot(g + enclosure.twice_offset) + enclosure.power;
    let power = if power < 0.0 && !leaves { power } else { 0.0 };
    let q = b.abs() + (b * b - power).sqrt();
    if b > 0.0 { -power / q } else { q }
}

/// The numbers of a ray and a sphere: with f the vector from the centre to the origin, `b = f . d`, the power of the
/// origin `f . f - r^2`, and the squared half length of the chord, by the ray's distance from the centre.
struct Chord {
    b: f32,
    power: f32,
    discriminant: f32,
}

impl Chord {
    fn new(sphere: &Sphere, ray: &Ray) -> Self {
        let f = ray.origin - sphere.center;
        let b = f.dot(ray.direction);
        let radius_squared = sphere.radius * sphere.radius;
        let nearest = f - ray.direction * b;
        let discriminant = radius_squared - nearest.dot(nearest);
        Self { b, power: f.dot(f) - radius_squared, discriminant }
    }
}

/// The hit at distance `t` on sphere `id`.
fn surface_at(still: &Still, id: SphereId, ray: &Ray, t: f32) -> Hit {
    let point = ray.origin + ray.direction * t;
    if let Role::Enclosure(e) = still.roles[id as usize] {
        let enclosure = &still.enclosures[e as usize];
        // The far root is accurate to rounding, and so is the length of this vector, almost: a step of Newton's
        // makes it 1. Left as it is, its error would lengthen a mirrored direction by up to 4 times as much, and
        // that the next hit's error in turn: inside of a mirror ball, without bound.
        let from_center = (point - enclosure.anchor) + enclosure.offset;
        let normal = from_center * enclosure.minus_inverse_radius;
        let normal = normal * (1.5 - 0.5 * normal.dot(normal));
        return Hit { sphere: id, t, point, normal, inside: true };
    }
    let sphere = &still.spheres[id as usize];
    let from_center = point - sphere.center;
    let outward = from_center * (1.0 / from_center.dot(from_center).sqrt());
    let point = sphere.center + outward * sphere.radius;
    let inside = outward.dot(ray.direction) > 0.0 && still.roles[id as usize] == Role::Glass;
    Hit { sphere: id, t, point, normal: if inside { -outward } else { outward }, inside }
}
