//! Numbers of a role are spread more evenly than unrelated ones would be: those of a pixel over the iterations, and those of the
//! photons of an iteration. If some were not, every mean would stay what it is, and images would be noisier.

use super::camera::{half_mirror, shells};
use super::photons::{covered, shell};
use super::{hemisphere_numbers, sphere_numbers};
use crate::cases::tell;
use crate::harness::{BLACK, Build, diffuse, empty_scene, pinhole, render_path, run, settings};
use glam::DVec3;
use reference::Sppm;
use reference::emission::{Emitted, emit};
use reference::photon_numbers::PhotonNumbers;
use reference::photon_pass::{Deposit, photon_pass};
use scene::aim::{Aim, Target, Targets};
use scene::guide::{Guide, RUN, SIDE, SURFACES};
use scene::ray::SphereId;
use scene::{Film, Rgb, Scene, Settings, Stats, Still, Vec3};
use std::f64::consts::PI;
use std::ops::Range;
use std::sync::Arc;

/// Iterations of a pixel, for each of so many seeds.
const ITERATIONS: u32 = 256;
const SEEDS: u32 = 16;

/// Of 256 unrelated numbers the count of those in one half deviates by 8, and the root mean square of 16 such deviations is below
/// this in one of a thousand cases. Those of evenly spread numbers are at most 3, and their root mean square is about 1.
const EVEN: f64 = 4.0;

type Render = fn(&Scene, &Settings) -> Film;

fn render_sppm(scene: &Scene, settings: &Settings) -> Film {
    run(Sppm::new(scene, settings).aimed_at(Targets::default()), settings)
}

/// The root mean square deviation of the number of iterations in which the path of a pixel brings light: it brings `light` with
/// probability `share`, and else none.
fn deviation(render: Render, (scene, depth): (&Scene, u32), share: f64, light: f64) -> f64 {
    let squares = (1..=SEEDS).map(|seed| {
        let settings =
            Settings { seed: seed.into(), iterations: ITERATIONS, ..settings(1, 1, 1, depth, 1.0) };
        let mean = f64::from(render(scene, &settings).pixels[0].x) / light;
        ((mean - share) * f64::from(ITERATIONS)).powi(2)
    });
    (squares.sum::<f64>() / f64::from(SEEDS)).sqrt()
}

/// Of the first four segments from the eye, and of paths of the first two.
#[test]
fn choices_at_glass_are_spread_evenly_over_the_iterations() {
    // The eye is in the glass, so what is outside is brighter by the square of the index.
    let light = f64::from(half_mirror()).powi(2);
    let renders: [(&str, Render, u32); 2] = [("SPPM", render_sppm, 4), ("path tracer", render_path, 2)];
    for (name, render, segments) in renders {
        for segment in 0..segments {
            let (scene, depth) = shells(segment);
            let found = deviation(render, (&scene, depth), 0.5, light);
            assert!(found < EVEN, "{name}, segment {segment}: {found}");
        }
    }
    tell("physics", 6 * SEEDS as usize, "pixels with choices at glass");
}

/// The top of a white ball in a shell that glows, of which a black ball hides a part: overhead by the height of the direction, and to
/// one side by its turn.
#[test]
fn directions_from_the_first_surface_are_spread_evenly_over_the_iterations() {
    let lit = |eye: Vec3| {
        empty_scene(pinhole(eye, Vec3::ZERO, 1e-3)).lamp(Vec3::ZERO, 100.0, BLACK, Rgb::ONE).ball(
            Vec3::NEG_Z,
            1.0,
            diffuse(1.0),
        )
    };
    // The share of a ball overhead is the square of its sine. That of a ball whose middle is at the horizon is known as well.
    let overhead = lit(Vec3::new(0.0, 9.0, 0.5)).ball(Vec3::Z * 3.0, 3.0 * 0.5_f32.sqrt(), BLACK);
    let beside = lit(Vec3::Z * 30.0).ball(Vec3::X * 10.0, 9.99, BLACK);
    let sine: f64 = 0.999;
    let hidden = (sine.asin() - sine * (1.0 - sine * sine).sqrt()) / PI;
    for (what, scene, share) in [("overhead", overhead, 0.5), ("beside", beside, 1.0 - hidden)] {
        let found = deviation(render_path, (&scene, 2), share, 1.0);
        assert!(found < EVEN, "{what}: {found}");
    }
    tell("physics", 2 * SEEDS as usize, "pixels with directions from the first surface");
}

