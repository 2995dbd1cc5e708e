//! Where photons leave from: each the lamp that its colour tells, or for far lamps the ball around all that is near.

use crate::cases::tell;
use crate::harness::{BLACK, Build, diffuse, empty_scene, glass, pinhole};
use reference::emission::{Emitted, emit};
use reference::intersect::intersect;
use reference::photon_numbers::PhotonNumbers;
use scene::aim::{Aim, Target, Targets};
use scene::guide::{Guide, SIDE, SURFACES};
use scene::ray::NO_SPHERE;
use scene::rng::{Family, Stream, StreamKey};
use scene::{Ray, Rgb, Scene, Vec3, max_component};
use std::sync::Arc;

const PHOTONS: u32 = 1 << 16;

/// A far sun, a sky, three near lamps, one of which is sunk into a ball, and two balls. Each light has a colour of its own.
fn scene() -> Scene {
    empty_scene(pinhole(Vec3::Z * 9.0, Vec3::ZERO, 30.0))
        .lamp(Vec3::new(30.0, 60.0, 20.0), 6.0, BLACK, Rgb::new(2.8, 1.4, 0.7))
        .lamp(Vec3::new(-1.5, 3.0, 0.0), 0.5, BLACK, Rgb::new(100.0, 200.0, 50.0))
        .lamp(Vec3::new(1.0, 0.8, 0.0), 0.4, BLACK, Rgb::splat(300.0))
        .lamp(Vec3::ZERO, 200.0, BLACK, Rgb::new(8e-4, 1.6e-3, 2.4e-3))
        .ball(Vec3::ZERO, 1.0, diffuse(0.5))
        .ball(Vec3::new(2.0, -1.0, 0.5), 0.7, diffuse(0.5))
        // In the way of the sun, as seen from the targets.
        .lamp(Vec3::new(2.7, 3.4, 1.2), 0.5, BLACK, Rgb::new(100.0, 10.0, 50.0))
}

/// Which lights are far, by their spheres.
const FAR: [u32; 2] = [0, 3];

/// Half of the photons alike from all lamps, the others at three balls.
fn aimed() -> Targets {
    let balls = [(Vec3::ZERO, 1.0), (Vec3::new(2.0, -1.0, 0.5), 0.7), (Vec3::X, 2.5)];
    let balls = balls.map(|(center, radius)| Target::ball(center, radius)).to_vec();
    Targets { balls, middle: 2, shares: vec![0.5, 0.2, 0.2, 0.1], expected: 0.0, guide: None }
}

fn guided() -> Targets {
    let shares = [[1.0 / (SIDE * SIDE) as f64; SIDE]; SIDE];
    let guide = Guide::of_shares(Vec3::ZERO, 1.0, (0..SURFACES).map(|_| shares), &shares);
    Targets { guide: Some(Arc::new(guide)), ..Targets::default() }
}

/// The sphere of the light whose colour a photon has.
fn sphere_of(scene: &Scene, power: Rgb) -> u32 {
    let color = power / max_component(power);
    let still = scene.at(0.0);
    let same = |light: &&scene::still::Light| (light.photon_power - color).abs().max_element() < 1e-4;
    still.lights.entries.iter().find(same).unwrap().sphere
}

/// Roundings of the farthest lamp.
const ROUNDING: f32 = 4e-3;

