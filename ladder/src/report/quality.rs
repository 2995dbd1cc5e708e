//! Compares the quality of rows: their errors after the same iterations, and the cost of equal quality.
//!
//! An engine that traces fewer photons is faster and noisier, and one that spreads them better is less noisy in the
//! same time. If an error is mostly noise, it falls as one over the time spent. So time multiplied by mean square error
//! is the cost of an image of given quality. Means of blocks of pixels are compared, because single pixels show only
//! the noise of direct light after few iterations.

use super::case::Case;
use super::csv;
use super::measured::Measured;
use super::progress::Progress;
use crate::error::Error;
use crate::options::Options;
use crate::table::Row;
use rayon::prelude::*;
use scene::{Engine, Film, Settings, Vec3};
use serde::Serialize;
use std::fmt::Write;
use std::path::Path;

/// Width and height of a block, in pixels.
const BLOCK: usize = 8;

/// The converged image takes this many times the iterations of the case, and at least this many in all. Then its own
/// noise adds at most a hundredth to the errors.
const CONVERGED: (u32, u32) = (100, 600);

/// The seed of the converged image. The compared images have the seeds 1, 2, 3, ...
const ITS_SEED: u64 = 0x636f_6e76_6572_6765;

/// The relative mean square error by case and row, averaged over the seeds.
pub(crate) struct Quality {
    errors: Vec<Vec<f64>>,
    seeds: u32,
}

/// Renders every case with every row and with each seed, and computes the errors.
pub(crate) fn compared(
    measured: &Measured,
    options: &Options,
    seeds: u32,
    progress: &mut dyn Progress,
) -> Quality {
    progress.begin((measured.cases.len() * (measured.rows.len() + 1)) as u32, "compared rows");
    let (mut errors, mut done) = (Vec::new(), 0);
    let mut step = |what: &str| {
        progress.step(done, what);
        done += 1;
    };
    for case in measured.cases {
        step(&format!("{} converged", case.name));
        let truth = block_means(&converged(case));
        let mut of_case = Vec::new();
        for row in measured.rows {
            step(&format!("{} row {}", case.name, row.name));
            // Collected in order, so that the sum does not depend on the threads.
            let of_seeds: Vec<f64> = (1..=seeds)
                .into_par_iter()
                .map(|seed| relative_square_error(&block_means(&film(case, row, options, seed)), &truth))
                .collect();
            of_case.push(of_seeds.iter().sum::<f64>() / f64::from(seeds));
        }
        errors.push(of_case);
    }
    progress.end();
    Quality { errors, seeds }
}

/// The converged image of a case. All rows render the same physics, so one image is the limit of all.
fn converged(case: &Case) -> Film {
    let (times, least) = CONVERGED;
    let iterations = case.settings.iterations.saturating_mul(times).max(least);
    let mut engine = fast::Sppm::new(&case.scene, &Settings { iterations, seed: ITS_SEED, ..case.settings });
    for _ in 0..iterations {
        engine.iterate();
    }
    engine.develop()
}

fn film(case: &Case, row: &Row, options: &Options, seed: u32) -> Film {
    let settings = Settings { seed: seed.into(), ..case.settings };
    let mut rung = row.start(&case.scene, &settings, options);
    for _ in 0..settings.iterations {
        rung.iterate();
    }
    rung.develop()
}

/// The means of blocks, row by row. Blocks at the right and bottom edge may have fewer pixels.
fn block_means(film: &Film) -> Vec<[f64; 3]> {
    let (width, height) = (film.width as usize, film.height as usize);
    let across = width.div_ceil(BLOCK);
    let mut sums = vec![([0.0; 3], 0.0); across * height.div_ceil(BLOCK)];
    for (at, pixel) in film.pixels.iter().enumerate() {
        let (sum, count) = &mut sums[at / width / BLOCK * across + at % width / BLOCK];
        *count += 1.0;
        for (total, channel) in sum.iter_mut().zip(Vec3::to_array(pixel)) {
            *total += f64::from(channel);
        }
    }
    sums.into_iter().map(|(sum, count)| sum.map(|total| total / count)).collect()
}

/// The mean square difference, divided by the mean square of the ground truth.
fn relative_square_error(means: &[[f64; 3]], truth: &[[f64; 3]]) -> f64 {
    let (mut error, mut square) = (0.0, 0.0);
    for (mean, truth) in means.as_flattened().iter().zip(truth.as_flattened()) {
        error += (mean - truth).powi(2);
        square += truth.powi(2);
    }
    error / square
}

/// A line of the table: the quality of a row.
#[derive(Serialize)]
struct Record<'a> {
    scene: &'a str,
    row: &'a str,
    seconds: f64,
    relative_square_error: f64,
    cost: f64,
}

