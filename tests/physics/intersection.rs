//! Ray-sphere intersection compared with `f64`, and tests that there are no self-intersections, leaks or wrong ties.

use crate::cases::tell;
use crate::harness::{BLACK, Build, empty_scene, glass, pinhole};
use proptest::prelude::*;
use proptest::test_runner::{RngAlgorithm, RngSeed};
use reference::intersect::{distance, from_either_side, from_outside, intersect};
use reference::sampling::{cosine_hemisphere, uniform_sphere, unit};
use scene::ray::NO_SPHERE;
use scene::rng::{Family, Stream, StreamKey};
use scene::{Material, Ray, Rgb, Scene, Sphere, Vec3};

/// Half the spacing of floats at 1: the relative rounding error of one operation.
const U: f64 = 1.0 / 16_777_216.0;

/// Bound on the rounding errors of `b`, the power and the discriminant, in units of `U` times the lengths or squared
/// lengths involved: at most 2 for each component of the vector from the centre, 3 for a dot product, twice that where
/// vectors are combined, and 2 for the length of the direction.
const ROUNDINGS: f64 = 16.0;

fn ball(center: Vec3, radius: f32) -> Sphere {
    Sphere { center, velocity: Vec3::ZERO, radius, material: 0, emission: Rgb::ZERO }
}

/// The exact geometry of a ray and a sphere, with bounds on the errors of a computation in `f32`.
struct Exact {
    b: f64,
    power: f64,
    discriminant: f64,
    b_error: f64,
    square_error: f64,
}

impl Exact {
    fn new(sphere: &Sphere, ray: &Ray) -> Self {
        let d = ray.direction.as_dvec3().normalize();
        let f = ray.origin.as_dvec3() - sphere.center.as_dvec3();
        let r2 = f64::from(sphere.radius).powi(2);
        let b = f.dot(d);
        Self {
            b,
            power: f.length_squared() - r2,
            discriminant: r2 - (f - d * b).length_squared(),
            b_error: ROUNDINGS * U * f.length(),
            square_error: ROUNDINGS * U * (f.length_squared() + r2),
        }
    }

    /// Error bound of the square root of the discriminant.
    fn root_error(&self) -> f64 {
        let root = self.discriminant.max(0.0).sqrt();
        if self.discriminant > 2.0 * self.square_error {
            self.square_error / root
        } else {
            (2.0 * self.square_error).sqrt() + root
        }
    }

    /// The near root for a ray towards the sphere from outside, and its error bound.
    fn near(&self) -> (f64, f64) {
        let q = self.discriminant.max(0.0).sqrt() - self.b;
        let t = self.power / q;
        (
            t,
            (self.square_error + t.abs() * (self.root_error() + self.b_error)) / (q - self.b_error)
                + U * t.abs(),
        )
    }

    /// The far root for a ray from inside, and its error bound.
    fn far(&self) -> (f64, f64) {
        let q = self.b.abs() + self.discriminant.max(0.0).sqrt();
        let q_error = self.root_error() + self.b_error;
        if self.b > 0.0 {
            let t = -self.power / q;
            (t, (self.square_error + t * q_error) / (q - q_error).max(0.0) + U * t)
        } else {
            (q, q_error + U * q)
        }
    }
}

fn direction() -> impl Strategy<Value = Vec3> {
    (0.0_f32..1.0, 0.0_f32..1.0).prop_map(|(u, v)| unit(uniform_sphere(u, v)))
}

/// Radii from 1e-3 to 1e5, uniform in the exponent.
fn radius() -> impl Strategy<Value = f32> {
    (-3.0_f32..5.0).prop_map(|e| 10.0_f32.powf(e))
}

/// Distances as multiples of the radius: on the sphere, close to it, and far.
fn from_center() -> impl Strategy<Value = f32> {
    prop_oneof![
        Just(0.0_f32),
        Just(1.0),
        0.999_f32..1.001,
        0.0_f32..2.0,
        (0.0_f32..4.0).prop_map(|e| 10.0_f32.powf(e))
    ]
}

/// Distance at which a ray passes the centre, in radii: through it, tangent, close to tangent, anywhere.
fn aim() -> impl Strategy<Value = f32> {
    prop_oneof![Just(0.0_f32), Just(1.0), 0.9999_f32..1.0001, 0.0_f32..3.0]
}

