//! Whole iterations of photon mapping, beside what its definition makes of the same paths and photons by brute force in `f64`.

use crate::cases::tell;
use crate::clearance;
use crate::grid::room;
use crate::harness::{BLACK, Build, diffuse, glass};
use glam::DVec3;
use reference::Sppm;
use reference::camera_pass::{CameraNumbers, camera_ray, trace};
use reference::photon_pass::{Deposit, photon_pass};
use reference::survey::survey;
use scene::aim::{Aim, Targets};
use scene::film::FLUX_ONE;
use scene::ray::SphereId;
use scene::{
    Engine, ExactSums, Film, Filter, FirstRadii, RadiusSchedule, Resumable, Rgb, Scene, Settings, Stats,
    Still, Stop, Vec3,
};
use std::f64::consts::PI;
use std::ops::Range;

const ALPHA: f64 = 2.0 / 3.0;

/// Roundings of `f32` over the iterations.
const ROUNDING: f64 = 2e-4;

/// A pixel as the paper has it; with global radii `tau` is the sum of the iterations' estimates.
#[derive(Clone, Copy)]
struct Pixel {
    direct: DVec3,
    tau: DVec3,
    n: f64,
    radius_squared: f64,
}

/// A render by its definition.
struct Definition<'a> {
    scene: &'a Scene,
    settings: Settings,
    targets: Targets,
    pixels: Vec<Pixel>,
    done: u32,
}

impl<'a> Definition<'a> {
    fn new(scene: &'a Scene, settings: &Settings, targets: &Targets, radii: &FirstRadii) -> Self {
        let size = (settings.width, settings.height);
        let pixel = |index: u32| {
            let radius = f64::from(radii.at((index % size.0, index / size.0), size));
            Pixel { direct: DVec3::ZERO, tau: DVec3::ZERO, n: 0.0, radius_squared: radius * radius }
        };
        let pixels = (0..size.0 * size.1).map(pixel).collect();
        Self { scene, settings: *settings, targets: targets.clone(), pixels, done: 0 }
    }

    fn is_global(&self) -> bool {
        self.settings.radius_schedule == RadiusSchedule::Global
    }

    fn iterate(&mut self) {
        let (scene, settings, iteration) = (self.scene, self.settings, self.done);
        let is_global = self.is_global();
        let still = scene.at(scene.camera.shutter_time(settings.seed, iteration));
        let aim = Aim::new(&still, &self.targets, settings.photons_per_iteration);
        let (mut stats, mut deposits) = (Stats::default(), Vec::<Deposit>::new());
        let photons = 0..settings.photons_per_iteration;
        photon_pass(&still, &aim, &settings, iteration, photons, &mut stats, |deposit, _| {
            deposits.push(*deposit);
        });
        let unit = f64::from(still.lights.power) / f64::from(FLUX_ONE) / f64::from(aim.scale());
        let frame = scene.camera.frame(settings.width, settings.height);
        let table = settings.filter.table();
        for (index, pixel) in self.pixels.iter_mut().enumerate() {
            let (x, y) = (index as u32 % settings.width, index as u32 / settings.width);
            let mut numbers = CameraNumbers::new(&settings, iteration, x, y);
            let ray = camera_ray(&frame, table, x, y, &numbers);
            let sample = trace(&still, ray, settings.max_depth, &mut numbers, &mut stats);
            pixel.direct += sample.direct.as_dvec3();
            let (mut m, mut phi) = (0.0, DVec3::ZERO);
            let mut radius_squared = pixel.radius_squared;
            if let Some(visible) = sample.visible {
                if pixel.n == 0.0 && settings.radius_clearance > 0.0 {
                    let limit = limit(&settings, &still, (visible.point, visible.sphere));
                    radius_squared = radius_squared.min(limit * limit);
                }
                let is_near = |d: &&Deposit| {
                    let distance = (d.point - visible.point).as_dvec3();
                    distance.length_squared() < radius_squared && d.wi.dot(visible.normal) > 0.0
                };
                for deposit in deposits.iter().filter(is_near) {
                    m += 1.0;
                    phi += DVec3::from_array(deposit.flux.values().map(|flux| flux as f64 * unit));
                }
                phi *= visible.beta.as_dvec3();
            }
            if is_global {
                let all = f64::from(settings.photons_per_iteration);
                pixel.tau += phi / (all * PI * pixel.radius_squared);
                pixel.n += m;
                let i = f64::from(iteration + 1);
                pixel.radius_squared *= (i + ALPHA) / (i + 1.0);
            } else if m > 0.0 {
                let ratio = (pixel.n + ALPHA * m) / (pixel.n + m);
                pixel.tau = (pixel.tau + phi) * ratio;
                pixel.radius_squared = radius_squared * ratio;
                pixel.n += ALPHA * m;
            }
        }
        self.done += 1;
    }

