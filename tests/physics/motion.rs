//! Spheres that move: where they are at an instant, and that the sky is around them as long as the shutter is open.

use crate::harness::{
    BLACK, Build, assert_mean, diffuse, empty_scene, glass, mirror, pinhole, render_path, render_sppm,
    settings,
};
use reference::{PathTracer, Sppm};
use scene::aim::Targets;
use scene::{Camera, Film, Resumable, Rgb, Scene, Settings, Spheres, Stats, Vec3};

fn moved(spheres: &Spheres, velocities: &[Vec3]) -> Spheres {
    let with = |(sphere, velocity): (&scene::Sphere, &Vec3)| scene::Sphere { velocity: *velocity, ..*sphere };
    spheres.iter().zip(velocities).map(with).collect()
}

/// A shutter may open for no time, at any time: then spheres that move are where they are at that instant, as if they were
/// there from the beginning. Bit by bit, as all numbers are exact: lamps, glass and the sky among them.
#[test]
fn at_one_instant_spheres_are_where_their_velocities_have_taken_them() {
    let room = |camera: Camera, at: &dyn Fn(Vec3, Vec3) -> Vec3, velocities: &[Vec3; 4]| {
        let [a, b, c, d] = *velocities;
        let scene = Scene { background: Rgb::splat(0.25), ..empty_scene(camera) };
        scene
            .ball(at(Vec3::new(0.0, -101.0, -8.0), a), 100.0, diffuse(0.75))
            .lamp(at(Vec3::new(2.0, 3.0, -8.0), b), 0.5, diffuse(0.5), Rgb::splat(9.0))
            .ball(at(Vec3::new(-1.0, 0.0, -8.0), c), 1.0, glass(1.0, 1.5))
            .ball(at(Vec3::new(1.5, 0.0, -9.0), d), 1.0, mirror(0.75))
    };
    let velocities =
        [Vec3::ZERO, Vec3::new(-4.0, 0.0, 2.0), Vec3::new(2.0, 2.0, 0.0), Vec3::new(0.0, 1.0, 4.0)];
    let camera = pinhole(Vec3::ZERO, Vec3::NEG_Z, 40.0);
    for time in [0.5_f32, -2.0] {
        let placed = room(camera, &|center, velocity| center + velocity * time, &velocities).with_sky();
        let moving = room(Camera { shutter: [time; 2], ..camera }, &|center, _| center, &velocities);
        let moving = Scene { spheres: moved(&moving.spheres, &velocities), ..moving }.with_sky();
        let settings = Settings { iterations: 2, ..settings(16, 12, 500, 6, 0.5) };
        assert!(render_sppm(&moving, &settings) == render_sppm(&placed, &settings), "by photons at {time}");
        assert!(render_path(&moving, &settings) == render_path(&placed, &settings), "by paths at {time}");
    }
}

/// A convex ball under a uniform sky has the radiance of its albedo times the sky's, wherever it flies while the shutter is
/// open. It fills the image at all times, as it comes from afar or goes there. Directions are drawn by the cosine, so every
/// sample is exact.
#[test]
fn the_sky_lights_a_ball_that_flies_from_afar() {
    /// Roundings of `f32`.
    const ROUNDING: f64 = 1e-5;
    let camera = Camera { shutter: [0.0, 1.0], ..pinhole(Vec3::ZERO, Vec3::NEG_Z, 2.0) };
    for (begin, end) in [(-10.0_f32, -190.0_f32), (-190.0, -10.0)] {
        let scene = Scene { background: Rgb::new(1.0, 2.0, 0.5), ..empty_scene(camera) };
        let scene = scene.ball(Vec3::Z * begin, 8.0, diffuse(0.5));
        let spheres = moved(&scene.spheres, &[Vec3::Z * (end - begin)]);
        let scene = Scene { spheres, ..scene }.with_sky();
        let settings = Settings { iterations: 16, ..settings(4, 4, 16, 4, 0.5) };
        let what = format!("from {begin} to {end}");
        assert_mean(&render_sppm(&scene, &settings), [0.5, 1.0, 0.25], ROUNDING, &what);
        assert_mean(&render_path(&scene, &settings), [0.5, 1.0, 0.25], ROUNDING, &what);
    }
}

/// How a render by some method begins.
type Begin = for<'a> fn(&'a Scene, &Settings) -> Box<dyn Resumable + 'a>;

fn photons<'a>(scene: &'a Scene, settings: &Settings) -> Box<dyn Resumable + 'a> {
    Box::new(Sppm::new(scene, settings).aimed_at(Targets::default()))
}

fn photons_of_caustics<'a>(scene: &'a Scene, settings: &Settings) -> Box<dyn Resumable + 'a> {
    Box::new(Sppm::new(scene, settings).of_caustics().aimed_at(Targets::default()))
}

fn paths<'a>(scene: &'a Scene, settings: &Settings) -> Box<dyn Resumable + 'a> {
    Box::new(PathTracer::new(scene, settings))
}

/// The image of two iterations, of which so many are done and were dark.
fn of_two(mut engine: Box<dyn Resumable + '_>, dark: u32) -> Film {
    if dark > 0 {
        engine.go_on_after(dark, Stats::default());
    }
    (dark..2).for_each(|_| engine.iterate());
    assert_eq!(engine.iterations(), 2);
    engine.develop()
}

/// An instant at which the only lamp is hidden is a dark one, and counts as the others do: by photons, by those of caustics, and by
/// paths. Bit by bit as if it had been rendered before, and black.
#[test]
fn instants_at_which_the_lamp_is_hidden_are_dark() {
    let (at, shutter) = (Vec3::new(0.8, 3.0, 0.5), [0.0, 1.0]);
    let camera = Camera { shutter, ..pinhole(Vec3::new(0.0, 3.0, 6.0), Vec3::ZERO, 40.0) };
    let open = empty_scene(camera)
        .ball(Vec3::new(0.0, -100.0, 0.0), 100.0, diffuse(0.6))
        .ball(Vec3::new(-0.8, 0.6, 0.0), 0.6, mirror(0.9))
        .ball(Vec3::new(0.9, 0.4, -0.6), 0.4, diffuse(0.8))
        .lamp(at, 0.05, BLACK, Rgb::splat(1000.0));
    // A black ball around the lamp, which flies off to where nothing comes from.
    let mut covered = open.clone().ball(at, 1.0, BLACK);
    covered.spheres[4].velocity = Vec3::Y * 2.2;
    // The second iteration is half of the exposure later: then the ball is above the lamp.
    let seed = (1..1000).find(|seed| camera.shutter_time(*seed, 0) < 0.4).unwrap();
    let lamps = [0, 1].map(|i| covered.at(camera.shutter_time(seed, i)).lights.entries.len());
    assert_eq!(lamps, [0, 1]);
    let settings = Settings { seed, ..settings(16, 12, 20_000, 6, 1.0) };
    let methods: [(&str, Begin); 3] =
        [("photons", photons), ("photons of caustics", photons_of_caustics), ("paths", paths)];
    for (method, begin) in methods {
        let (found, expected) = (of_two(begin(&covered, &settings), 0), of_two(begin(&open, &settings), 1));
        assert!(expected.pixels.iter().any(|pixel| *pixel != Rgb::ZERO), "{method}: all is black");
        assert!(found == expected, "{method}");
    }
}