prop_compose! {
    /// A sphere off the origin, and a ray whose line passes its centre at the chosen distance.
    fn ray_and_sphere()(
        radius in radius(), start in from_center(), aim in aim(), place in direction(), axis in direction(),
        twist in direction(), away in any::<bool>(),
    ) -> (Sphere, Ray) {
        let sphere = ball(place * (2.0 * radius), radius);
        let origin = sphere.center + axis * (start * radius);
        let sideways = axis.cross(twist);
        let offset = if sideways.length() > 0.0 { unit(sideways) * (aim * radius) } else { Vec3::ZERO };
        let target = sphere.center + offset;
        let to_target = if target == origin { twist } else { unit(target - origin) };
        let direction = if away { -to_target } else { to_target };
        (sphere, Ray { origin, direction, leaves: NO_SPHERE })
    }
}

fn cases(count: u32) -> ProptestConfig {
    tell("physics", count as usize, "random rays and spheres");
    // A fixed seed, and nothing written to the source tree.
    ProptestConfig {
        cases: count,
        rng_seed: RngSeed::Fixed(1),
        // The alternatives of `prop_oneof!` draw seeds of their own, which is slow with ChaCha.
        rng_algorithm: RngAlgorithm::XorShift,
        failure_persistence: None,
        ..ProptestConfig::default()
    }
}

proptest! {
    #![proptest_config(cases(20_000))]

    #[test]
    fn opaque_from_outside_agrees_with_f64((sphere, ray) in ray_and_sphere()) {
        let exact = Exact::new(&sphere, &ray);
        let t = f64::from(from_outside(&sphere, &ray, false));
        prop_assert!(t >= 0.0);
        if exact.b > exact.b_error || exact.discriminant < -exact.square_error {
            prop_assert_eq!(t, f64::INFINITY);
        } else if exact.b < -exact.b_error && exact.discriminant > exact.square_error {
            prop_assert!(t.is_finite());
        }
        if t.is_finite() && exact.b < -2.0 * exact.b_error {
            let (expected, bound) = exact.near();
            // An origin inside is treated as one on the surface.
            prop_assert!((t - expected.max(0.0)).abs() <= bound, "{} instead of {} +- {}", t, expected, bound);
        }
    }

    #[test]
    fn glass_agrees_with_f64((sphere, ray) in ray_and_sphere()) {
        let exact = Exact::new(&sphere, &ray);
        let t = f64::from(from_either_side(&sphere, &ray, false));
        prop_assert!(t > 0.0);
        if exact.power > exact.square_error {
            if exact.b > exact.b_error || exact.discriminant < -exact.square_error {
                prop_assert_eq!(t, f64::INFINITY);
            } else if exact.b < -exact.b_error && exact.discriminant > exact.square_error {
                let (expected, bound) = exact.near();
                prop_assert!((t - expected).abs() <= bound, "{} instead of {} +- {}", t, expected, bound);
            }
        } else if exact.power < -exact.square_error && exact.b.abs() > exact.b_error {
            let (expected, bound) = exact.far();
            prop_assert!((t - expected).abs() <= bound, "{} instead of {} +- {}", t, expected, bound);
        }
    }

    #[test]
    fn enclosures_agree_with_f64(
        (sphere, _) in ray_and_sphere(), (depth, toward) in (0.0_f32..0.999, direction()),
        start in prop_oneof![Just(0.0_f32), 0.999_f32..1.0, 0.0_f32..1.0], axis in direction(), direction in direction(),
    ) {
        let ray = Ray { origin: sphere.center + axis * (start * sphere.radius), direction, leaves: NO_SPHERE };
        let eye = sphere.center + toward * (depth * sphere.radius);
        let scene = empty_scene(pinhole(eye, eye + Vec3::X, 90.0)).ball(sphere.center, sphere.radius, BLACK);
        let still = scene.at(0.0);
        let exact = Exact::new(&sphere, &ray);
        let t = f64::from(distance(&still, 0, &ray));
        prop_assert!(t.is_finite() && t >= 0.0, "{} does not hit", t);
        let (expected, bound) = exact.far();
        let certain = exact.power < -exact.square_error && exact.b.abs() > exact.b_error;
        prop_assert!(!certain || (t - expected).abs() <= bound, "{} not {} +- {}", t, expected, bound);
    }

    #[test]
    fn a_ray_that_leaves_outward_misses_and_one_into_glass_crosses_it(
        (sphere, _) in ray_and_sphere(), outward in direction(), direction in direction(),
    ) {
        let ray = Ray { origin: sphere.center + outward * sphere.radius, direction, leaves: 0 };
        let b = (ray.origin - sphere.center).dot(direction);
        let opaque = from_outside(&sphere, &ray, true);
        let transparent = from_either_side(&sphere, &ray, true);
        if b >= 0.0 {
            prop_assert_eq!(opaque, f32::INFINITY);
        }
        if b > 0.0 {
            prop_assert_eq!(transparent, f32::INFINITY);
        } else if f64::from(b) < -1e-3 * f64::from(sphere.radius) {
            // The chord is 2 |b|; the error of each half comes from the errors of the origin and of b.
            let exact = Exact::new(&sphere, &ray);
            let bound = exact.root_error() + 2.0 * exact.b_error;
            prop_assert!((f64::from(transparent) + 2.0 * exact.b).abs() <= bound);
        }
    }

    #[test]
    fn hits_lie_on_the_sphere_under_a_unit_normal_that_faces_the_ray((sphere, ray) in ray_and_sphere()) {
        let scene = empty_scene(pinhole(ray.origin, ray.origin + Vec3::X, 90.0));
        for material in [BLACK, glass(1.0, 1.5)] {
            let scene = scene.clone().ball(sphere.center, sphere.radius, material);
            let Some(hit) = intersect(&scene.at(0.0), &ray) else { continue };
            let from_center = hit.point.as_dvec3() - sphere.center.as_dvec3();
            let size = f64::from(sphere.radius) + sphere.center.as_dvec3().length() + ray.origin.as_dvec3().length();
            prop_assert!((from_center.length() - f64::from(sphere.radius)).abs() <= ROUNDINGS * U * size);
            prop_assert!((hit.normal.as_dvec3().length() - 1.0).abs() <= 8.0 * U);
            // For a grazing ray, rounding decides on which side of the surface it is.
            let grazing = 2.0 * (ROUNDINGS * U * size / f64::from(sphere.radius)).sqrt();
            prop_assert!(f64::from(hit.normal.dot(ray.direction)) <= grazing);
        }
    }
}

