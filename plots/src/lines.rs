//! Line plots with a common horizontal axis and a legend on the right.

use crate::axis::label;
use crate::canvas::{Canvas, Drawn};
use plotters::coord::ranged1d::ValueFormatter;
use plotters::prelude::*;

/// Room for the legend on the right, as a share of the width of the lines.
const ROOM: f64 = 0.25;

/// A line.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Its name in the legend.
    pub label: String,
    /// Its points (x, y), by increasing x.
    pub points: Vec<(f64, f64)>,
}

/// The scale of both axes of a plot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Linear.
    Linear,
    /// Logarithmic; all values must be positive.
    Logarithmic,
}

/// A plot of lines.
#[derive(Clone, Copy, Debug)]
pub struct LinePlot<'a> {
    /// The caption.
    pub title: &'a str,
    /// The label of the horizontal axis.
    pub x_axis: &'a str,
    /// The label of the vertical axis.
    pub y_axis: &'a str,
    /// The scale of both axes.
    pub scale: Scale,
    /// The lines.
    pub series: &'a [Series],
}

impl LinePlot<'_> {
    /// Draws the plot.
    ///
    /// # Errors
    /// If the backend fails.
    pub fn draw(&self, canvas: &Canvas) -> Drawn {
        let ((left, right), (low, high)) = (self.range(|point| point.0), self.range(|point| point.1));
        let mut builder = ChartBuilder::on(canvas);
        builder
            .caption(self.title, ("sans-serif", 20))
            .margin(10)
            .x_label_area_size(40)
            .y_label_area_size(50);
        match self.scale {
            Scale::Logarithmic => {
                let x = (left..right * (right / left).powf(ROOM)).log_scale();
                let y = (low * 0.9..high * 1.2).log_scale();
                self.draw_on(builder.build_cartesian_2d(x, y)?)
            }
            Scale::Linear => {
                let x = left..right + ROOM * (right - left);
                self.draw_on(builder.build_cartesian_2d(x, low..high * 1.1)?)
            }
        }
    }

    /// The least and the greatest `value` of all points.
    fn range(&self, value: fn(&(f64, f64)) -> f64) -> (f64, f64) {
        let values = self.series.iter().flat_map(|series| &series.points).map(value);
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
    }

    fn draw_on<'a, 'b, X, Y>(&self, mut chart: ChartContext<'a, SVGBackend<'b>, Cartesian2d<X, Y>>) -> Drawn
    where
        'b: 'a,
        X: Ranged<ValueType = f64> + ValueFormatter<f64>,
        Y: Ranged<ValueType = f64> + ValueFormatter<f64>,
    {
        chart
            .configure_mesh()
            .light_line_style(WHITE)
            .x_desc(self.x_axis)
            .y_desc(self.y_axis)
            .x_label_formatter(&label)
            .y_label_formatter(&label)
            .draw()?;
        for (number, series) in self.series.iter().enumerate() {
            let colour = Palette99::pick(number).stroke_width(2);
            chart
                .draw_series(LineSeries::new(series.points.iter().copied(), colour).point_size(3))?
                .label(&series.label)
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 14, y)], colour));
        }
        let labels = SeriesLabelPosition::MiddleRight;
        chart.configure_series_labels().position(labels).border_style(BLACK).draw()?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::canvas::render;

    fn series(points: &[(f64, f64)]) -> Series {
        Series { label: "a line".into(), points: points.to_vec() }
    }

    fn plot(series: &[Series], scale: Scale) -> LinePlot<'_> {
        LinePlot { title: "", x_axis: "", y_axis: "", scale, series }
    }

    /// The places of all points.
    fn places(drawn: &str) -> Vec<(i32, i32)> {
        let place = |circle: &str| {
            let mut numbers = circle.split('"').filter_map(|part| part.parse().ok());
            (numbers.next().unwrap(), numbers.next().unwrap())
        };
        drawn.split("<circle cx=\"").skip(1).map(place).collect()
    }

    #[test]
    fn titles_and_labels_stand_where_they_belong() {
        let named = |label: &str, points: &[(f64, f64)]| Series { label: label.into(), ..series(points) };
        let lines = [named("one", &[(1.0, 2.0), (3.0, 4.0)]), named("two", &[(1.0, 4.0), (3.0, 2.0)])];
        let plot = LinePlot { title: "all", x_axis: "across", y_axis: "up", ..plot(&lines, Scale::Linear) };
        let drawn = render(|canvas| plot.draw(canvas)).unwrap();
        // What begins a text, and where it is.
        let tag = |text: &str| {
            let end = drawn.find(&format!(">\n{text}\n")).unwrap_or_else(|| panic!("no {text} in {drawn}"));
            &drawn[drawn[..end].rfind('<').unwrap()..end]
        };
        assert!(tag("up").contains("rotate(270") && !tag("across").contains("rotate"), "{drawn}");
        let heights = ["all", "one", "two", "across"].map(|text| {
            let mut parts = tag(text).split(" y=\"").nth(1).unwrap().split('"');
            parts.next().unwrap().parse::<i32>().unwrap()
        });
        assert!(heights.is_sorted_by(|above, below| above < below), "{heights:?}");
        // Every line has a colour of its own, which its name in the legend has too.
        let lines = drawn.split("<polyline").skip(1).filter(|line| line.contains("stroke-width=\"2\""));
        let colour =
            |line: &str| line.split("stroke=\"").nth(1).unwrap().split('"').next().unwrap().to_owned();
        let colours: Vec<String> = lines.map(colour).filter(|colour| colour != "#000000").collect();
        let of = |colour: &String| colours.iter().filter(|other| *other == colour).count();
        assert!(colours.len() == 4 && colours.iter().all(|colour| of(colour) == 2), "{colours:?}");
    }

    #[test]
    fn equal_ratios_are_equally_far_apart_on_logarithmic_axes_alone() {
        let lines = [series(&[(1.0, 1.0), (10.0, 10.0), (100.0, 100.0)])];
        let steps = |scale| {
            let [a, b, c] = places(&render(|canvas| plot(&lines, scale).draw(canvas)).unwrap())[..] else {
                panic!("three points")
            };
            [b.0 - a.0, c.0 - b.0, a.1 - b.1, b.1 - c.1]
        };
        let [x, next_x, y, next_y] = steps(Scale::Logarithmic);
        assert!((x - next_x).abs() <= 1 && (y - next_y).abs() <= 1 && x.min(y) > 100);
        let [x, next_x, y, next_y] = steps(Scale::Linear);
        assert!(next_x > 9 * x && next_y > 9 * y);
    }

    #[test]
    fn axes_hold_all_points_of_all_lines() {
        let lines =
            [series(&[(2.0, 5.0), (3.0, 4.0)]), series(&[(1.0, 6.0), (4.0, 3.0)]), series(&[(2.5, 9.0)])];
        let plot = plot(&lines, Scale::Linear);
        assert_eq!((plot.range(|point| point.0), plot.range(|point| point.1)), ((1.0, 4.0), (3.0, 9.0)));
    }

    /// No point is drawn at the edge of the image, where what is outside of the axes is.
    #[test]
    fn points_are_drawn_within_the_image() {
        for scale in [Scale::Linear, Scale::Logarithmic] {
            let lines = [series(&[(2.0, 5.0), (3.0, 4.0)]), series(&[(1.0, 50.0), (40.0, 0.5)])];
            let drawn = render(|canvas| plot(&lines, scale).draw(canvas)).unwrap();
            let places = places(&drawn);
            assert_eq!(places.len(), 4, "{drawn}");
            assert!(
                places.iter().all(|&(x, y)| (50..880).contains(&x) && (20..540).contains(&y)),
                "{places:?}"
            );
            // Four points, four places.
            assert!((0..4).all(|a| (0..a).all(|b| places[a] != places[b])), "{places:?}");
        }
    }
}
