//! Formats median seconds and speedups as text, and for a sweep how they grow.

use crate::report::measured::Measured;
use crate::report::passes::PASSES;
use crate::report::sweep::Sweep;
use std::fmt::Write;

/// Median seconds and speedups as a table of text, scene by scene.
pub(crate) fn text(measured: &Measured) -> String {
    let mut text = String::new();
    for (name, cases) in measured.scenes() {
        write_scene(&mut text, measured, name, &cases);
        if let Some(sweep) = measured.sweep {
            write_spreads(&mut text, measured, &cases, sweep);
        }
    }
    text
}

fn write_scene(text: &mut String, measured: &Measured, name: &str, cases: &[usize]) {
    let widest = measured.widest_name();
    let header = match measured.sweep {
        None => format!("{:>10}  {:>8}", "seconds", "speedup"),
        Some(sweep) => {
            let values: Vec<String> =
                cases.iter().map(|case| format!("{:>10}", measured.cases[*case].value)).collect();
            format!("{}  grows as {} to the", values.concat(), sweep.noun())
        }
    };
    let _ = writeln!(text, "{name}\n  {:widest$}  {header}", "row");
    for (number, row) in measured.rows.iter().enumerate() {
        let _ = write!(text, "  {:widest$}  ", row.name);
        for &case in cases {
            let _ = write!(text, "{:>10.3}", measured.runs[case][number].median().seconds);
        }
        let _ = match measured.sweep {
            None => writeln!(text, "  {:>8.2}", measured.speedup(cases[0], number)),
            Some(_) => writeln!(text, "  {:.2}", measured.growth(cases, number)),
        };
    }
}

/// Writes how far the growth of each pass is from the paper's analysis; 1 is exact.
fn write_spreads(text: &mut String, measured: &Measured, cases: &[usize], sweep: Sweep) {
    let widest = measured.widest_name();
    let _ = writeln!(text, "  seconds over the work that the paper's analysis predicts, most over least");
    let names = PASSES.map(|pass| format!("{:>13}", pass.name)).concat();
    let _ = writeln!(text, "  {:widest$}  {names}", "row");
    for (number, row) in measured.rows.iter().enumerate() {
        let spread = |pass| {
            let costs = measured.cost_of_work(cases, number, pass, sweep);
            let most = costs.iter().copied().fold(0.0, f64::max);
            format!("{:>13.2}", most / costs.into_iter().fold(f64::INFINITY, f64::min))
        };
        let _ = writeln!(text, "  {:widest$}  {}", row.name, [0, 1, 2, 3].map(spread).concat());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::example::Example;

    /// Speedups are over the first row of the same scene.
    #[test]
    fn every_scene_has_a_table_of_medians_and_speedups() {
        let told = "\
a
  row      seconds   speedup
  0          8.000      1.00
  6          2.000      4.00
  fast       1.000      8.00
b
  row      seconds   speedup
  0         12.000      1.00
  6          4.000      3.00
  fast       2.000      6.00
";
        assert_eq!(text(&Example::of_scenes().measured()), told);
    }

    /// More photons are work for the photon pass alone.
    #[test]
    fn a_sweep_is_told_with_how_rows_and_passes_grow() {
        let told = "\
a
  row           10        40  grows as photons to the
  0          1.000     8.000  1.50
  6          0.500     2.000  1.00
  fast       0.250     0.500  0.50
  seconds over the work that the paper's analysis predicts, most over least
  row     camera pass        index  photon pass  consolidate
  0              8.00         8.00         2.00         1.00
  6              4.00         4.00         1.00         1.00
  fast           2.00         2.00         2.00         1.00
b
";
        let text = text(&Example::of_sweep().measured());
        assert!(text.starts_with(told), "{text}");
    }
}
