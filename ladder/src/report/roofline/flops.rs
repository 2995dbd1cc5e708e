//! Plots FLOPs per cycle over the values of a sweep (figure 5 of the paper).

use super::count::Roofline;
use crate::error::Error;
use crate::report::measured::Measured;
use crate::report::sweep::Sweep;
use plots::{LinePlot, Scale, Series, save};
use std::path::Path;

/// Writes a plot for each scene.
pub(crate) fn write(
    folder: &Path,
    roofline: &Roofline,
    measured: &Measured,
    sweep: Sweep,
) -> Result<(), Error> {
    for (name, cases) in measured.scenes() {
        let noun = sweep.noun();
        let series = [rows(roofline, measured, &cases), peaks(roofline, measured, &cases)].concat();
        let plot = LinePlot {
            title: &format!("{name}: FLOPs per cycle"),
            x_axis: noun,
            y_axis: "FLOPs/cycle",
            scale: Scale::Logarithmic,
            series: &series,
        };
        save(&folder.join(format!("flops-{noun}-{name}.svg")), |canvas| plot.draw(canvas))?;
    }
    Ok(())
}

/// The rows whose operations are counted.
fn rows(roofline: &Roofline, measured: &Measured, cases: &[usize]) -> Vec<Series> {
    let mut series = Vec::new();
    for (number, row) in measured.rows.iter().enumerate() {
        let point = |&case: &usize| {
            let (all, _) = roofline.points(measured, case, number)?;
            Some((measured.cases[case].value as f64, all.flops_per_cycle()))
        };
        let points: Vec<(f64, f64)> = cases.iter().filter_map(point).collect();
        if !points.is_empty() {
            series.push(Series { label: row.name.into(), points });
        }
    }
    series
}

/// The peaks of the machine.
fn peaks(roofline: &Roofline, measured: &Measured, cases: &[usize]) -> Vec<Series> {
    let peaks = &roofline.peaks;
    let level = |(label, flops): (&str, f64)| {
        let point = |&case: &usize| (measured.cases[case].value as f64, flops / peaks.clock.hertz);
        Series { label: label.into(), points: cases.iter().map(point).collect() }
    };
    [("peak, one float", peaks.scalar_flops), ("peak, 8 floats", peaks.vector_flops)].map(level).into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::example::Example;

    /// Rows that count nothing have no line; those that do are below the peaks, which are the same at all values.
    #[test]
    fn lines_are_of_counted_rows_and_of_the_peaks() {
        let (example, roofline) = (Example::of_sweep(), Roofline::example(4));
        let measured = example.measured();
        let lines = rows(&roofline, &measured, &[0, 1]);
        assert_eq!(lines.iter().map(|line| &line.label[..]).collect::<Vec<_>>(), ["0", "6"]);
        let flops = |case| roofline.points(&measured, case, 1).unwrap().0.flops_per_cycle();
        assert_eq!(lines[1].points, [(10.0, flops(0)), (40.0, flops(1))]);
        let peaks = peaks(&roofline, &measured, &[2, 3]);
        let lines: Vec<_> = peaks.iter().map(|line| (&line.label[..], &line.points[..])).collect();
        let expected: [(&str, &[(f64, f64)]); 2] = [
            ("peak, one float", &[(10.0, 4.0), (40.0, 4.0)]),
            ("peak, 8 floats", &[(10.0, 32.0), (40.0, 32.0)]),
        ];
        assert_eq!(lines, expected);
    }
}
