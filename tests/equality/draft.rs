//! Generates random scenes for property tests. Each is written as a scene file and parsed by `files::scene_file`, so
//! that only scenes are rendered that a user could render, and a failing scene can be kept as a file.

use crate::placement::{Placement, among_others, around_all, log_uniform, point};
use files::scene_file;
use proptest::prelude::*;
use scene::settings::{MAX_GLINT_SAMPLES, MAX_LIGHT_SAMPLES, RADIUS_RANGE};
use scene::{Filter, Material, RadiusSchedule, Rgb, Scene, Settings, Vec3};
use std::fmt::Write;

/// A random scene, which need not be valid.
#[derive(Clone, Debug)]
struct Draft {
    eye: Eye,
    target: Vec3,
    fov: f32,
    aperture: f32,
    focus: f32,
    shutter: [f32; 2],
    background: Option<Rgb>,
    /// In the order of the file.
    spheres: Vec<Ball>,
    /// The whole scene is scaled by this factor and moved by the offset.
    unit: f32,
    offset: Vec3,
}

#[derive(Clone, Debug)]
enum Eye {
    At(Vec3),
    /// At an offset from the centre of a sphere, in units of its radius. This puts the eye inside glass, shells and
    /// lamps.
    In(prop::sample::Index, Vec3),
}

#[derive(Clone, Debug)]
struct Ball {
    placement: Placement,
    material: Material,
    /// Radiance times the squared radius, so that lamps of all sizes get a share of the photons.
    intensity: Option<Rgb>,
    velocity: Option<Vec3>,
}

/// A valid random scene with its scene file, and settings with which it renders within milliseconds.
#[derive(Clone)]
pub(crate) struct Case {
    text: String,
    pub(crate) scene: Scene,
    pub(crate) settings: Settings,
}

impl std::fmt::Debug for Case {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:?}\n{}", self.settings, self.text)
    }
}

/// Random scenes of `spheres` spheres, plus up to six walls and shells around them.
pub(crate) fn case(spheres: impl Into<prop::collection::SizeRange>) -> impl Strategy<Value = Case> {
    (draft(spheres), settings()).prop_filter_map("the scene is not valid", |(draft, settings)| {
        let [low, high] = RADIUS_RANGE;
        let initial_radius = (settings.initial_radius * draft.unit).clamp(low, high);
        let settings = Settings { initial_radius, ..settings };
        let text = draft.to_toml();
        let scene = scene_file::parse("random.toml", &text).ok()?;
        Some(Case { text, scene, settings })
    })
}

fn settings() -> impl Strategy<Value = Settings> {
    let few = prop_oneof![Just(1), Just(7), 1..255_u32];
    let photons = prop_oneof![1 => few, 1 => 255..=257_u32, 3 => 300..1500_u32, 1 => Just(4097)];
    let depth = prop_oneof![8 => 1..8_u32, 1 => Just(24)];
    let any_radius = log_uniform(1e-15, 1e15);
    let radius = prop_oneof![1 => any_radius, 4 => log_uniform(1e-3, 300.0), 12 => log_uniform(0.3, 10.0)];
    let size = || prop_oneof![4 => 1..20_u32, 1 => Just(8), 1 => Just(16)];
    let filter =
        prop_oneof![2 => Just(Filter::Box), 1 => Just(Filter::Gaussian), 1 => Just(Filter::Mitchell)];
    let pilots = prop_oneof![5 => Just(0), 1 => 1..3_u32];
    let clearance = prop_oneof![3 => Just(0.0), 2 => log_uniform(0.1, 10.0)];
    let samples = prop_oneof![3 => Just(1), 1 => 2..=MAX_LIGHT_SAMPLES];
    let glints = prop_oneof![3 => Just(1), 2 => 2..=8_u32, 1 => Just(MAX_GLINT_SAMPLES)];
    let radii = (radius, pilots, clearance);
    (size(), size(), 1..4_u32, photons, depth, (radii, samples), any::<u64>(), (filter, glints)).prop_map(
        |(
            width,
            height,
            iterations,
            photons_per_iteration,
            max_depth,
            ((initial_radius, pilots, clearance), light_samples),
            seed,
            (filter, glint_samples),
        )| {
            // Too small a radius has no eighth.
            let (radius_pilots, radius_clearance) =
                if initial_radius < 1e-9 { (0, 0.0) } else { (pilots, clearance) };
            Settings {
                width,
                height,
                iterations,
                photons_per_iteration,
                max_depth,
                initial_radius,
                seed,
                filter,
                radius_schedule: RadiusSchedule::PerPixel,
                radius_pilots,
                radius_clearance,
                light_samples,
                glint_samples,
            }
        },
    )
}

