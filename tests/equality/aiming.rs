//! Open scenes, in which photons are aimed: what they are aimed at, and whole renders.

use crate::cases;
use crate::open::{Open, case};
use crate::pair::{MOST_THREADS, all_lanes, compare_aimed_at, compared, effort, lanes_in_turn, scaled, tell};
use fast::LaneKind;
use files::scene_file;
use proptest::prelude::*;
use proptest::test_runner::TestRunner;
use reference::survey::survey;
use scene::aim::Targets;
use scene::{Rgb, Settings, Sphere, Vec3};
use std::cell::Cell;

/// Compares surveys and renders of `cases` open scenes. In at least a quarter of them photons must be aimed.
fn check(cases: u32, balls: std::ops::RangeInclusive<usize>) {
    let (renders, aimed) = (Cell::new(0), Cell::new(0));
    let result = TestRunner::new(effort(cases)).run(&case(balls), |(text, scene, settings)| {
        let ways = lanes_in_turn(1 + settings.seed as usize % MOST_THREADS, settings.seed);
        let reference = compared(&scene, &settings, &ways)
            .map_err(|why| TestCaseError::fail(format!("{why}\n{text}")))?;
        renders.set(renders.get() + ways.len());
        let is_aimed = reference.targets().is_some_and(|targets| !targets.shares.is_empty());
        aimed.set(aimed.get() + u32::from(is_aimed));
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
    let reference = compared(&scene, &settings, &all_lanes(2)).unwrap();
    let targets = reference.targets().unwrap();
    assert!(!targets.shares.is_empty(), "nothing is aimed: {}", targets.expected);
    tell(LaneKind::ALL.len(), "a scene of 3000 lamps");
}

/// Photons are aimed at what is given, instead of at what a survey finds: at what is seen in other scenes, or at nothing.
#[test]
fn targets_that_are_given() {
    let small =
        |settings| Settings { width: 20, height: 16, iterations: 2, photons_per_iteration: 3000, ..settings };
    let [open, guided] = ["terrace", "surgery"].map(|name| files::builtin::scene(name).unwrap());
    let targets = [
        Targets::default(),
        survey(&open, &small(open.settings)),
        survey(&guided, &Settings { photons_per_iteration: 200_000, ..small(guided.settings) }),
    ];
    assert!(!targets[1].shares.is_empty() && targets[2].guide.is_some(), "nothing is aimed or guided");
    let mut renders = 0;
    for name in ["cornell", "terrace"] {
        let scene = files::builtin::scene(name).unwrap();
        for targets in &targets {
            let stats = compare_aimed_at(&scene, &small(scene.settings), &all_lanes(2), targets).expect(name);
            assert!(stats.photons > 0);
            renders += LaneKind::ALL.len();
        }
    }
    tell(renders, "targets that are given");
}
