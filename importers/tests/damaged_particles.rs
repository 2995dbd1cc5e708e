//! Damages a file of every format in thousands of ways. Readers must reject it with one line or read particles that
//! satisfy what they promise, and must use at most twice the memory that the undamaged file takes.
//!
//! This is a separate binary with a single test because it measures the memory of the whole process.

#[path = "../../tests/shared/cases.rs"]
mod cases;
mod specimens;

use importers::{Frame, Particles, Properties, Request, read_from};
use peak_alloc::PeakAlloc;
use scene::rng::{Family, Stream, StreamKey};
use specimens::{COUNT, Specimen, specimens};
use std::io::Cursor;

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// Damaged variants per file, unless `SPPM_DAMAGES` gives another number.
const DAMAGES: u32 = 600;
/// Additional memory allowed for error messages and for allocations that are rounded up.
const SLACK: usize = 1 << 14;

fn read(specimen: &Specimen, bytes: &[u8], frame: Frame) -> Result<Particles, String> {
    let request = Request { frame, properties: Properties::All, ..Request::default() };
    read_from(specimen.name, Cursor::new(bytes), specimen.format, &request).map_err(|error| error.to_string())
}

/// Reads a file in memory; returns the result and the peak memory used in addition to `bytes`.
fn measured(specimen: &Specimen, bytes: &[u8], frame: Frame) -> (Result<Particles, String>, usize) {
    let before = MEMORY.current_usage();
    MEMORY.reset_peak_usage();
    let result = read(specimen, bytes, frame);
    (result, MEMORY.peak_usage().saturating_sub(before))
}

/// Flips some bits, truncates, overwrites a word, or replaces a number of a text. In half of the cases this is near the
/// beginning, where sizes are stored. Returns a description.
fn damage(bytes: &mut Vec<u8>, numbers: &mut Stream) -> String {
    let length = bytes.len();
    let span = if numbers.next_u32().is_multiple_of(2) { length.min(600) } else { length };
    let at = numbers.next_u32() as usize % span;
    match numbers.next_u32() % 10 {
        0 => {
            bytes.truncate(at);
            format!("cut after {at} of {length} bytes")
        }
        1 if at + 8 <= length => {
            let words = [0, u64::MAX, i64::MAX as u64, 1 << 63, 1 << 40, u64::from(u32::MAX), 1 << 31];
            let word = words[numbers.next_u32() as usize % words.len()];
            let size = [4, 8][numbers.next_u32() as usize % 2];
            bytes[at..at + size].copy_from_slice(&word.to_le_bytes()[..size]);
            format!("{word:#x} of {size} bytes at {at}")
        }
        2..=5 => {
            let texts = [
                "999999999999",
                "-1",
                "1e308",
                "nan",
                "4294967296",
                "18446744073709551615",
                "",
                "0",
                "\"",
                "\n",
                "99999",
                "x",
            ];
            let text = texts[numbers.next_u32() as usize % texts.len()];
            let is_digit = |byte: &u8| byte.is_ascii_digit() || matches!(byte, b'.' | b'-');
            let start = at + bytes[at..].iter().position(is_digit).unwrap_or(0);
            let end = start + bytes[start..].iter().position(|byte| !is_digit(byte)).unwrap_or(0);
            bytes.splice(start..end, text.bytes());
            format!("{text:?} at {start}..{end}")
        }
        6 => {
            let end = (at + numbers.next_u32() as usize % 100).min(length);
            bytes.drain(at..end);
            format!("{at}..{end} left out")
        }
        more => {
            let bits: Vec<usize> =
                (6..more).map(|_| 8 * at + numbers.next_u32() as usize % (8 * (length - at))).collect();
            for bit in &bits {
                bytes[bit / 8] ^= 1 << (bit % 8);
            }
            format!("bits {bits:?} flipped")
        }
    }
}

