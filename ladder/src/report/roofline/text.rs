//! Formats peaks, FLOPs and FLOPs per cycle as tables of text.

use super::count::Roofline;
use crate::machine::Peaks;
use crate::report::measured::Measured;
use crate::report::passes::PASSES;
use std::fmt::Write;

/// The clock, the peaks, and the counts of every row in every case.
pub(crate) fn text(roofline: &Roofline, measured: &Measured) -> String {
    let mut text = String::new();
    write_peaks(&mut text, &roofline.peaks);
    for case in 0..measured.cases.len() {
        write_case(&mut text, roofline, measured, case);
    }
    text
}

fn write_peaks(text: &mut String, peaks: &Peaks) {
    let Peaks { clock, scalar_flops, vector_flops, bandwidths } = peaks;
    let _ = writeln!(text, "\n{:.2} GHz; {}", clock.hertz / 1e9, clock.source.about());
    for (name, flops) in [("one float", scalar_flops), ("8 floats", vector_flops)] {
        let (rate, each) = (flops / 1e9, flops / clock.hertz);
        let _ = writeln!(text, "peak by FMA of {name}: {rate:.1} GFLOP/s, {each:.2} FLOPs/cycle");
    }
    for bandwidth in bandwidths {
        let (level, rate) = (bandwidth.level.name(), bandwidth.bytes_per_second / 1e9);
        let each = bandwidth.bytes_per_second / clock.hertz;
        let _ = writeln!(text, "peak reading {level}: {rate:.1} GB/s, {each:.2} bytes/cycle");
    }
}

fn write_case(text: &mut String, roofline: &Roofline, measured: &Measured, number: usize) {
    let case = &measured.cases[number];
    let widest = measured.widest_name().max(3);
    let value = measured.sweep.map_or(String::new(), |sweep| format!(", {} {}", case.value, sweep.noun()));
    let passes = PASSES.map(|pass| format!("{:>12}", pass.name)).concat();
    let _ =
        writeln!(text, "\n{}{value}: FLOPs, FLOPs/byte, and FLOPs/cycle of all and of each pass", case.name);
    let _ = writeln!(text, "  {:widest$}  {:>10}{:>12}{:>12}{passes}", "row", "GFLOPs", "FLOPs/byte", "all");
    for (place, row) in measured.rows.iter().enumerate() {
        let name = row.name;
        let _ = match roofline.points(measured, number, place) {
            None => writeln!(text, "  {name:widest$}  {:>10}", "not counted"),
            Some((all, passes)) => {
                let each = passes.map(|pass| format!("{:>12.3}", pass.flops_per_cycle())).concat();
                let (flops, intensity) = (all.operations.flops() as f64 / 1e9, all.intensity());
                let whole = all.flops_per_cycle();
                writeln!(text, "  {name:widest$}  {flops:>10.3}{intensity:>12.3}{whole:>12.3}{each}")
            }
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::example::Example;

    #[test]
    fn peaks_and_counts_are_told_per_second_and_per_cycle() {
        let told = "
4.00 GHz; no hardware counter here: cycles are time at the clock measured by a chain of dependent operations
peak by FMA of one float: 16.0 GFLOP/s, 4.00 FLOPs/cycle
peak by FMA of 8 floats: 128.0 GFLOP/s, 32.00 FLOPs/cycle
peak reading L1: 400.0 GB/s, 100.00 bytes/cycle
peak reading DRAM: 20.0 GB/s, 5.00 bytes/cycle

a: FLOPs, FLOPs/byte, and FLOPs/cycle of all and of each pass
  row       GFLOPs  FLOPs/byte         all camera pass       index photon pass consolidate
  0         26.000       1.182       1.841       0.625       3.000       1.750      64.000
  6         26.000       1.182       3.586       1.250       6.000       3.500      32.000
  fast  not counted

b: FLOPs,";
        let text = text(&Roofline::example(2), &Example::of_scenes().measured());
        assert!(text.starts_with(told), "{text}");
    }

    #[test]
    fn cases_of_a_sweep_are_told_with_their_values() {
        let text = text(&Roofline::example(4), &Example::of_sweep().measured());
        for head in ["\na, 10 photons: FLOPs,", "\na, 40 photons: FLOPs,", "\nb, 10 photons: FLOPs,"] {
            assert!(text.contains(head), "no {head:?} in {text}");
        }
    }
}