    fn radiance(&self, pixel: &Pixel) -> DVec3 {
        let n = f64::from(self.done);
        let photons = n * f64::from(self.settings.photons_per_iteration);
        let indirect =
            if self.is_global() { pixel.tau / n } else { pixel.tau / (photons * PI * pixel.radius_squared) };
        pixel.direct / n + indirect
    }

    /// Expects the engine to have the same radii, counts and image.
    #[track_caller]
    fn assert_same(&self, engine: &Sppm, what: &str) {
        // A photon exactly at the rim may count on one side and not on the other; none of these does.
        for (index, pixel) in self.pixels.iter().enumerate() {
            let (x, y) = (index as u32 % self.settings.width, index as u32 / self.settings.width);
            let found = engine.probe(x, y);
            let at = format!("{what}: pixel {x}, {y} after {} iterations", self.done);
            let radius = pixel.radius_squared.sqrt();
            assert!(
                (f64::from(found.radius) / radius - 1.0).abs() < ROUNDING,
                "{at}: {found:?}, not {radius}"
            );
            assert!((f64::from(found.count) - pixel.n).abs() <= ROUNDING * pixel.n, "{at}: {found:?}");
            let (expected, radiance) = (self.radiance(pixel), found.radiance.as_dvec3());
            let error = (radiance - expected).abs().max_element();
            assert!(
                error <= ROUNDING * (expected.abs().max_element() + 0.1),
                "{at}: {radiance}, not {expected}"
            );
        }
    }
}

/// What clearance limits the radius to at a point of sphere `own`.
fn limit(settings: &Settings, still: &Still, (point, own): (Vec3, SphereId)) -> f64 {
    let others = still.spheres.iter().enumerate().filter(|(id, _)| *id != own as usize);
    let of = |sphere| clearance::limit(sphere, point, settings.radius_clearance, settings.initial_radius);
    others.map(|(_, sphere)| of(sphere)).fold(f64::INFINITY, f64::min)
}

