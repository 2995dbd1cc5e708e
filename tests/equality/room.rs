//! Random closed rooms of which the eye sees a part, in which photons are guided.

use proptest::prelude::*;
use scene::{Camera, Material, Rgb, Scene, Settings, Sphere, Vec3};

/// A ball within the room: its place in the part that is seen, its radius, its material, and its emission.
type Ball = ([f32; 3], f32, usize, Option<f32>);

/// Balls between the walls of a shaft below a dome. The eye sees its floor.
#[derive(Clone, Debug)]
pub(crate) struct Room {
    balls: Vec<Ball>,
    /// The radius of the dome, of which the eye sees nothing.
    dome: f32,
    /// Where the lamp hangs.
    lamp: [f32; 3],
    albedo: f32,
    walls_glow: bool,
    unit: f32,
    offset: f32,
    velocity: f32,
}

fn room() -> impl Strategy<Value = Room> {
    let place = || [-2.5..=2.5_f32, -3.5..=-1.0_f32, -2.5..=2.5_f32];
    let emission = prop::option::weighted(0.2, 0.5..=20.0_f32);
    let ball = (place(), 0.2..=1.0_f32, 0..3_usize, emission);
    let unit = prop::sample::select(vec![1e-3_f32, 1.0, 1.0, 1e3]);
    let offset = prop::sample::select(vec![0.0_f32, 0.0, 200.0]);
    let velocity = prop::sample::select(vec![0.0_f32, 0.0, 0.5]);
    let glow = prop::bool::weighted(0.2);
    let shape = (20.0..=200.0_f32, place(), 0.3..=0.9_f32, glow);
    (prop::collection::vec(ball, 0..=6), shape, unit, offset, velocity).prop_map(
        |(balls, (dome, lamp, albedo, walls_glow), unit, offset, velocity)| Room {
            balls,
            dome,
            lamp,
            albedo,
            walls_glow,
            unit,
            offset,
            velocity,
        },
    )
}

impl Room {
    pub(crate) fn scene(&self) -> Scene {
        let Self { unit, offset, .. } = *self;
        let at = |v: Vec3| (v + offset) * unit;
        let eye = at(Vec3::new(0.0, -1.0, 3.8));
        let camera = Camera {
            eye,
            direction: at(Vec3::NEG_Y * 3.0) - eye,
            up: Vec3::Y,
            vertical_fov_degrees: 40.0,
            aperture_radius: 0.0,
            focus_distance: 1.0,
            shutter: [0.0, 1.0],
        };
        let materials = vec![
            Material::Diffuse { albedo: Rgb::new(self.albedo, 0.6, 0.5) },
            Material::Dielectric { albedo: Rgb::new(1.0, 0.9, 1.0), ior: 1.5 },
            Material::Specular { albedo: Rgb::splat(0.9) },
        ];
        let mut spheres = Vec::new();
        let mut add = |center: Vec3, radius: f32, material: u32, emission: f32, velocity: f32| {
            spheres.push(Sphere {
                center: at(center),
                velocity: Vec3::X * velocity * unit,
                radius: radius * unit,
                material,
                emission: Rgb::new(emission, 0.8 * emission, 0.5 * emission),
            });
        };
        let far = 1000.0;
        for axis in [Vec3::X, Vec3::NEG_X, Vec3::Z, Vec3::NEG_Z, Vec3::NEG_Y] {
            let glow = if self.walls_glow && axis == Vec3::X { 0.1 } else { 0.0 };
            add(axis * (far + 4.0), far, 0, glow, 0.0);
        }
        add(Vec3::Y * (self.dome - 5.0), self.dome, 0, 0.0, 0.0);
        add(Vec3::from(self.lamp) + Vec3::Y * 2.0, 0.3, 0, 30.0, 0.0);
        for (place, radius, material, emission) in &self.balls {
            add(Vec3::from(*place), *radius, *material as u32, emission.unwrap_or(0.0), self.velocity);
        }
        Scene {
            name: "a room".into(),
            camera,
            materials,
            spheres: spheres.into(),
            background: Rgb::ZERO,
            transparent_background: false,
            imports: Vec::new(),
            settings: Settings::default(),
        }
    }
}

pub(crate) fn case() -> impl Strategy<Value = (Room, Settings)> {
    // With fewer photons than these none are guided as they leave.
    let photons = prop_oneof![1 => 1000..8192_u32, 3 => 20_000..50_000_u32];
    let depth = prop_oneof![4 => 3..=8_u32, 1 => Just(24)];
    (room(), 1..=24_u32, 1..=20_u32, photons, depth, any::<u64>()).prop_map(
        |(room, width, height, photons_per_iteration, max_depth, seed)| {
            let initial_radius = 0.3 * room.unit;
            let settings = Settings {
                width,
                height,
                iterations: 2,
                photons_per_iteration,
                max_depth,
                initial_radius,
                seed,
                ..Settings::default()
            };
            (room, settings)
        },
    )
}
