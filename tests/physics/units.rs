//! Images do not depend on the units of length, light and time, nor on which channel is called red: bit by bit, as units that
//! differ by powers of two differ by no rounding. What is learnt before a render is held to it as well: what photons are aimed
//! at, how they are guided, first radii.

use crate::cases::tell;
use crate::harness::{BLACK, Build, coloured, empty_scene, glass, pinhole, settings};
use reference::survey::survey;
use reference::{PathTracer, Sppm};
use scene::{Camera, Filter, Material, RadiusSchedule, Resumable, Rgb, Scene, Settings, Vec3};

/// Balls of all materials on a wide ground, some of which move, under coloured lamps of which one is far; seen through a lens.
fn open() -> Scene {
    let camera = Camera {
        aperture_radius: 0.125,
        focus_distance: 8.0,
        shutter: [0.5, 1.0],
        ..pinhole(Vec3::new(0.0, 2.0, 8.0), Vec3::new(0.0, 0.75, 0.0), 32.0)
    };
    let mut scene = empty_scene(camera)
        .ball(Vec3::new(0.0, -2000.0, 0.0), 2000.0, coloured([0.5, 0.6, 0.25]))
        .ball(Vec3::new(-1.5, 0.75, 0.0), 0.75, coloured([0.8, 0.2, 0.5]))
        .ball(Vec3::new(0.0, 0.75, -0.5), 0.75, glass(0.9, 1.5))
        .ball(Vec3::new(1.5, 0.75, 0.5), 0.75, Material::Specular { albedo: Rgb::new(0.9, 0.5, 0.7) })
        .lamp(Vec3::new(300.0, 600.0, 200.0), 20.0, BLACK, Rgb::new(300.0, 200.0, 0.0))
        .lamp(Vec3::new(-1.0, 3.0, 1.0), 0.25, BLACK, Rgb::new(0.0, 5.0, 20.0))
        .lamp(Vec3::new(1.0, 2.5, 1.0), 0.125, glass(1.0, 1.25), Rgb::new(9.0, 0.0, 30.0));
    scene.spheres[1].velocity = Vec3::new(0.5, 0.25, 0.0);
    scene.spheres[5].velocity = Vec3::new(0.0, -1.0, 2.0);
    scene
}

/// The same under a sky.
fn under_the_sky() -> Scene {
    Scene { background: Rgb::new(0.25, 0.5, 0.75), ..open() }.with_sky()
}

/// A room of which the eye sees a corner, with a dozen lamps.
fn room() -> Scene {
    let wall = |scene: Scene, axis: Vec3| scene.ball(axis * 1004.0, 1000.0, coloured([0.6, 0.5, 0.7]));
    let scene = empty_scene(pinhole(Vec3::new(0.0, 0.0, 3.5), Vec3::new(0.0, -2.5, 0.0), 45.0))
        .ball(Vec3::Y * 26.0, 60.0, coloured([0.5, 0.6, 0.4]))
        .ball(Vec3::new(-1.25, -3.25, -0.5), 0.75, coloured([0.3, 0.8, 0.6]))
        .ball(Vec3::new(1.25, -3.25, 0.0), 0.75, glass(1.0, 1.5));
    let scene = [Vec3::X, Vec3::NEG_X, Vec3::Z, Vec3::NEG_Z, Vec3::NEG_Y].into_iter().fold(scene, wall);
    (0..12).fold(scene, |scene, k: u32| {
        let place = Vec3::new(0.25 * (k % 4) as f32, 2.75 + 0.25 * (k % 3) as f32, -0.25 * (k / 3) as f32);
        let color = Rgb::new(40.0 + k as f32, 30.0, 20.0 + (k % 4) as f32);
        scene.lamp(place, 0.0625 + 0.03125 * (k % 2) as f32, BLACK, color)
    })
}

/// A scene with its settings.
type Case = (&'static str, Scene, Settings);

fn cases() -> [Case; 5] {
    let settings = Settings { iterations: 2, ..settings(12, 9, 16_000, 8, 0.5) };
    let filtered = Settings { filter: Filter::Mitchell, light_samples: 3, ..settings };
    let piloted = Settings { radius_pilots: 1, photons_per_iteration: 2000, ..settings };
    [
        ("the open", open(), filtered),
        (
            "the open, limited by what is near",
            under_the_sky(),
            Settings { radius_clearance: 0.5, ..settings },
        ),
        ("the open, global radii", open(), Settings { radius_schedule: RadiusSchedule::Global, ..settings }),
        ("a room", room(), settings),
        ("a room with pilots", room(), piloted),
    ]
}

/// Radiance and radius of all pixels, by every method that can render it.
fn images(scene: &Scene, settings: &Settings) -> Vec<Vec<(Rgb, f32)>> {
    settings.validate().unwrap();
    let photons = || Sppm::new(scene, settings);
    let paths = || PathTracer::new(scene, settings);
    let mut engines: Vec<Box<dyn Resumable + '_>> = vec![Box::new(photons()), Box::new(paths())];
    if settings.radius_schedule == RadiusSchedule::PerPixel {
        engines.push(Box::new(reference::hybrid(paths(), photons())));
    }
    let pixels = |mut engine: Box<dyn Resumable + '_>| {
        (0..settings.iterations).for_each(|_| engine.iterate());
        let places = (0..settings.height).flat_map(|y| (0..settings.width).map(move |x| (x, y)));
        places.map(|(x, y)| engine.probe(x, y)).map(|probe| (probe.radiance, probe.radius)).collect()
    };
    engines.into_iter().map(pixels).collect()
}