/// First radii that differ from pixel to pixel and along both axes: those that would be chosen where photons are noise at the left,
/// light bends at the right, and both are below.
fn uneven_radii(settings: &Settings) -> FirstRadii {
    let chosen = FirstRadii::choose(&Settings { radius_pilots: 1, ..*settings }, &Stop::new(), |pilot, _| {
        let share = pilot.initial_radius / settings.initial_radius;
        let noise = |x: u32, y: u32| {
            let mixed = (pilot.seed ^ u64::from(x * 131 + y * 57)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            ((mixed >> 60) as f32 - 7.5) * 0.01 / share
        };
        let bias = |x: u32, y: u32| match (x > pilot.width / 2, y > pilot.height / 2) {
            (true, _) => 0.5,
            (false, true) => 0.05,
            (false, false) => 0.0,
        };
        let pixel = |x, y| Rgb::splat(1.0 + bias(x, y) * share * share + noise(x, y));
        Some(Film::from_fn(pilot.width, pilot.height, pixel))
    });
    chosen.unwrap()
}

/// In motion, through a filter that is negative in places.
fn moving_room() -> Scene {
    let mut scene = room();
    scene.camera.shutter = [0.0, 2.0];
    for (k, sphere) in scene.spheres.iter_mut().filter(|sphere| sphere.radius < 1e3).enumerate() {
        sphere.velocity = Vec3::new(0.4, -0.2, 0.3) * if k % 2 == 0 { 1.0 } else { -0.7 };
    }
    scene
}

/// A second lamp, which a ball hides while the shutter opens: so the power of all lamps is another from instant to instant.
fn room_with_a_lamp_that_comes_out() -> Scene {
    let at = Vec3::new(-4.0, 4.0, 0.0);
    let mut scene = room().ball(at, 2.0, diffuse(0.5)).lamp(at, 1.0, BLACK, Rgb::new(10.0, 30.0, 60.0));
    scene.camera.shutter = [0.0, 2.0];
    scene.spheres.last_mut().unwrap().velocity = Vec3::new(1.0, -1.0, 0.5);
    assert_eq!([0.0, 2.0].map(|time| scene.at(time).lights.entries.len()), [1, 2]);
    scene
}

#[test]
fn iterations_are_what_the_definition_makes_of_their_paths_and_photons() {
    const ITERATIONS: u32 = 4;
    let size = crate::harness::settings(17, 13, 3000, 6, 1.5);
    let global = Settings { radius_schedule: RadiusSchedule::Global, ..size };
    let filtered = Settings { filter: Filter::Mitchell, light_samples: 3, ..size };
    let (still, moving, coming) = (room(), moving_room(), room_with_a_lamp_that_comes_out());
    // On a ball no wider than the search radius, photons arrive within it from behind.
    let with_ball = room().ball(Vec3::new(0.0, -2.0, 3.0), 1.0, diffuse(0.7));
    let even = FirstRadii::even(1.5);
    let uneven = uneven_radii(&size);
    let places = [(0, 0), (16, 0), (0, 12), (16, 12)].map(|place| uneven.at(place, (17, 13)));
    assert!(places[0] != places[1] && places[0] != places[2] && places[1] != places[2], "{places:?}");
    for (what, scene, settings, radii) in [
        ("radii per pixel", &still, size, &even),
        ("global radii", &still, global, &even),
        ("in motion", &moving, size, &even),
        ("global, in motion", &moving, Settings { filter: Filter::Gaussian, ..global }, &even),
        ("on a small ball", &with_ball, size, &even),
        ("filtered", &still, filtered, &even),
        ("global, filtered", &still, Settings { filter: Filter::Mitchell, ..global }, &even),
        ("limited by half of what is near", &still, Settings { radius_clearance: 0.5, ..size }, &even),
        ("limited by more, in motion", &moving, Settings { radius_clearance: 3.0, ..size }, &even),
        ("uneven first radii", &still, size, &uneven),
        ("with a lamp that comes out", &coming, size, &even),
        ("global, with a lamp that comes out", &coming, global, &even),
    ] {
        let targets = survey(scene, &settings);
        let mut definition = Definition::new(scene, &settings, &targets, radii);
        let mut engine = Sppm::new(scene, &settings);
        if !std::ptr::eq(radii, &raw const even) {
            engine = engine.beginning_with(radii.clone());
        }
        for _ in 0..ITERATIONS {
            definition.iterate();
            engine.iterate();
            definition.assert_same(&engine, what);
        }
        let counted: f64 = definition.pixels.iter().map(|pixel| pixel.n).sum();
        assert!(counted > 100.0, "{what}: too few photons for a test, {counted}");
    }
    tell("physics", 12 * 17 * 13 * ITERATIONS as usize, "pixels that are those of the definition");
}

/// Pilots are renders of the same method and of the same light, of as many iterations as are asked for.
#[test]
fn pilots_are_renders_of_as_many_iterations_as_they_have() {
    type Render = for<'a> fn(&'a Scene, &Settings) -> Sppm<'a>;
    let of_all: Render = |scene, settings| Sppm::new(scene, settings);
    let of_caustics: Render = |scene, settings| Sppm::new(scene, settings).of_caustics();
    let scene = room().ball(Vec3::new(0.0, -2.0, 3.0), 1.0, glass(1.0, 1.5));
    for (render, pilots) in [(of_all, 1), (of_all, 3), (of_caustics, 1)] {
        let settings = Settings { radius_pilots: pilots, ..crate::harness::settings(17, 13, 1000, 5, 2.0) };
        let radii = FirstRadii::choose(&settings, &Stop::new(), |settings, _| {
            let mut pilot = render(&scene, settings);
            (0..settings.iterations).for_each(|_| pilot.iterate());
            assert_eq!(settings.iterations, pilots);
            Some(pilot.develop())
        });
        let radii = radii.unwrap();
        let (mut found, mut expected) =
            (render(&scene, &settings), render(&scene, &settings).beginning_with(radii));
        (0..2).for_each(|_| {
            found.iterate();
            expected.iterate();
        });
        assert!(found.develop() == expected.develop(), "{pilots} iterations of each pilot");
        assert!(found.radius() == expected.radius(), "{pilots} iterations of each pilot");
    }
}

