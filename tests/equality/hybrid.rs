//! Path tracing with photons for caustics: the fast engine gives the reference's bits. Random scenes are in
//! `random_scenes.rs`.

use crate::pair::{all_lanes, assert_equal_hybrids, tell};
use fast::LaneKind;
use fast::kernels;
use files::builtin::{SCENES, scene};
use reference::survey::survey_for;
use scene::state::transfer;
use scene::still::Carried;
use scene::{Resumable, Scene, Settings};

#[test]
fn built_in_scenes_by_both() {
    let mut cases = 0;
    for builtin in SCENES {
        let scene = builtin.scene();
        for (max_depth, radius_clearance, glint_samples) in [(scene.settings.max_depth, 0.0, 1), (12, 0.7, 5)]
        {
            let settings = Settings {
                width: 40,
                height: 30,
                iterations: 3,
                photons_per_iteration: 4000,
                max_depth,
                radius_clearance,
                glint_samples,
                ..scene.settings
            };
            let ways: Vec<_> = [1, 2].into_iter().flat_map(all_lanes).collect();
            let (renders, contributions) = assert_equal_hybrids(&scene, &settings, &ways);
            cases += renders;
            assert!(contributions > 0, "{} has no caustics", builtin.name);
        }
    }
    tell(cases, "built-in scenes by paths and photons for caustics");
}

/// Aimed photons, guided ones and first radii are learnt from the same walks and pilots.
#[test]
fn surveys_for_caustics() {
    let mut aimed = 0;
    for builtin in SCENES {
        let scene = builtin.scene();
        let settings = Settings { photons_per_iteration: 20_000, ..scene.settings };
        let expected = survey_for(&scene, &settings, Carried::Caustics);
        aimed += usize::from(!expected.shares.is_empty());
        for lanes in LaneKind::ALL.into_iter().filter(|lanes| lanes.is_available()) {
            let found = kernels::survey_for(&scene, &settings, Carried::Caustics, lanes);
            assert_eq!(format!("{found:?}"), format!("{expected:?}"), "{} on {lanes:?}", scene.name);
        }
    }
    assert!(aimed > 1, "{aimed} scenes are aimed at");
}

#[test]
fn first_radii_of_caustics_by_pilots() {
    let scene = scene("random").unwrap();
    let settings = Settings {
        width: 24,
        height: 18,
        iterations: 2,
        photons_per_iteration: 3000,
        radius_pilots: 1,
        ..scene.settings
    };
    let (renders, contributions) = assert_equal_hybrids(&scene, &settings, &all_lanes(2));
    assert!(contributions > 0);
    tell(renders, "pilots by photons for caustics");
}

fn by_reference<'a>(scene: &'a Scene, settings: &Settings) -> Box<dyn Resumable + 'a> {
    let photons = reference::Sppm::new(scene, settings);
    Box::new(reference::hybrid(reference::PathTracer::new(scene, settings), photons))
}

fn by_fast<'a>(scene: &'a Scene, settings: &Settings) -> Box<dyn Resumable + 'a> {
    let photons = fast::Sppm::new(scene, settings);
    Box::new(fast::hybrid(fast::PathTracer::new(scene, settings), photons))
}

fn words(engine: &dyn Resumable) -> Vec<u32> {
    let Settings { width, height, .. } = *engine.settings();
    let row = width as usize * engine.sums().words();
    let mut words = vec![0; row * height as usize];
    words.chunks_exact_mut(row).zip(0..).for_each(|(words, y)| engine.save_row(y, words));
    words
}

/// Either engine goes on where the other, or itself, has stopped, in resting and in moving scenes.
#[test]
fn resumed_by_either_engine() {
    for name in ["cornell", "motion", "terrace"] {
        let scene = scene(name).unwrap();
        let settings =
            Settings { width: 20, height: 13, iterations: 3, photons_per_iteration: 2000, ..scene.settings };
        let mut whole = by_reference(&scene, &settings);
        (0..3).for_each(|_| whole.iterate());
        for first in [by_reference, by_fast] {
            for second in [by_reference, by_fast] {
                let mut begun = first(&scene, &settings);
                begun.iterate();
                let mut resumed = second(&scene, &settings);
                transfer(&*begun, &mut *resumed);
                assert_eq!((resumed.stats(), words(&*resumed)), (begun.stats(), words(&*begun)));
                resumed.iterate();
                resumed.iterate();
                assert_eq!(words(&*resumed), words(&*whole), "{name}");
                assert_eq!(resumed.develop(), whole.develop(), "{name}");
                let work = |engine: &dyn Resumable| (engine.stats().photons, engine.stats().camera_segments);
                assert_eq!(work(&*resumed), work(&*whole));
            }
        }
    }
}