#[test]
fn photons_leave_their_own_lamp_or_enter_where_all_that_is_near_begins() {
    let scene = scene();
    let still = scene.at(0.0);
    let numbers = PhotonNumbers::new(5, 0);
    for (what, targets) in [("alike", Targets::default()), ("aimed", aimed()), ("guided", guided())] {
        let aim = Aim::new(&still, &targets, PHOTONS);
        let core = aim.core.as_ref().map(|core| &core.ball);
        assert_eq!(core.is_some(), what == "aimed");
        let mut counts = [[0; 2]; 7];
        for photon in 0..PHOTONS {
            let Some(Emitted { ray, power }) = emit(&still, &aim, &numbers, photon) else { continue };
            let light = sphere_of(&scene, power);
            let lamp = &scene.spheres[light as usize];
            let inwards = light == 3;
            counts[light as usize][usize::from(ray.leaves == NO_SPHERE)] += 1;
            if ray.leaves != NO_SPHERE {
                assert_eq!(ray.leaves, light, "{what}: {ray:?} leaves another lamp than its colour's");
                let outward = (ray.origin - lamp.center) / lamp.radius;
                assert!((outward.length() - 1.0).abs() < ROUNDING, "{what}: {ray:?} begins off its lamp");
                let cos = outward.dot(ray.direction);
                assert!(if inwards { cos < ROUNDING } else { cos > -ROUNDING }, "{what}: {ray:?}, {cos}");
                // Where it is sunk into the ball nothing leaves it.
                assert!(ray.origin.length() > 1.0 - ROUNDING, "{what}: {ray:?} begins within the ball");
                continue;
            }
            let core = core.unwrap();
            assert!(FAR.contains(&light), "{what}: {ray:?} of a near lamp begins at the core");
            let outward = (ray.origin - core.center) / core.radius;
            assert!((outward.length() - 1.0).abs() < ROUNDING && outward.dot(ray.direction) < ROUNDING);
            // Between its lamp and there nothing stands: backwards, the first that it meets is the lamp.
            let back = Ray { origin: ray.origin, direction: -ray.direction, leaves: NO_SPHERE };
            let met = intersect(&still, &back).map(|hit| hit.sphere);
            assert_eq!(met, Some(light), "{what}: {ray:?} has something behind it");
            // Backwards it meets its lamp.
            let way = lamp.center - ray.origin;
            let nearest = way - ray.direction * way.dot(ray.direction);
            assert!(
                nearest.length() < lamp.radius * (1.0 + ROUNDING),
                "{what}: {ray:?} is no line of its lamp"
            );
        }
        let lamps = counts.into_iter().enumerate().filter(|(id, _)| scene.spheres[*id].is_emitter());
        for (light, [at_lamp, at_core]) in lamps {
            let is_far = FAR.contains(&(light as u32)) && what == "aimed";
            assert!(at_lamp + at_core > 100, "{what}: {light} sends few photons, {at_lamp} and {at_core}");
            assert_eq!(at_core > 0, is_far, "{what}: {light}");
        }
    }
    tell("physics", 3 * PHOTONS as usize, "departures of photons");
}

/// However far a glowing ball of glass is, what its inner side sends meets the glass before anything else: so its photons begin on
/// it, and not where all that is near begins.
#[test]
fn light_of_the_inner_side_of_far_glass_meets_that_glass_first() {
    let (center, radius) = (Vec3::new(30.0, 60.0, 20.0), 6.0);
    let scene = empty_scene(pinhole(Vec3::Z * 9.0, Vec3::ZERO, 30.0))
        .ball(Vec3::ZERO, 1.0, diffuse(0.5))
        .lamp(center, radius, glass(1.0, 1.5), Rgb::ONE);
    let still = scene.at(0.0);
    let aim = Aim::new(&still, &aimed(), PHOTONS);
    let numbers = PhotonNumbers::new(5, 0);
    let (mut inwards, mut of_aimed) = (0, 0);
    for photon in 0..PHOTONS {
        let Some(Emitted { ray, .. }) = emit(&still, &aim, &numbers, photon) else { continue };
        let outward = (ray.origin - center) / radius;
        assert!((outward.length() - 1.0).abs() < ROUNDING, "{ray:?} begins off its lamp");
        if outward.dot(ray.direction) < -ROUNDING {
            assert_eq!(intersect(&still, &ray).map(|hit| hit.sphere), Some(1), "{ray:?}");
            inwards += 1;
            of_aimed += u32::from(aim.component(photon) > 0);
        }
    }
    assert!(inwards > 10_000 && of_aimed > 5000, "{inwards} photons inwards, {of_aimed} of them aimed");
    tell("physics", inwards as usize, "photons of the inner side of far glass");
}

/// A ball anywhere around the origin, as far and as large as between these, all magnitudes alike.
fn somewhere(stream: &mut Stream, distances: [f32; 2], radii: [f32; 2]) -> (Vec3, f32) {
    let between = |[low, high]: [f32; 2], u: f32| low * (high / low).powf(u);
    let way = Vec3::from_array(std::array::from_fn(|_| stream.next_f32() - 0.5));
    (way.normalize() * between(distances, stream.next_f32()), between(radii, stream.next_f32()))
}

