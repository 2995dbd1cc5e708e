//! Finds the first sphere that a ray hits, robustly and without an epsilon.
//!
//! Most renderers shift ray origins by a small distance to avoid hitting the surface that a ray leaves. Three rules
//! replace this:
//!
//! 1. A ray knows the sphere that it leaves. The power of its origin with respect to that sphere (`|o - c|^2 - r^2`,
//!    the product of both roots) is zero by definition, so it is set to zero.
//! 2. An opaque sphere is hit from one side only (see [`scene::still`]). Where surfaces meet, rounding may put an
//!    origin behind it. Then the power is clamped to zero, and the ray hits at distance 0 or not at all.
//! 3. Of equal distances the lower sphere id counts.
//!
//! Spheres seen from outside use the formulas of Haines, Gunther and Akenine-Moller, "Precision improvements for
//! ray/sphere intersection" (Ray Tracing Gems, 2019, chapter 7). For a wall of radius 10^4 seen from inside, these lose
//! the distance in the rounding of the squared radius. So from inside the power is measured from an anchor on the
//! surface ([`Enclosure`]), and from outside as well if the eye is close to the sphere ([`Ground`]).

use scene::ray::SphereId;
use scene::still::{Enclosure, Ground, Role};
use scene::{Ray, Sphere, Still, Vec3};

/// The point where a ray hits a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The sphere that is hit.
    pub sphere: SphereId,
    /// Distance along the ray, at least 0; the ray's direction has unit length.
    pub t: f32,
    /// The point; for spheres seen from outside and for glass it is moved onto the sphere.
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

/// True if `ray` hits a surface other than `light` nearer than `t`.
pub fn occluded(still: &Still, ray: &Ray, t: f32, light: SphereId) -> bool {
    let casts_shadow = |id: SphereId| match still.roles[id as usize] {
        Role::Enclosure(e) => still.enclosures[e as usize].casts_shadow,
        Role::Solid | Role::Ground(_) | Role::Glass => true,
    };
    (0..still.spheres.len() as SphereId)
        .any(|id| id != light && casts_shadow(id) && distance(still, id, ray) < t)
}

/// The distance at which `ray` hits sphere `id`, or infinity.
#[expect(clippy::inline_always, reason = "with a call for each sphere, rays take up to a quarter longer")]
#[inline(always)]
pub fn distance(still: &Still, id: SphereId, ray: &Ray) -> f32 {
    let (sphere, leaves) = (&still.spheres[id as usize], ray.leaves == id);
    match still.roles[id as usize] {
        Role::Solid => from_outside(sphere, ray, leaves),
        Role::Ground(g) => from_above(&still.grounds[g as usize], ray, leaves),
        Role::Glass => from_either_side(sphere, ray, leaves),
        Role::Enclosure(e) => from_inside(&still.enclosures[e as usize], ray, leaves),
    }
}

/// Distance to an opaque sphere that is hit from outside: the near root.
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
    let q = b.abs() + discriminant.sqrt(); // NaN if the ray misses; then t is NaN too
    let t = if b > 0.0 {
        -power / q
    } else if power > 0.0 {
        power / q
    } else {
        q
    };
    if t > 0.0 { t } else { f32::INFINITY }
}

/// Distance to a ground: the near root.
///
/// Roots are computed as if the ray started at the point of its line that is nearest to the anchor, and its own start is
/// subtracted. So they are accurate even if it starts far away.
pub fn from_above(ground: &Ground, ray: &Ray, leaves: bool) -> f32 {
    let g = ray.origin - ground.anchor;
    let along = g.dot(ray.direction);
    let nearest = g - ray.direction * along;
    let b = ground.offset.dot(ray.direction);
    let nearest_power = nearest.dot(nearest + ground.twice_offset);
    let discriminant = b * b - nearest_power;
    if !(along + b < 0.0 && discriminant >= 0.0) {
        return f32::INFINITY;
    }
    let root = discriminant.sqrt();
    let t = if b < 0.0 { nearest_power / (root - b) } else { -b - root } - along;
    let is_above = ground.power(ray.origin) > 0.0 && !leaves;
    if is_above && t > 0.0 { t } else { 0.0 }
}

/// Distance to an opaque sphere that is hit from inside: the far root, which always exists.
pub fn from_inside(enclosure: &Enclosure, ray: &Ray, leaves: bool) -> f32 {
    let g = ray.origin - enclosure.anchor;
    let b = (g + enclosure.offset).dot(ray.direction);
    let power = g.dot(g + enclosure.twice_offset) + enclosure.power;
    let power = if power < 0.0 && !leaves { power } else { 0.0 };
    let q = b.abs() + (b * b - power).sqrt();
    if b > 0.0 { -power / q } else { q }
}

/// The terms of the quadratic equation for a ray and a sphere. With f the vector from the centre to the origin:
/// `b = f . d`, the power of the origin `f . f - r^2`, and the discriminant, which is the square of half the chord. It
/// is computed from the ray's distance to the centre.
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

/// A vector of nearly unit length, made 1 long by one step of Newton's method. Without that step, the error would lengthen a
/// mirrored direction by up to 4 times as much, and that in turn the error of the next hit. Inside of a mirror ball it would
/// grow without bound.
fn lengthened_to_1(normal: Vec3) -> Vec3 {
    normal * (1.5 - 0.5 * normal.dot(normal))
}

