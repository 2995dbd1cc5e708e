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
