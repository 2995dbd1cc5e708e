//! The scenes of the corpus: those of the equality tests, drawn from fixed seeds.

use super::render::{Found, Method};
use crate::draft::{self, Case};
use crate::{open, room};
use files::scene_file;
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use scene::{Filter, Material, RadiusSchedule, Rgb, Scene, Settings, Sphere, Vec3};

/// Kinds of scenes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Family {
    /// Up to a dozen spheres in a room.
    Few,
    /// Some dozens.
    Some,
    /// With global radii.
    Global,
    /// By path tracing.
    Paths,
    /// Open scenes, in which photons are aimed.
    Open,
    /// Closed rooms, in which photons are guided.
    Rooms,
    /// Open scenes with many lamps.
    Lamps,
    /// The background alone, of which alpha is made.
    Alpha,
    /// Settings that are chosen.
    Choice,
}

/// How many of each, in their order.
const FAMILIES: [(Family, u32); 9] = [
    (Family::Few, 76),
    (Family::Some, 16),
    (Family::Global, 22),
    (Family::Paths, 44),
    (Family::Open, 40),
    (Family::Rooms, 20),
    (Family::Lamps, 14),
    (Family::Alpha, 6),
    (Family::Choice, 12),
];

impl Family {
    /// How many scenes there are.
    pub(super) fn total() -> u32 {
        FAMILIES.iter().map(|(_, count)| count).sum()
    }

    fn of(number: u32) -> Self {
        let mut before = 0;
        let found = FAMILIES.iter().find(|(_, count)| {
            before += count;
            number < before
        });
        found.expect("there are fewer scenes").0
    }
}

/// A scene of the corpus with its settings.
pub(super) struct Sample {
    pub(super) number: u32,
    family: Family,
    pub(super) scene: Scene,
    pub(super) settings: Settings,
    pub(super) method: Method,
    /// Whether its line tells if photons are aimed or guided.
    pub(super) tells_aim: bool,
}

/// The scene of this number.
pub(super) fn sample(number: u32) -> Sample {
    let family = Family::of(number);
    let mut seed = [0; 32];
    seed[..4].copy_from_slice(&number.to_le_bytes());
    let rng = TestRng::from_seed(RngAlgorithm::ChaCha, &seed);
    let mut dice = TestRunner::new_with_rng(Config { max_local_rejects: u32::MAX, ..Config::default() }, rng);
    let of = |Case { scene, settings, .. }: Case| (scene, settings);
    let (scene, settings) = match family {
        Family::Few => of(draw(draft::case(1..=12), &mut dice)),
        Family::Some => of(draw(draft::case(13..=60), &mut dice)),
        Family::Global => {
            let (scene, settings) = of(draw(draft::case(1..=20), &mut dice));
            (scene, global(settings))
        }
        Family::Paths => of(draw(draft::case(1..=16), &mut dice)),
        Family::Open => with_others(draw(open::case(1..=12), &mut dice), &mut dice),
        Family::Rooms => guided_room(&mut dice),
        Family::Lamps => lamps(number, &mut dice),
        Family::Alpha => {
            let (scene, settings) = of(draw(draft::case(1..=12), &mut dice));
            (scene.background_alone(), Settings { photons_per_iteration: 1, ..settings })
        }
        Family::Choice => with_others(draw(open::case(1..=6), &mut dice), &mut dice),
    };
    let method = match family {
        Family::Choice => Method::Choice,
        Family::Paths => Method::Path,
        Family::Alpha if number.is_multiple_of(2) => Method::Path,
        _ => Method::Sppm,
    };
    let tells_aim = matches!(family, Family::Open | Family::Rooms | Family::Lamps);
    Sample { number, family, scene, settings, method, tells_aim }
}

fn draw<S: Strategy>(strategy: S, dice: &mut TestRunner) -> S::Value {
    strategy.new_tree(dice).expect("no scene is valid").current()
}

fn global(settings: Settings) -> Settings {
    Settings { radius_schedule: RadiusSchedule::Global, radius_pilots: 0, radius_clearance: 0.0, ..settings }
}

