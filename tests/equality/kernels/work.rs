//! Counts the work that the engine does for an image. The image does not depend on it, so no other test would notice if
//! culling became less effective. If a change to these counts is intended, explain it and update the numbers.

use super::inputs::{scattered, scene_of};
use super::tell;
use fast::{Intersector, LaneKind, Search, Sppm};
use scene::ray::NO_SPHERE;
use scene::{Engine, Settings, Vec3};

/// Relative tolerance: back ends may use fused multiply-add in culling tests, which rounds some of them differently.
const NEAR: f64 = 2e-3;

#[track_caller]
fn assert_near(actual: &[u64], expected: &[u64], what: &str) {
    let is_near = |(&a, &e): (&u64, &u64)| (a as f64 - e as f64).abs() <= NEAR * e as f64;
    assert!(actual.len() == expected.len() && actual.iter().zip(expected).all(is_near), "{what}: {actual:?}");
}

/// Boxes and balls tested for nearest hits, then those tested for short shadow rays.
#[test]
fn searches_try_few_balls() {
    let cases = [
        (60, Search::Clusters, [1702, 748, 1434, 607]),
        (1000, Search::Clusters, [3692, 1799, 2009, 890]),
        (1000, Search::Tree, [3322, 1049, 2201, 677]),
        (20_000, Search::Tree, [5321, 1445, 3119, 811]),
    ];
    for (count, search, expected) in cases {
        // An incomplete last packet, and some shadow rays with a negative limit, which cannot hit anything.
        let (spheres, rays) = scattered(count, 1, 997, 900);
        let scene = scene_of(spheres, Vec3::splat(1e3));
        let still = scene.at(0.0);
        let intersector = Intersector::with_search(&still, LaneKind::Emulated, search);
        let limits: Vec<f32> = (0..rays.len()).map(|k| if k % 7 == 0 { -1.0 } else { 2.0 }).collect();
        let lamps = vec![NO_SPHERE; rays.len()];
        let work = intersector.work(&rays, &limits, &lamps).map(|work| [work.boxes, work.balls]);
        assert_near(work.as_flattened(), &expected, &format!("{count} balls, {search:?}"));
    }
    tell(cases.len(), "searches' work");
}

/// Pairs whose distance is tested, and deposits kept.
#[test]
fn joins_test_few_pairs() {
    let cases = [
        ("cornell", [1_267_764, 24_584]),
        ("large", [148_623, 2545]),
        ("mirror", [83_803, 3144]),
        ("random", [415_021, 8724]),
        ("surgery", [214_197, 4133]),
    ];
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    for (name, expected) in cases {
        let scene = files::builtin::scene(name).unwrap();
        let settings = Settings {
            width: 128,
            height: 96,
            photons_per_iteration: 20_000,
            initial_radius: 2.0,
            ..scene.settings
        };
        let mut engine = Sppm::with_lanes(&scene, &settings, LaneKind::Emulated);
        one_thread.install(|| (0..3).for_each(|_| engine.iterate()));
        let stats = engine.stats();
        assert_near(&[stats.candidates, engine.kept() as u64], &expected, name);
    }
    tell(cases.len(), "joins' work");
}
