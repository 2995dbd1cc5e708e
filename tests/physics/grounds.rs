//! Grounds: opaque spheres that the eye is close to. Compared with `f64` to roundings of what is seen, however large the sphere
//! is; and pictures of tiny things on a huge ground.

use crate::cases::tell;
use crate::harness::{
    BLACK, Build, coloured, diffuse, empty_scene, glass, pinhole, relative_error, render_paths,
    render_photons, render_sppm_fast, settings,
};
use glam::DVec3;
use reference::emission::{Emitted, emit};
use reference::intersect::{distance, from_outside, intersect};
use reference::photon_numbers::PhotonNumbers;
use reference::sampling::{uniform_sphere, unit};
use scene::aim::Aim;
use scene::ray::NO_SPHERE;
use scene::rng::{Family, Stream, StreamKey};
use scene::still::{NEAR, Role};
use scene::{Engine, Film, Ray, Rgb, Scene, Sphere, Vec3};

/// Half the spacing of floats at 1: the relative rounding error of one operation.
const U: f64 = 1.0 / 16_777_216.0;

/// Bound on rounding errors, in units of `U` times the coordinates involved: those of origin, anchor and point, each from a
/// few operations.
const ROUNDINGS: f64 = 16.0;

/// A ground, and the eye over it.
struct Over {
    scene: Scene,
    eye: Vec3,
    /// The height of the eye.
    gap: f64,
}

fn ground(over: &Over) -> &Sphere {
    &over.scene.spheres[0]
}

/// How high a point is over the ground.
fn height(over: &Over, point: DVec3) -> f64 {
    let s = ground(over);
    point.distance(s.center.as_dvec3()) - f64::from(s.radius)
}

fn direction(stream: &mut Stream) -> Vec3 {
    let (u, v) = (stream.next_f32(), stream.next_f32());
    unit(uniform_sphere(u, v))
}

/// The eye near the origin, over a ground of radius 10^2 to 10^6. Its height is from a millionth of the largest at which
/// that is a ground to the largest.
fn over(stream: &mut Stream) -> Over {
    let radius = 10.0_f32.powf(2.0 + 4.0 * stream.next_f32());
    let gap = f64::from(radius) / NEAR * 10.0_f64.powf(-6.0 * f64::from(stream.next_f32()));
    let up = direction(stream);
    let center = -up * radius;
    let to_top = -center.as_dvec3().normalize();
    let eye = (center.as_dvec3() + to_top * (f64::from(radius) + gap)).as_vec3();
    let scene = empty_scene(pinhole(eye, eye + direction(stream), 40.0)).ball(center, radius, diffuse(0.5));
    let gap = eye.as_dvec3().distance(center.as_dvec3()) - f64::from(radius);
    Over { scene, eye, gap }
}

/// The exact near root of a ray, and the cosine at which it arrives; `None` if it clearly or perhaps misses.
fn exact(over: &Over, ray: &Ray) -> Option<(f64, f64)> {
    let s = ground(over);
    let (d, f) = (ray.direction.as_dvec3().normalize(), ray.origin.as_dvec3() - s.center.as_dvec3());
    let (b, r) = (f.dot(d), f64::from(s.radius));
    // By the height: no squares of the radius that cancel.
    let height = height(over, ray.origin.as_dvec3());
    let power = height * (height + 2.0 * r);
    let discriminant = b * b - power;
    (b < 0.0 && height > 0.0 && discriminant > 0.0).then(|| {
        let root = discriminant.sqrt();
        (power / (root - b), root / r)
    })
}

/// Below this cosine, roundings decide where a ray meets the ground, or whether.
const GRAZING: f64 = 0.02;
/// The same for rays from afar, which are off to the side by roundings of where they start.
const GRAZING_FROM_AFAR: f64 = 0.2;

