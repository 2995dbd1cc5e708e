//! Determinism: an image depends only on scene, settings and seed.

use crate::cases::tell;
use crate::harness::{Build, diffuse, empty_scene, glass, mirror, pinhole, run, settings};
use reference::survey::survey;
use reference::{PathTracer, Sppm};
use scene::state::transfer;
use scene::{Engine, Film, RadiusSchedule, Rgb, Scene, Settings, Vec3};

const SIZES: [(u32, u32); 6] = [(48, 27), (36, 30), (1, 1), (7, 3), (1, 1000), (1000, 1)];

/// A scene with every feature: glass, a mirror, two lamps, a lens, and a moving ball.
fn scene() -> Scene {
    let mut scene = empty_scene(pinhole(Vec3::new(0.0, 0.0, 4.0), Vec3::ZERO, 70.0))
        .ball(Vec3::ZERO, 5.0, diffuse(0.7))
        .lamp(Vec3::new(0.0, 3.0, 0.0), 0.5, diffuse(0.2), Rgb::new(9.0, 7.0, 5.0))
        .lamp(Vec3::new(3.0, 0.0, 0.0), 0.3, diffuse(0.0), Rgb::new(1.0, 2.0, 9.0))
        .ball(Vec3::new(-1.0, -1.0, 0.0), 0.8, glass(0.9, 1.5))
        .ball(Vec3::new(1.0, -1.0, 0.0), 0.7, mirror(0.9))
        .ball(Vec3::new(0.0, 1.0, 0.0), 0.4, diffuse(0.5));
    scene.spheres[5].velocity = Vec3::new(1.0, 0.0, 0.0);
    scene.camera.shutter = [0.0, 1.0];
    (scene.camera.aperture_radius, scene.camera.focus_distance) = (0.1, 4.0);
    scene
}

fn engines<'a>(scene: &'a Scene, settings: &Settings) -> [Box<dyn Engine + 'a>; 2] {
    [Box::new(Sppm::new(scene, settings)), Box::new(PathTracer::new(scene, settings))]
}

fn render(engine: &mut dyn Engine, iterations: u32) -> Film {
    (0..iterations).for_each(|_| engine.iterate());
    engine.develop()
}

#[test]
fn the_same_seed_gives_the_same_bits_and_another_seed_another_image() {
    let scene = scene();
    for (width, height) in SIZES {
        let settings = Settings { iterations: 2, ..settings(width, height, 2000, 5, 1.0) };
        let other_seed = Settings { seed: 2, ..settings };
        let again = engines(&scene, &settings);
        let others = engines(&scene, &other_seed);
        for ((mut first, mut second), mut other) in
            engines(&scene, &settings).into_iter().zip(again).zip(others)
        {
            let film = render(first.as_mut(), 2);
            assert_eq!((film.width, film.height, film.pixels.len()), (width, height, settings.pixels()));
            assert!(film.pixels.iter().all(|p| p.is_finite() && p.min_element() >= 0.0), "{width}x{height}");
            assert!(film.pixels.iter().any(|p| p.max_element() > 0.0), "{width}x{height} is black");
            let bits = |f: &Film| f.pixels.iter().map(|p| p.to_array().map(f32::to_bits)).collect::<Vec<_>>();
            assert!(bits(&film) == bits(&render(second.as_mut(), 2)), "{width}x{height} differs from itself");
            assert!(first.radius() == second.radius() && first.count() == second.count());
            assert!(film != render(other.as_mut(), 2), "{width}x{height} does not depend on the seed");
        }
    }
    tell("physics", 2 * SIZES.len(), "images repeated and compared with another seed");
}

#[test]
fn each_high_bit_of_the_seed_matters() {
    let scene = scene();
    let image = |seed| {
        let settings = Settings { seed, ..settings(8, 8, 100, 5, 1.0) };
        run(Sppm::new(&scene, &settings), &settings)
    };
    let expected = image(1);
    for bit in [1, 31, 32, 63] {
        assert!(image(1 | 1 << bit) != expected, "bit {bit}");
    }
}

#[test]
fn developing_does_not_change_a_render() {
    let scene = scene();
    let settings = settings(16, 9, 500, 5, 1.0);
    let disturbed = engines(&scene, &settings);
    for (mut quiet, mut disturbed) in engines(&scene, &settings).into_iter().zip(disturbed) {
        assert!(disturbed.develop() == Film::new(16, 9), "not black before the first iteration");
        for n in 1..=3 {
            disturbed.iterate();
            assert_eq!(disturbed.iterations(), n);
            disturbed.develop();
        }
        assert!(render(quiet.as_mut(), 3) == disturbed.develop());
    }
}

#[test]
fn images_do_not_depend_on_the_number_of_threads() {
    let scene = scene();
    let settings = Settings { iterations: 2, ..settings(37, 23, 1000, 5, 1.0) };
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| engines(&scene, &settings).map(|mut engine| render(engine.as_mut(), 2)))
    };
    assert!(on(1) == on(2) && on(1) == on(5));
}

/// In the open, so that photons are aimed: balls move over a wide ground, lit by a lamp of their size from afar.
fn open_scene() -> Scene {
    let mut scene = empty_scene(pinhole(Vec3::new(0.0, 3.0, 12.0), Vec3::ZERO, 30.0))
        .ball(Vec3::new(0.0, -1e3, 0.0), 1e3, diffuse(0.5))
        .ball(Vec3::new(-1.0, 1.0, 0.0), 1.0, diffuse(0.8))
        .ball(Vec3::new(1.0, 0.7, 0.5), 0.7, glass(1.0, 1.5))
        .lamp(Vec3::new(30.0, 40.0, 0.0), 1.0, diffuse(0.0), Rgb::splat(900.0));
    for sphere in &mut scene.spheres[1..3] {
        sphere.velocity = Vec3::new(0.0, 2.0, -8.0);
    }
    scene.camera.shutter = [0.0, 1.0];
    scene
}

/// What an engine holds is all that another one needs to go on, whatever has been learnt before the first iteration.
#[test]
fn a_resumed_render_goes_on_as_if_it_had_not_ended() {
    for (name, scene) in [("a room", scene()), ("in the open", open_scene())] {
        for radius_schedule in RadiusSchedule::ALL {
            let settings = Settings { radius_schedule, ..settings(16, 12, 3000, 5, 1.0) };
            let targets = survey(&scene, &settings);
            assert_eq!(targets.shares.is_empty(), name == "a room", "{name}");
            let mut whole = Sppm::new(&scene, &settings);
            whole.iterate();
            let mut resumed = Sppm::new(&scene, &settings);
            transfer(&whole, &mut resumed);
            for iteration in 2..=3 {
                whole.iterate();
                resumed.iterate();
                let is_same = whole.develop() == resumed.develop()
                    && whole.radius() == resumed.radius()
                    && whole.count() == resumed.count()
                    && whole.direct() == resumed.direct();
                assert!(is_same, "{name}, radii {radius_schedule}, after {iteration} iterations");
            }
        }
    }
    tell("physics", 8, "iterations of resumed renders");
}
