//! Unit tests of whole iterations.

use super::render::{Parts, Sppm};
use crate::hierarchy::Hierarchy;
use crate::join::GroupSums;
use crate::parameters::Parameters;
use crate::pixels::GROUP;
use crate::search::Search;
use lanes::LaneKind;
use scene::still::Role;
use scene::{Engine, Rgb, Scene, Settings, Stats, Vec3};
use std::time::Instant;

/// Per iteration, on one thread: the pairs tested, the bytes held, and whether the next join will be long.
fn iterations(mut engine: Sppm, count: u32) -> Vec<(u64, u64, Option<bool>)> {
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let iteration = |_| {
        let before = engine.stats().candidates;
        one_thread.install(|| engine.iterate());
        (engine.stats().candidates - before, engine.stats().bytes, engine.join.was_long)
    };
    (0..count).map(iteration).collect()
}

/// Sums of all pixels are held if the last join was long.
#[test]
fn a_join_is_long_after_one_that_tested_many_pairs() {
    let scene = files::builtin::scene("cornell").unwrap();
    let settings = Settings { width: 64, height: 48, photons_per_iteration: 20_000, ..scene.settings };
    let engine = || Sppm::new(&scene, &settings);
    let short = iterations(engine(), 3);
    assert!(short.iter().all(|iteration| iteration.2 == Some(false)));
    let most = short.iter().map(|iteration| iteration.0).max().unwrap();
    assert_eq!(iterations(engine().long_join(most + 1), 3), short);
    let sums = size_of::<GroupSums>() as u64 * 64 * 48 / GROUP as u64;
    let from_the_second = iterations(engine().long_join(1), 3);
    let always = iterations(engine().long_join(0), 3);
    for (number, iteration) in short.iter().enumerate() {
        let (pairs, bytes, _) = *iteration;
        let held = if number > 0 { bytes + sums } else { bytes };
        assert_eq!(from_the_second[number], (pairs, held, Some(true)));
        assert_eq!(always[number], (pairs, bytes + sums, Some(true)));
    }
}

/// The first join is long if there are many deposits.
#[test]
fn a_first_join_is_long_where_there_are_many_deposits() {
    let scene = files::builtin::scene("cornell").unwrap();
    let bytes = |photons, long_join: Option<u64>| {
        let settings = Settings {
            width: 16,
            height: 16,
            photons_per_iteration: photons,
            initial_radius: 20.0,
            ..scene.settings
        };
        let engine = Sppm::new(&scene, &settings);
        iterations(if let Some(pairs) = long_join { engine.long_join(pairs) } else { engine }, 1)[0].1
    };
    assert!(bytes(10_000, None) < bytes(10_000, Some(0)));
    assert_eq!(bytes(1 << 20, None), bytes(1 << 20, Some(0)));
}

#[test]
fn seconds_of_passes_add_up_to_no_more_than_all() {
    let scene = files::builtin::scene("cornell").unwrap();
    let settings = Settings { width: 40, height: 30, photons_per_iteration: 5000, ..scene.settings };
    let began = Instant::now();
    let mut engine = Sppm::new(&scene, &settings);
    for _ in 0..3 {
        engine.iterate();
        let all = began.elapsed().as_secs_f64();
        let Stats { camera_seconds, build_grid_seconds, photon_seconds, consolidate_seconds, .. } =
            *engine.stats();
        let passes = [camera_seconds, build_grid_seconds, photon_seconds, consolidate_seconds];
        assert!(passes.iter().all(|&seconds| seconds > 0.0), "{passes:?}");
        assert!(passes.iter().sum::<f64>() <= all, "{passes:?} in {all}");
    }
}

/// Camera, materials, sizes and spheres change from render to render; the parts go on.
#[test]
fn an_image_does_not_depend_on_the_parts_of_renders_before() {
    let small = Settings { width: 24, height: 17, photons_per_iteration: 3000, ..Settings::default() };
    let mut scene = files::builtin::scene("random").unwrap();
    let mut parts = Parts::default();
    let changes: [fn(&mut Scene, &mut Settings); 6] = [
        |_, _| {},
        |scene, _| scene.camera.eye.x += 1.0,
        |scene, _| scene.materials.rotate_left(1),
        |_, settings| settings.width = 40,
        |scene, _| scene.spheres.swap(7, 8),
        |scene, settings| (scene.spheres[9].radius, settings.height) = (scene.spheres[9].radius * 0.5, 9),
    ];
    let mut settings = small;
    for (number, change) in changes.into_iter().enumerate() {
        change(&mut scene, &mut settings);
        let image = |parts| {
            let (lanes, parameters) = (LaneKind::best(), Parameters::default());
            let mut engine = Sppm::with_parts(&scene, &settings, lanes, &parameters, parts);
            engine.iterate();
            engine.iterate();
            (engine.develop(), engine.into_parts())
        };
        let (fresh, _) = image(Parts::default());
        let (warm, used) = image(parts);
        assert_eq!(warm, fresh, "after change {number}");
        parts = used;
    }
}

/// A hierarchy is used again exactly if it holds the same balls.
#[test]
fn a_hierarchy_is_of_the_balls_that_it_was_built_for() {
    let scene = files::builtin::scene("random").unwrap();
    let reused = |scene: &Scene| {
        let built = |scene: &Scene| Hierarchy::with_search(&scene.at(0.0), Search::Clusters);
        let old = built(&files::builtin::scene("random").unwrap());
        old.is_of(&scene.at(0.0), Search::Clusters)
    };
    assert!(reused(&scene));
    let ball = ball_of(&scene);
    let changes: [fn(&mut Scene, usize); 4] = [
        |scene, ball| scene.spheres[ball].center.x += 1.0,
        |scene, ball| scene.spheres[ball].radius *= 1.5,
        |scene, ball| _ = scene.spheres.remove(ball),
        |scene, ball| scene.spheres.extend_from_within(ball..=ball),
    ];
    for change in changes {
        let mut other = scene.clone();
        change(&mut other, ball);
        assert!(!reused(&other));
    }
    let mut recoloured = scene.clone();
    recoloured.spheres[ball].emission = Rgb::ONE;
    recoloured.camera.eye += Vec3::splat(0.5);
    assert!(reused(&recoloured));
}

/// A sphere that is met from outside.
fn ball_of(scene: &Scene) -> usize {
    let still = scene.at(0.0);
    still.roles.iter().rposition(|role| *role == Role::Solid).unwrap()
}
