//! Roofline plots (Williams, Waterman and Patterson 2009; figures 10 to 12 of the paper): performance over operational
//! intensity, under the roofs of the machine.

use super::Measured;
use super::passes::PASSES;
use super::plots::{Area, Drawn, save};
use super::roofline::{Point, Roofline};
use crate::terminal::error::Error;
use ladder::Peaks;
use plotters::prelude::*;
use std::path::Path;

/// A point with its name and colour.
struct Dot<'a> {
    name: &'a str,
    point: Point,
    colour: RGBColor,
    size: u32,
}

/// For each scene, one plot of all rows, and one of each row's passes.
pub(super) fn write(folder: &Path, measured: &Measured, roofline: &Roofline) -> Result<(), Error> {
    for (number, case) in measured.cases.iter().enumerate() {
        let mut rows = Vec::new();
        for (place, row) in measured.rows.iter().enumerate() {
            let Some((all, passes)) = roofline.points(measured, number, place) else { continue };
            let colour = Palette99::pick(place).to_rgba();
            rows.push(Dot {
                name: row.name,
                point: all,
                colour: RGBColor(colour.0, colour.1, colour.2),
                size: 5,
            });
            let mut dots = vec![Dot { name: "all", point: all, colour: BLACK, size: 8 }];
            // The pass that takes longest is red, as in the paper.
            let longest = passes.iter().fold(0.0, |most: f64, pass| most.max(pass.seconds));
            for (pass, point) in PASSES.iter().zip(passes) {
                let colour = if point.seconds == longest { RED } else { RGBColor(30, 100, 200) };
                dots.push(Dot { name: pass.name, point, colour, size: 5 });
            }
            let title = format!("{}: roofline of row {} ({})", case.name, row.name, row.about);
            save(folder, &format!("roofline-{}-{}", case.name, row.name), |root| {
                draw(root, &title, &roofline.peaks, &dots)
            })?;
        }
        let title = format!("{}: rooflines of all rows", case.name);
        save(folder, &format!("roofline-{}", case.name), |root| draw(root, &title, &roofline.peaks, &rows))?;
    }
    Ok(())
}

/// Draws roofs and points: both axes logarithmic, with room on all sides.
fn draw(root: &Area, title: &str, peaks: &Peaks, dots: &[Dot]) -> Drawn {
    /// Least and greatest FLOPs a byte that are shown, and more if points lie beyond.
    const INTENSITIES: (f64, f64) = (0.05, 20.0);
    let is_drawn = |dot: &&Dot| dot.point.intensity().is_finite() && dot.point.performance() > 0.0;
    let dots: Vec<&Dot> = dots.iter().filter(is_drawn).collect();
    let fold = |value: fn(&Point) -> f64, start: f64, pick: fn(f64, f64) -> f64| {
        dots.iter().fold(start, |chosen, dot| pick(chosen, value(&dot.point)))
    };
    let left = fold(Point::intensity, INTENSITIES.0, f64::min) * 0.8;
    let right = fold(Point::intensity, INTENSITIES.1, f64::max) * 1.2;
    let (low, high) = (fold(Point::performance, 1e9, f64::min) * 0.4 / 1e9, peaks.vector_flops * 2.0 / 1e9);
    let mut chart = ChartBuilder::on(root)
        .caption(title, ("sans-serif", 18))
        .margin(12)
        .x_label_area_size(42)
        .y_label_area_size(56)
        .build_cartesian_2d((left..right).log_scale(), (low..high).log_scale())?;
    chart
        .configure_mesh()
        .light_line_style(WHITE)
        .x_desc("operational intensity, FLOPs per byte loaded or stored")
        .y_desc("GFLOP/s")
        .x_label_formatter(&plain)
        .y_label_formatter(&plain)
        .draw()?;
    let grey = RGBColor(90, 90, 90);
    let small = ("sans-serif", 13).into_font().color(&grey);
    // Each roof begins where the fastest memory meets it.
    let fastest = peaks.bandwidths.iter().fold(0.0, |most: f64, level| most.max(level.bytes_per_second));
    for (name, flops) in [("FMA, 8 floats", peaks.vector_flops), ("FMA, one float", peaks.scalar_flops)] {
        let (begin, flops_scaled) = ((flops / fastest).max(left), flops / 1e9);
        chart.draw_series(LineSeries::new(
            [(begin, flops_scaled), (right, flops_scaled)],
            grey.stroke_width(2),
        ))?;
        let text = format!("{name}: {flops_scaled:.0} GFLOP/s");
        chart.draw_series([Text::new(text, (right / 6.5, flops_scaled * 1.3), small.clone())])?;
    }
    for (number, level) in peaks.bandwidths.iter().enumerate() {
        let bytes = level.bytes_per_second / 1e9;
        let end = (peaks.vector_flops / level.bytes_per_second).min(right);
        let begin = left.max(low / bytes);
        let slope = [(begin, begin * bytes), (end, end * bytes)];
        chart.draw_series(LineSeries::new(slope, grey.stroke_width(1)))?;
        // Labels one below the other along the left edge would collide where levels are alike: they are moved along.
        let at = begin * 1.15 * 1.9_f64.powi(number as i32);
        let text = format!("{} {bytes:.0} GB/s", level.level.name());
        chart.draw_series([Text::new(text, (at, at * bytes * 1.25), small.clone())])?;
    }
    for dot in dots {
        let at = (dot.point.intensity(), dot.point.performance() / 1e9);
        chart.draw_series([Circle::new(at, dot.size, dot.colour.filled())])?;
        let font = ("sans-serif", 14).into_font().color(&dot.colour);
        // The whole lies upon its longest pass: their names go to different sides.
        let beside = if dot.colour == BLACK { (-4, 10) } else { (9, -6) };
        chart.draw_series([EmptyElement::at(at) + Text::new(dot.name.to_owned(), beside, font)])?;
    }
    Ok(())
}

/// A number on an axis: as many digits as it has.
#[allow(clippy::trivially_copy_pass_by_ref)] // as plotters wants it
pub(super) fn plain(value: &f64) -> String {
    format!("{}", (value * 1e6).round() / 1e6)
}