impl Quality {
    fn cost(&self, measured: &Measured, case: usize, row: usize) -> f64 {
        self.errors[case][row] * measured.runs[case][row].median().seconds
    }

    /// The qualities as a table of text.
    pub(crate) fn text(&self, measured: &Measured) -> String {
        let mut text = format!(
            "\nError: mean square of the means of {BLOCK}x{BLOCK} pixels against a converged image, relative, in \
             millionths; mean of {} seeds.\nCost of equal quality: error times seconds.\n",
            self.seeds
        );
        let widest = measured.widest_name().max(3);
        for (case, of_case) in measured.cases.iter().enumerate() {
            let least = (0..measured.rows.len())
                .map(|row| self.cost(measured, case, row))
                .fold(f64::INFINITY, f64::min);
            let _ = writeln!(
                text,
                "{}\n  {:widest$}  {:>10}{:>10}{:>10}{:>16}",
                of_case.name, "row", "seconds", "error", "cost", "over the least"
            );
            for (number, row) in measured.rows.iter().enumerate() {
                let cost = self.cost(measured, case, number);
                let _ = writeln!(
                    text,
                    "  {:widest$}  {:>10.3}{:>10.1}{:>10.1}{:>16.2}",
                    row.name,
                    measured.runs[case][number].median().seconds,
                    1e6 * self.errors[case][number],
                    1e6 * cost,
                    cost / least
                );
            }
        }
        text
    }

    /// Writes all values as `quality.csv`.
    pub(crate) fn write(&self, folder: &Path, measured: &Measured) -> Result<(), Error> {
        let mut records = Vec::new();
        for (case, of_case) in measured.cases.iter().enumerate() {
            for (number, row) in measured.rows.iter().enumerate() {
                records.push(Record {
                    scene: &of_case.name,
                    row: row.name,
                    seconds: measured.runs[case][number].median().seconds,
                    relative_square_error: self.errors[case][number],
                    cost: self.cost(measured, case, number),
                });
            }
        }
        csv::write(&folder.join("quality.csv"), &records)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::example::Example;

    #[test]
    fn blocks_at_the_edges_are_means_of_what_there_is() {
        let pixels = (0..10 * 9).map(|at| Vec3::new((at % 10) as f32, (at / 10) as f32, 1.0)).collect();
        let means = block_means(&Film { width: 10, height: 9, pixels });
        assert_eq!(means, [[3.5, 3.5, 1.0], [8.5, 3.5, 1.0], [3.5, 8.0, 1.0], [8.5, 8.0, 1.0]]);
    }

    /// The cost is the error times the seconds, and what is told of it is over the least of the same scene.
    #[test]
    fn errors_are_told_with_what_equal_quality_costs() {
        let errors = vec![vec![1e-4, 1e-4, 4e-4], vec![2e-4, 2e-4, 2e-4]];
        let told = "
Error: mean square of the means of 8x8 pixels against a converged image, relative, in millionths; mean of 7 seeds.
Cost of equal quality: error times seconds.
a
  row      seconds     error      cost  over the least
  0          8.000     100.0     800.0            4.00
  6          2.000     100.0     200.0            1.00
  fast       1.000     400.0     400.0            2.00
b
  row      seconds     error      cost  over the least
  0         12.000     200.0    2400.0            6.00
  6          4.000     200.0     800.0            2.00
  fast       2.000     200.0     400.0            1.00
";
        assert_eq!(Quality { errors, seeds: 7 }.text(&Example::of_scenes().measured()), told);
    }

    /// Errors are means over several seeds; with one seed they would be of one image, however many are asked for.
    #[test]
    fn every_seed_gives_another_image_of_all_iterations() {
        let example = Example::of_scenes();
        let (case, row) = (&example.measured().cases[0], example.measured().rows[1]);
        let [one, two] = [1, 2].map(|seed| film(case, row, &Options::paper(), seed));
        assert_ne!(one, two);
        let settings = Settings { seed: 2, ..case.settings };
        let mut rung = row.start(&case.scene, &settings, &Options::paper());
        (0..3).for_each(|_| rung.iterate());
        assert_eq!(rung.develop(), two);
    }

    #[test]
    fn errors_are_relative_and_square() {
        let truth = [[1.0, 2.0, 2.0], [0.0, 4.0, 0.0]];
        assert_eq!(relative_square_error(&truth, &truth), 0.0);
        let brighter = truth.map(|mean| mean.map(|channel| 1.1 * channel));
        approx::assert_abs_diff_eq!(relative_square_error(&brighter, &truth), 0.01, epsilon = 1e-12);
    }
}
