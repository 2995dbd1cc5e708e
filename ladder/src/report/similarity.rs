//! Compares the images of rows with those of the first row over increasing iterations (figure 8 of the paper).

use super::case::Case;
use super::csv;
use super::films::films;
use super::measured::Measured;
use super::progress::Progress;
use crate::error::Error;
use crate::options::Options;
use crate::table::Row;
use compare::Metrics;
use plots::{LinePlot, Scale, Series, save};
use scene::Film;
use serde::Serialize;
use std::fmt::Write;
use std::path::Path;

/// The structural similarity of every row's image to that of the first row, in every case.
pub(crate) struct Similarity {
    /// The SSIM index, by case and row.
    ssim: Vec<Vec<f64>>,
}

/// Renders the cases of a sweep over iterations once more, and compares the images.
pub(crate) fn compared(
    measured: &Measured,
    options: &Options,
    progress: &mut dyn Progress,
) -> Result<Similarity, Error> {
    let scenes = measured.scenes();
    progress.begin((scenes.len() * measured.rows.len()) as u32, "compared rows");
    let (mut ssim, mut done) = (vec![Vec::new(); measured.cases.len()], 0);
    for (name, numbers) in scenes {
        let cases: Vec<&Case> = numbers.iter().map(|&number| &measured.cases[number]).collect();
        let mut first = Vec::new();
        for row in measured.rows {
            progress.step(done, &format!("{name} row {}", row.name));
            done += 1;
            let films = films_of(&cases, row, options);
            if first.is_empty() {
                first.clone_from(&films);
            }
            for ((&number, film), first) in numbers.iter().zip(&films).zip(&first) {
                ssim[number].push(Metrics::of(first, film)?.ssim.all);
            }
        }
    }
    progress.end();
    Ok(Similarity { ssim })
}

/// A row's images in cases of increasing iterations, all from one render of the last case.
fn films_of(cases: &[&Case], row: &Row, options: &Options) -> Vec<Film> {
    let counts = cases.iter().map(|case| case.settings.iterations);
    cases.last().map_or_else(Vec::new, |case| films(case, row, options, counts).collect())
}

/// A line of the table: one comparison.
#[derive(Serialize)]
struct Record<'a> {
    scene: &'a str,
    iterations: u64,
    row: &'a str,
    ssim: f64,
}

impl Similarity {
    /// The comparisons as a table of text.
    pub(crate) fn text(&self, measured: &Measured) -> String {
        let mut text = String::new();
        let widest = measured.widest_name();
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

    /// Writes a plot for each scene, and all values as a table.
    pub(crate) fn write(&self, folder: &Path, measured: &Measured) -> Result<(), Error> {
        for (name, cases) in measured.scenes() {
            let plot = LinePlot {
                title: &format!("{name}: similarity to row {}", measured.rows[0].name),
                x_axis: "iterations",
                y_axis: "SSIM",
                scale: Scale::Linear,
                series: &self.series(measured, &cases),
            };
            save(&folder.join(format!("ssim-{name}.svg")), |canvas| plot.draw(canvas))?;
        }
        csv::write(&folder.join("similarity.csv"), &self.records(measured))
    }

    /// A line for every row but the first.
    fn series(&self, measured: &Measured, cases: &[usize]) -> Vec<Series> {
        let series = |(number, row): (usize, &&'static Row)| {
            let point = |&case: &usize| (measured.cases[case].value as f64, self.ssim[case][number]);
            Series { label: row.name.into(), points: cases.iter().map(point).collect() }
        };
        measured.rows.iter().enumerate().skip(1).map(series).collect()
    }

    fn records<'a>(&self, measured: &'a Measured) -> Vec<Record<'a>> {
        let mut records = Vec::new();
        for (case, of_rows) in measured.cases.iter().zip(&self.ssim) {
            for (row, &ssim) in measured.rows.iter().zip(of_rows) {
                records.push(Record { scene: &case.name, iterations: case.value, row: row.name, ssim });
            }
        }
        records
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::example::Example;

    fn example() -> Similarity {
        Similarity {
            ssim: vec![vec![1.0, 0.5, 0.75], vec![1.0, 0.25, 0.125], vec![1.0; 3], vec![1.0, 0.0, 0.5]],
        }
    }

    #[test]
    fn similarities_are_told_by_row_and_iterations() {
        let told = "
a: structural similarity (SSIM) to row 0, by iterations
  row           10        40
  0         1.0000    1.0000
  6         0.5000    0.2500
  fast      0.7500    0.1250

b: structural similarity (SSIM) to row 0, by iterations
";
        let text = example().text(&Example::of_sweep().measured());
        assert!(text.starts_with(told), "{text}");
    }

    /// The first row is what the others are compared with.
    #[test]
    fn all_rows_are_in_the_table_and_all_but_the_first_in_the_plot() {
        let sweep = Example::of_sweep();
        let table = csv::text(&example().records(&sweep.measured()));
        let expected =
            "scene,iterations,row,ssim\na,10,0,1.0\na,10,6,0.5\na,10,fast,0.75\na,40,0,1.0\na,40,6,0.25\n";
        assert!(table.starts_with(expected) && table.ends_with("b,40,fast,0.5\n"), "{table}");
        let series = example().series(&sweep.measured(), &[2, 3]);
        let lines: Vec<_> = series.iter().map(|series| (&series.label[..], &series.points[..])).collect();
        let expected: [(&str, &[(f64, f64)]); 2] =
            [("6", &[(10.0, 1.0), (40.0, 0.0)]), ("fast", &[(10.0, 1.0), (40.0, 0.5)])];
        assert_eq!(lines, expected);
    }
}
