//! Intersects rays with a scene at one instant.
//!
//! The intersection of engines is made for rays that start on surfaces of the scene or at its eye. A ray of a user may
//! start anywhere: at 1e38, where squares overflow and boxes of the fast engine's tree hold no more, or behind a wall,
//! where formulas that presume a point on a sphere give no unit vector. What is answered holds everywhere: see [`trace`].

use crate::choice::EngineChoice;
use crate::names::EngineName;
use fast::Intersector;
use rayon::prelude::*;
use reference::intersect::intersect;
use scene::check::LIMIT;
use scene::ray::{NO_SPHERE, SphereId};
use scene::still::Role;
use scene::{Ray, Still, Vec3};

/// Rays per work item.
const RAYS_AT_ONCE: usize = 1 << 14;
/// The result for a ray that hits nothing.
const MISS: (f32, SphereId, Vec3) = (f32::INFINITY, NO_SPHERE, Vec3::ZERO);
/// A normal whose squared length is this close to 1 is answered as the engines compute it, with an error of some roundings.
const UNIT_TOLERANCE: f64 = 1e-5;

/// Distance in scene units, sphere and unit normal of the nearest hit of each ray, computed on the current rayon pool.
/// Every engine gives the same bits.
///
/// A distance is finite and at least 0, or infinite for a miss. A normal has unit length, but for rounding; or it is zero,
/// for a miss and where there is none, as at the centre of a sphere.
pub fn trace(engine: EngineChoice, still: &Still, rays: &[Ray]) -> Vec<(f32, SphereId, Vec3)> {
    let intersector = Intersector::new(still, engine.lane_kind());
    let one_by_one = |ray: &Ray| intersect(still, ray).map_or(MISS, |hit| (hit.t, hit.sphere, hit.normal));
    let some = |rays: &[Ray]| -> Vec<_> {
        let met: Vec<_> = match engine.name() {
            EngineName::Fast => {
                let near: Vec<Ray> = rays.iter().copied().filter(is_near).collect();
                let mut met = intersector.surfaces(&near).into_iter();
                let mut next = || met.next().flatten().map_or(MISS, |met| (met.t, met.sphere, met.normal));
                rays.iter().map(|ray| if is_near(ray) { next() } else { one_by_one(ray) }).collect()
            }
            EngineName::Reference => rays.iter().map(one_by_one).collect(),
        };
        rays.iter().zip(met).map(|(ray, met)| answer(still, ray, met)).collect()
    };
    rays.par_chunks(RAYS_AT_ONCE).flat_map_iter(some).collect()
}

/// Whether a ray starts where something of a scene can be. What starts beyond is answered by the reference, whichever the
/// engine.
fn is_near(ray: &Ray) -> bool {
    f64::from(ray.origin.abs().max_element()) <= LIMIT
}

/// What is answered for a ray for which an engine found `t`, `sphere` and `normal`.
fn answer(still: &Still, ray: &Ray, (t, sphere, normal): (f32, SphereId, Vec3)) -> (f32, SphereId, Vec3) {
    if !(t >= 0.0 && t.is_finite()) {
        return MISS;
    }
    let length_squared = normal.as_dvec3().length_squared();
    let is_unit = (length_squared - 1.0).abs() <= UNIT_TOLERANCE;
    // Adding 0 turns -0 into 0.
    (t + 0.0, sphere, if is_unit { normal } else { normal_at(still, ray, t, sphere) })
}

/// The unit normal at distance `t`, on the side that the ray comes from, in `f64`: the direction from the centre of the
/// sphere, wherever the point is. Zero at the centre.
fn normal_at(still: &Still, ray: &Ray, t: f32, sphere: SphereId) -> Vec3 {
    let direction = ray.direction.as_dvec3();
    let point = ray.origin.as_dvec3() + direction * f64::from(t);
    let outward = (point - still.spheres[sphere as usize].center.as_dvec3()).normalize_or_zero();
    let is_inside = match still.roles[sphere as usize] {
        Role::Enclosure(_) => true,
        Role::Solid | Role::Ground(_) => false,
        Role::Glass => outward.dot(direction) > 0.0,
    };
    let normal = if is_inside { -outward } else { outward };
    normal.as_vec3() + Vec3::ZERO // no -0
}

#[cfg(test)]
mod tests {
    use super::*;
    use scene::Sphere;

    /// What rounding of `f32` may turn a unit vector by.
    const ROUNDING: f32 = 1e-6;

