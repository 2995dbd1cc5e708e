//! Prints what the reader finds in a file, for tests in other languages: `dump FILE [FRAME|last]`.
//!
//! The first line is an object of JSON with counts, names, cell and bonds. Then come the columns, little-endian, in the
//! order in which the object lists them.

use importers::{Frame, Labels, Particles, Properties, Request, frames, read};
use std::fmt::Write as _;
use std::io::{self, Write as _};
use std::path::Path;
use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let frame = match arguments.get(1).map(String::as_str) {
        None => Some(Frame::Number(0)),
        Some("last") => Some(Frame::Last),
        Some(number) => number.parse().ok().map(Frame::Number),
    };
    let (Some(path), Some(frame)) = (arguments.first(), frame) else {
        eprintln!("usage: dump FILE [FRAME|last]");
        return ExitCode::from(2);
    };
    let path = Path::new(path);
    let request = Request { frame, properties: Properties::All, ..Request::default() };
    match frames(path).and_then(|frames| Ok((frames, read(path, &request)?))) {
        Ok((frames, particles)) => match write(frames, &particles) {
            Ok(()) => ExitCode::SUCCESS,
            Err(error) => fail(&error),
        },
        Err(error) => fail(&error),
    }
}

fn fail(error: &dyn std::error::Error) -> ExitCode {
    eprintln!("error: {error}");
    ExitCode::FAILURE
}

fn write(frames: usize, particles: &Particles) -> io::Result<()> {
    let mut columns: Vec<(String, &str, Vec<u8>)> = Vec::new();
    let mut add = |name: &str, kind: &'static str, bytes: Option<Vec<u8>>| {
        columns.extend(bytes.map(|bytes| (name.to_owned(), kind, bytes)));
    };
    let f64s = particles.positions.iter().flatten().flat_map(|number| number.to_le_bytes());
    add("positions", "<f8", Some(f64s.collect()));
    add("elements", "|u1", particles.elements.clone());
    add(
        "radii",
        "<f4",
        particles.radii.as_ref().map(|all| all.iter().flat_map(|v| v.to_le_bytes()).collect()),
    );
    let colors = particles.colors.as_ref();
    add("colors", "<f4", colors.map(|all| all.iter().flatten().flat_map(|v| v.to_le_bytes()).collect()));
    add("ids", "<u8", particles.ids.as_ref().map(|all| all.iter().flat_map(|v| v.to_le_bytes()).collect()));
    let molecules = particles.molecules.as_ref();
    add("molecules", "<u4", molecules.map(|all| all.iter().flat_map(|v| v.to_le_bytes()).collect()));
    let numbers = particles.residue_numbers.as_ref();
    add("residue_numbers", "<i4", numbers.map(|all| all.iter().flat_map(|v| v.to_le_bytes()).collect()));
    let index = |labels: &Labels| labels.index.iter().flat_map(|v| v.to_le_bytes()).collect();
    let labels = [
        ("types", &particles.types),
        ("names", &particles.names),
        ("residues", &particles.residues),
        ("chains", &particles.chains),
    ];
    for (name, labels) in &labels {
        add(name, "<u2", labels.as_ref().map(index));
    }
    for property in &particles.properties {
        add(&property.name, "<f4", Some(property.values.iter().flat_map(|v| v.to_le_bytes()).collect()));
    }
    let names = labels.iter().filter_map(|(name, labels)| Some((name, &labels.as_ref()?.names)));
    let names: Vec<String> = names.map(|(name, names)| format!("{name:?}: {names:?}")).collect();
    let cell = particles.cell.map_or("null".to_owned(), |cell| {
        let sides = cell.periodic.map(u8::from);
        format!("{{\"origin\": {:?}, \"vectors\": {:?}, \"periodic\": {sides:?}}}", cell.origin, cell.vectors)
    });
    let listed: Vec<String> = columns.iter().map(|(name, kind, _)| format!("[{name:?}, {kind:?}]")).collect();
    let mut line = String::new();
    let _ = write!(
        line,
        "{{\"format\": {:?}, \"frames\": {frames}, \"count\": {}, \"unit\": \"{:?}\", \"cell\": {cell}, \"bonds\": {:?}, ",
        particles.format.name(),
        particles.len(),
        particles.unit,
        particles.bonds,
    );
    let _ = writeln!(line, "\"labels\": {{{}}}, \"columns\": [{}]}}", names.join(", "), listed.join(", "));
    let mut out = io::stdout().lock();
    out.write_all(line.as_bytes())?;
    columns.iter().try_for_each(|(_, _, bytes)| out.write_all(bytes))
}