/// Half the width of the rooms below.
const HALF: f32 = 50.0;
const WALL_RADIUS: f32 = 1e4;

/// A cube of side 100 around the origin. Its walls are spheres of radius 10^4, as in the paper's scenes.
fn room() -> Scene {
    let mut scene = empty_scene(pinhole(Vec3::new(3.0, -7.0, 11.0), Vec3::ZERO, 60.0));
    for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
        for side in [-1.0, 1.0] {
            scene = scene.ball(axis * (side * (HALF - WALL_RADIUS)), WALL_RADIUS, BLACK);
        }
    }
    scene
}

/// How far a point is outside the room, as the largest distance over all walls; negative if it is inside.
fn out_of(scene: &Scene, point: Vec3) -> f64 {
    let out = |s: &Sphere| (point.as_dvec3() - s.center.as_dvec3()).length() - f64::from(s.radius);
    scene.spheres.iter().map(out).fold(f64::NEG_INFINITY, f64::max)
}

fn numbers(index: u32) -> Stream {
    StreamKey::new(1, Family::Path, 0).stream(index)
}

/// Tolerance in scene units: ten rounding errors of numbers up to 100, the size of the room. The much larger radius of
/// the walls must not matter.
const WALL_ERROR: f64 = 6e-5;

#[test]
fn a_million_bounces_do_not_leave_a_room_of_huge_walls() {
    let scene = room();
    let still = scene.at(0.0);
    let mut stream = numbers(0);
    let mut ray = Ray { origin: scene.camera.eye, direction: Vec3::X, leaves: NO_SPHERE };
    for bounce in 0..1_000_000 {
        let hit = intersect(&still, &ray).unwrap_or_else(|| panic!("bounce {bounce} escapes: {ray:?}"));
        assert!(out_of(&scene, hit.point).abs() < WALL_ERROR, "bounce {bounce} at {:?}", hit.point);
        let direction = cosine_hemisphere(hit.normal, stream.next_f32(), stream.next_f32());
        ray = Ray { origin: hit.point, direction, leaves: hit.sphere };
    }
    tell("physics", 1_000_000, "bounces in a room of huge walls");
}

