//! Counts of arithmetic operations and of bytes moved.

use crate::difference::Outcome;
use crate::pair::builtin;
use ladder::{Operations, Options, ROWS, Rung, find};
use scene::Settings;

const CAMERA: usize = 0;
const INDEX: usize = 1;
const PHOTON: usize = 2;
const CONSOLIDATION: usize = 3;

fn counted(name: &str, settings: &Settings) -> (Box<dyn Rung>, [Operations; 4]) {
    let (scene, _) = builtin("cornell");
    let options = Options { counts_operations: true, ..Options::exact() };
    // Leak the scene, so that the returned row can borrow it.
    let mut rung = find(name).unwrap().start(Box::leak(Box::new(scene)), settings, &options);
    rung.iterate();
    let operations = rung.operations().unwrap();
    (rung, operations)
}

fn small() -> Settings {
    Settings { photons_per_iteration: 300, ..builtin("cornell").1 }
}

#[test]
fn counting_does_not_change_the_image() {
    let settings = small();
    let (scene, _) = builtin("cornell");
    for row in ROWS.iter().filter(|row| !row.is_always_exact()) {
        let (rung, _) = counted(row.name, &settings);
        let mut plain = row.start(&scene, &settings, &Options::exact());
        plain.iterate();
        let difference = Outcome::of(&*plain).difference(&Outcome::of(&*rung));
        assert_eq!(difference, None, "row {}", row.name);
    }
}

#[test]
fn counts_are_the_same_each_time() {
    for name in ["0", "3", "4", "5", "6"] {
        assert_eq!(counted(name, &small()).1, counted(name, &small()).1, "row {name}");
    }
}

/// The scalar stages organise the computation differently, but do the same operations.
#[test]
fn scalar_stages_have_equal_counts() {
    let [zero, one, two, three] = ["0", "1", "2", "3"].map(|name| counted(name, &small()).1);
    for pass in [CAMERA, PHOTON] {
        let flops = [zero, one, two, three].map(|operations| operations[pass].flops());
        assert_eq!(flops[0], flops[1]);
        assert_eq!(flops[2], flops[3]);
        assert_eq!(flops[0], flops[2]);
    }
}

/// Vertical stages have higher counts, because masked lanes compute too. Stage 6 gathers half as many bytes as stage 5.
#[test]
fn vertical_stages_compute_more_and_the_last_moves_less() {
    let [three, four, five, six] = ["3", "4", "5", "6"].map(|name| counted(name, &small()).1);
    assert!(four[PHOTON].flops() > three[PHOTON].flops());
    assert!(six[PHOTON].bytes_loaded < five[PHOTON].bytes_loaded);
    for operations in [three, four, five, six] {
        for pass in [CAMERA, PHOTON] {
            assert!(operations[pass].square_roots > 0 && operations[pass].divisions > 0);
        }
    }
}

/// With more photons, the counts of the photon pass grow in proportion, up to noise, and those of the camera pass not
/// at all.
#[test]
fn counts_follow_the_work() {
    let few = small();
    let many = Settings { photons_per_iteration: 4 * few.photons_per_iteration, ..few };
    let (few, many) = (counted("6", &few).1, counted("6", &many).1);
    assert_eq!(few[CAMERA], many[CAMERA]);
    let ratio = many[PHOTON].flops() as f64 / few[PHOTON].flops() as f64;
    assert!((3.0..5.0).contains(&ratio), "{ratio}");
}

/// The index takes a root for the radius of each visible point; every pixel is consolidated, by 14 operations of which one is a
/// division, whatever it sees. Later iterations add to what is told.
#[test]
fn passes_are_told_their_own_operations_of_all_iterations() {
    let settings = small();
    let pixels = settings.pixels() as u64;
    for (name, consolidated) in [("0", pixels), ("3", pixels), ("6", pixels.next_multiple_of(8))] {
        let (mut rung, operations) = counted(name, &settings);
        assert_eq!(operations[CONSOLIDATION].divisions, consolidated, "row {name}");
        assert_eq!(operations[CONSOLIDATION].flops(), 14 * consolidated, "row {name}");
        let points = rung.stats().visible_points;
        if name != "6" {
            assert_eq!(operations[INDEX].square_roots, points, "row {name}");
        }
        assert_eq!(operations[CONSOLIDATION].square_roots, 0, "row {name}");
        rung.iterate();
        let again = rung.operations().unwrap();
        assert_eq!(again[CONSOLIDATION].flops(), 2 * 14 * consolidated, "row {name}");
        for pass in [CAMERA, INDEX, PHOTON] {
            assert!(again[pass].flops() > operations[pass].flops(), "row {name}, pass {pass}");
        }
    }
}

/// Counting takes its time, so rows do it only if they are asked to; the fast engine never does.
#[test]
fn operations_are_counted_on_request() {
    let (scene, _) = builtin("cornell");
    for row in ROWS {
        let wanted = Options { counts_operations: true, ..Options::exact() };
        let counts = |options| row.start(&scene, &small(), options).operations().is_some();
        assert_eq!(
            [&Options::exact(), &wanted].map(counts),
            [false, !row.is_always_exact()],
            "row {}",
            row.name
        );
    }
}