#[test]
fn points_on_a_ground_are_exact_to_roundings_of_what_is_seen() {
    let (mut rays, mut worse) = (0, 0);
    for index in 0..40_000 {
        let mut stream = StreamKey::new(7, Family::Path, 0).stream(index);
        let over = over(&mut stream);
        if !matches!(over.scene.at(0.0).roles[0], Role::Ground(0)) {
            continue;
        }
        let still = over.scene.at(0.0);
        let origin = over.eye + direction(&mut stream) * (over.gap as f32 * 3.0 * stream.next_f32());
        let ray = Ray { origin, direction: direction(&mut stream), leaves: NO_SPHERE };
        let Some((t, cos)) = exact(&over, &ray).filter(|(_, cos)| *cos > GRAZING) else { continue };
        rays += 1;
        let hit = intersect(&still, &ray).unwrap_or_else(|| panic!("{index}: {ray:?} misses"));
        let sizes = [ray.origin, still.grounds[0].anchor, hit.point].map(|p| p.as_dvec3().length());
        let bound = ROUNDINGS * U * (sizes.iter().sum::<f64>() + t);
        let over_it = height(&over, hit.point.as_dvec3());
        assert!(over_it.abs() <= bound, "{index}: {over_it} over the ground, not within {bound}");
        assert!((f64::from(hit.t) - t).abs() * cos <= bound, "{index}: {} for {t}, {cos}, {bound}", hit.t);
        let normal = (hit.point.as_dvec3() - ground(&over).center.as_dvec3()).normalize();
        assert!(hit.normal.as_dvec3().distance(normal) <= ROUNDINGS * U, "{index}: {} {normal}", hit.normal);
        assert!(!hit.inside && hit.sphere == 0);
        let as_a_ball = f64::from(from_outside(ground(&over), &ray, false));
        worse += u32::from((as_a_ball - t).abs() * cos > bound);
    }
    assert!(rays > 10_000, "{rays}");
    // The formula of balls is worse by roundings of the radius.
    assert!(worse > rays / 2, "{worse} of {rays} would be as exact by the formula of balls");
    tell("physics", rays as usize, "rays that meet grounds");
}

/// What a lamp far away sends arrives on the ground, not in a layer around it as thick as roundings at the lamp.
#[test]
fn rays_from_afar_arrive_on_the_ground() {
    let mut rays = 0;
    for index in 0..40_000 {
        let mut stream = StreamKey::new(8, Family::Path, 0).stream(index);
        let over = over(&mut stream);
        let still = over.scene.at(0.0);
        let direction = direction(&mut stream);
        let near = over.eye + self::direction(&mut stream) * (over.gap as f32);
        let away = (over.gap as f32 * 10.0_f32.powf(6.0 * stream.next_f32())).min(1e3 * ground(&over).radius);
        let ray = Ray { origin: near - direction * away, direction, leaves: NO_SPHERE };
        if still.grounds.is_empty() || exact(&over, &ray).is_none_or(|(_, cos)| cos < GRAZING_FROM_AFAR) {
            continue;
        }
        rays += 1;
        let hit = intersect(&still, &ray).unwrap_or_else(|| panic!("{index}: {ray:?} misses"));
        let on_ground = hit.point.as_dvec3();
        let bound = ROUNDINGS * U * (on_ground.length() + still.grounds[0].anchor.as_dvec3().length());
        // The point is moved onto the ground by one step of Newton's method, which leaves the square of what it was off by.
        let off = ROUNDINGS * U * ray.origin.as_dvec3().length();
        let bound = bound + off * off / f64::from(ground(&over).radius);
        assert!(height(&over, on_ground).abs() <= bound, "{index}: {} {bound}", height(&over, on_ground));
        let (d, way) = (ray.direction.as_dvec3().normalize(), on_ground - ray.origin.as_dvec3());
        let beside = (way - d * way.dot(d)).length();
        assert!(
            beside <= ROUNDINGS * U * (way.length() + ray.origin.as_dvec3().length()),
            "{index}: {beside}"
        );
    }
    assert!(rays > 5_000, "{rays}");
    tell("physics", rays as usize, "rays from afar that meet grounds");
}