fn draft(spheres: impl Into<prop::collection::SizeRange>) -> impl Strategy<Value = Draft> {
    let eye = prop_oneof![
        4 => point(4.0).prop_map(Eye::At),
        1 => (any::<prop::sample::Index>(), point(0.5)).prop_map(|(i, v)| Eye::In(i, v)),
    ];
    let fov = prop_oneof![8 => 5.0..150.0_f32, 1 => 0.001..179.9_f32];
    let camera = (eye, point(3.0), fov, rarely(log_uniform(0.01, 1.0)), log_uniform(0.5, 30.0));
    let shutter = prop_oneof![Just([0.0, 1.0]), Just([0.0, 0.0]), Just([-1.0, 0.5]), Just([0.75, 0.75])];
    let unit = prop_oneof![6 => Just(1.0), 1 => log_uniform(1e-4, 1e4)];
    let offset = prop_oneof![6 => Just(Vec3::ZERO), 1 => point(300.0)];
    let room = prop::collection::vec(ball(around_all(), 0.1), 0..=6);
    let things = prop::collection::vec(ball(among_others(), 0.3), spheres);
    let spheres = (room, things, any::<bool>()).prop_map(|(room, things, room_first)| {
        if room_first { [room, things].concat() } else { [things, room].concat() }
    });
    (camera, shutter, rarely(color()), spheres, unit, offset).prop_map(
        |((eye, target, fov, aperture, focus), shutter, background, spheres, unit, offset)| Draft {
            eye,
            target,
            fov,
            aperture: aperture.unwrap_or(0.0),
            focus,
            shutter,
            background,
            spheres,
            unit,
            offset,
        },
    )
}

fn rarely<T: Strategy>(what: T) -> impl Strategy<Value = Option<T::Value>>
where
    T::Value: Clone,
{
    prop::option::weighted(0.25, what)
}

fn ball(placement: impl Strategy<Value = Placement>, glows: f64) -> impl Strategy<Value = Ball> {
    let velocity = prop::option::weighted(0.15, point(1.0));
    let intensity = prop::option::weighted(glows, color());
    (placement, material(), intensity, velocity).prop_map(|(placement, material, intensity, velocity)| Ball {
        placement,
        material,
        intensity,
        velocity,
    })
}

fn material() -> impl Strategy<Value = Material> {
    let ior = prop_oneof![Just(1.0), Just(1.5), 1.0..3.0_f32, Just(100.0)];
    prop_oneof![
        4 => albedo().prop_map(|albedo| Material::Diffuse { albedo }),
        2 => albedo().prop_map(|albedo| Material::Specular { albedo }),
        2 => (albedo(), ior).prop_map(|(albedo, ior)| Material::Dielectric { albedo, ior }),
    ]
}

/// Black, white, and random colours, some with channels that are zero.
fn albedo() -> impl Strategy<Value = Rgb> {
    let channel =
        || prop_oneof![2 => Just(0.0), 2 => Just(1.0), 8 => 0.0..=1.0_f32, 1 => log_uniform(1e-38, 1e-3)];
    prop_oneof![
        1 => Just(Rgb::ZERO),
        2 => Just(Rgb::ONE),
        5 => [channel(), channel(), channel()].prop_map(Rgb::from_array),
    ]
}

/// Radiance of any strength, sometimes with channels that are zero.
fn color() -> impl Strategy<Value = Rgb> {
    let channel = || prop_oneof![1 => Just(0.0), 4 => 0.0..1.0_f32];
    let strength = prop_oneof![16 => Just(1.0), 3 => log_uniform(1e-6, 1e6), 1 => log_uniform(1e-37, 1e30)];
    ([channel(), channel(), channel()], strength)
        .prop_map(|(color, strength)| Rgb::from_array(color) * strength)
}

impl Draft {
    fn to_toml(&self) -> String {
        let mut balls: Vec<(Vec3, f32)> = Vec::new();
        for ball in &self.spheres {
            balls.push(ball.placement.resolve(&balls));
        }
        let place = |p: Vec3| array(p * self.unit + self.offset * self.unit);
        let eye = match &self.eye {
            Eye::At(eye) => *eye,
            Eye::In(index, offset) => {
                let (center, radius) = *index.get(&balls);
                center + *offset * radius
            }
        };
        let mut text = String::new();
        if let Some(background) = self.background {
            writeln!(text, "background = {}", array(background)).unwrap();
        }
        writeln!(text, "[camera]\neye = {}\ntarget = {}", place(eye), place(self.target)).unwrap();
        writeln!(text, "vertical_fov_degrees = {:?}", self.fov).unwrap();
        writeln!(text, "aperture_radius = {:?}", self.aperture * self.unit).unwrap();
        writeln!(text, "focus_distance = {:?}\nshutter = {:?}", self.focus * self.unit, self.shutter)
            .unwrap();
        for (ball, (center, radius)) in self.spheres.iter().zip(&balls) {
            writeln!(text, "[[sphere]]\ncenter = {}\nradius = {:?}", place(*center), radius * self.unit)
                .unwrap();
            writeln!(text, "material = {}", material_text(&ball.material)).unwrap();
            if let Some(intensity) = ball.intensity {
                writeln!(text, "emission = {}", array(intensity / (radius * radius))).unwrap();
            }
            if let Some(velocity) = ball.velocity {
                writeln!(text, "velocity = {}", array(velocity * self.unit)).unwrap();
            }
        }
        text
    }
}

fn array(v: Vec3) -> String {
    format!("{:?}", v.to_array())
}

fn material_text(material: &Material) -> String {
    let (kind, ior) = match material {
        Material::Diffuse { .. } => ("diffuse", String::new()),
        Material::Specular { .. } => ("specular", String::new()),
        Material::Dielectric { ior, .. } => ("dielectric", format!(", ior = {ior:?}")),
    };
    format!("{{ type = \"{kind}\", albedo = {}{ior} }}", array(material.albedo()))
}
