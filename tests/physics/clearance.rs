//! First search radii limited by clearance: what they are, and that light close to a ball is right with them.

use crate::harness::{
    BLACK, Build, diffuse, empty_scene, glass, lamp_within_glass, mean, pinhole, relative_error, settings,
};
use reference::Sppm;
use reference::camera_pass::{CameraNumbers, camera_ray, trace};
use reference::consolidate::ALPHA;
use scene::aim::Targets;
use scene::rng::{Family, StreamKey};
use scene::{Clearance, Engine, Resumable, Rgb, Scene, Settings, Sphere, Stats, Vec3};

/// A room, a shell of radius 3, with a ball of radius 1 that touches its floor and one of glass above it.
fn room() -> Scene {
    let eye = Vec3::new(0.0, -1.2, 2.5);
    empty_scene(pinhole(eye, Vec3::new(0.0, -2.93, 0.55), 20.0))
        .lamp(Vec3::ZERO, 3.0, diffuse(0.5), Rgb::splat(0.5))
        .lamp(Vec3::new(0.0, -2.0, 0.0), 1.0, diffuse(0.5), Rgb::splat(0.5))
        .ball(Vec3::new(1.4, -2.0, 0.6), 0.4, glass(1.0, 1.5))
}

/// The same room while the shutter is open, in which the ball on the floor has come from elsewhere.
fn room_in_motion() -> Scene {
    let mut scene = room();
    scene.camera.shutter = [2.0, 2.0];
    let ball = &mut scene.spheres[1];
    ball.velocity = Vec3::new(0.3, 0.9, 0.0);
    ball.center -= 2.0 * ball.velocity;
    scene
}

/// The radius to which a sphere limits that of a pixel that sees `point`, by the definition.
pub(crate) fn limit(sphere: &Sphere, point: Vec3, radius_clearance: f32, initial_radius: f32) -> f64 {
    let beyond = point.as_dvec3().distance(sphere.center.as_dvec3()) - f64::from(sphere.radius);
    let least = f64::from(initial_radius) / if beyond < 0.0 { 3.0 } else { 8.0 };
    (f64::from(radius_clearance) * beyond.abs()).max(least)
}

/// After an iteration, the squared radius of a pixel that has counted photons is alpha times the first, and that is computed here
/// from the definition, for the point that the pixel sees. A pixel that has counted none keeps the initial radius.
#[test]
fn first_radii_are_so_many_times_the_distance_to_what_is_near() {
    /// Roundings of `f32`, few of them.
    const ROUNDING: f64 = 1e-6;
    let (room, in_motion) = (room(), room_in_motion());
    let mut all_least = 0;
    for (scene, radius_clearance, photons) in
        [(&room, 1.0, 4000), (&room, 0.4, 4000), (&room, 2.5, 200), (&in_motion, 1.0, 4000)]
    {
        let settings = Settings { radius_clearance, ..settings(40, 30, photons, 12, 0.8) };
        let mut engine = Sppm::new(scene, &settings);
        engine.iterate();
        let (still, frame) = (scene.at(scene.camera.shutter[0]), scene.camera.frame(40, 30));
        let (mut limited, mut least, mut none) = (0, 0, 0);
        for (x, y) in (0..30).flat_map(|y| (0..40).map(move |x| (x, y))) {
            let mut numbers = CameraNumbers::new(&settings, 0, x, y);
            let ray = camera_ray(&frame, None, x, y, &numbers);
            let sample = trace(&still, ray, settings.max_depth, &mut numbers, &mut Stats::default());
            let probe = engine.probe(x, y);
            let Some(seen) = sample.visible.filter(|_| probe.count > 0.0) else {
                assert_eq!(probe.radius, settings.initial_radius);
                none += 1;
                continue;
            };
            let of =
                |id: usize| limit(&still.spheres[id], seen.point, radius_clearance, settings.initial_radius);
            let others = (0..scene.spheres.len()).filter(|id| *id != seen.sphere as usize);
            let initial = f64::from(settings.initial_radius);
            let first = others.map(of).fold(initial, f64::min);
            let expected = f64::from(ALPHA) * first * first;
            let found = f64::from(probe.radius).powi(2);
            assert!((found / expected - 1.0).abs() < ROUNDING, "{found}, not {expected}, at {x}, {y}");
            limited += u32::from(first < initial);
            least += u32::from(first <= initial / 8.0);
        }
        assert!(limited > 50, "{limited} of 1200 pixels");
        all_least += least;
        assert!(photons > 1000 || none > 50, "{none} pixels without photons");
    }
    assert!(all_least > 20, "{all_least} pixels");
}

