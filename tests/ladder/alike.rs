//! The paper's own generators: rows agree with the baseline as the baseline does with itself under another seed, and
//! the more so the more iterations there are (figure 8 of the paper).

use crate::pair::builtin;
use ladder::{Options, ROWS, Row};
use scene::{Film, Scene, Settings};
use sppm::compare::compare;

/// A row's similarity to the baseline may fall short of the least that the baseline has with itself by so much: about
/// what the similarity of two noisy images of this size varies by from seed to seed.
const SLACK: f64 = 0.02;
/// The mean radiance of two renders of `ITERATIONS[1]` iterations differs by noise alone, by less than 1 %.
const MEAN_SLACK: f64 = 0.02;
/// Few, and enough for images to be alike.
const ITERATIONS: [u32; 2] = [2, 16];
/// Seeds under which the baseline is compared with itself.
const SEEDS: std::ops::Range<u64> = 2..6;

fn render(row: &Row, scene: &Scene, settings: &Settings, seed: u64) -> [Film; 2] {
    let settings = Settings { seed, ..*settings };
    let mut rung = row.start(scene, &settings, &Options::paper());
    ITERATIONS.map(|iterations| {
        while rung.iterations() < iterations {
            rung.iterate();
        }
        rung.develop()
    })
}

fn similarity(a: &Film, b: &Film) -> f64 {
    compare(a, b).unwrap().ssim.all
}

fn mean(film: &Film) -> f64 {
    film.pixels.iter().map(|pixel| f64::from(pixel.element_sum())).sum::<f64>()
}

#[test]
fn rows_agree_with_the_baseline_as_it_does_with_itself() {
    for name in ["cornell", "surgery"] {
        let (scene, settings) = builtin(name);
        let settings = Settings {
            width: 48,
            height: 36,
            photons_per_iteration: 10_000,
            initial_radius: 4.0,
            ..settings
        };
        let baseline = render(&ROWS[0], &scene, &settings, 1);
        let again: Vec<_> = SEEDS.map(|seed| render(&ROWS[0], &scene, &settings, seed)).collect();
        let similarities =
            |n: usize| again.iter().map(|again| similarity(&baseline[n], &again[n])).collect::<Vec<_>>();
        let few = similarities(0).into_iter().fold(0.0, f64::max);
        let many = similarities(1).into_iter().fold(1.0, f64::min);
        assert!(many > few, "{name}: the baseline does not converge: {few}, then {many}");
        for row in &ROWS[1..] {
            let other = render(row, &scene, &settings, SEEDS.end);
            let [other_few, other_many] = [0, 1].map(|n| similarity(&baseline[n], &other[n]));
            let case = format!("{name}, row {}", row.name);
            assert!(other_many > other_few, "{case}: {other_few}, then {other_many}");
            assert!(other_many > many - SLACK, "{case}: {other_many}, the baseline with itself {many}");
            let ratio = mean(&other[1]) / mean(&baseline[1]);
            assert!(
                (ratio - 1.0).abs() < MEAN_SLACK,
                "{case}: mean radiance is {ratio} times the baseline's"
            );
        }
    }
}
