//! Roofline plots (Williams, Waterman and Patterson 2009; figures 10 to 12 of the paper): performance over operational
//! intensity, below the limits ("roofs") of the machine.

use super::count::{Point, Roofline};
use crate::error::Error;
use crate::machine::{Bandwidth, Peaks};
use crate::report::measured::Measured;
use crate::report::passes::PASSES;
use plots::{Canvas, Drawn, label, save};
use plotters::prelude::*;
use std::path::Path;

/// The range of FLOPs per byte that is shown. It is extended if points lie beyond.
const INTENSITIES: (f64, f64) = (0.05, 20.0);

/// The colour of the roofs.
const GREY: RGBColor = RGBColor(90, 90, 90);

/// A point with its name and colour.
struct Dot<'a> {
    name: &'a str,
    point: Point,
    colour: RGBColor,
    size: u32,
}

/// Writes a plot of all rows for each scene, and a plot of the passes for each row.
pub(crate) fn write(folder: &Path, roofline: &Roofline, measured: &Measured) -> Result<(), Error> {
    for (number, case) in measured.cases.iter().enumerate() {
        let mut rows = Vec::new();
        for (place, row) in measured.rows.iter().enumerate() {
            let Some((all, passes)) = roofline.points(measured, number, place) else { continue };
            let colour = Palette99::pick(place).to_rgba();
            let colour = RGBColor(colour.0, colour.1, colour.2);
            rows.push(Dot { name: row.name, point: all, colour, size: 5 });
            let title = format!("{}: roofline of row {} ({})", case.name, row.name, row.about);
            let path = folder.join(format!("roofline-{}-{}.svg", case.name, row.name));
            save(&path, |canvas| draw(canvas, &title, &roofline.peaks, &dots(all, &passes)))?;
        }
        let title = format!("{}: rooflines of all rows", case.name);
        let path = folder.join(format!("roofline-{}.svg", case.name));
        save(&path, |canvas| draw(canvas, &title, &roofline.peaks, &rows))?;
    }
    Ok(())
}

/// The points of a whole row and of its passes. The longest pass is red, as in the paper.
fn dots(all: Point, passes: &[Point; 4]) -> Vec<Dot<'static>> {
    let longest = passes.iter().fold(0.0, |most: f64, pass| most.max(pass.seconds));
    let pass = |(name, &point): (&'static str, &Point)| {
        let colour = if point.seconds == longest { RED } else { RGBColor(30, 100, 200) };
        Dot { name, point, colour, size: 5 }
    };
    let whole = Dot { name: "all", point: all, colour: BLACK, size: 8 };
    std::iter::once(whole).chain(PASSES.map(|pass| pass.name).into_iter().zip(passes).map(pass)).collect()
}

/// A chart with two logarithmic axes.
type Chart<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<LogCoord<f64>, LogCoord<f64>>>;

/// The ranges of the axes: FLOPs per byte, and billions of FLOPs per second.
#[derive(Clone, Copy)]
struct View {
    left: f64,
    right: f64,
    low: f64,
    high: f64,
}

impl View {
    /// The view that shows all dots and the roofs, with some room on all sides.
    fn of(peaks: &Peaks, dots: &[&Dot]) -> Self {
        let fold = |value: fn(&Point) -> f64, start: f64, pick: fn(f64, f64) -> f64| {
            dots.iter().fold(start, |chosen, dot| pick(chosen, value(&dot.point)))
        };
        Self {
            left: fold(Point::intensity, INTENSITIES.0, f64::min) * 0.8,
            right: fold(Point::intensity, INTENSITIES.1, f64::max) * 1.2,
            low: fold(Point::performance, 1e9, f64::min) * 0.4 / 1e9,
            high: peaks.vector_flops * 2.0 / 1e9,
        }
    }
}

/// Draws roofs and points.
fn draw(canvas: &Canvas, title: &str, peaks: &Peaks, dots: &[Dot]) -> Drawn {
    let is_drawn = |dot: &&Dot| dot.point.intensity().is_finite() && dot.point.performance() > 0.0;
    let dots: Vec<&Dot> = dots.iter().filter(is_drawn).collect();
    let view = View::of(peaks, &dots);
    let mut chart = ChartBuilder::on(canvas)
        .caption(title, ("sans-serif", 18))
        .margin(12)
        .x_label_area_size(42)
        .y_label_area_size(56)
        .build_cartesian_2d((view.left..view.right).log_scale(), (view.low..view.high).log_scale())?;
    chart
        .configure_mesh()
        .light_line_style(WHITE)
        .x_desc("operational intensity, FLOPs per byte loaded or stored")
        .y_desc("GFLOP/s")
        .x_label_formatter(&label)
        .y_label_formatter(&label)
        .draw()?;
    draw_flop_roofs(&mut chart, view, peaks)?;
    draw_memory_roofs(&mut chart, view, peaks)?;
    draw_dots(&mut chart, &dots)
}