    /// Of what is opaque normals are on the side that can be seen, of glass on the side that the ray comes from.
    #[test]
    fn normals_are_on_the_side_of_the_ray() {
        let text = "background = [1, 1, 1]\n\
            camera = { eye = [0, 0, 10], direction = [0, 0, -1], vertical_fov_degrees = 40 }\n\
            [[sphere]]\ncenter = [0, 0, 0]\nradius = 2\n\
            material = { type = \"dielectric\", albedo = [1, 1, 1], ior = 1.5 }\n\
            [[sphere]]\ncenter = [9, 0, 0]\nradius = 1\nmaterial = { type = \"diffuse\", albedo = [1, 1, 1] }\n";
        let scene = files::scene_file::parse("balls.toml", text).unwrap();
        let still = scene.at(0.0);
        let (glass, ball, sky) = (0, 1, 2);
        let Sphere { center: middle, radius: sky_radius, .. } = still.spheres[sky as usize];
        for (origin, t, sphere, normal) in [
            (Vec3::Z * 10.0, 8.0, glass, Vec3::Z),
            (Vec3::ZERO, 2.0, glass, Vec3::Z),
            // A ray that only touches it stays outside.
            (Vec3::new(2.0, 0.0, 10.0), 10.0, glass, Vec3::X),
            (Vec3::new(9.0, 0.0, 10.0), 9.0, ball, Vec3::Z),
            (middle, sky_radius, sky, Vec3::Z),
        ] {
            let ray = Ray { origin, direction: Vec3::NEG_Z, leaves: NO_SPHERE };
            let found = normal_at(&still, &ray, t, sphere);
            assert!((found - normal).length() < ROUNDING, "{found} of sphere {sphere} from {origin}");
        }
    }

    fn hit(t: f32, normal: Vec3) -> (f32, SphereId, Vec3) {
        let scene = files::builtin::scene("cornell").unwrap();
        let ray = Ray { origin: scene.camera.eye, direction: scene.camera.direction, leaves: NO_SPHERE };
        answer(&scene.at(0.0), &ray, (t, 0, normal))
    }

    /// Distances are finite and at least 0, normals of unit length.
    #[test]
    fn what_is_no_distance_is_a_miss() {
        for t in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1e-9] {
            assert_eq!(hit(t, Vec3::X), MISS, "{t}");
        }
        let (t, sphere, normal) = hit(-0.0, Vec3::X);
        assert_eq!((t.to_bits(), sphere, normal), (0, 0, Vec3::X));
        assert_eq!(hit(f32::MAX, Vec3::X).0, f32::MAX);
    }

    /// The engines' own normal stays to the bit; what is none is computed.
    #[test]
    fn normals_that_are_not_of_unit_length_are_computed() {
        let nearly = Vec3::X * 1.000_004;
        assert_eq!(hit(1.0, nearly).2, nearly);
        for wrong in [Vec3::X * 1.001, Vec3::X * 0.999, Vec3::ZERO, Vec3::splat(f32::NAN)] {
            let (_, _, normal) = hit(1.0, wrong);
            assert!((normal.length() - 1.0).abs() < ROUNDING && normal != wrong, "{normal}");
        }
    }

    /// Behind a part of an array that the lanes take, the rays are still in their order.
    #[test]
    fn hits_are_in_the_order_of_the_rays() {
        let scene = files::builtin::scene("cornell").unwrap();
        let still = scene.at(0.0);
        let ray = |i: usize| {
            let far = if i.is_multiple_of(3) { 1e30 } else { 0.0 };
            let origin = scene.camera.eye + Vec3::X * (0.01 * (i % 100) as f32 + far);
            Ray { origin, direction: scene.camera.direction, leaves: NO_SPHERE }
        };
        let rays: Vec<Ray> = (0..RAYS_AT_ONCE + 5).map(ray).collect();
        let by = |engine| trace(EngineChoice::new(engine, None).unwrap(), &still, &rays);
        let (fast, reference) = (by(EngineName::Fast), by(EngineName::Reference));
        assert_eq!(fast, reference);
        for i in [0, 1, 99, RAYS_AT_ONCE - 1, RAYS_AT_ONCE, RAYS_AT_ONCE + 4] {
            assert_eq!(
                fast[i],
                trace(EngineChoice::new(EngineName::Reference, None).unwrap(), &still, &rays[i..=i])[0],
                "{i}"
            );
        }
        assert_eq!(fast.len(), rays.len());
    }

    #[test]
    fn what_starts_at_the_limit_of_a_scene_is_near() {
        let at = |origin| is_near(&Ray { origin, direction: Vec3::X, leaves: NO_SPHERE });
        let limit = LIMIT as f32;
        assert!(at(Vec3::ZERO) && at(Vec3::splat(-limit)) && at(Vec3::Y * limit));
        assert!(!at(Vec3::Y * limit * 1.001) && !at(Vec3::Z * limit * -1.001));
    }

    /// Where a ray meets a ball obliquely, the normal is that of the point.
    #[test]
    fn normals_are_those_of_the_points_that_are_met() {
        let scene = files::builtin::scene("cornell").unwrap();
        let still = scene.at(0.0);
        let (id, ball) =
            (0..).zip(still.spheres.iter()).find(|(id, _)| still.roles[*id] == Role::Solid).unwrap();
        for (x, y) in [(0.6, 0.0), (-0.3, 0.5), (0.0, -0.8)] {
            let normal = Vec3::new(x, y, (1.0 - x * x - y * y).sqrt());
            let ray = Ray {
                origin: ball.center + normal * ball.radius + Vec3::Z * 5.0,
                direction: Vec3::NEG_Z,
                leaves: NO_SPHERE,
            };
            let found = normal_at(&still, &ray, 5.0, id as SphereId);
            assert!((found - normal).length() < 1e-4, "{found}, not {normal}");
        }
    }
}