/// With global radii a part of a render, begun at any iteration, has the radii and the instants of these iterations; its image is
/// their mean, and its sums are what they add to the whole.
#[test]
fn parts_of_a_render_have_the_radii_of_their_iterations_and_add_up_to_it() {
    let mut moving = room();
    for (k, sphere) in moving.spheres.iter_mut().enumerate().skip(1) {
        sphere.velocity = 0.1 * Vec3::new(1.0, -1.0, k as f32);
    }
    moving.camera.shutter = [0.0, 1.0];
    // In the third, pixels see the lamp in a mirror and in glass by several rays, which each iteration has of its own.
    for (scene, glint_samples) in [(room(), 1), (moving, 1), (room(), 32)] {
        parts_add_up(&scene, glint_samples);
    }
}

fn parts_add_up(scene: &Scene, glint_samples: u32) {
    const ITERATIONS: u32 = 7;
    let settings = Settings {
        radius_schedule: RadiusSchedule::Global,
        glint_samples,
        ..crate::harness::settings(17, 13, 3000, 6, 1.5)
    };
    let part = |iterations: Range<u32>| {
        let mut engine = Sppm::new(scene, &settings);
        engine.skip_to(iterations.start);
        let radius = f64::from(engine.probe(0, 0).radius);
        let shrunk: f64 =
            (0..iterations.start).map(f64::from).map(|i| (i + 1.0 + ALPHA) / (i + 2.0)).product();
        let expected = f64::from(settings.initial_radius) * shrunk.sqrt();
        assert!(
            (radius / expected - 1.0).abs() < ROUNDING,
            "{radius}, not {expected}, from {iterations:?} on"
        );
        iterations.for_each(|_| engine.iterate());
        engine
    };
    let sums = |engine: &Sppm| -> Vec<ExactSums> {
        let mut row = vec![0; 17 * ExactSums::WORDS];
        let rows = (0..13).flat_map(|y| {
            engine.save_row(y, &mut row);
            row.as_chunks().0.iter().map(|words| ExactSums::from_words(*words)).collect::<Vec<_>>()
        });
        rows.collect()
    };
    let whole = part(0..ITERATIONS);
    for middle in [1, 3, 6] {
        let parts = [part(0..middle), part(middle..ITERATIONS)];
        let (mut first, second) = (sums(&parts[0]), sums(&parts[1]));
        first.iter_mut().zip(&second).for_each(|(sum, other)| sum.add(other));
        assert!(first == sums(&whole), "parts before and after {middle}");
        for (x, y) in (0..13).flat_map(|y| (0..17).map(move |x| (x, y))) {
            let [a, b, all] =
                [&parts[0], &parts[1], &whole].map(|engine| engine.probe(x, y).radiance.as_dvec3());
            let (of_a, of_all) = (f64::from(middle), f64::from(ITERATIONS));
            let expected = (all * of_all - a * of_a) / (of_all - of_a);
            let error = (b - expected).abs().max_element();
            assert!(
                error <= ROUNDING * (all.max_element() + 0.1),
                "{x}, {y} from {middle} on: {b}, not {expected}"
            );
        }
    }
}
