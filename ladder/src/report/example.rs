//! Measurements of known figures, for the tests of what is told of them.

use super::case::Case;
use super::measured::Measured;
use super::runs::Runs;
use super::sweep::Sweep;
use crate::table::{Row, find};
use scene::Settings;

/// Rows 0, 6 and fast in a few cases. Of row 0 cycles are counted.
pub(crate) struct Example {
    rows: Vec<&'static Row>,
    cases: Vec<Case>,
    runs: Vec<Vec<Runs>>,
    sweep: Option<Sweep>,
}

impl Example {
    /// In the scenes a and b.
    pub(crate) fn of_scenes() -> Self {
        Self::new(None, &[("a", 0, [8.0, 2.0, 1.0]), ("b", 0, [12.0, 4.0, 2.0])])
    }

    /// In the scenes a and b with 10 and with 40 photons.
    pub(crate) fn of_sweep() -> Self {
        let cases = [
            ("a", 10, [1.0, 0.5, 0.25]),
            ("a", 40, [8.0, 2.0, 0.5]),
            ("b", 10, [2.0, 1.0, 0.5]),
            ("b", 40, [4.0, 1.0, 1.0]),
        ];
        Self::new(Some(Sweep::Photons), &cases)
    }

    /// With the name, the value and the rows' seconds of each case.
    fn new(sweep: Option<Sweep>, cases: &[(&str, u32, [f64; 3])]) -> Self {
        let scene = files::builtin::scene("cornell").unwrap();
        let case = |&(name, value, _): &(&str, u32, [f64; 3])| {
            let photons_per_iteration = if sweep.is_some() { value } else { 50 };
            let (width, height, iterations, max_depth) = (8, 6, 3, 5);
            let settings =
                Settings { width, height, iterations, max_depth, photons_per_iteration, ..scene.settings };
            Case { name: name.into(), scene: scene.clone(), settings, value: value.into() }
        };
        let runs_of = |&(_, _, seconds): &(&str, u32, [f64; 3])| {
            let cycles = [Some((2e9 * seconds[0]) as u64), None, None];
            seconds.into_iter().zip(cycles).map(|(seconds, cycles)| Runs::example(seconds, cycles)).collect()
        };
        Self {
            rows: ["0", "6", "fast"].map(|name| find(name).unwrap()).into(),
            cases: cases.iter().map(case).collect(),
            runs: cases.iter().map(runs_of).collect(),
            sweep,
        }
    }

    pub(crate) fn measured(&self) -> Measured<'_> {
        Measured { rows: &self.rows, cases: &self.cases, runs: &self.runs, sweep: self.sweep }
    }
}