/// Photons of an iteration: a power of two, so each class of a stratified number has as many.
const PHOTONS: u32 = 4096;
const CLASSES: usize = 16;

/// Numbers next to the border of a class may be rounded into the next one. Counts of unrelated numbers deviate from 256 by 15.
const FURTHEST: u32 = 6;

#[track_caller]
fn assert_even<const N: usize>(numbers: impl Iterator<Item = [f64; N]>, what: &str) {
    let mut counts = [[0_u32; CLASSES]; N];
    for numbers in numbers {
        for (counts, number) in counts.iter_mut().zip(numbers) {
            counts[((number * CLASSES as f64) as usize).min(CLASSES - 1)] += 1;
        }
    }
    let each = PHOTONS / CLASSES as u32;
    assert!(counts.iter().flatten().all(|count| count.abs_diff(each) <= FURTHEST), "{what}: {counts:?}");
}

/// Photons with these numbers, as they leave their lamps.
fn emitted(still: &Still, aim: &Aim, iteration: u32, photons: Range<u32>) -> impl Iterator<Item = Emitted> {
    let numbers = PhotonNumbers::new(1, iteration);
    photons.filter_map(move |photon| emit(still, aim, &numbers, photon))
}

#[test]
fn photons_leave_lamps_evenly() {
    let (center, none) = (Vec3::new(2.0, -1.0, 3.0), Aim::default());
    let scene = shell(0.0).lamp(center, 1.0, BLACK, Rgb::ONE);
    let still = scene.at(0.0);
    for iteration in [0, 5] {
        let numbers = emitted(&still, &none, iteration, 0..PHOTONS).map(|Emitted { ray, .. }| {
            let normal = (ray.origin - center).as_dvec3().normalize();
            let ([a, b], [c, d]) =
                (sphere_numbers(normal), hemisphere_numbers(normal, ray.direction.as_dvec3()));
            [a, b, c, d]
        });
        assert_even(numbers, "starts and directions");
    }
    let two = scene.clone().lamp(-center, 1.0, BLACK, Rgb::ONE);
    assert_half_leave(&two.at(0.0), &none, 0..PHOTONS, 1);
}

/// Expects half of these photons to leave the lamp that is sphere `lamp`, in every iteration.
#[track_caller]
fn assert_half_leave(still: &Still, aim: &Aim, photons: Range<u32>, lamp: SphereId) {
    for iteration in 0..8 {
        let all = emitted(still, aim, iteration, photons.clone());
        let found = all.filter(|emitted| emitted.ray.leaves == lamp).count() as u32;
        assert!(found.abs_diff(PHOTONS / 2) <= FURTHEST, "{found} leave the first of two lamps");
    }
}

/// Photons leave a tiny lamp in the middle of a shell, which reflects them once: by two numbers, and by another if it is grey.
#[test]
fn photons_leave_the_first_surface_evenly() {
    let landed = |albedo: f32, iteration: u32| {
        let (scene, mut landed) = (covered(shell(albedo), 0), Vec::new());
        let (still, settings) = (scene.at(0.0), settings(1, 1, PHOTONS, 2, 1.0));
        let (none, mut stats) = (Aim::default(), Stats::default());
        photon_pass(&still, &none, &settings, iteration, 0..PHOTONS, &mut stats, |deposit, _| {
            landed.push(*deposit);
        });
        // A few meet the lamp.
        landed.retain(|deposit| deposit.sphere == 0);
        landed
    };
    for iteration in [0, 5] {
        let numbers = landed(1.0, iteration).into_iter().map(|Deposit { point, wi, .. }| {
            let (point, wi) = (point.as_dvec3(), wi.as_dvec3());
            let before: DVec3 = point - wi * (2.0 * point.dot(wi));
            hemisphere_numbers(-before.normalize(), -wi)
        });
        assert_even(numbers, "directions from the shell");
        let survivors = landed(0.5, iteration).len() as u32;
        assert!(survivors.abs_diff(PHOTONS / 2) <= FURTHEST, "{survivors} of {PHOTONS} survive");
    }
}