#[test]
fn what_leaves_a_ground_does_not_meet_it_again_and_what_is_behind_it_meets_it_at_once() {
    let mut grounds = 0;
    for index in 0..5_000 {
        let mut stream = StreamKey::new(9, Family::Path, 0).stream(index);
        let over = over(&mut stream);
        let still = over.scene.at(0.0);
        let Some(ground) = still.grounds.first() else { continue };
        grounds += 1;
        let up = unit(ground.offset);
        let outward = direction(&mut stream);
        let outward = if outward.dot(up) < 0.0 { -outward } else { outward };
        let on_it = Ray { origin: ground.anchor, direction: outward, leaves: 0 };
        assert_eq!(distance(&still, 0, &on_it), f32::INFINITY, "{index}");
        assert_eq!(distance(&still, 0, &Ray { direction: -outward, ..on_it }), 0.0, "{index}");
        let within = Ray { origin: ground.anchor - up * over.gap as f32, direction: -up, leaves: NO_SPHERE };
        assert_eq!(distance(&still, 0, &within), 0.0, "{index}");
        assert_eq!(distance(&still, 0, &Ray { direction: up, ..within }), f32::INFINITY, "{index}");
        // However far from its foot a ray is that goes away.
        let away = Ray { origin: over.eye, direction: outward, leaves: NO_SPHERE };
        assert_eq!(distance(&still, 0, &away), f32::INFINITY, "{index}");
    }
    assert!(grounds > 4_000, "{grounds}");
    tell("physics", 5 * grounds, "rays that leave grounds, or start behind them");
}

/// Of a lamp that is sunk into a ground to its middle, light leaves the upper half: to the height itself, not to roundings of the
/// ground's radius, which are as large as the lamp.
#[test]
fn photons_leave_the_part_of_a_lamp_that_is_over_the_ground() {
    let scene = empty_scene(pinhole(Vec3::new(0.0, 1.0, 6.0) * TINY, Vec3::ZERO, 40.0))
        .ball(Vec3::NEG_Y * 1e4, 1e4, diffuse(0.5))
        .lamp(Vec3::ZERO, TINY, BLACK, Rgb::ONE);
    let still = scene.at(0.0);
    assert_eq!(still.grounds.len(), 1);
    let lamp = &still.lights.entries[0];
    let mut photons = 0;
    for photon in 0..20_000 {
        let mut stream = StreamKey::new(10, Family::Path, 0).stream(photon);
        let point = direction(&mut stream) * TINY;
        assert_eq!(still.is_hidden(lamp, point), point.y < 0.0, "{point}");
        let numbers = PhotonNumbers::new(10, photon);
        if let Some(Emitted { ray, .. }) = emit(&still, &Aim::default(), &numbers, photon) {
            assert!(ray.origin.y >= 0.0, "{ray:?} starts in the ground");
            photons += 1;
        }
    }
    assert!((f64::from(photons) / 20_000.0 - 0.5).abs() < HALF, "{photons}");
    tell("physics", 20_000, "photons of a lamp that is sunk into a ground");
}

/// The same of so many lamps that what hides them is looked up.
#[test]
fn photons_leave_the_parts_of_many_lamps_that_are_over_the_ground() {
    /// How far the ground sinks below the eye's feet from one end of the lamps to the other, and roundings.
    const EVEN: f32 = 1e-3 * TINY;
    const PHOTONS: u32 = 20_000;
    let ground = empty_scene(pinhole(Vec3::new(0.0, 1.0, 6.0) * TINY, Vec3::ZERO, 40.0)).ball(
        Vec3::NEG_Y * 1e4,
        1e4,
        diffuse(0.5),
    );
    let places = (-20..20).map(|k| Vec3::X * 3.0 * TINY * k as f32);
    let scene = places.fold(ground, |scene, center| scene.lamp(center, TINY, BLACK, Rgb::ONE));
    let still = scene.at(0.0);
    assert_eq!((still.grounds.len(), still.lights.entries.len()), (1, 40));
    let numbers = PhotonNumbers::new(10, 0);
    let mut left = 0;
    for photon in 0..PHOTONS {
        if let Some(Emitted { ray, .. }) = emit(&still, &Aim::default(), &numbers, photon) {
            assert!(ray.origin.y >= -EVEN, "{ray:?} starts in the ground");
            left += 1;
        }
    }
    assert!((f64::from(left) / f64::from(PHOTONS) - 0.5).abs() < HALF, "{left}");
    tell("physics", PHOTONS as usize, "photons of lamps that are sunk into a ground");
}

