//! Random open scenes, in which photons are aimed.

use files::scene_file;
use proptest::prelude::*;
use scene::{Scene, Settings, Vec3};
use std::fmt::Write;

/// A ball of an open scene: its place on the plain, its height above it, its radius, its material, and its emission.
type Ball = ([f32; 2], f32, f32, usize, Option<f32>);

/// An open scene: balls on a plain, perhaps a sky and a far sun.
#[derive(Clone, Debug)]
pub(crate) struct Open {
    pub(crate) balls: Vec<Ball>,
    /// Radius of the plain's ball.
    pub(crate) ground: f32,
    pub(crate) has_sky: bool,
    /// The sun's distance, and its radius over that.
    pub(crate) sun: Option<(f32, f32)>,
    /// The sun's direction.
    pub(crate) towards_sun: [f32; 2],
    /// All of it is scaled by this, and moved by the offset before that.
    pub(crate) unit: f32,
    pub(crate) offset: f32,
    pub(crate) velocity: f32,
}

const MATERIALS: [&str; 4] = ["chalk", "clay", "glass", "mirror"];

fn open(balls: impl Into<prop::collection::SizeRange>) -> impl Strategy<Value = Open> {
    let place = [-6.0..=6.0_f32, -6.0..=6.0_f32];
    let emission = prop::option::weighted(0.2, 0.5..=50.0_f32);
    let ball = (place, 0.0..=3.0_f32, 0.1..=1.0_f32, 0..MATERIALS.len(), emission);
    let ground = prop::sample::select(vec![50.0_f32, 1e3, 1e4, 1e5, 1e7]);
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
    pub(crate) fn to_toml(&self) -> String {
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
pub(crate) fn case(
    balls: impl Into<prop::collection::SizeRange>,
) -> impl Strategy<Value = (String, Scene, Settings)> {
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