/// Half of the photons, which are uniform, and the other half.
fn aimed_at(ball: Target) -> Targets {
    Targets { balls: vec![ball], middle: 0, shares: vec![0.5, 0.5], expected: 0.0, guide: None }
}

/// Of a sky, through a ball in a cap of directions; and of two lamps within the ball, of which each sends as many.
#[test]
fn photons_are_aimed_evenly() {
    let height = 0.7;
    let sky = empty_scene(pinhole(Vec3::Z * 9.0, Vec3::ZERO, 30.0)).lamp(
        Vec3::new(3.0, -4.0, 5.0),
        50.0,
        BLACK,
        Rgb::ONE,
    );
    let still = sky.at(0.0);
    let target = Target { axis: Vec3::Z, height, ..Target::ball(Vec3::new(1.0, 2.0, 3.0), 0.7) };
    let aim = Aim::new(&still, &aimed_at(target), 2 * PHOTONS);
    assert_eq!(aim.ends, [PHOTONS, 2 * PHOTONS]);
    let numbers = emitted(&still, &aim, 0, PHOTONS..2 * PHOTONS).map(|Emitted { ray, .. }| {
        let (f, d) = ((ray.origin - target.center).as_dvec3(), ray.direction.as_dvec3());
        let from_axis = (f - d * f.dot(d)) / f64::from(target.radius);
        [(1.0 - d.z) / f64::from(height), sphere_numbers(d)[1], from_axis.length_squared()]
    });
    assert_even(numbers, "lines of the sky");
    let lamps = empty_scene(pinhole(Vec3::Z * 99.0, Vec3::ZERO, 30.0))
        .lamp(Vec3::X * 5.0, 1.0, BLACK, Rgb::ONE)
        .lamp(Vec3::NEG_X * 5.0, 1.0, BLACK, Rgb::ONE);
    let still = lamps.at(0.0);
    let aim = Aim::new(&still, &aimed_at(Target::ball(Vec3::ZERO, 20.0)), 2 * PHOTONS);
    assert_half_leave(&still, &aim, PHOTONS..2 * PHOTONS, 0);
}

/// Photons that leave into one cell of directions do so in runs, of which each has one photon in every sixteenth of either number.
#[test]
fn guided_photons_leave_lamps_evenly() {
    /// Runs with a number that is rounded into the next sixteenth.
    const ROUNDED: usize = 8;
    assert_eq!(RUN as usize, CLASSES);
    let scene = shell(0.0).lamp(Vec3::new(2.0, -1.0, 3.0), 1.0, BLACK, Rgb::ONE);
    let still = scene.at(0.0);
    let shares = [[1.0 / (SIDE * SIDE) as f64; SIDE]; SIDE];
    let guide = Guide::of_shares(Vec3::ZERO, 1.0, (0..SURFACES).map(|_| shares), &shares);
    let targets = Targets { guide: Some(Arc::new(guide)), ..Targets::default() };
    let aim = Aim::new(&still, &targets, 2 * PHOTONS);
    let departures = aim.departures.as_ref().unwrap();
    let numbers = PhotonNumbers::new(1, 0);
    let mut uneven = 0;
    for first in (0..2 * PHOTONS).step_by(CLASSES) {
        let corner = departures.cell(first).corner;
        let mut seen = [[false; CLASSES]; 2];
        for photon in first..first + RUN {
            let ray = emit(&still, &aim, &numbers, photon).unwrap().ray;
            let places = sphere_numbers(ray.direction.as_dvec3()).map(|number| number * SIDE as f64);
            for ((seen, place), corner) in seen.iter_mut().zip(places).zip(corner) {
                let class = ((place - f64::from(corner)) * CLASSES as f64).max(0.0) as usize;
                seen[class.min(CLASSES - 1)] = true;
            }
        }
        uneven += usize::from(seen.iter().flatten().any(|seen| !seen));
    }
    assert!(uneven <= ROUNDED, "{uneven} runs are uneven");
    tell("physics", 2 * PHOTONS as usize, "directions of guided photons");
}
