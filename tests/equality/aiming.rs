//! Open scenes, in which photons are aimed: what they are aimed at, and whole renders.

use crate::cases;
use crate::pair::{MOST_THREADS, all_lanes, compare, effort, scaled, tell};
use fast::LaneKind;
use fast::kernels;
use files::scene_file;
use proptest::prelude::*;
use proptest::test_runner::TestRunner;
use reference::survey::survey;
use scene::{Rgb, Scene, Settings, Sphere, Vec3};
use std::cell::Cell;
use std::fmt::Write;

/// A ball of an open scene: its place on the plain, its height above it, its radius, its material, and its emission.
type Ball = ([f32; 2], f32, f32, usize, Option<f32>);

/// An open scene: balls on a plain, perhaps a sky and a far sun.
#[derive(Clone, Debug)]
struct Open {
    balls: Vec<Ball>,
    /// Radius of the plain's ball.
    ground: f32,
    has_sky: bool,
    /// The sun's distance, and its radius over that.
    sun: Option<(f32, f32)>,
    /// The sun's direction.
    towards_sun: [f32; 2],
    /// All of it is scaled by this, and moved by the offset before that.
    unit: f32,
    offset: f32,
    velocity: f32,
}

const MATERIALS: [&str; 4] = ["chalk", "clay", "glass", "mirror"];

fn open(balls: impl Into<prop::collection::SizeRange>) -> impl Strategy<Value = Open> {
    let place = [-6.0..=6.0_f32, -6.0..=6.0_f32];
    let emission = prop::option::weighted(0.2, 0.5..=50.0_f32);
    let ball = (place, 0.0..=3.0_f32, 0.1..=1.0_f32, 0..MATERIALS.len(), emission);
    let ground = prop::sample::select(vec![50.0_f32, 1e3, 1e4, 1e5]);
    let sun = prop::option::of((prop::sample::select(vec![50.0_f32, 1e3, 1e6]), 0.005..=0.3_f32));
    let unit = prop::sample::select(vec![1e-3_f32, 1.0, 1.0, 1.0, 1e3]);
    let offset = prop::sample::select(vec![0.0_f32, 0.0, 30.0, 2000.0]);
    let velocity = prop::sample::select(vec![0.0_f32, 0.0, 0.5]);
    let towards_sun = [-2.0..=2.0_f32, -2.0..=2.0_f32];
    let parts = (prop::collection::vec(ball, balls), ground, any::<bool>(), sun);
    (parts, towards_sun, unit, offset, velocity).prop_map(
        |((balls, ground, has_sky, sun), towards_sun, unit, offset, velocity)| Open {
            balls,
            ground,
            has_sky,
            sun,
            towards_sun,
            unit,
            offset,
            velocity,
        },
    )
}

impl Open {
    fn to_toml(&self) -> String {
        let Self { ground, unit, offset, velocity, .. } = *self;
        let at = |v: Vec3| ((v + offset) * unit).to_array();
        let mut text = String::new();
        if self.has_sky {
            text.push_str("background = [0.3, 0.5, 0.9]\n");
        }
        let (eye, target) = (at(Vec3::new(0.0, 4.0, 14.0)), at(Vec3::Y));
        write!(
            text,
            "[camera]\neye = {eye:?}\ntarget = {target:?}\nshutter = [0.0, 1.0]\nvertical_fov_degrees = 40\n"
        )
        .unwrap();
        text.push_str(
            r#"
[materials.ground]
type = "diffuse"
albedo = [0.5, 0.6, 0.4]
[materials.chalk]
type = "diffuse"
albedo = [0.8, 0.8, 0.8]
[materials.clay]
type = "diffuse"
albedo = [0.8, 0.3, 0.1]
[materials.glass]
type = "dielectric"
albedo = [1, 0.9, 1]
ior = 1.5
[materials.mirror]
type = "specular"
albedo = [0.9, 0.9, 0.9]
[materials.black]
type = "diffuse"
albedo = [0, 0, 0]
"#,
        );
        let mut sphere = |center: Vec3, radius: f32, material: &str, more: &str| {
            let (center, radius) = (at(center), radius * unit);
            let what = format!("center = {center:?}\nradius = {radius:?}\nmaterial = \"{material}\"");
            writeln!(text, "[[sphere]]\n{what}\n{more}").unwrap();
        };
        sphere(Vec3::NEG_Y * ground, ground, "ground", "");
        if let Some((distance, radius)) = self.sun {
            let [x, z] = self.towards_sun;
            let direction = Vec3::new(x, 1.5, z).normalize();
            let emission = 1.0 / (radius * radius);
            let emission = format!("emission = [{emission:?}, {emission:?}, {emission:?}]");
            sphere(direction * distance, distance * radius, "black", &emission);
        }
        for (number, ([x, z], y, radius, material, emission)) in self.balls.iter().enumerate() {
            let mut more = String::new();
            if let Some(emission) = emission {
                write!(more, "emission = [{emission:?}, 1.0, 2.0]").unwrap();
            }
            if number == 0 && velocity > 0.0 {
                let velocity = velocity * unit;
                write!(more, "\nvelocity = [{velocity:?}, 0.0, 0.0]").unwrap();
            }
            sphere(Vec3::new(*x, *y, *z), *radius, MATERIALS[*material], &more);
        }
        text
    }
}