/// Balls and lamps of any size at any distance, in a room that may glow, none of them around the eye but the room; and
/// targets. Each light has its own share of green. Every third scene has a ground, and a room around it.
fn anywhere(seed: u32) -> (Scene, Targets) {
    let mut stream = StreamKey::new(31, Family::Survey, 0).stream(seed);
    let beside = |(center, radius): (Vec3, f32)| (center, radius.min(0.9 * center.length()));
    let mut scene = empty_scene(pinhole(Vec3::ZERO, Vec3::X, 30.0));
    for _ in 0..3 {
        let (center, radius) = beside(somewhere(&mut stream, [0.5, 2.0], [0.1, 0.6]));
        scene = scene.ball(center, radius, diffuse(0.5));
    }
    for lamp in 0..5 {
        let (center, radius) = beside(somewhere(&mut stream, [1.0, 40.0], [0.02, 8.0]));
        let color = Rgb::new(1.0, 0.1 + 0.1 * lamp as f32, 0.0);
        scene = scene.lamp(center, radius, BLACK, color / (radius * radius));
    }
    let (mut center, mut radius) = somewhere(&mut stream, [0.1, 4.0], [8.0, 60.0]);
    let mut dim = radius * radius;
    if seed.is_multiple_of(3) {
        let ground = 50.0;
        // As bright as a room that is nearer.
        (center, radius, dim) = (Vec3::NEG_Y * ground, 6.0 * ground, 20.0);
        scene = scene.ball(Vec3::NEG_Y * (ground + 2.0 * stream.next_f32() + 0.5), ground, diffuse(0.5));
    }
    let glow = if seed.is_multiple_of(2) { Rgb::new(1.0, 0.9, 0.0) / dim } else { Rgb::ZERO };
    scene = scene.lamp(center, radius, diffuse(0.5), glow);
    let balls = (0..3).map(|_| somewhere(&mut stream, [0.1, 3.0], [0.2, 2.0]));
    let balls = balls.map(|(center, radius)| Target::ball(center, radius)).collect();
    (scene, Targets { balls, middle: 0, shares: vec![0.25; 4], expected: 0.0, guide: None })
}

/// A room with a lamp far from the one place where photons are wanted. The ball around that place reaches beyond the wall on the side
/// that the lamp shines on, so photons that started there would start outside of the room.
fn wanted_at_the_wall() -> (Scene, Targets) {
    let place = Vec3::NEG_Y * 9.5;
    let scene = empty_scene(pinhole(Vec3::ZERO, place, 30.0))
        .ball(Vec3::ZERO, 10.0, diffuse(0.5))
        .ball(Vec3::NEG_Y * 9.0, 0.5, diffuse(0.5))
        .lamp(Vec3::new(9.0, -2.0, 0.0), 0.2, BLACK, Rgb::new(1.0, 0.1, 0.0));
    let balls = vec![Target::ball(place, 3.0)];
    (scene, Targets { balls, middle: 0, shares: vec![0.1, 0.9], expected: 0.0, guide: None })
}

/// Where photons enter what is near is free space, which the light of their lamp reaches: within no ball, in every room, and
/// nothing between it and their lamp.
#[test]
fn photons_enter_what_is_near_in_free_space_and_in_sight_of_their_lamp() {
    let (mut cores, mut photons, mut over_grounds) = (0, 0, 0);
    for (seed, (scene, targets)) in (0..).zip((0..400).map(anywhere).chain([wanted_at_the_wall()])) {
        let still = scene.at(0.0);
        let aim = Aim::new(&still, &targets, 256);
        cores += u32::from(aim.core.is_some());
        let numbers = PhotonNumbers::new(5, seed);
        let emitted = (0..256).filter_map(|photon| emit(&still, &aim, &numbers, photon));
        for Emitted { ray, power } in emitted.filter(|emitted| emitted.ray.leaves == NO_SPHERE) {
            photons += 1;
            over_grounds += still.grounds.len();
            for (sphere, role) in scene.spheres.iter().zip(still.roles.iter()) {
                let depth = sphere.radius - (ray.origin - sphere.center).length();
                let is_free = if role.is_solid() { depth < ROUNDING } else { depth > -ROUNDING };
                assert!(is_free, "{seed}: {ray:?} begins beyond the surface of {sphere:?}");
            }
            let back = Ray { direction: -ray.direction, ..ray };
            let met = intersect(&still, &back).map(|hit| hit.sphere);
            assert_eq!(met, Some(sphere_of(&scene, power)), "{seed}: {ray:?} has something behind it");
        }
    }
    assert!(cores > 50 && photons > 2000, "{cores} scenes, {photons} photons");
    assert!(over_grounds > 500, "{over_grounds} photons over grounds");
    tell("physics", photons, "photons that enter what is near");
}