/// Among hundreds of spheres, of which some are nearer than what the least radius asks for, and with any factor: it is the nearest
/// that counts, whichever is found first.
#[test]
fn the_nearest_of_many_spheres_limits_the_radius() {
    /// Roundings of `f32`.
    const ROUNDING: f64 = 1e-6;
    let mut stream = StreamKey::new(3, Family::Dither, 0).stream(0);
    let mut place = |side: f32| Vec3::from_array(std::array::from_fn(|_| side * (stream.next_f32() - 0.5)));
    let mut scene = empty_scene(pinhole(Vec3::ZERO, Vec3::NEG_Z, 40.0)).ball(Vec3::ZERO, 30.0, BLACK);
    for k in 0..400 {
        scene = scene.ball(place(6.0), [0.02, 0.1, 0.5][k % 3], BLACK);
    }
    let points: Vec<Vec3> = (0..300).map(|_| place(6.5)).collect();
    let (mut limited, mut least) = (0, 0);
    for radius_clearance in [0.1, 0.5, 0.99, 1.01, 2.0, 10.0] {
        let settings = Settings { radius_clearance, ..settings(8, 8, 1, 2, 0.8) };
        let clearance = Clearance::new(&settings).unwrap();
        for (k, &point) in points.iter().enumerate() {
            let own = (7 * k % scene.spheres.len()) as u32;
            let others = scene.spheres.iter().enumerate().filter(|(id, _)| *id != own as usize);
            let of = |sphere: &Sphere| limit(sphere, point, radius_clearance, settings.initial_radius);
            let limit = others.map(|(_, sphere)| of(sphere)).fold(f64::INFINITY, f64::min);
            let eighth = f64::from(settings.initial_radius) / 8.0;
            for first in [0.8_f32, 0.3] {
                let expected = f64::from(first * first).min(limit * limit);
                let found = f64::from(clearance.limited(&scene.spheres, (point, own), first * first));
                assert!(
                    (found / expected - 1.0).abs() < ROUNDING,
                    "{radius_clearance}: {found}, not {expected}"
                );
                limited += u32::from(expected < f64::from(first * first) && limit > eighth);
                least += u32::from(limit <= eighth);
            }
        }
    }
    assert!(limited > 500 && least > 500, "{limited} limited, {least} to the least");
}

/// What is near counts until a pixel has gathered photons: from then on its radius shrinks by photons alone, as in a render
/// without clearance that begins with the same sums.
#[test]
fn clearance_matters_until_photons_are_gathered() {
    let scene = room();
    let with = Settings { radius_clearance: 0.4, ..settings(40, 30, 2000, 12, 0.8) };
    let without = Settings { radius_clearance: 0.0, ..with };
    let (mut limited, mut free) = (Sppm::new(&scene, &with), Sppm::new(&scene, &without));
    limited.iterate();
    for y in 0..30 {
        let mut words = vec![0; 40 * limited.sums().words()];
        limited.save_row(y, &mut words);
        free.load_row(y, &words);
    }
    free.go_on_after(1, *limited.stats());
    let places = || (0..30).flat_map(|y| (0..40).map(move |x| (x, y)));
    let had_photons: Vec<bool> = places().map(|(x, y)| limited.probe(x, y).count > 0.0).collect();
    limited.iterate();
    free.iterate();
    let (mut same, mut others) = (0, 0);
    for ((x, y), had_photons) in places().zip(had_photons) {
        let (limited, free) = (limited.probe(x, y), free.probe(x, y));
        if had_photons {
            assert_eq!(limited, free, "at {x}, {y}");
            same += 1;
        } else {
            others += u32::from(limited.radius < free.radius);
        }
    }
    assert!(same > 300 && others > 5, "{same} pixels with photons, {others} limited later");
}

/// A little lamp in the middle of a ball of glass over a floor, which all its light reaches by photons: below it irradiance is
/// that of a point, `Phi / (4 pi h^2)`, less what the glass reflects back into the lamp. A wide disc reaches to where it is
/// dark; clearance keeps the disc small below the ball.
#[test]
fn light_below_a_ball_of_glass_is_that_of_its_lamp() {
    /// Of the disc of radius 0.1, 0.7 below the lamp, 1.5 %; three standard errors of some 4,000 photons, 5 %.
    const NEAR: f64 = 0.065;
    /// What is wrong without: over the disc of radius 0.8 irradiance is about half of that in its middle.
    const WRONG: f64 = 0.3;
    let (scene, expected) = lamp_within_glass();
    let error = |radius_clearance| {
        let settings = Settings { iterations: 4, radius_clearance, ..settings(4, 3, 200_000, 8, 0.8) };
        let mut engine = Sppm::new(&scene, &settings).aimed_at(Targets::default());
        (0..settings.iterations).for_each(|_| engine.iterate());
        let found = mean(&engine.develop());
        (relative_error(found, [expected; 3]), found[0] / expected)
    };
    let (with, without) = (error(0.5), error(0.0));
    assert!(with.0 < NEAR, "{with:?} with clearance");
    assert!(without.0 > WRONG && without.1 < 1.0, "{without:?} without");
}