/// A scene with settings, with which it renders within some ten milliseconds.
fn case(balls: impl Into<prop::collection::SizeRange>) -> impl Strategy<Value = (String, Scene, Settings)> {
    let size = || prop::sample::select(vec![1_u32, 7, 16, 20]);
    let photons = prop_oneof![1 => 1..100_u32, 4 => 100..3000_u32];
    (open(balls), size(), size(), 1..4_u32, photons, 1..8_u32, 0.05..=1.0_f32, any::<u64>()).prop_filter_map(
        "the scene is not valid",
        |(open, width, height, iterations, photons_per_iteration, max_depth, radius, seed)| {
            let text = open.to_toml();
            let scene = scene_file::parse("open.toml", &text).ok()?;
            let initial_radius = radius * open.unit;
            let settings = Settings {
                width,
                height,
                iterations,
                photons_per_iteration,
                max_depth,
                initial_radius,
                seed,
                ..Settings::default()
            };
            Some((text, scene, settings))
        },
    )
}

/// Compares surveys and renders of `cases` open scenes. In at least a quarter of them photons must be aimed.
fn check(cases: u32, balls: std::ops::RangeInclusive<usize>) {
    let (renders, aimed) = (Cell::new(0), Cell::new(0));
    let result = TestRunner::new(effort(cases)).run(&case(balls), |(text, scene, settings)| {
        let expected = survey(&scene, &settings);
        for lanes in LaneKind::ALL {
            let actual = kernels::survey(&scene, &settings, lanes);
            prop_assert_eq!(&actual, &expected, "{:?} in\n{}", lanes, text);
        }
        let ways = all_lanes(1 + settings.seed as usize % MOST_THREADS);
        compare(&scene, &settings, &ways).map_err(|why| TestCaseError::fail(format!("{why}\n{text}")))?;
        renders.set(renders.get() + ways.len());
        aimed.set(aimed.get() + u32::from(!expected.shares.is_empty()));
        Ok(())
    });
    result.unwrap();
    tell(renders.get(), "open scenes");
    cases::tell("equality", renders.get(), "surveys equal the reference");
    assert!(scaled(cases) < cases || aimed.get() > cases / 4, "only {} are aimed", aimed.get());
}

#[test]
fn few_balls() {
    check(250, 1..=6);
}

#[test]
fn many_balls() {
    check(50, 20..=60);
}

/// More lamps than are aimed one by one.
#[test]
fn thousands_of_lamps() {
    let open = Open {
        balls: vec![([0.0, 0.0], 1.0, 1.0, 2, None), ([2.0, 1.0], 0.5, 0.8, 0, Some(3.0))],
        ground: 1e3,
        has_sky: false,
        sun: None,
        towards_sun: [0.0; 2],
        unit: 1.0,
        offset: 0.0,
        velocity: 0.0,
    };
    let mut scene = scene_file::parse("lamps.toml", &open.to_toml()).unwrap();
    for k in 0..3000_u32 {
        let center = Vec3::new((k % 60) as f32 - 30.0, 2.0 + (k % 7) as f32, (k / 60) as f32 - 40.0) * 3.0;
        let emission = Rgb::new(1.0, 2.0, (k % 5) as f32);
        scene.spheres.push(Sphere { center, velocity: Vec3::ZERO, radius: 0.1, material: 0, emission });
    }
    let settings =
        Settings { width: 20, height: 16, iterations: 2, photons_per_iteration: 5000, ..scene.settings };
    let targets = survey(&scene, &settings);
    assert!(!targets.shares.is_empty(), "nothing is aimed: {}", targets.expected);
    compare(&scene, &settings, &all_lanes(2)).unwrap();
    tell(LaneKind::ALL.len(), "a scene of 3000 lamps");
}
