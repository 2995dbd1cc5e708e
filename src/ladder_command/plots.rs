//! Plots: speedups as bars, sweeps as lines, and whether time grows as the paper's analysis says.

use super::Measured;
use super::args::Sweep;
use super::passes::PASSES;
use super::roofline::Roofline;
use super::rooflines::plain;
use crate::terminal::error::Error;
use files::atomic_file;
use plotters::coord::Shift;
use plotters::prelude::*;
use std::io::Write;
use std::path::Path;

const SIZE: (u32, u32) = (900, 560);
/// Room for the legend to the right of all lines, over their width.
const ROOM: f64 = 0.25;
/// What is drawn on.
pub(crate) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
pub(crate) type Drawn = Result<(), Box<dyn std::error::Error>>;

/// A line of a plot.
pub(super) struct Series {
    pub(super) label: String,
    pub(super) points: Vec<(f64, f64)>,
}

/// Writes all plots into `folder`.
pub(super) fn write(folder: &Path, measured: &Measured) -> Result<(), Error> {
    let Some(sweep) = measured.sweep else {
        return save(folder, "speedup", |root| bars(root, measured));
    };
    for (name, cases) in measured.scenes() {
        let noun = sweep.noun();
        let title = format!("{name}: times as fast as stage {}", measured.rows[0].name);
        save(folder, &format!("speedup-{noun}-{name}"), |root| {
            lines(root, &title, noun, "speedup", &speedups(measured, &cases), true)
        })?;
        let row = measured.rows.iter().rposition(|row| row.is_stage).unwrap_or(0);
        let title = format!("{name}, row {}: time of each pass over its most", measured.rows[row].name);
        save(folder, &format!("complexity-{noun}-{name}"), |root| {
            let axis = format!("{noun} over their most");
            lines(root, &title, &axis, "normalised time", &normalised(measured, &cases, row, sweep), false)
        })?;
        let title = format!("{name}, row {}: time of each pass over predicted work", measured.rows[row].name);
        save(folder, &format!("flat-{noun}-{name}"), |root| {
            lines(
                root,
                &title,
                noun,
                "time over work, of its mean",
                &over_work(measured, &cases, row, sweep),
                true,
            )
        })?;
    }
    Ok(())
}

/// Writes how many FLOPs a cycle the rows take as the value of a sweep grows (figure 5 of the paper).
pub(super) fn flops(
    folder: &Path,
    measured: &Measured,
    sweep: Sweep,
    roofline: &Roofline,
) -> Result<(), Error> {
    for (name, cases) in measured.scenes() {
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
        let peaks = &roofline.peaks;
        for (label, flops) in
            [("peak, one float", peaks.scalar_flops), ("peak, 8 floats", peaks.vector_flops)]
        {
            let points =
                cases.iter().map(|&case| (measured.cases[case].value as f64, flops / peaks.clock.hertz));
            series.push(Series { label: label.into(), points: points.collect() });
        }
        let noun = sweep.noun();
        save(folder, &format!("flops-{noun}-{name}"), |root| {
            lines(root, &format!("{name}: FLOPs per cycle"), noun, "FLOPs/cycle", &series, true)
        })?;
    }
    Ok(())
}

/// Draws into a string and writes that to `name`.svg in `folder`.
pub(crate) fn save(folder: &Path, name: &str, draw: impl FnOnce(&Area) -> Drawn) -> Result<(), Error> {
    let path = folder.join(format!("{name}.svg"));
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
        let drawn = root.fill(&WHITE).map_err(Into::into).and_then(|()| draw(&root));
        let drawn = drawn.and_then(|()| root.present().map_err(Into::into));
        drawn.map_err(|error| Error::Failed(format!("cannot draw {}: {error}", path.display())))?;
    }
    atomic_file::replace(&path, |out| out.write_all(svg.as_bytes()))
        .map_err(|error| Error::Failed(error.to_string()))
}

/// Speedup over the first row, as bars: a group for each row, a bar for each scene; logarithmic.
fn bars(root: &Area, measured: &Measured) -> Drawn {
    let (rows, scenes) = (measured.rows.len(), measured.cases.len());
    let all: Vec<f64> =
        (0..scenes).flat_map(|case| (0..rows).map(move |row| measured.speedup(case, row))).collect();
    let (low, high) = (all.iter().copied().fold(1.0, f64::min), all.iter().copied().fold(1.0, f64::max));
    let low = low * 0.8;
    let title = format!("times as fast as row {}", measured.rows[0].name);
    let mut chart = ChartBuilder::on(root)
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
    let series = |(number, row): (usize, &&ladder::Row)| Series {
        label: row.name.into(),
        points: cases
            .iter()
            .map(|&case| (measured.cases[case].value as f64, measured.speedup(case, number)))
            .collect(),
    };
    measured.rows.iter().enumerate().map(series).collect()
}

/// Time of every pass over its most, against the value over its most: a straight line through 1 where it is linear.
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

/// Time of every pass over the work that the paper's analysis predicts, over the mean of that: 1 throughout where the
/// analysis is exact, falling where it is a bound only.
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

pub(super) fn lines(
    root: &Area,
    title: &str,
    x_axis: &str,
    y_axis: &str,
    series: &[Series],
    is_logarithmic: bool,
) -> Drawn {
    let points = || series.iter().flat_map(|series| &series.points);
    let bounds = |value: fn(&(f64, f64)) -> f64| {
        let values = points().map(value);
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
    };
    let ((left, right), (low, high)) = (bounds(|p| p.0), bounds(|p| p.1));
    let mut builder = ChartBuilder::on(root);
    builder.caption(title, ("sans-serif", 20)).margin(10).x_label_area_size(40).y_label_area_size(50);
    // The two kinds of axes are two types.
    macro_rules! draw {
        ($chart:expr) => {{
            let mut chart = $chart;
            chart
                .configure_mesh()
                .light_line_style(WHITE)
                .x_desc(x_axis)
                .y_desc(y_axis)
                .x_label_formatter(&plain)
                .y_label_formatter(&plain)
                .draw()?;
            for (number, one) in series.iter().enumerate() {
                let colour = Palette99::pick(number).stroke_width(2);
                chart
                    .draw_series(LineSeries::new(one.points.iter().copied(), colour).point_size(3))?
                    .label(&one.label)
                    .legend(move |(x, y)| PathElement::new([(x, y), (x + 14, y)], colour));
            }
            let labels = SeriesLabelPosition::MiddleRight;
            chart.configure_series_labels().position(labels).border_style(BLACK).draw()?;
        }};
    }
    if is_logarithmic {
        let (x, y) =
            ((left..right * (right / left).powf(ROOM)).log_scale(), (low * 0.9..high * 1.2).log_scale());
        draw!(builder.build_cartesian_2d(x, y)?);
    } else {
        draw!(builder.build_cartesian_2d(left..right + ROOM * (right - left), low..high * 1.1)?);
    }
    Ok(())
}
