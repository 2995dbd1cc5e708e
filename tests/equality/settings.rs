//! Depth, photons and seed.

use crate::pair::{MOST_THREADS, all_lanes, assert_equal, scaled, tell};
use scene::settings::MAX_DEPTH;
use scene::{Engine, Film, Rgb, Scene, Settings, Sphere};

fn builtin(name: &str) -> (Scene, Settings) {
    let scene = files::builtin::scene(name).unwrap();
    let settings = Settings {
        width: 20,
        height: 15,
        iterations: 2,
        photons_per_iteration: 400,
        initial_radius: 12.0,
        ..scene.settings
    };
    (scene, settings)
}

#[test]
fn depths() {
    let mut cases = 0;
    for name in ["mirror", "motion"] {
        let (scene, settings) = builtin(name);
        for max_depth in (1..=64).chain([200, MAX_DEPTH]) {
            let threads = 1 + max_depth as usize % MOST_THREADS;
            cases += assert_equal(&scene, &Settings { max_depth, ..settings }, &all_lanes(threads));
        }
    }
    tell(cases, "depths 1 to 64 and beyond");
}

#[test]
fn photons() {
    let mut cases = 0;
    for name in ["cornell", "surgery"] {
        let (scene, settings) = builtin(name);
        for photons_per_iteration in [1, 7, 8, 15, 16, 17, 255, 256, 257, 4095, 4096, 4097] {
            let settings = Settings { photons_per_iteration, ..settings };
            cases += assert_equal(&scene, &settings, &all_lanes(1));
            cases += assert_equal(&scene, &settings, &all_lanes(2));
        }
    }
    tell(cases, "1 to 4097 photons");
}

#[test]
fn seeds() {
    let (scene, settings) = builtin("large");
    let mut cases = 0;
    for seed in (0..u64::from(scaled(16))).map(|i| i.wrapping_mul(0x9e37_79b9_7f4a_7c15)).chain([1, u64::MAX])
    {
        cases += assert_equal(&scene, &Settings { seed, ..settings }, &all_lanes(2));
    }
    tell(cases, "seeds");
}

/// More photons at a point than a sum of 32 bits holds.
#[test]
fn many_photons_at_a_point() {
    let mut cases = 0;
    for name in ["cornell", "focus"] {
        let (scene, settings) = builtin(name);
        // Pixels of one block of 4x4, and pixels far apart in space.
        for (width, height) in [(4, 4), (2, 9)] {
            let settings =
                Settings { width, height, photons_per_iteration: 20_000, initial_radius: 1e3, ..settings };
            cases += assert_equal(&scene, &settings, &all_lanes(1));
        }
    }
    tell(cases, "many photons at a point");
}

/// Down to where radiance is subnormal and up to where powers leave the range of `f32`.
#[test]
fn units_of_light() {
    let mut cases = 0;
    for exponent in [-118, -100, -50, 50, 100] {
        let (mut scene, settings) = builtin("cornell");
        for sphere in &mut scene.spheres {
            sphere.emission *= f32::powi(2.0, exponent);
        }
        // One channel without light, too.
        scene.spheres.iter_mut().for_each(|sphere| sphere.emission.y = 0.0);
        assert!(scene.at(0.0).lights.power.is_normal());
        cases += assert_equal(&scene, &settings, &all_lanes(1));
    }
    tell(cases, "units of light");
}

/// Scenes that no file states, but a program may build: black, by both engines.
#[test]
fn nothing_to_see_and_nothing_that_glows() {
    let (whole, settings) = builtin("surgery");
    let dark: Vec<Sphere> =
        whole.spheres.iter().map(|sphere| Sphere { emission: Rgb::ZERO, ..*sphere }).collect();
    let mut cases = 0;
    for (spheres, materials) in
        [(vec![], vec![]), (vec![], whole.materials.clone()), (dark, whole.materials.clone())]
    {
        let scene = Scene { spheres, materials, ..whole.clone() };
        cases += assert_equal(&scene, &settings, &all_lanes(2));
        let mut engine = reference::Sppm::new(&scene, &settings);
        engine.iterate();
        assert_eq!(engine.develop(), Film::new(settings.width, settings.height));
    }
    tell(cases, "nothing");
}