/// Four deviations of the mean of 20,000 that are 0 or 1.
const HALF: f64 = 0.015;

/// An opaque sphere that does not glow is a ground if the eye is outside, at a sixteenth of its radius or closer.
#[test]
fn grounds_are_those_that_the_eye_is_close_to() {
    let role = |gap: f32, scene: fn(Scene, Vec3, f32) -> Scene| {
        let scene = scene(empty_scene(pinhole(Vec3::Y * gap, Vec3::X, 40.0)), Vec3::NEG_Y * 64.0, 64.0);
        scene.at(0.0).roles[0]
    };
    let ball: fn(Scene, Vec3, f32) -> Scene =
        |scene, center, radius| scene.ball(center, radius, diffuse(0.5));
    assert_eq!([4.0, 0.001].map(|gap| role(gap, ball)), [Role::Ground(0); 2]);
    assert_eq!([4.001, 100.0].map(|gap| role(gap, ball)), [Role::Solid; 2]);
    assert_eq!(role(-1.0, ball), Role::Enclosure(0));
    assert_eq!(role(1.0, |scene, center, radius| scene.ball(center, radius, glass(1.0, 1.5))), Role::Glass);
    assert_eq!(role(1.0, |scene, center, radius| scene.lamp(center, radius, BLACK, Rgb::ONE)), Role::Solid);
}

/// A thousandth: the size of the things below.
const TINY: f32 = 1e-3;

/// Balls a thousandth in size on a ground of this radius, under a sky and a lamp. A mirror shows what is below it.
fn tiny(radius: f32) -> Scene {
    let at = |x: f32, y: f32, z: f32| Vec3::new(x, y, z) * TINY;
    let scene = empty_scene(pinhole(at(0.0, 1.4, 6.0), at(0.0, 0.5, 0.0), 36.0))
        .ball(Vec3::NEG_Y * radius, radius, coloured([0.6, 0.5, 0.4]))
        .ball(at(-0.9, 0.7, 0.0), 0.7 * TINY, diffuse(0.8))
        .ball(at(0.8, 0.6, 0.2), 0.6 * TINY, coloured([0.9, 0.3, 0.2]))
        .ball(at(0.0, 0.3, 1.1), 0.3 * TINY, crate::harness::mirror(0.9))
        .lamp(at(2.0, 5.0, 3.0), 0.6 * TINY, BLACK, Rgb::new(40.0, 36.0, 30.0));
    Scene { background: Rgb::new(0.2, 0.3, 0.5), ..scene }.with_sky()
}

/// Means of blocks of 8x8 pixels.
fn blocks(film: &Film) -> Vec<[f64; 3]> {
    let block = |x: u32, y: u32| crate::harness::block_mean(film, 8 * x..8 * x + 8, 8 * y..8 * y + 8);
    (0..film.height / 8).flat_map(|y| (0..film.width / 8).map(move |x| block(x, y))).collect()
}

/// Relative tolerance: noise of blocks is about a hundredth.
const NOISE: f64 = 0.05;

/// The ground that is seen is as good as flat in both, so a radius of 10 and one of 10^4 look alike but at the horizon, which
/// the upper third of the picture shows.
#[test]
fn tiny_things_look_the_same_on_a_huge_ground() {
    let settings = scene::Settings { iterations: 400, ..settings(48, 48, 1, 8, 0.1 * TINY) };
    let [large, huge] = [10.0, 1e4].map(|radius| blocks(&render_paths(&tiny(radius), &settings)));
    for (index, (a, b)) in large.iter().zip(&huge).enumerate().skip(12) {
        let error = relative_error(*b, *a);
        assert!(error < NOISE, "block {index}: {b:?} on a huge ground, {a:?} on a large one");
    }
    tell("physics", 2, "images of tiny things on the ground");
}