/// The hit at distance `t` on sphere `id`.
fn surface_at(still: &Still, id: SphereId, ray: &Ray, t: f32) -> Hit {
    let point = ray.origin + ray.direction * t;
    if let Role::Enclosure(e) = still.roles[id as usize] {
        let enclosure = &still.enclosures[e as usize];
        // The far root is accurate to rounding, and the length of the normal nearly so.
        let from_center = (point - enclosure.anchor) + enclosure.offset;
        let normal = from_center * enclosure.minus_inverse_radius;
        let normal = lengthened_to_1(normal);
        return Hit { sphere: id, t, point, normal, inside: true };
    }
    if let Role::Ground(g) = still.roles[id as usize] {
        let ground = &still.grounds[g as usize];
        // Moved onto the ground along the normal, by the height over it: power over diameter.
        let from_anchor = point - ground.anchor;
        let outward = (from_anchor + ground.offset) * ground.inverse_radius;
        let height = from_anchor.dot(from_anchor + ground.twice_offset) * (0.5 * ground.inverse_radius);
        let from_anchor = from_anchor - outward * height;
        let normal = (from_anchor + ground.offset) * ground.inverse_radius;
        let normal = lengthened_to_1(normal);
        return Hit { sphere: id, t, point: ground.anchor + from_anchor, normal, inside: false };
    }
    let sphere = &still.spheres[id as usize];
    let from_center = point - sphere.center;
    let outward = from_center * (1.0 / from_center.dot(from_center).sqrt());
    let point = sphere.center + outward * sphere.radius;
    let inside = outward.dot(ray.direction) > 0.0 && still.roles[id as usize] == Role::Glass;
    Hit { sphere: id, t, point, normal: if inside { -outward } else { outward }, inside }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ray(origin: Vec3, direction: Vec3) -> Ray {
        Ray { origin, direction, leaves: scene::ray::NO_SPHERE }
    }

    fn ball() -> Sphere {
        Sphere {
            center: Vec3::ZERO,
            velocity: Vec3::ZERO,
            radius: 5.0,
            material: 0,
            emission: scene::Rgb::ZERO,
        }
    }

    const NONE: f32 = f32::INFINITY;

    /// Along a line at a distance of 3 from the middle, which is in the ball from -4 to 4.
    #[test]
    fn roots_are_those_of_the_side_that_is_hit() {
        let ball = ball();
        let at = |z: f32| ray(Vec3::new(3.0, 0.0, z), Vec3::Z);
        let [outside, either] = [from_outside, from_either_side];
        assert_eq!([outside(&ball, &at(-10.0), false), either(&ball, &at(-10.0), false)], [6.0, 6.0]);
        // Behind the surface an opaque ball is hit at once if the ray goes inwards, and else passed.
        assert_eq!([outside(&ball, &at(-1.0), false), either(&ball, &at(-1.0), false)], [0.0, 5.0]);
        assert_eq!([outside(&ball, &at(1.0), false), either(&ball, &at(1.0), false)], [NONE, 3.0]);
        assert_eq!([outside(&ball, &at(10.0), false), either(&ball, &at(10.0), false)], [NONE, NONE]);
        // From the surface itself: not hit again, but glass from within.
        assert_eq!([outside(&ball, &at(4.0), true), either(&ball, &at(4.0), true)], [NONE, NONE]);
        assert_eq!([outside(&ball, &at(-4.0), true), either(&ball, &at(-4.0), true)], [0.0, 8.0]);
        let past = ray(Vec3::new(5.1, 0.0, -10.0), Vec3::Z);
        assert_eq!([outside(&ball, &past, false), either(&ball, &past, false)], [NONE, NONE]);
    }

    /// Of equal distances the lower sphere counts, and what is nearer before that.
    #[test]
    fn the_nearest_counts_and_of_equals_the_first() {
        let text = |balls: &[(f32, f32)]| {
            let camera = "{ eye = [0, 0, 9], direction = [0, 0, -1], vertical_fov_degrees = 40 }";
            let mut text = format!("background = [1, 1, 1]\ncamera = {camera}\n");
            for (z, radius) in balls {
                let material = "material = { type = \"diffuse\", albedo = [1, 1, 1] }";
                let place = format!("center = [0, 0, {z:?}]\nradius = {radius:?}\n");
                text.extend(["[[sphere]]\n", &place, material, "\n"]);
            }
            text
        };
        let hit = |balls: &[(f32, f32)]| {
            let scene = files::scene_file::parse("a.toml", &text(balls)).unwrap();
            let still = scene.at(0.0);
            let ray = ray(Vec3::Z * 9.0, Vec3::NEG_Z);
            let hit = intersect(&still, &ray).unwrap();
            assert!(
                occluded(&still, &ray, hit.t + 0.5, SphereId::MAX)
                    && !occluded(&still, &ray, hit.t, SphereId::MAX)
            );
            assert_eq!(occluded(&still, &ray, NONE, hit.sphere), balls.len() > 1);
            (hit.sphere, hit.t, hit.normal, hit.inside)
        };
        assert_eq!(hit(&[(0.0, 1.0)]), (0, 8.0, Vec3::Z, false));
        assert_eq!(hit(&[(0.0, 1.0), (0.5, 0.5)]), (0, 8.0, Vec3::Z, false));
        assert_eq!(hit(&[(0.0, 1.0), (3.0, 1.0)]), (1, 5.0, Vec3::Z, false));
        assert_eq!(hit(&[(3.0, 1.0), (0.0, 1.0)]), (0, 5.0, Vec3::Z, false));
    }
}
