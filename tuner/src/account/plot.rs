//! Plots the course of the search.

use super::outcome::Outcome;
use crate::error::Error;
use plots::{Canvas, Drawn, save};
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use std::path::Path;

/// The greatest ratio shown. Few points are slower, and those near the defaults matter.
const MOST: f64 = 1.5;

type Chart<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

/// Draws the ratio of every point, the least ratio so far, and the best point with its interval.
pub(crate) fn write(path: &Path, outcome: &Outcome) -> Result<(), Error> {
    Ok(save(path, |canvas| draw(canvas, outcome))?)
}

fn draw(canvas: &Canvas, outcome: &Outcome) -> Drawn {
    let ratios: Vec<f64> = outcome.found.tried.iter().map(|tried| tried.ratios.median()).collect();
    let [low, high] = outcome.found.best.ratios.interval();
    let all = || ratios.iter().copied().chain([low, high, 1.0]);
    let (least, most) = (all().fold(1.0, f64::min), all().fold(1.0, f64::max).min(MOST));
    let last = ratios.len() as f64 + 1.0;
    let mut chart = ChartBuilder::on(canvas)
        .caption(format!("{}: time over the defaults'", outcome.subject.scene), ("sans-serif", 20))
        .margin(10)
        .x_label_area_size(40)
        .y_label_area_size(50)
        .build_cartesian_2d(0.0..last + 1.0, least - 0.02..most + 0.02)?;
    chart.configure_mesh().x_desc("points tried; at last the best, measured anew").y_desc("ratio").draw()?;
    chart.draw_series(LineSeries::new([(0.0, 1.0), (last + 1.0, 1.0)], BLACK))?;
    draw_points(&mut chart, ratios.into_iter().map(|ratio| ratio.min(most)).collect())?;
    draw_least(&mut chart, outcome.found.best_so_far())?;
    draw_best(&mut chart, last, outcome)?;
    chart.configure_series_labels().position(SeriesLabelPosition::UpperRight).border_style(BLACK).draw()?;
    Ok(())
}

/// The values with their numbers, counted from 1.
fn numbered(values: Vec<f64>) -> impl Iterator<Item = (f64, f64)> {
    (1..).map(f64::from).zip(values)
}

fn draw_points(chart: &mut Chart, ratios: Vec<f64>) -> Drawn {
    let point = Palette99::pick(0).filled();
    chart
        .draw_series(numbered(ratios).map(|at| Circle::new(at, 3, point)))?
        .label("a point")
        .legend(move |(x, y)| Circle::new((x + 7, y), 3, point));
    Ok(())
}

fn draw_least(chart: &mut Chart, least: Vec<f64>) -> Drawn {
    let line = Palette99::pick(1).stroke_width(2);
    chart
        .draw_series(LineSeries::new(numbered(least), line))?
        .label("the least so far")
        .legend(move |(x, y)| PathElement::new([(x, y), (x + 14, y)], line));
    Ok(())
}

fn draw_best(chart: &mut Chart, at: f64, outcome: &Outcome) -> Drawn {
    let ratios = &outcome.found.best.ratios;
    let (bar, [low, high]) = (Palette99::pick(3).stroke_width(3), ratios.interval());
    chart
        .draw_series([PathElement::new([(at, low), (at, high)], bar)])?
        .label("the best, 95 % interval")
        .legend(move |(x, y)| PathElement::new([(x, y), (x + 14, y)], bar));
    chart.draw_series([Circle::new((at, ratios.median()), 5, bar)])?;
    Ok(())
}
