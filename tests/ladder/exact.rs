//! With keyed random numbers and integer flux, every row must give the same bits as the reference.

use crate::cases::tell;
use crate::difference::Outcome;
use crate::pair::{References, assert_exact, builtin, first_difference};
use ladder::{Options, ROWS, Row, Tuning, find};
use scene::{Material, Rgb, Scene, Settings, Sphere};

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

/// A point that is seen in one channel alone has a throughput that is zero in the others.
#[test]
fn mirrors_of_pure_colours() {
    let (scene, settings) = builtin("cornell");
    let settings = Settings { width: 24, height: 18, photons_per_iteration: 600, ..settings };
    for colour in [Rgb::X, Rgb::Y, Rgb::Z] {
        let mut scene = scene.clone();
        for material in &mut scene.materials {
            if let Material::Specular { albedo } = material {
                *albedo = colour;
            }
        }
        assert_exact(&scene, &settings, &all_rows(), &Options::exact());
    }
}

/// With cells smaller than the radius and larger ones, bins that begin without room, and an image of many blocks.
#[test]
fn parameters_of_indices() {
    let (scene, settings) = builtin("cornell");
    let rows = ["0", "1", "2", "6", "sorted", "blocked"].map(|name| find(name).unwrap());
    for (cell_size, first_capacity, block) in [(0.7, 0, 16), (5.0, 3, 64), (1.0, 1, 100)] {
        let tuning = Tuning { cell_size, first_capacity, block };
        let settings = Settings { photons_per_iteration: 600, ..settings };
        assert_exact(&scene, &settings, &rows, &Options { tuning, ..Options::exact() });
    }
}

#[test]
fn rows_that_have_not_begun_are_black() {
    let (scene, settings) = builtin("cornell");
    let references = References::new(&scene, &settings);
    for row in ROWS {
        let rung = row.start(&scene, &settings, &Options::exact());
        let difference = references.of(row).difference(&Outcome::of(&*rung));
        assert_eq!(difference, None, "row {}", row.name);
    }
}

/// Scenes without spheres or light, which only a program can build.
#[test]
fn nothing_to_see_and_nothing_that_glows() {
    let (whole, settings) = builtin("surgery");
    let settings = Settings { width: 11, height: 5, photons_per_iteration: 50, ..settings };
    let dark: Vec<Sphere> =
        whole.spheres.iter().map(|sphere| Sphere { emission: Rgb::ZERO, ..*sphere }).collect();
    for spheres in [vec![], dark] {
        let scene = Scene { spheres: spheres.into(), ..whole.clone() };
        assert_eq!(first_difference(&scene, &settings, &all_rows(), &Options::exact()), Ok(0));
    }
}
