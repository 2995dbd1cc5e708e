//! With the paper's own random number generators, each row must agree with the baseline as well as the baseline agrees
//! with itself under another seed, and better with more iterations (figure 8 of the paper).

use crate::cases::tell;
use crate::pair::builtin;
use compare::Metrics;
use ladder::{Options, ROWS, Row};
use scene::{Film, Scene, Settings};

/// A row's similarity to the baseline may be this much less than the least similarity of the baseline to itself. It is
/// about the variation of the similarity of two noisy images of this size between seeds.
const SLACK: f64 = 0.02;
/// Largest deviation of a row's mean radiance from the baseline's, in standard errors. These are estimated from the
/// baseline's variation over a few seeds, and so are uncertain by about a third.
const MOST_ERRORS: f64 = 5.0;
/// Numbers of iterations: few, and enough for similar images.
const ITERATIONS: [u32; 2] = [2, 16];
/// Seeds under which the baseline is compared with itself.
const SEEDS: std::ops::Range<u64> = 2..8;
/// Seeds of every other row.
const OTHER_SEEDS: std::ops::Range<u64> = 11..14;

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
    Metrics::of(a, b).unwrap().ssim.all
}

/// The mean, and the variance of a single value.
fn mean_and_variance(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    (mean, values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / (n - 1.0))
}

/// The sum over all pixels. It is used like a mean, as all images have the same size.
fn mean(film: &Film) -> f64 {
    film.pixels.iter().map(|pixel| f64::from(pixel.element_sum())).sum::<f64>()
}

/// Compares each row with the baseline.
fn assert_alike(name: &str) {
    let (scene, settings) = builtin(name);
    let settings =
        Settings { width: 48, height: 36, photons_per_iteration: 10_000, initial_radius: 4.0, ..settings };
    let baseline = render(&ROWS[0], &scene, &settings, 1);
    let again: Vec<_> = SEEDS.map(|seed| render(&ROWS[0], &scene, &settings, seed)).collect();
    let similarities =
        |n: usize| again.iter().map(|again| similarity(&baseline[n], &again[n])).collect::<Vec<_>>();
    let few = similarities(0).into_iter().fold(0.0, f64::max);
    let many = similarities(1).into_iter().fold(1.0, f64::min);
    assert!(many > few, "{name}: the baseline does not converge: {few}, then {many}");
    let baseline_means: Vec<f64> = again.iter().map(|again| mean(&again[1])).collect();
    let (baseline_mean, variance) = mean_and_variance(&baseline_means);
    for row in &ROWS[1..] {
        let others: Vec<_> = OTHER_SEEDS.map(|seed| render(row, &scene, &settings, seed)).collect();
        let [other_few, other_many] = [0, 1].map(|n| similarity(&baseline[n], &others[0][n]));
        let case = format!("{name}, row {}", row.name);
        assert!(other_many > other_few, "{case}: {other_few}, then {other_many}");
        assert!(other_many > many - SLACK, "{case}: {other_many}, the baseline with itself {many}");
        let means: Vec<f64> = others.iter().map(|other| mean(&other[1])).collect();
        let (others_mean, _) = mean_and_variance(&means);
        let share = 1.0 / means.len() as f64 + 1.0 / baseline_means.len() as f64;
        let errors = (others_mean - baseline_mean) / (variance * share).sqrt();
        assert!(errors.abs() < MOST_ERRORS, "{case}: mean radiance is {errors} standard errors from it");
    }
    tell("ladder", ROWS.len() - 1, "rows compared with the baseline by the paper's own generators");
}

#[test]
fn rows_agree_with_the_baseline_in_cornell() {
    assert_alike("cornell");
}

#[test]
fn rows_agree_with_the_baseline_in_surgery() {
    assert_alike("surgery");
}