#[test]
fn rays_into_the_corners_of_a_room_do_not_leak() {
    let scene = room();
    let still = scene.at(0.0);
    let mut stream = numbers(1);
    for index in 0..100_000_u32 {
        let mut jitter = || (stream.next_f32() - 0.5) * 1e-4;
        // Two or three of the coordinates are on walls, so that the ray aims at an edge or a corner of the room.
        let edge = |bit: u32| if index >> bit & 1 == 1 { HALF } else { -HALF };
        let along = if index & 8 == 0 { edge(2) } else { jitter() * 9e5 };
        let corner = Vec3::new(edge(0) + jitter(), edge(1) + jitter(), along);
        let mut ray =
            Ray { origin: scene.camera.eye, direction: unit(corner - scene.camera.eye), leaves: NO_SPHERE };
        for _ in 0..4 {
            let hit = intersect(&still, &ray).expect("the ray leaks");
            assert!(out_of(&scene, hit.point) < WALL_ERROR, "{:?}", hit.point);
            let direction = cosine_hemisphere(hit.normal, stream.next_f32(), stream.next_f32());
            ray = Ray { origin: hit.point, direction, leaves: hit.sphere };
        }
    }
    tell("physics", 400_000, "rays into corners");
}

/// Balls of a cage overlap or barely do, as those of molecules and heaps; many of its hits are where two or three meet.
#[test]
fn no_light_leaks_out_of_a_cage_of_balls() {
    const BALLS: u32 = 600;
    /// Radius of the cage.
    const CAGE: f64 = 10.0;
    let turn = std::f64::consts::PI * (3.0 - 5_f64.sqrt());
    let mut stream = numbers(3);
    // Spread evenly, no point of the cage is farther from a centre than 1.2.
    for (radius, middle) in [(1.2_f32, Vec3::ZERO), (2.5, Vec3::ZERO), (1.3, Vec3::new(300.0, -70.0, 1e3))] {
        let place = |i: u32| {
            let height = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(BALLS);
            let (sin, cos) = (turn * f64::from(i)).sin_cos();
            let aside = (1.0 - height * height).sqrt();
            Vec3::from([aside * cos, aside * sin, height].map(|x| (CAGE * x) as f32)) + middle
        };
        let mut scene = room();
        scene.camera.eye = middle;
        scene.spheres = (0..BALLS).map(|i| ball(place(i), radius)).collect();
        let still = scene.at(0.0);
        let mut ray = Ray { origin: middle, direction: Vec3::X, leaves: NO_SPHERE };
        for _ in 0..60_000 {
            let hit = intersect(&still, &ray).expect("the ray leaks");
            let out = hit.point.distance(middle) - CAGE as f32;
            assert!(out < 0.0, "{out} beyond the centres of a cage of radius {radius}");
            let direction = cosine_hemisphere(hit.normal, stream.next_f32(), stream.next_f32());
            ray = Ray { origin: hit.point, direction, leaves: hit.sphere };
        }
    }
    tell("physics", 180_000, "bounces in cages of balls that overlap");
}

#[test]
fn distances_to_huge_walls_are_right_to_a_hundred_thousandth_of_the_room() {
    let scene = room();
    let still = scene.at(0.0);
    let mut stream = numbers(2);
    for _ in 0..200_000 {
        let mut coordinate = || (stream.next_f32() - 0.5) * 99.0;
        let origin = Vec3::new(coordinate(), coordinate(), coordinate());
        let direction = unit(uniform_sphere(stream.next_f32(), stream.next_f32()));
        let ray = Ray { origin, direction, leaves: NO_SPHERE };
        let hit = intersect(&still, &ray).unwrap();
        let (o, d) = (origin.as_dvec3(), direction.as_dvec3().normalize());
        let far = |s: &Sphere| {
            let f = o - s.center.as_dvec3();
            let b = f.dot(d);
            (b * b - (f.length_squared() - f64::from(s.radius).powi(2))).sqrt() - b
        };
        let expected = scene.spheres.iter().map(far).fold(f64::INFINITY, f64::min);
        // The error is bounded perpendicular to the wall; along a grazing ray it grows by the inverse cosine.
        let cosine = f64::from(-hit.normal.dot(direction));
        assert!((f64::from(hit.t) - expected).abs() * cosine < WALL_ERROR, "{} instead of {expected}", hit.t);
    }
    tell("physics", 200_000, "distances to huge walls");
}