/// What readers promise of all particles.
fn check(particles: &Particles) {
    let count = particles.len();
    assert!(particles.positions.iter().flatten().all(|number| number.abs() <= Particles::FARTHEST));
    let lengths = [
        particles.elements.as_ref().map(Vec::len),
        particles.radii.as_ref().map(Vec::len),
        particles.colors.as_ref().map(Vec::len),
        particles.residue_numbers.as_ref().map(Vec::len),
        particles.molecules.as_ref().map(Vec::len),
        particles.ids.as_ref().map(Vec::len),
    ];
    let labels = [&particles.types, &particles.names, &particles.residues, &particles.chains];
    let labels = labels.into_iter().flatten();
    assert!(
        labels
            .clone()
            .all(|labels| labels.index.iter().all(|&index| usize::from(index) < labels.names.len()))
    );
    let lengths = lengths.into_iter().flatten().chain(labels.map(|labels| labels.index.len()));
    let lengths = lengths.chain(particles.properties.iter().map(|property| property.values.len()));
    assert_eq!(lengths.filter(|length| *length != count).count(), 0);
    assert!(particles.elements.iter().flatten().all(|&number| number <= importers::elements::COUNT));
    assert!(particles.radii.iter().flatten().all(|radius| radius.is_finite() && *radius >= 0.0));
    assert!(particles.colors.iter().flatten().flatten().all(|component| (0.0..=1.0).contains(component)));
    assert!(particles.bonds.iter().all(|[a, b]| a < b && (*b as usize) < count));
    assert!(particles.bonds.is_sorted());
    assert!(
        particles
            .cell
            .is_none_or(|cell| cell.volume() > 0.0 && cell.corners().iter().flatten().all(|c| c.is_finite()))
    );
    assert!(
        particles.title.chars().count() <= Particles::TITLE && !particles.title.contains(char::is_control)
    );
}

#[test]
fn damaged_files_are_rejected_with_bounded_memory() {
    let asked = std::env::var("SPPM_DAMAGES").ok().map(|damages| damages.parse::<u32>().expect("a number"));
    let (mut faults, mut all) = (Vec::new(), 0);
    for specimen in specimens() {
        let (name, bytes) = (specimen.name, &specimen.bytes);
        // Once before measuring, as the first time fills tables that are kept.
        let whole = read(&specimen, bytes, Frame::Number(0)).unwrap();
        assert!((COUNT / 2..=COUNT).contains(&whole.len()), "{name} has {} particles", whole.len());
        let honest = [Frame::Number(0), Frame::Last].map(|frame| measured(&specimen, bytes, frame).1);
        let honest = honest[0].max(honest[1]);
        let (mut refused, mut worst) = (0, 0);
        let damages = asked.unwrap_or(DAMAGES);
        for number in 0..damages {
            let mut numbers = StreamKey::new(3, Family::Path, 0).stream(number);
            let mut damaged = bytes.clone();
            let what = damage(&mut damaged, &mut numbers);
            let frame = if number % 3 == 0 { Frame::Last } else { Frame::Number(0) };
            let (result, peak) = measured(&specimen, &damaged, frame);
            worst = worst.max(peak);
            if peak > 2 * honest + SLACK {
                let result = result.as_ref().map(Particles::len);
                faults.push(format!(
                    "{name}, {what}: {peak} bytes, where the whole file takes {honest}: {result:?}"
                ));
            }
            match result {
                Err(line) => {
                    refused += 1;
                    let is_line =
                        line.starts_with(name) && line.len() < 600 && !line.contains(char::is_control);
                    assert!(is_line, "{name}, {what}: {line:?}");
                }
                Ok(particles) => check(&particles),
            }
        }
        all += damages as usize;
        assert!(refused > damages / 10, "{name}: only {refused} of {damages} damages were refused");
        println!(
            "{name}: {refused} of {damages} damages refused; {worst} bytes at worst, the whole file {honest}"
        );
    }
    assert!(
        faults.is_empty(),
        "{} faults, the first of them:\n{}",
        faults.len(),
        faults[..faults.len().min(20)].join("\n")
    );
    cases::tell("damaged_particles", all, "damaged files");
}
