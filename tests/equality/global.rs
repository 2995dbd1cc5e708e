//! Global radii: both engines give the same bits, and iterations rendered apart add up to the render, in any grouping and
//! order.

use crate::cases::tell;
use crate::draft::{Case, case};
use crate::pair::{compare, effort, lanes_in_turn};
use fast::LaneKind;
use proptest::prelude::*;
use scene::{Engine, ExactSums, Film, RadiusSchedule, Resumable, Rgb, Scene, Settings};
use std::cell::Cell;

fn global(settings: Settings) -> Settings {
    // Pilots choose radii of pixels, of which there are none.
    Settings { radius_schedule: RadiusSchedule::Global, radius_pilots: 0, radius_clearance: 0.0, ..settings }
}

#[test]
fn random_scenes() {
    let (renders, whole) = (Cell::new(0), Cell::new(0));
    let cases = effort(150);
    let all = cases.cases;
    proptest!(cases, |(case in case(1..=40))| {
        let Case { scene, settings, .. } = case;
        let ways = lanes_in_turn(1 + settings.seed as usize % 3, settings.seed);
        let stats = compare(&scene, &global(settings), &ways).map_err(TestCaseError::fail)?;
        renders.set(renders.get() + ways.len());
        whole.set(whole.get() + u32::from(stats.contributions > 0));
    });
    assert!(whole.get() > all / 10, "photons count in {} scenes alone", whole.get());
    tell("equality", renders.get(), "renders of random scenes with global radii equal the reference");
}

/// The sums of all pixels, in order.
fn sums(engine: &dyn Resumable) -> Vec<ExactSums> {
    let Settings { width, height, .. } = *engine.settings();
    let mut row = vec![0; width as usize * ExactSums::WORDS];
    let rows = (0..height).flat_map(|y| {
        engine.save_row(y, &mut row);
        row.as_chunks().0.iter().map(|words| ExactSums::from_words(*words)).collect::<Vec<_>>()
    });
    rows.collect()
}

fn scenes() -> Vec<(Scene, Settings)> {
    let tiny = |name| {
        let scene = files::builtin::scene(name).unwrap();
        let settings = Settings {
            width: 19,
            height: 11,
            iterations: 12,
            photons_per_iteration: 600,
            initial_radius: 8.0,
            ..scene.settings
        };
        (scene, global(settings))
    };
    ["cornell", "motion", "terrace"].map(tiny).to_vec()
}

/// Every iteration by itself, from the last to the first, each by another engine.
#[test]
fn iterations_rendered_apart_add_up_to_the_render() {
    for (scene, settings) in scenes() {
        let mut whole = reference::Sppm::new(&scene, &settings);
        (0..settings.iterations).for_each(|_| whole.iterate());
        let lanes: Vec<_> = LaneKind::ALL.into_iter().filter(|lanes| lanes.is_available()).collect();
        let mut total = vec![ExactSums::default(); settings.pixels()];
        for k in (0..settings.iterations).rev() {
            let mut alone: Box<dyn Resumable> = match k as usize % (lanes.len() + 1) {
                0 => Box::new(reference::Sppm::new(&scene, &settings)),
                other => Box::new(fast::Sppm::with_lanes(&scene, &settings, lanes[other - 1])),
            };
            alone.skip_to(k);
            alone.iterate();
            assert_eq!((alone.iterations(), alone.progress().next), (1, k + 1));
            total.iter_mut().zip(sums(&*alone)).for_each(|(total, sum)| total.add(&sum));
        }
        assert_eq!(total, sums(&whole), "{}", scene.name);
        assert!(total.iter().any(|sum| sum.photons > 0), "{}: no photon counts", scene.name);
    }
}

/// Of sums that are loaded, the next iteration has the radius of its number, also where it is not named by `skip_to`.
#[test]
fn engines_go_on_after_sums_of_the_first_iterations() {
    for (scene, settings) in scenes() {
        let (mut whole, mut first) =
            (reference::Sppm::new(&scene, &settings), fast::Sppm::new(&scene, &settings));
        (0..5).for_each(|_| whole.iterate());
        (0..3).for_each(|_| first.iterate());
        let others: [Box<dyn Resumable>; 2] =
            [Box::new(reference::Sppm::new(&scene, &settings)), Box::new(fast::Sppm::new(&scene, &settings))];
        for mut other in others {
            let mut row = vec![0; settings.width as usize * ExactSums::WORDS];
            for y in 0..settings.height {
                first.save_row(y, &mut row);
                other.load_row(y, &row);
            }
            other.go_on_after(3, *first.stats());
            (0..2).for_each(|_| other.iterate());
            assert_eq!(sums(&*other), sums(&whole), "{}", scene.name);
        }
    }
}

/// The first iteration has the same radii by both schedules, so it is the same estimate but for its rounding.
#[test]
fn the_first_iteration_is_that_of_radii_per_pixel() {
    /// Both are a product of a few numbers of 24 bits.
    const TOLERANCE: f32 = 1e-6;
    for (scene, settings) in scenes() {
        let image = |radius_schedule| -> Film {
            let mut engine = reference::Sppm::new(&scene, &Settings { radius_schedule, ..settings });
            engine.iterate();
            engine.develop()
        };
        let (global, own) = (image(RadiusSchedule::Global), image(RadiusSchedule::PerPixel));
        assert!(global.pixels.iter().any(|pixel| *pixel != Rgb::ZERO));
        for (a, b) in global.pixels.iter().zip(&own.pixels) {
            assert!(
                (*a - *b).abs().max_element() <= TOLERANCE * b.max_element(),
                "{}: {a} and {b}",
                scene.name
            );
        }
    }
}
