//! Plots speedups as bars, and sweeps as lines: speedups, and the growth of time against the paper's analysis.

use crate::error::Error;
use crate::report::measured::Measured;
use crate::report::passes::PASSES;
use crate::report::sweep::Sweep;
use crate::table::Row;
use plots::{Canvas, Drawn, LinePlot, Scale, Series, label, save};
use plotters::prelude::*;
use std::path::Path;

/// Writes all plots into `folder`.
pub(crate) fn write(folder: &Path, measured: &Measured) -> Result<(), Error> {
    let Some(sweep) = measured.sweep else {
        return Ok(save(&folder.join("speedup.svg"), |canvas| bars(canvas, measured))?);
    };
    for (name, cases) in measured.scenes() {
        write_speedups(folder, measured, name, &cases, sweep)?;
        write_complexity(folder, measured, name, &cases, sweep)?;
    }
    Ok(())
}

/// Writes the plots of speedups over the first row.
fn write_speedups(
    folder: &Path,
    measured: &Measured,
    name: &str,
    cases: &[usize],
    sweep: Sweep,
) -> Result<(), Error> {
    let noun = sweep.noun();
    let plot = LinePlot {
        title: &format!("{name}: times as fast as stage {}", measured.rows[0].name),
        x_axis: noun,
        y_axis: "speedup",
        scale: Scale::Logarithmic,
        series: &speedups(measured, cases),
    };
    Ok(save(&folder.join(format!("speedup-{noun}-{name}.svg")), |canvas| plot.draw(canvas))?)
}

/// Writes the plots of how the time of each pass of the last stage grows.
fn write_complexity(
    folder: &Path,
    measured: &Measured,
    name: &str,
    cases: &[usize],
    sweep: Sweep,
) -> Result<(), Error> {
    let noun = sweep.noun();
    let row = measured.rows.iter().rposition(|row| row.is_stage).unwrap_or(0);
    let of_row = format!("{name}, row {}: time of each pass", measured.rows[row].name);
    let plot = LinePlot {
        title: &format!("{of_row} over its most"),
        x_axis: &format!("{noun} over their most"),
        y_axis: "normalised time",
        scale: Scale::Linear,
        series: &normalised(measured, cases, row, sweep),
    };
    save(&folder.join(format!("complexity-{noun}-{name}.svg")), |canvas| plot.draw(canvas))?;
    let plot = LinePlot {
        title: &format!("{of_row} over predicted work"),
        x_axis: noun,
        y_axis: "time over work, of its mean",
        scale: Scale::Logarithmic,
        series: &over_work(measured, cases, row, sweep),
    };
    Ok(save(&folder.join(format!("flat-{noun}-{name}.svg")), |canvas| plot.draw(canvas))?)
}

/// Draws the speedups over the first row as bars on a logarithmic scale: a group for each row, a bar for each scene.
fn bars(canvas: &Canvas, measured: &Measured) -> Drawn {
    let (rows, scenes) = (measured.rows.len(), measured.cases.len());
    let all: Vec<f64> =
        (0..scenes).flat_map(|case| (0..rows).map(move |row| measured.speedup(case, row))).collect();
    let (low, high) = (all.iter().copied().fold(1.0, f64::min), all.iter().copied().fold(1.0, f64::max));
    let low = low * 0.8;
    let title = format!("times as fast as row {}", measured.rows[0].name);
    let mut chart = ChartBuilder::on(canvas)
        .caption(title, ("sans-serif", 20))
        .margin(10)
        .x_label_area_size(40)
        .y_label_area_size(50)
        .build_cartesian_2d(0.0..rows as f64, (low..high * 1.3).log_scale())?;
    let name = |x: &f64| {
        let is_middle = (x.fract() - 0.5).abs() < 1e-6;
        measured.rows.get(*x as usize).filter(|_| is_middle).map_or(String::new(), |row| row.name.into())
    };
    chart
        .configure_mesh()
        .disable_x_mesh()
        .light_line_style(WHITE)
        .label_style(("sans-serif", 11))
        .x_labels(2 * rows + 1)
        .x_label_formatter(&name)
        .y_label_formatter(&label)
        .y_desc("speedup")
        .draw()?;
    let width = 0.8 / scenes as f64;
    for (case, of_case) in measured.cases.iter().enumerate() {
        let colour = Palette99::pick(case).filled();
        let bar = |row: usize| {
            let left = row as f64 + 0.1 + width * case as f64;
            Rectangle::new([(left, low), (left + width, measured.speedup(case, row))], colour)
        };
        chart
            .draw_series((0..rows).map(bar))?
            .label(&of_case.name)
            .legend(move |(x, y)| Rectangle::new([(x, y - 5), (x + 12, y + 5)], colour));
    }
    chart.configure_series_labels().position(SeriesLabelPosition::UpperLeft).border_style(BLACK).draw()?;
    Ok(())
}

