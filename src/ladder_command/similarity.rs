//! How alike the rows' images are to the first row's as iterations go by (figure 8 of the paper).

use super::Measured;
use super::cases::Case;
use super::films::films;
use super::plots::{Series, lines, save};
use super::roofline::table;
use crate::terminal::bar::Bar;
use crate::terminal::error::Error;
use compare::Metrics;
use ladder::{Options, Row};
use scene::Film;
use serde::Serialize;
use std::fmt::Write;
use std::path::Path;

/// The structural similarity of every row's image to the first row's, in every case.
pub(crate) struct Similarity {
    /// By case and row.
    ssim: Vec<Vec<f64>>,
}

/// Renders the cases of a sweep over iterations once more, and compares.
pub(super) fn compared(measured: &Measured, options: &Options) -> Result<Similarity, Error> {
    let scenes = measured.scenes();
    let progress = Bar::of((scenes.len() * measured.rows.len()) as u32, "compared rows");
    let (mut ssim, mut done) = (vec![Vec::new(); measured.cases.len()], 0);
    for (name, numbers) in scenes {
        let cases: Vec<&Case> = numbers.iter().map(|&number| &measured.cases[number]).collect();
        let mut first = Vec::new();
        for row in measured.rows {
            progress.step(done, &format!("{name} row {}", row.name));
            done += 1;
            let counts = cases.iter().map(|case| case.settings.iterations);
            let films: Vec<Film> =
                cases.last().map_or_else(Vec::new, |case| films(case, row, options, counts).collect());
            if first.is_empty() {
                first.clone_from(&films);
            }
            for ((&number, film), first) in numbers.iter().zip(&films).zip(&first) {
                let compared = Metrics::of(first, film).map_err(|error| Error::Failed(error.to_string()))?;
                ssim[number].push(compared.ssim.all);
            }
        }
    }
    progress.clear();
    Ok(Similarity { ssim })
}

/// A comparison as a line of a table.
#[derive(Serialize)]
struct Record<'a> {
    scene: &'a str,
    iterations: u64,
    row: &'a str,
    ssim: f64,
}

impl Similarity {
    /// A table for people.
    pub(super) fn report(&self, measured: &Measured) -> String {
        let mut text = String::new();
        let widest = measured.rows.iter().map(|row| row.name.len()).max().unwrap_or(0);
        for (name, cases) in measured.scenes() {
            let _ = writeln!(
                text,
                "\n{name}: structural similarity (SSIM) to row {}, by iterations",
                measured.rows[0].name
            );
            let values: Vec<String> =
                cases.iter().map(|&case| format!("{:>10}", measured.cases[case].value)).collect();
            let _ = writeln!(text, "  {:widest$}  {}", "row", values.concat());
            for (number, row) in measured.rows.iter().enumerate() {
                let values: Vec<String> =
                    cases.iter().map(|&case| format!("{:>10.4}", self.ssim[case][number])).collect();
                let _ = writeln!(text, "  {:widest$}  {}", row.name, values.concat());
            }
        }
        text
    }

    /// Writes a plot for each scene, and all values.
    pub(super) fn write(&self, folder: &Path, measured: &Measured) -> Result<(), Error> {
        for (name, cases) in measured.scenes() {
            let series = |(number, row): (usize, &&'static Row)| Series {
                label: row.name.into(),
                points: cases
                    .iter()
                    .map(|&case| (measured.cases[case].value as f64, self.ssim[case][number]))
                    .collect(),
            };
            let series: Vec<Series> = measured.rows.iter().enumerate().skip(1).map(series).collect();
            let title = format!("{name}: similarity to row {}", measured.rows[0].name);
            save(folder, &format!("ssim-{name}"), |root| {
                lines(root, &title, "iterations", "SSIM", &series, false)
            })?;
        }
        let mut records = Vec::new();
        for (case, of_rows) in measured.cases.iter().zip(&self.ssim) {
            for (row, &ssim) in measured.rows.iter().zip(of_rows) {
                records.push(Record { scene: &case.name, iterations: case.value, row: row.name, ssim });
            }
        }
        table(&folder.join("similarity.csv"), &records)
    }
}
