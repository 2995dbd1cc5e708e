//! Various settings: depth, photons, seed, and units of light.

use crate::pair::{MOST_THREADS, all_lanes, assert_equal, scaled, tell};
use scene::settings::{MAX_DEPTH, MAX_GLINT_SAMPLES};
use scene::{Engine, Film, Filter, Rgb, Scene, Settings, Sphere};

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

/// Rims of lamps, mirrors and glass; batches of more rays than paths.
#[test]
fn glint_samples() {
    let mut cases = 0;
    for name in ["mirror", "dusk", "focus"] {
        let (scene, settings) = builtin(name);
        for glint_samples in [2, 3, 8, MAX_GLINT_SAMPLES] {
            for filter in [Filter::Box, Filter::Gaussian] {
                let settings = Settings { glint_samples, filter, ..settings };
                cases += assert_equal(&scene, &settings, &all_lanes(2));
            }
        }
    }
    tell(cases, "rays that see lamps");
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

/// So many photons at a point that sums of flux exceed 32 bits.
#[test]
fn many_photons_at_a_point() {
    let mut cases = 0;
    for name in ["cornell", "focus"] {
        let (scene, settings) = builtin(name);
        // The pixels of one 4x4 block, and pixels that see points far apart.
        for (width, height) in [(4, 4), (2, 9)] {
            let settings =
                Settings { width, height, photons_per_iteration: 20_000, initial_radius: 1e3, ..settings };
            cases += assert_equal(&scene, &settings, &all_lanes(1));
        }
    }
    tell(cases, "many photons at a point");
}

/// From emissions at which radiance is subnormal up to those at which powers almost leave the range of `f32`.
#[test]
fn units_of_light() {
    let mut cases = 0;
    for exponent in [-118, -100, -50, 50, 100] {
        let (mut scene, settings) = builtin("cornell");
        for sphere in &mut scene.spheres {
            sphere.emission *= f32::powi(2.0, exponent);
        }
        // Also without light in one channel.
        scene.spheres.iter_mut().for_each(|sphere| sphere.emission.y = 0.0);
        assert!(scene.at(0.0).lights.power.is_normal());
        cases += assert_equal(&scene, &settings, &all_lanes(1));
    }
    tell(cases, "units of light");
}

/// Scenes without spheres or light, which only a program can build: both engines render black.
#[test]
fn nothing_to_see_and_nothing_that_glows() {
    let (whole, settings) = builtin("surgery");
    let dark: Vec<Sphere> =
        whole.spheres.iter().map(|sphere| Sphere { emission: Rgb::ZERO, ..*sphere }).collect();
    let mut cases = 0;
    for (spheres, materials) in
        [(vec![], vec![]), (vec![], whole.materials.clone()), (dark, whole.materials.clone())]
    {
        let scene = Scene { spheres: spheres.into(), materials, ..whole.clone() };
        cases += assert_equal(&scene, &settings, &all_lanes(2));
        let mut engine = reference::Sppm::new(&scene, &settings);
        engine.iterate();
        assert_eq!(engine.develop(), Film::new(settings.width, settings.height));
    }
    tell(cases, "nothing");
}