/// Draws the roofs of arithmetic. Each begins where the roof of the fastest memory meets it.
fn draw_flop_roofs(chart: &mut Chart, view: View, peaks: &Peaks) -> Drawn {
    let fastest = peaks.bandwidths.iter().fold(0.0, |most: f64, level| most.max(level.bytes_per_second));
    for (name, flops) in [("FMA, 8 floats", peaks.vector_flops), ("FMA, one float", peaks.scalar_flops)] {
        let (begin, height) = ((flops / fastest).max(view.left), flops / 1e9);
        chart.draw_series(LineSeries::new([(begin, height), (view.right, height)], GREY.stroke_width(2)))?;
        let text = format!("{name}: {height:.0} GFLOP/s");
        let small = ("sans-serif", 13).into_font().color(&GREY);
        chart.draw_series([Text::new(text, (view.right / 6.5, height * 1.3), small)])?;
    }
    Ok(())
}

/// Draws the roofs of memory, up to the roof of vector arithmetic.
fn draw_memory_roofs(chart: &mut Chart, view: View, peaks: &Peaks) -> Drawn {
    for (number, Bandwidth { level, bytes_per_second, .. }) in peaks.bandwidths.iter().enumerate() {
        let bytes = bytes_per_second / 1e9;
        let (begin, end) =
            (view.left.max(view.low / bytes), (peaks.vector_flops / bytes_per_second).min(view.right));
        let slope = [(begin, begin * bytes), (end, end * bytes)];
        chart.draw_series(LineSeries::new(slope, GREY.stroke_width(1)))?;
        // Levels may be equally fast, so each label is further to the right, and none covers another.
        let at = begin * 1.15 * 1.9_f64.powi(number as i32);
        let text = format!("{} {bytes:.0} GB/s", level.name());
        let small = ("sans-serif", 13).into_font().color(&GREY);
        chart.draw_series([Text::new(text, (at, at * bytes * 1.25), small)])?;
    }
    Ok(())
}

fn draw_dots(chart: &mut Chart, dots: &[&Dot]) -> Drawn {
    for dot in dots {
        let at = (dot.point.intensity(), dot.point.performance() / 1e9);
        chart.draw_series([Circle::new(at, dot.size, dot.colour.filled())])?;
        let font = ("sans-serif", 14).into_font().color(&dot.colour);
        // The point of the whole row is often close to that of its longest pass, so their names are on different sides.
        let beside = if dot.colour == BLACK { (-4, 10) } else { (9, -6) };
        chart.draw_series([EmptyElement::at(at) + Text::new(dot.name.to_owned(), beside, font)])?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::counted::Operations;
    use crate::report::example::Example;

    #[test]
    fn the_longest_pass_is_red() {
        let (example, roofline) = (Example::of_scenes(), Roofline::example(2));
        let (all, mut passes) = roofline.points(&example.measured(), 0, 0).unwrap();
        let told = |passes: &[Point; 4]| {
            let red = |dot: &Dot<'static>| (dot.name, dot.colour == RED);
            dots(all, passes).iter().map(red).collect::<Vec<_>>()
        };
        let names = ["all", "camera pass", "index", "photon pass", "consolidate"];
        assert_eq!(told(&passes), names.map(|name| (name, name == "camera pass")));
        passes[2].seconds = 5.0;
        assert_eq!(told(&passes), names.map(|name| (name, name == "photon pass")));
        assert_eq!(dots(all, &passes)[0].point, all);
    }

    /// No point is drawn beyond the axes, and the roofs have room.
    #[test]
    fn the_view_is_as_wide_as_points_and_roofs_need() {
        let peaks = Roofline::example(1).peaks;
        let point = |flops: u64, bytes: u64, seconds: f64| {
            let operations = Operations { additions: flops, bytes_loaded: bytes, ..Operations::default() };
            Dot { name: "a", point: Point { seconds, cycles: 1.0, operations }, colour: RED, size: 5 }
        };
        let view = |dots: &[&Dot]| {
            let View { left, right, low, high } = View::of(&peaks, dots);
            [left, right, low, high]
        };
        let usual = view(&[]);
        for (found, expected) in usual.into_iter().zip([0.04, 24.0, 0.4, 256.0]) {
            approx::assert_relative_eq!(found, expected, max_relative = 1e-12);
        }
        assert_eq!(view(&[&point(4_000_000_000, 4_000_000_000, 1.0)]), usual);
        // Little work for its bytes and slow, and much of it.
        let wide = view(&[&point(100, 10_000, 1e-6), &point(100, 1, 1.0)]);
        assert!(wide[0] < 0.01 && wide[1] > 100.0 && wide[2] < 1e-7 && wide[3] == usual[3], "{wide:?}");
    }
}