fn speedups(measured: &Measured, cases: &[usize]) -> Vec<Series> {
    let series = |(number, row): (usize, &&Row)| Series {
        label: row.name.into(),
        points: cases
            .iter()
            .map(|&case| (measured.cases[case].value as f64, measured.speedup(case, number)))
            .collect(),
    };
    measured.rows.iter().enumerate().map(series).collect()
}

/// The time of every pass against the varied value, both divided by their maxima. Linear growth gives a straight line
/// through (1, 1).
fn normalised(measured: &Measured, cases: &[usize], row: usize, sweep: Sweep) -> Vec<Series> {
    let most = cases.iter().map(|&case| measured.cases[case].value).max().unwrap_or(1) as f64;
    let series = |pass: usize| {
        let times = measured.pass_seconds(cases, row, pass);
        let longest = times.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
        let values = cases.iter().map(|&case| measured.cases[case].value as f64 / most);
        Series {
            label: PASSES[pass].name.into(),
            points: values.zip(times.iter().map(|t| t / longest)).collect(),
        }
    };
    let linear =
        Series { label: format!("linear in {}", sweep.noun()), points: vec![(0.0, 0.0), (1.0, 1.0)] };
    (0..PASSES.len()).map(series).chain([linear]).collect()
}

/// The time of every pass divided by the work that the paper's analysis predicts, relative to the mean. It is 1
/// throughout if the analysis is exact, and falls if the analysis is only an upper bound.
fn over_work(measured: &Measured, cases: &[usize], row: usize, sweep: Sweep) -> Vec<Series> {
    let series = |pass: usize| {
        let costs = measured.cost_of_work(cases, row, pass, sweep);
        let mean = costs.iter().sum::<f64>() / costs.len() as f64;
        let values = cases.iter().map(|&case| measured.cases[case].value as f64);
        Series {
            label: PASSES[pass].name.into(),
            points: values.zip(costs.iter().map(|c| c / mean)).collect(),
        }
    };
    (0..PASSES.len()).map(series).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::example::Example;

    /// The label and the points of a line.
    fn line(series: &Series) -> (&str, &[(f64, f64)]) {
        (&series.label, &series.points)
    }

    #[test]
    fn lines_of_a_sweep_are_speedups_over_its_values() {
        let example = Example::of_sweep();
        let series = speedups(&example.measured(), &[0, 1]);
        let expected: [(&str, &[(f64, f64)]); 3] = [
            ("0", &[(10.0, 1.0), (40.0, 1.0)]),
            ("6", &[(10.0, 2.0), (40.0, 4.0)]),
            ("fast", &[(10.0, 4.0), (40.0, 16.0)]),
        ];
        assert_eq!(series.iter().map(line).collect::<Vec<_>>(), expected);
        // The other scene has cases of its own.
        assert_eq!(speedups(&example.measured(), &[2, 3])[1].points, [(10.0, 2.0), (40.0, 4.0)]);
    }

    #[test]
    fn the_growth_of_each_pass_ends_at_its_longest_time() {
        let example = Example::of_sweep();
        let series = normalised(&example.measured(), &[0, 1], 0, Sweep::Photons);
        let expected: [(&str, &[(f64, f64)]); 5] = [
            ("camera pass", &[(0.25, 0.125), (1.0, 1.0)]),
            ("index", &[(0.25, 0.125), (1.0, 1.0)]),
            ("photon pass", &[(0.25, 0.125), (1.0, 1.0)]),
            ("consolidate", &[(0.25, 1.0), (1.0, 1.0)]),
            ("linear in photons", &[(0.0, 0.0), (1.0, 1.0)]),
        ];
        assert_eq!(series.iter().map(line).collect::<Vec<_>>(), expected);
    }

    /// Photons are work for the photon pass alone. It takes 0.025 and then 0.05 seconds for each.
    #[test]
    fn time_over_work_is_told_relative_to_its_mean() {
        let example = Example::of_sweep();
        let series = over_work(&example.measured(), &[0, 1], 0, Sweep::Photons);
        for (pass, [first, last]) in
            [(0, [2.0 / 9.0, 16.0 / 9.0]), (2, [2.0 / 3.0, 4.0 / 3.0]), (3, [1.0, 1.0])]
        {
            let [a, b] = series[pass].points[..] else { panic!("{series:?}") };
            assert_eq!(([a.0, b.0], &series[pass].label[..]), ([10.0, 40.0], PASSES[pass].name));
            approx::assert_relative_eq!(a.1, first, max_relative = 1e-12);
            approx::assert_relative_eq!(b.1, last, max_relative = 1e-12);
        }
        assert_eq!(series.len(), PASSES.len());
    }
}
