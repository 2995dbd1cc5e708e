//! The measurements: the runs of all rows in all cases, and figures computed from them.

use super::case::Case;
use super::passes::PASSES;
use super::runs::Runs;
use super::sweep::Sweep;
use crate::table::Row;

/// The measurements.
pub(crate) struct Measured<'a> {
    /// The rows that ran.
    pub rows: &'a [&'static Row],
    /// The cases that each row rendered.
    pub cases: &'a [Case],
    /// The runs of each row, for each case.
    pub runs: &'a [Vec<Runs>],
    /// The parameter that was varied, if any.
    pub sweep: Option<Sweep>,
}

impl Measured<'_> {
    /// The length of the longest row name, in characters.
    pub(crate) fn widest_name(&self) -> usize {
        self.rows.iter().map(|row| row.name.len()).max().unwrap_or(0)
    }

    /// The speedup of a row over the first row in a case.
    pub(crate) fn speedup(&self, case: usize, row: usize) -> f64 {
        let seconds = |row: usize| self.runs[case][row].median().seconds;
        seconds(0) / seconds(row)
    }

    /// The scenes, each with the indices of its cases.
    pub(crate) fn scenes(&self) -> Vec<(&str, Vec<usize>)> {
        let mut scenes: Vec<(&str, Vec<usize>)> = Vec::new();
        for (number, case) in self.cases.iter().enumerate() {
            match scenes.last_mut() {
                Some((name, cases)) if *name == case.name => cases.push(number),
                _ => scenes.push((&case.name, vec![number])),
            }
        }
        scenes
    }

    /// The seconds of a row's pass in the median runs of these cases.
    pub(crate) fn pass_seconds(&self, cases: &[usize], row: usize, pass: usize) -> Vec<f64> {
        cases.iter().map(|&case| (PASSES[pass].seconds)(&self.runs[case][row].median().stats)).collect()
    }

    /// The seconds of a pass, divided by the work that the paper's analysis predicts.
    pub(crate) fn cost_of_work(&self, cases: &[usize], row: usize, pass: usize, sweep: Sweep) -> Vec<f64> {
        let times = self.pass_seconds(cases, row, pass).into_iter();
        times.zip(cases).map(|(t, &case)| t / PASSES[pass].predicted(sweep, self.cases[case].value)).collect()
    }

    /// The exponent with which a row's time grows with the varied parameter.
    pub(crate) fn growth(&self, cases: &[usize], row: usize) -> f64 {
        let point = |case: &usize| (self.cases[*case].value as f64, self.runs[*case][row].median().seconds);
        exponent(&cases.iter().map(point).collect::<Vec<_>>())
    }
}

/// The exponent of `y` as a power of `x`: the slope of the least-squares line through the logarithms.
fn exponent(points: &[(f64, f64)]) -> f64 {
    let logarithms: Vec<(f64, f64)> = points.iter().map(|(x, y)| (x.ln(), y.ln())).collect();
    let n = logarithms.len() as f64;
    let (mean_x, mean_y) = logarithms.iter().fold((0.0, 0.0), |(a, b), (x, y)| (a + x / n, b + y / n));
    let (mut covariance, mut variance) = (0.0, 0.0);
    for (x, y) in logarithms {
        covariance += (x - mean_x) * (y - mean_y);
        variance += (x - mean_x) * (x - mean_x);
    }
    covariance / variance
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponents_of_powers_are_found() {
        let points = |p: f64| [1.0_f64, 2.0, 8.0].map(|x| (x, 3.0 * x.powf(p)));
        for power in [0.0, 1.0, 1.5] {
            approx::assert_abs_diff_eq!(exponent(&points(power)), power, epsilon = 1e-12);
        }
    }
}