/// Expects the images of a changed scene to be those of the scene with every pixel changed.
#[track_caller]
fn assert_changed(
    (name, scene, settings): &Case,
    (other, others): (&Scene, &Settings),
    change: impl Fn((Rgb, f32)) -> (Rgb, f32),
) {
    let (before, after) = (images(scene, settings), images(other, others));
    for (method, (before, after)) in before.iter().zip(&after).enumerate() {
        assert!(before.iter().any(|(radiance, _)| *radiance != Rgb::ZERO), "{name} is black");
        let changed = before.iter().map(|pixel| change(*pixel));
        let different = changed.zip(after).filter(|(expected, found)| expected != *found).count();
        assert_eq!(different, 0, "{name}: so many pixels differ by method {method}");
    }
}

fn with_length(scene: &Scene, unit: f32) -> Scene {
    let mut scene = scene.clone();
    let camera = &mut scene.camera;
    camera.eye *= unit;
    camera.aperture_radius *= unit;
    camera.focus_distance *= unit;
    for sphere in &mut scene.spheres {
        sphere.center *= unit;
        sphere.velocity *= unit;
        sphere.radius *= unit;
    }
    scene
}

#[test]
fn the_unit_of_length_does_not_matter() {
    let mut count = 0;
    for case in cases() {
        for unit in [1.0 / 64.0, 16.0] {
            let (_, scene, settings) = &case;
            let settings = Settings { initial_radius: settings.initial_radius * unit, ..*settings };
            let scene = with_length(scene, unit);
            assert_changed(&case, (&scene, &settings), |(radiance, radius)| (radiance, radius * unit));
            count += 1;
        }
    }
    tell("physics", count, "scenes in other units of length");
}

fn with_light(scene: &Scene, change: impl Fn(Rgb) -> Rgb) -> Scene {
    let mut scene = scene.clone();
    scene.background = change(scene.background);
    for sphere in &mut scene.spheres {
        sphere.emission = change(sphere.emission);
    }
    scene
}

#[test]
fn the_unit_of_light_does_not_matter() {
    let mut count = 0;
    for case in cases() {
        for unit in [1.0 / 256.0, 1024.0] {
            let (_, scene, settings) = &case;
            let scene = with_light(scene, |light| light * unit);
            assert_changed(&case, (&scene, settings), |(radiance, radius)| (radiance * unit, radius));
            count += 1;
        }
    }
    tell("physics", count, "scenes in other units of light");
}

#[test]
fn the_unit_of_time_does_not_matter() {
    for case in cases().iter().filter(|(_, scene, _)| scene.moves()) {
        for unit in [1.0 / 32.0, 4.0] {
            let (_, scene, settings) = case;
            let mut scene = scene.clone();
            scene.camera.shutter = scene.camera.shutter.map(|time| time * unit);
            scene.spheres.iter_mut().for_each(|sphere| sphere.velocity *= 1.0 / unit);
            assert_changed(case, (&scene, settings), |pixel| pixel);
        }
    }
}

/// Red, green and blue take each other's places.
#[test]
fn channels_are_alike() {
    let turned = |color: Rgb| Rgb::new(color.z, color.x, color.y);
    for (name, scene, settings) in cases() {
        // Pilots take means over channels, which are rounded in the order of the channels.
        let settings = Settings { radius_pilots: 0, ..settings };
        let mut other = with_light(&scene, turned);
        for material in &mut other.materials {
            let albedo = turned(material.albedo());
            *material = match *material {
                Material::Diffuse { .. } => Material::Diffuse { albedo },
                Material::Specular { .. } => Material::Specular { albedo },
                Material::Dielectric { ior, .. } => Material::Dielectric { albedo, ior },
            };
        }
        let case = (name, scene, settings);
        assert_changed(&case, (&other, &settings), |(radiance, radius)| (turned(radiance), radius));
    }
}

/// In which order spheres are listed does not matter but for noise: all light of both orders is the same by every method.
#[test]
fn the_order_of_spheres_does_not_matter() {
    /// Noise of the mean over an image, of so many iterations.
    const NOISE: f64 = 0.04;
    const ITERATIONS: u32 = 48;
    let sums = |scene: &Scene, settings: &Settings| -> Vec<f64> {
        let images = images(scene, settings);
        let light = |(radiance, _): &(Rgb, f32)| f64::from(radiance.x + radiance.y + radiance.z);
        images.iter().map(|image| image.iter().map(light).sum::<f64>()).collect()
    };
    for (name, scene, settings) in cases().into_iter().filter(|(name, ..)| !name.contains("global")) {
        let settings =
            Settings { iterations: ITERATIONS, photons_per_iteration: 4000, radius_pilots: 0, ..settings };
        let mut other = scene.clone();
        other.spheres.reverse();
        let (before, after) = (sums(&scene, &settings), sums(&other, &settings));
        for (method, (before, after)) in before.iter().zip(&after).enumerate() {
            assert!(
                (after / before - 1.0).abs() < NOISE,
                "{name} by method {method}: {before}, reversed {after}"
            );
        }
    }
}

/// These scenes are of both kinds.
#[test]
fn photons_of_these_scenes_are_aimed_in_the_open_and_guided_in_rooms() {
    for (name, scene, settings) in cases() {
        let targets = survey(&scene, &settings);
        let is_room = name.starts_with("a room");
        assert_eq!((targets.shares.is_empty(), targets.guide.is_some()), (is_room, is_room), "{name}");
    }
}
