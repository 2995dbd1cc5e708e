//! With keyed random numbers and integer flux, every row must give the same bits as the reference.

use crate::cases::tell;
use crate::pair::{assert_exact, builtin};
use ladder::{Options, ROWS, Row};
use scene::Settings;

fn all_rows() -> Vec<&'static Row> {
    ROWS.iter().collect()
}

#[test]
fn builtin_scenes() {
    for about in files::builtin::SCENES {
        let (scene, settings) = builtin(about.name);
        assert_exact(&scene, &settings, &all_rows(), &Options::exact());
    }
    tell("ladder", files::builtin::SCENES.len() * ROWS.len(), "built-in scenes, by all rows, on bits");
}

/// Image sizes at which the published program fails: those whose number of bins divides a difference of its hashes, and
/// those that leave lanes without a pixel.
#[test]
fn sizes() {
    let (scene, settings) = builtin("cornell");
    for (width, height) in [(48, 27), (36, 30), (1, 1), (7, 3), (8, 8), (9, 8), (1, 17), (16, 16), (257, 2)] {
        let settings = Settings { width, height, initial_radius: 20.0, ..settings };
        assert_exact(&scene, &settings, &all_rows(), &Options::exact());
    }
}

/// Lamps so faint that a flux of 1 is less than the least normal `f32`.
#[test]
fn faint_lamps() {
    let (mut scene, settings) = builtin("cornell");
    for sphere in &mut scene.spheres {
        sphere.emission *= 1e-38;
    }
    let settings = Settings { initial_radius: 20.0, ..settings };
    assert_exact(&scene, &settings, &all_rows(), &Options::exact());
}

#[test]
fn depths_and_photons() {
    let (scene, settings) = builtin("mirror");
    for (max_depth, photons_per_iteration) in [(1, 100), (2, 1), (3, 7), (8, 8), (24, 1001)] {
        let settings = Settings { max_depth, photons_per_iteration, initial_radius: 200.0, ..settings };
        let expects_photons = max_depth > 1 && photons_per_iteration > 8;
        if expects_photons || max_depth == 1 {
            assert_exact(&scene, &settings, &all_rows(), &Options::exact());
        }
    }
}
