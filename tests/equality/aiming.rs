//! Open scenes, in which photons are aimed: what they are aimed at, and whole renders.

use crate::cases;
use crate::open::{Open, case};
use crate::pair::{MOST_THREADS, Way, all_lanes, compare, effort, lanes_in_turn, scaled, tell};
use fast::LaneKind;
use fast::kernels;
use files::scene_file;
use proptest::prelude::*;
use proptest::test_runner::TestRunner;
use reference::survey::survey;
use scene::{Rgb, Settings, Sphere, Vec3};
use std::cell::Cell;

/// Compares surveys and renders of `cases` open scenes. In at least a quarter of them photons must be aimed.
fn check(cases: u32, balls: std::ops::RangeInclusive<usize>) {
    let (renders, aimed) = (Cell::new(0), Cell::new(0));
    let result = TestRunner::new(effort(cases)).run(&case(balls), |(text, scene, settings)| {
        let expected = survey(&scene, &settings);
        let ways = lanes_in_turn(1 + settings.seed as usize % MOST_THREADS, settings.seed);
        for Way { lanes, .. } in &ways {
            let actual = kernels::survey(&scene, &settings, *lanes);
            prop_assert_eq!(&actual, &expected, "{:?} in\n{}", lanes, text);
        }
        compare(&scene, &settings, &ways).map_err(|why| TestCaseError::fail(format!("{why}\n{text}")))?;
        renders.set(renders.get() + ways.len());
        aimed.set(aimed.get() + u32::from(!expected.shares.is_empty()));
        Ok(())
    });
    result.unwrap();
    tell(renders.get(), "open scenes");
    cases::tell("equality", renders.get(), "surveys equal the reference");
    assert!(scaled(cases) < cases || aimed.get() > cases / 4, "only {} are aimed", aimed.get());
}

#[test]
fn few_balls() {
    check(250, 1..=6);
}

#[test]
fn many_balls() {
    check(50, 20..=60);
}

/// More lamps than are aimed one by one.
#[test]
fn thousands_of_lamps() {
    let open = Open {
        balls: (0..30_u8)
            .map(|k| {
                ([f32::from(k % 6) - 3.0, f32::from(k / 6) - 2.0], 0.5, 0.45, 0, (k == 7).then_some(3.0))
            })
            .collect(),
        ground: 1e3,
        has_sky: false,
        sun: None,
        towards_sun: [0.0; 2],
        unit: 1.0,
        offset: 0.0,
        velocity: 0.0,
    };
    let mut scene = scene_file::parse("lamps.toml", &open.to_toml()).unwrap();
    for k in 0..3000_u32 {
        let center = Vec3::new((k % 60) as f32 - 30.0, 2.0 + (k % 7) as f32, (k / 60) as f32 - 40.0) * 3.0;
        let emission = Rgb::new(1.0, 2.0, (k % 5) as f32);
        scene.spheres.push(Sphere { center, velocity: Vec3::ZERO, radius: 0.1, material: 0, emission });
    }
    let settings =
        Settings { width: 20, height: 16, iterations: 2, photons_per_iteration: 5000, ..scene.settings };
    let targets = survey(&scene, &settings);
    assert!(!targets.shares.is_empty(), "nothing is aimed: {}", targets.expected);
    compare(&scene, &settings, &all_lanes(2)).unwrap();
    tell(LaneKind::ALL.len(), "a scene of 3000 lamps");
}