/// An open scene, with other settings in which the scenes of that kind do not differ, and more photons that count.
fn with_others((_, scene, settings): (String, Scene, Settings), dice: &mut TestRunner) -> (Scene, Settings) {
    let filter = prop::sample::select(Filter::ALL.to_vec());
    let others = (filter, any::<bool>(), prop::sample::select(vec![0.0_f32, 0.7]), 1..=3_u32);
    let (filter, is_global, radius_clearance, light_samples) = draw(others, dice);
    let photons_per_iteration = 2 * settings.photons_per_iteration + 1000;
    let initial_radius = 4.0 * settings.initial_radius;
    let max_depth = settings.max_depth + 2;
    let settings = Settings {
        filter,
        light_samples,
        radius_clearance,
        photons_per_iteration,
        initial_radius,
        max_depth,
        ..settings
    };
    (scene, if is_global { global(settings) } else { settings })
}

/// A room with just enough photons to be guided as they leave lamps too.
fn guided_room(dice: &mut TestRunner) -> (Scene, Settings) {
    let (room, settings) = draw(room::case(), dice);
    (room.scene(), Settings { photons_per_iteration: settings.photons_per_iteration.min(9001), ..settings })
}

/// An open scene below a lattice of lamps of different powers, every fourth of glass: dozens of them, or in the last more than
/// are aimed one by one.
fn lamps(number: u32, dice: &mut TestRunner) -> (Scene, Settings) {
    let (scene, settings) = with_others(draw(open::case(1..=6), dice), dice);
    let count = if number.is_multiple_of(8) { 1100 } else { 17 + 31 * (number % 8) };
    let unit = settings.initial_radius / 8.0;
    let eye = scene.camera.eye;
    let mut scene = Scene { background: Rgb::ZERO, spheres: scene.without_sky().to_vec().into(), ..scene };
    let material = |wanted: fn(&Material) -> bool| scene.materials.iter().position(wanted).unwrap() as u32;
    let [matt, glass] = [material(|m| matches!(m, Material::Diffuse { .. })), scene.materials.len() as u32];
    scene.materials.push(Material::Dielectric { albedo: Rgb::new(0.9, 1.0, 0.8), ior: 1.4 });
    for k in 0..count {
        let place = Vec3::new((k % 12) as f32 - 6.0, 1.0 + (k % 7) as f32, -((k / 12) as f32)) * (8.0 * unit);
        let emission = Rgb::new(1.0 + (k % 3) as f32, 2.0, (k % 5) as f32);
        let (radius, material) = (unit * (0.5 + (k % 4) as f32 / 2.0), if k % 4 == 3 { glass } else { matt });
        scene.spheres.push(Sphere { center: eye + place, velocity: Vec3::ZERO, radius, material, emission });
    }
    (scene, settings)
}

impl Sample {
    /// Its number, how it is rendered, and what is in it.
    pub(super) fn title(&self, found: &Found) -> String {
        let Self { number, settings: s, scene, .. } = self;
        let method = match self.method {
            Method::Sppm => "sppm",
            Method::Path => "path",
            Method::Choice => "choice",
        };
        let mut title = format!(
            "{number:03} {} {method} {}x{} {}x{} depth {}",
            format!("{:?}", self.family).to_lowercase(),
            s.width,
            s.height,
            s.iterations,
            s.photons_per_iteration,
            s.max_depth
        );
        let material = |sphere: &Sphere| &scene.materials[sphere.material as usize];
        let any = |is: &dyn Fn(&Sphere) -> bool| scene.without_sky().iter().any(is);
        let glass = |sphere: &Sphere| !material(sphere).is_opaque();
        let has_photons = self.method != Method::Path;
        let words = [
            ("glass", any(&glass)),
            ("glowing-glass", any(&|sphere| glass(sphere) && sphere.is_emitter())),
            ("mirror", any(&|sphere| matches!(material(sphere), Material::Specular { .. }))),
            ("sky", scene.background != Rgb::ZERO),
            ("lens", scene.camera.aperture_radius > 0.0),
            ("motion", scene.moves()),
            (s.filter.name(), s.filter != Filter::Box),
            ("global", s.radius_schedule == RadiusSchedule::Global),
            ("pilots", has_photons && s.radius_pilots > 0),
            ("clearance", has_photons && s.radius_clearance > 0.0),
            ("samples", s.light_samples > 1),
            ("glints", s.glint_samples > 1),
            (found.photons, !found.photons.is_empty()),
        ];
        for (word, _) in words.into_iter().filter(|(_, is)| *is) {
            title.push(' ');
            title.push_str(word);
        }
        title
    }

    /// Its scene file, with its settings.
    pub(super) fn text(&self) -> String {
        scene_file::to_text(&self.scene, &self.settings)
    }

    pub(super) fn digest(&self) -> u32 {
        crc32fast::hash(self.text().as_bytes())
    }
}
