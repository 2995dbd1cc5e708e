//! Unit tests of the passes in order.

use super::*;
use scene::Engine;
use scene::{Rgb, Sphere};

#[test]
fn cells_shrink_as_more_photons_count() {
    assert_eq!([1.0, 16.0, 1e9].map(|neighbours| fitting_cells(5.0, neighbours)), [5.0, 2.5, 1.0]);
    assert_eq!(fitting_cells(12.0, 0.0), 6.0);
}

#[test]
fn typical_radii_are_those_of_pixels_that_count_photons() {
    let pixel = |n, radius: f32| Row([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, n, radius * radius]);
    // In three chunks, the last of which is short.
    let mut pixels = vec![pixel(0.0, 9.0); 2 * RADII_AT_ONCE + 5];
    for at in [1, RADII_AT_ONCE + 2, 2 * RADII_AT_ONCE] {
        pixels[at] = pixel(3.0, 2.0);
    }
    let Radii { largest, typical } = Radii::of(&pixels);
    assert_eq!((largest, typical), (9.0, 2.0));
    let Radii { largest, typical } = Radii::of(&pixels[3..9]);
    assert_eq!((largest, typical), (9.0, 9.0));
}

#[test]
fn cells_fit_the_typical_radius_but_hold_the_largest_in_a_window() {
    assert_eq!(Radii { largest: 1.0, typical: 0.5 }.cell(5.0), 2.5);
    assert_eq!(Radii { largest: 10.0, typical: 0.5 }.cell(5.0), 4.0);
}

#[test]
fn points_are_trusted_to_a_few_roundings_of_the_largest_coordinate_of_a_ball() {
    let sphere = |x: f32, radius| Sphere {
        center: Vec3::new(x, 1.0, 2.0),
        velocity: Vec3::ZERO,
        radius,
        material: 0,
        emission: Rgb::ZERO,
    };
    let bound = |balls: &[Sphere]| {
        let mut scene = files::builtin::scene("cornell").unwrap();
        // Walls do not count.
        scene.spheres.retain(|sphere| sphere.radius > 1e3);
        scene.spheres.extend_from_slice(balls);
        rounding_of_points(&scene.at(0.0))
    };
    assert_eq!(bound(&[]), 0.0);
    let roundings = |largest: f32| 4.0 * f32::EPSILON * largest..16.0 * f32::EPSILON * largest;
    assert!(roundings(40.0).contains(&bound(&[sphere(-30.0, 10.0), sphere(5.0, 20.0)])));
    assert!(roundings(302.0).contains(&bound(&[sphere(-300.0, 2.0), sphere(5.0, 20.0)])));
}

/// Per iteration, on one thread: the pairs tested, the bytes held, and whether the next join will be long.
fn iterations(mut engine: Sppm, count: u32) -> Vec<(u64, u64, Option<bool>)> {
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let iteration = |_| {
        let before = engine.stats().candidates;
        one_thread.install(|| engine.iterate());
        (engine.stats().candidates - before, engine.stats().bytes, engine.has_long_joins)
    };
    (0..count).map(iteration).collect()
}

/// Sums of all pixels are held for a join that is long, as the last one tells.
#[test]
fn a_join_is_long_after_one_that_tested_many_pairs() {
    let scene = files::builtin::scene("cornell").unwrap();
    let settings = Settings { width: 64, height: 48, photons_per_iteration: 20_000, ..scene.settings };
    let engine = || Sppm::new(&scene, &settings);
    let short = iterations(engine(), 3);
    assert!(short.iter().all(|iteration| iteration.2 == Some(false)));
    let most = short.iter().map(|iteration| iteration.0).max().unwrap();
    assert_eq!(iterations(engine().long_join(most + 1), 3), short);
    let sums = size_of::<Sums>() as u64 * 64 * 48 / GROUP as u64;
    let from_the_second = iterations(engine().long_join(1), 3);
    let always = iterations(engine().long_join(0), 3);
    for (number, iteration) in short.iter().enumerate() {
        let (pairs, bytes, _) = *iteration;
        let held = if number > 0 { bytes + sums } else { bytes };
        assert_eq!(from_the_second[number], (pairs, held, Some(true)));
        assert_eq!(always[number], (pairs, bytes + sums, Some(true)));
    }
}

/// The first join is long if there are many deposits, as no other has told.
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
