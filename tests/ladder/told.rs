//! What rows tell of themselves: seconds, bytes and candidates; and that they keep to the numbers and sums that are asked for.

use crate::pair::builtin;
use ladder::{Options, ROWS, Random, Row, Rung, Sums, Tuning, find};
use scene::{Film, Scene, Settings, Stats};
use std::time::Instant;

fn named(name: &str) -> &'static Row {
    find(name).unwrap()
}

/// After some iterations.
fn after<'a>(
    iterations: u32,
    row: &Row,
    scene: &'a Scene,
    settings: &Settings,
    options: &Options,
) -> Box<dyn Rung + 'a> {
    let mut rung = row.start(scene, settings, options);
    for _ in 0..iterations {
        rung.iterate();
    }
    rung
}

#[test]
fn seconds_of_passes_add_up_to_no_more_than_all() {
    let (scene, settings) = builtin("cornell");
    for row in ROWS {
        let mut rung = row.start(&scene, &settings, &Options::paper());
        let (began, mut before) = (Instant::now(), [0.0; 4]);
        for _ in 0..3 {
            rung.iterate();
            let all = began.elapsed().as_secs_f64();
            let Stats { camera_seconds, build_grid_seconds, photon_seconds, consolidate_seconds, .. } =
                *rung.stats();
            let passes = [camera_seconds, build_grid_seconds, photon_seconds, consolidate_seconds];
            let took_time = passes.iter().zip(before).all(|(&now, before)| now > before);
            assert!(took_time, "row {}: {passes:?} after {before:?}", row.name);
            assert!(passes.iter().sum::<f64>() <= all, "row {}: {passes:?} in {all}", row.name);
            before = passes;
        }
    }
}

/// Rows that differ in their index alone. Of a pixel with eight lanes there are 44 bytes in columns, which are as long as a
/// power of two, and in whole vectors a line of 32, sums in floats of 16 and in integers of 32.
#[test]
fn bytes_are_those_of_pixels_and_index() {
    let (scene, settings) = builtin("cornell");
    let held = |name: &str, options: &Options| {
        let rung = after(1, named(name), &scene, &settings, options);
        (rung.stats().bytes, rung.stats().visible_points)
    };
    let exact = Options::exact();
    let pixels = settings.pixels().next_multiple_of(16) as u64;
    let layout = 44 * 1024 + 32 * (pixels + 1) + (16 + 32) * pixels;
    // A position and two numbers for each point, in the tree of kiddo.
    let (bytes, points) = held("kdtree", &exact);
    assert_eq!(bytes, layout + (12 + 4 + 8) * points);
    // In our own a number, and few nodes.
    let (bytes, points) = held("kdtree-own", &exact);
    assert!((layout + 4 * points..layout + 8 * points).contains(&bytes), "{bytes}");
    // An array of 24 bytes with room for twenty numbers in each of 1024 bins.
    let (roomy, _) = held("6", &exact);
    assert!(roomy >= layout + 1024 * (24 + 20 * 4), "{roomy}");
    let tuning = Tuning { first_capacity: 0, ..Tuning::PAPER };
    let (bytes, _) = held("6", &Options { tuning, ..exact });
    assert!((layout + 1024 * 24 + 4 * points..roomy).contains(&bytes), "{bytes}");
    let (in_floats, _) = held("kdtree", &Options { sums: Sums::Float, ..exact });
    assert_eq!(in_floats + 32 * pixels, held("kdtree", &exact).0);
}

/// Photons are tested against the same points, whatever the layout of these and however many at a time.
#[test]
fn rows_with_equal_cells_test_equal_candidates() {
    let (scene, settings) = builtin("mirror");
    let tested = |name: &str| {
        let rung = after(2, named(name), &scene, &settings, &Options::exact());
        (rung.stats().candidates, rung.stats().contributions)
    };
    let (candidates, contributions) = tested("0");
    assert!(candidates > contributions && contributions > 0);
    for name in ["1", "2", "3", "horizontal", "4", "5", "6", "sorted", "blocked"] {
        assert_eq!(tested(name), (candidates, contributions), "row {name}");
    }
}

#[test]
fn a_grid_has_cells_of_the_size_that_is_asked_for() {
    let (scene, settings) = builtin("cornell");
    let candidates = |cell_size| {
        let options = Options { tuning: Tuning { cell_size, ..Tuning::PAPER }, ..Options::exact() };
        after(1, named("6"), &scene, &settings, &options).stats().candidates
    };
    let [usual, smaller, larger] = [Tuning::PAPER.cell_size, 1.0, 6.0].map(candidates);
    assert!(usual != smaller && usual != larger && smaller != larger, "{usual}, {smaller}, {larger}");
}

fn small(settings: &Settings, seed: u64) -> Settings {
    Settings { width: 12, height: 9, photons_per_iteration: 800, seed, ..*settings }
}

/// Rows that take the numbers of one generator as many at a time trace the same paths, and a pixel adds up its photons in
/// their order: their images are equal, and those of all others differ.
#[test]
fn rows_take_the_numbers_of_their_own_generators() {
    let (scene, settings) = builtin("surgery");
    let image = |name: &str| after(2, named(name), &scene, &small(&settings, 3), &Options::paper()).develop();
    let alike: [&[&str]; 7] = [
        &["0", "1", "2"],
        &["3", "horizontal"],
        &["3-unroll-1"],
        &["3-unroll-2"],
        &["3-unroll-4"],
        &["3-unroll-16"],
        &["4", "5", "6", "sorted", "blocked", "kdtree", "kdtree-own"],
    ];
    assert_eq!(alike.concat().len(), ROWS.len() - 1);
    let mut seen: Vec<Film> = Vec::new();
    for names in alike {
        let expected = image(names[0]);
        for name in &names[1..] {
            assert!(image(name) == expected, "row {name} is not as row {}", names[0]);
        }
        assert!(!seen.contains(&expected), "row {} is as another", names[0]);
        seen.push(expected);
    }
}

#[test]
fn own_numbers_follow_the_seed_and_are_not_the_references() {
    let (scene, settings) = builtin("cornell");
    let paper = Options::paper();
    for row in ROWS.iter().filter(|row| !row.is_always_exact()) {
        let image =
            |seed, options: &Options| after(1, row, &scene, &small(&settings, seed), options).develop();
        let own = image(1, &paper);
        assert!(image(1, &paper) == own, "row {} is another each time", row.name);
        assert!(image(2, &paper) != own, "row {} does not follow the seed", row.name);
        let keyed = Options { random: Random::Keyed, ..paper };
        let in_floats = image(1, &keyed);
        assert!(in_floats != own, "row {} takes the reference's numbers", row.name);
        let in_integers = image(1, &Options { sums: Sums::Integer, ..keyed });
        assert!(in_integers != in_floats, "row {} sums up integers", row.name);
    }
}

/// Not another pixel's.
#[test]
fn pixels_outside_of_the_image_have_no_values() {
    let (scene, settings) = builtin("cornell");
    for row in ROWS {
        let rung = row.start(&scene, &settings, &Options::exact());
        for (x, y) in [(settings.width, 0), (0, settings.height)] {
            let probe = std::panic::AssertUnwindSafe(|| rung.probe(x, y));
            assert!(std::panic::catch_unwind(probe).is_err(), "row {}, pixel ({x}, {y})", row.name);
        }
    }
}