/// Relative tolerance for the mean of many blocks: noise of the photons is some thousandths.
const MEAN: f64 = 0.01;

/// Photons of sky and lamp arrive among them: not where roundings of the ground's radius would put them.
#[test]
fn photons_light_tiny_things_on_a_huge_ground() {
    let paths = scene::Settings { iterations: 600, ..settings(48, 48, 1, 2, 0.1 * TINY) };
    let photons = scene::Settings { iterations: 30, ..settings(48, 48, 20_000, 2, 0.1 * TINY) };
    let scene = tiny(1e4);
    let mean = |film: &Film| {
        let blocks = blocks(film);
        let lower = &blocks[12..];
        [0, 1, 2].map(|channel| lower.iter().map(|b| b[channel]).sum::<f64>() / lower.len() as f64)
    };
    let (by_paths, by_photons) =
        (mean(&render_paths(&scene, &paths)), mean(&render_photons(&scene, &photons)));
    let error = relative_error(by_photons, by_paths);
    assert!(error < MEAN, "{by_photons:?} by photons, {by_paths:?} by paths");
    tell("physics", 2, "images of tiny things lit by photons");
}

/// Balls of this size on a huge ground under a sun so far away, as large as ours in the sky.
fn under_a_sun(size: f32, away: f32) -> Scene {
    let at = |x: f32, y: f32, z: f32| Vec3::new(x, y, z) * size;
    let towards = Vec3::new(0.48, 0.8, 0.36);
    empty_scene(pinhole(at(0.0, 1.8, 6.0), at(0.0, 0.5, 0.0), 36.0))
        .ball(Vec3::NEG_Y * 1e4, 1e4, coloured([0.6, 0.5, 0.4]))
        .ball(at(-0.9, 0.7, 0.0), 0.7 * size, glass(1.0, 1.5))
        .ball(at(0.8, 0.6, 0.2), 0.6 * size, coloured([0.9, 0.3, 0.2]))
        .lamp(towards * away, 7e-3 * away, BLACK, Rgb::splat(6e4))
}

/// Relative tolerance of the mean of caustics, whose photons are few.
const CAUSTICS: f64 = 0.03;

/// And of all light: a sun so near lights the ground at the horizon less, by the square of its distance.
const HORIZON: f64 = 0.03;

/// Tiny things look alike under suns of one size in the sky, however far: caustics of glass, and all light together. The farthest is 8 10^8
/// times as far as things are large. Its photons weigh 2^-60, and where they pass what is seen its rays are uncertain by a hundred times
/// the size of that. The nearest two are nearer than the ground is wide.
#[test]
fn a_far_sun_lights_tiny_things_as_a_near_one_does() {
    let settings =
        |size: f32| scene::Settings { iterations: 300, ..settings(48, 48, 20_000, 6, 0.05 * size) };
    let mean = |film: Film| crate::harness::mean(&film);
    let by = |size: f32, away: f32| {
        let (scene, settings) = (under_a_sun(size, away), settings(size));
        let mut caustics = fast::Sppm::new(&scene, &settings).of_caustics();
        (0..settings.iterations).for_each(|_| caustics.iterate());
        [mean(caustics.develop()), mean(render_sppm_fast(&scene, &settings))]
    };
    let near = by(TINY, 1e3 * TINY);
    for away in [800.0, 8e3, 8e5] {
        let far = by(TINY, away);
        for (what, near, far, most) in
            [("caustics", near[0], far[0], CAUSTICS), ("all", near[1], far[1], HORIZON)]
        {
            let error = relative_error(far, near);
            assert!(error < most, "{what}: {far:?} from {away} away, {near:?} from near by");
        }
    }
    tell("physics", 8, "images under suns far and near");
}