/// In numbers that are exact.
#[test]
fn a_ray_that_touches_glass_stays_outside() {
    let scene = empty_scene(pinhole(Vec3::Z * 9.0, Vec3::ZERO, 30.0)).ball(Vec3::ZERO, 2.0, glass(1.0, 1.5));
    let still = scene.at(0.0);
    let ray = Ray { origin: Vec3::new(-5.0, 2.0, 0.0), direction: Vec3::X, leaves: NO_SPHERE };
    let hit = intersect(&still, &ray).unwrap();
    assert_eq!((hit.t, hit.point, hit.normal, hit.inside), (5.0, Vec3::Y * 2.0, Vec3::Y, false));
    let across = intersect(&still, &Ray { origin: Vec3::ZERO, ..ray }).unwrap();
    assert_eq!((across.t, across.normal, across.inside), (2.0, -Vec3::X, true));
}

#[test]
fn of_coincident_spheres_the_lower_index_is_hit() {
    let eye = Vec3::new(0.0, 0.0, 5.0);
    for material in [BLACK, glass(1.0, 1.5), Material::Specular { albedo: Rgb::ONE }] {
        let mut scene = empty_scene(pinhole(eye, Vec3::ZERO, 60.0)).ball(Vec3::Y * 3.0, 0.5, BLACK);
        for _ in 0..3 {
            scene = scene.ball(Vec3::ZERO, 1.0, material).ball(Vec3::ZERO, 10.0, BLACK);
        }
        let still = scene.at(0.0);
        let mut stream = numbers(3);
        let mut hits = [0; 3];
        for _ in 0..10_000 {
            let direction = unit(Vec3::NEG_Z + 0.5 * uniform_sphere(stream.next_f32(), stream.next_f32()));
            let hit = intersect(&still, &Ray { origin: eye, direction, leaves: NO_SPHERE }).unwrap();
            hits[hit.sphere as usize] += 1;
        }
        assert!(hits[1] > 0 && hits[2] > 0, "{hits:?}");
    }
    tell("physics", 30_000, "hits of coincident spheres");
}

#[test]
fn a_mirror_ball_is_followed_inside_for_a_thousand_bounces() {
    let mirror = Material::Specular { albedo: Rgb::ONE };
    let eye = Vec3::new(0.5, 0.0, 2.0);
    let scene = empty_scene(pinhole(eye, Vec3::ZERO, 90.0)).ball(Vec3::ZERO, 3.0, mirror);
    let still = scene.at(0.0);
    let mut stream = numbers(4);
    for _ in 0..100 {
        let direction = unit(uniform_sphere(stream.next_f32(), stream.next_f32()));
        let mut ray = Ray { origin: eye, direction, leaves: NO_SPHERE };
        // All chords of the path pass the centre of the ball at the same distance.
        let distance = |ray: &Ray| ray.origin.as_dvec3().cross(ray.direction.as_dvec3()).length();
        let expected = distance(&ray);
        for bounce in 0..1000 {
            let hit = intersect(&still, &ray).unwrap_or_else(|| panic!("bounce {bounce} escapes"));
            let direction = reference::scatter::reflect(ray.direction, hit.normal);
            ray = Ray { origin: hit.point, direction, leaves: hit.sphere };
            assert!((distance(&ray) - expected).abs() < MIRROR_DRIFT, "bounce {bounce}");
        }
    }
    tell("physics", 100_000, "bounces in a mirror ball");
}

/// Tolerance after a thousand bounces. Each adds a rounding error of 10^-7 to the length of the direction, which shifts
/// all later hits.
const MIRROR_DRIFT: f64 = 1e-2;
