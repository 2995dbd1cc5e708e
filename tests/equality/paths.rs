//! The path tracers: the fast one gives the reference's bits. Random scenes are in `random_scenes.rs`.

use crate::pair::{MOST_THREADS, Way, all_lanes, assert_equal, assert_equal_paths, tell};
use fast::Parameters;
use files::builtin::{SCENES, scene};
use files::scene_file::parse;
use scene::settings::{MAX_DEPTH, MAX_GLINT_SAMPLES, MAX_LIGHT_SAMPLES};
use scene::{Filter, Scene, Settings};
use std::fmt::Write;

fn small(name: &str) -> (Scene, Settings) {
    let scene = scene(name).unwrap();
    let settings = Settings { width: 20, height: 15, iterations: 2, ..scene.settings };
    (scene, settings)
}

#[test]
fn built_in_scenes() {
    let mut cases = 0;
    for builtin in SCENES {
        let scene = builtin.scene();
        let settings = Settings { width: 52, height: 39, iterations: 3, ..scene.settings };
        let ways: Vec<_> = [1, 2].into_iter().flat_map(all_lanes).collect();
        cases += assert_equal_paths(&scene, &settings, &ways);
    }
    tell(cases, "built-in scenes by paths");
}

/// Partial tiles, and batches and work items that are not full.
#[test]
fn sizes() {
    let (scene, settings) = small("focus");
    let sizes = [(1, 1), (7, 3), (8, 8), (9, 8), (17, 33), (65, 7), (1, 200), (257, 2), (96, 80)];
    let mut cases = 0;
    for (number, (width, height)) in sizes.into_iter().enumerate() {
        let settings = Settings { width, height, ..settings };
        cases += assert_equal_paths(&scene, &settings, &all_lanes(1 + number % MOST_THREADS));
    }
    tell(cases, "several sizes by paths");
}

#[test]
fn depths() {
    let mut cases = 0;
    for name in ["mirror", "motion"] {
        let (scene, settings) = small(name);
        for max_depth in (1..=12).chain([64, MAX_DEPTH]) {
            cases += assert_equal_paths(&scene, &Settings { max_depth, ..settings }, &all_lanes(2));
        }
    }
    tell(cases, "depths by paths");
}

/// A list of points that is worked off in the midst of a stage, and one that holds a single packet.
#[test]
fn light_samples() {
    let mut cases = 0;
    for name in ["random", "mirror"] {
        let (scene, settings) = small(name);
        for light_samples in [2, 3, 7, MAX_LIGHT_SAMPLES] {
            cases += assert_equal_paths(&scene, &Settings { light_samples, ..settings }, &all_lanes(2));
        }
    }
    tell(cases, "light samples by paths");
}

/// Rims of lamps, mirrors and glass; work items of more rays than a batch holds.
#[test]
fn glint_samples() {
    let mut cases = 0;
    for name in ["mirror", "dusk", "focus"] {
        let (scene, settings) = small(name);
        for glint_samples in [2, 3, 8, MAX_GLINT_SAMPLES] {
            for filter in [Filter::Box, Filter::Mitchell] {
                let settings = Settings { glint_samples, filter, ..settings };
                cases += assert_equal_paths(&scene, &settings, &all_lanes(2));
            }
        }
    }
    tell(cases, "rays that see lamps by paths");
}

/// A wide lamp behind the eye, and mirrors that are narrower than a pixel: often the own path alone meets one, and what it brings stays.
#[test]
fn glints_of_the_own_path() {
    let mut text = "background = [0, 0, 0]\n\
        camera = { eye = [0, 0, 0], direction = [0, 0, -1], vertical_fov_degrees = 40 }\n\
        [[sphere]]\ncenter = [0, 0, 60]\nradius = 50\nemission = [1, 2, 3]\n\
        material = { type = \"diffuse\", albedo = [0, 0, 0] }\n"
        .to_owned();
    for (i, j) in (-11..=11).flat_map(|i| (-9..=9).map(move |j| (i, j))) {
        let (x, y, z) = (0.21 * f64::from(i), 0.19 * f64::from(j), -5.0 - 0.1 * f64::from((i * j) % 3));
        write!(
            text,
            "[[sphere]]\ncenter = [{x}, {y}, {z}]\nradius = 0.06\n\
             material = {{ type = \"specular\", albedo = [0.9, 0.8, 0.7] }}\n"
        )
        .unwrap();
    }
    let scene = parse("mirrors.toml", &text).unwrap();
    let mut cases = 0;
    for filter in [Filter::Gaussian, Filter::Mitchell] {
        for glint_samples in [2, 3] {
            let settings =
                Settings { width: 20, height: 15, iterations: 3, glint_samples, filter, ..scene.settings };
            cases += assert_equal_paths(&scene, &settings, &all_lanes(1));
            cases +=
                assert_equal(&scene, &Settings { photons_per_iteration: 500, ..settings }, &all_lanes(1));
        }
    }
    tell(cases, "glints that further rays miss");
}

#[test]
fn filters() {
    let (scene, settings) = small("cornell");
    let mut cases = 0;
    for filter in [Filter::Box, Filter::Gaussian, Filter::Mitchell] {
        cases += assert_equal_paths(&scene, &Settings { filter, ..settings }, &all_lanes(1));
    }
    tell(cases, "filters by paths");
}

/// The parameters that the path tracer reads, at either end of their ranges.
#[test]
fn parameters() {
    let names = ["pixels_per_batch", "pixels_per_job", "most_balls_in_turn", "most_balls_in_clusters"];
    let mut cases = 0;
    for (scene, settings) in ["random", "motion"].map(small) {
        for parameter in Parameters::ALL.iter().filter(|parameter| names.contains(&parameter.name)) {
            for end in [parameter.least, parameter.most] {
                let parameters = Parameters::default().with(parameter.name, end).unwrap();
                let ways: Vec<_> = all_lanes(2).into_iter().map(|way| Way { parameters, ..way }).collect();
                cases += assert_equal_paths(&scene, &settings, &ways);
            }
        }
    }
    tell(cases, "free parameters by paths");
}

/// Scenes without spheres or light, which only a program can build.
#[test]
fn nothing_to_see_and_nothing_that_glows() {
    let (whole, settings) = small("surgery");
    let mut dark = whole.clone();
    dark.spheres.iter_mut().for_each(|sphere| sphere.emission = scene::Rgb::ZERO);
    let empty = Scene { spheres: Vec::new().into(), materials: Vec::new(), ..whole };
    let cases = [dark, empty].map(|scene| assert_equal_paths(&scene, &settings, &all_lanes(2)));
    tell(cases.into_iter().sum(), "nothing by paths");
}
