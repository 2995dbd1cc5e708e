//! LAMMPS dumps as text: sections that begin with `ITEM:`, frame after frame (<https://docs.lammps.org/dump.html>).
//!
//! Atoms come in any order; they are sorted by id. Coordinates are `x` (as they are), `xs` (scaled by the box), `xu`
//! (unwrapped) or `xsu` (both). The bounds of a triclinic box are those of its bounding box. A general triclinic box is
//! given by its vectors.

use crate::cell::cell;
use crate::error::{Fault, quote};
use crate::format::Format;
use crate::layout::{Kind, Layout, MOST_COLUMNS, Role};
use crate::particles::{Cell, Particles, title};
use crate::request::{Properties, Request};
use crate::rows::{self, Separated};
use crate::text::{Fields, Text, number};
use crate::unit::Unit;

/// The names of coordinates, the preferred ones first, and whether they are scaled by the box.
const AXES: [([&str; 3], bool); 4] = [
    (["x", "y", "z"], false),
    (["xs", "ys", "zs"], true),
    (["xu", "yu", "zu"], false),
    (["xsu", "ysu", "zsu"], true),
];

/// What comes before the atoms of a frame.
struct Header {
    count: u64,
    time: Option<String>,
    unit: Unit,
    /// As the file says; it may be flat.
    bounds: Option<Cell>,
    /// The names of the columns, and the line that has them.
    columns: Vec<String>,
    line: u64,
}

/// Skips a frame; `false` if there is none.
pub(crate) fn skip(text: &mut Text) -> Result<bool, Fault> {
    if !text.skip_blank()? {
        return Ok(false);
    }
    let header = header(text)?;
    let (line, count) = (text.line(), header.count);
    match text.skip(count)? {
        skipped if skipped < count => {
            Err(Fault::line(line + skipped, format!("the file ends after {skipped} of {count} particles")))
        }
        _ => Ok(true),
    }
}

/// Reads a frame.
pub(crate) fn read(text: &mut Text, request: &Request) -> Result<Particles, Fault> {
    let header = header(text)?;
    let fault = |problem: String| Fault::line(header.line, problem);
    let (layout, is_scaled) = layout(&header.columns, &request.properties).map_err(fault)?;
    let expected = header.columns.join(" ");
    let reader = Separated { layout: &layout, expected: &expected, is_exact: true };
    let mut table = rows::read(text, Some(header.count), &layout, &reader, request)?;
    table.sort_by_id();
    if is_scaled {
        let missing = || fault("scaled coordinates need BOX BOUNDS, which the frame lacks".into());
        let bounds = header.bounds.ok_or_else(missing)?;
        for position in &mut table.positions {
            *position = bounds.point(*position);
        }
        let is_near = |position: &[f64; 3]| position.iter().all(|number| number.abs() <= Particles::FARTHEST);
        if !table.positions.iter().all(is_near) {
            return Err(fault("a scaled coordinate is too far outside of the box".into()));
        }
    }
    let mut particles = Particles::new(Format::Dump);
    particles.unit = header.unit;
    particles.title = title(&header.time.map_or(String::new(), |time| format!("timestep {time}")));
    particles.cell = header.bounds.and_then(|bounds| cell(bounds.origin, bounds.vectors, bounds.periodic));
    table.finish(layout, None, &mut particles);
    Ok(particles)
}

/// The unit that the first frame states, as LAMMPS writes it only there; unknown if that cannot be read.
pub(crate) fn unit(text: &mut Text) -> Unit {
    let first = text.skip_blank().and_then(|_| header(text));
    first.map_or(Unit::Unknown, |header| header.unit)
}

/// Reads up to the first atom.
fn header(text: &mut Text) -> Result<Header, Fault> {
    let mut header =
        Header { count: 0, time: None, unit: Unit::Unknown, bounds: None, columns: Vec::new(), line: 0 };
    let mut has_count = false;
    loop {
        let line = text.line();
        let item = String::from_utf8_lossy(text.need("ITEM: ATOMS")?).into_owned();
        let Some(item) = item.trim().strip_prefix("ITEM:") else {
            let problem = format!(
                "{} is no section; a section of a LAMMPS dump begins with ITEM:",
                quote(item.as_bytes())
            );
            return Err(Fault::line(line, problem));
        };
        let item = item.trim();
        if let Some(names) = item.strip_prefix("ATOMS") {
            if !has_count {
                return Err(Fault::line(line, "ITEM: NUMBER OF ATOMS is missing before the atoms"));
            }
            header.columns = names.split_whitespace().take(MOST_COLUMNS + 1).map(str::to_owned).collect();
            header.line = line;
            return Ok(header);
        }
        match item {
            "TIMESTEP" => header.time = Some(one_line(text, "the time step")?),
            "UNITS" => header.unit = unit_of(&one_line(text, "the units")?),
            "NUMBER OF ATOMS" => {
                let (line, count) = (text.line(), one_line(text, "the number of atoms")?);
                header.count = count.parse().map_err(|_| {
                    Fault::line(line, format!("{} is no number of atoms", quote(count.as_bytes())))
                })?;
                has_count = true;
            }
            _ if item.starts_with("BOX BOUNDS") => {
                header.bounds = Some(bounds(&item["BOX BOUNDS".len()..], text)?);
            }
            // `TIME`, and whatever comes to be.
            _ => skip_section(text)?,
        }
    }
}

fn one_line(text: &mut Text, what: &str) -> Result<String, Fault> {
    Ok(String::from_utf8_lossy(text.need(what)?).trim().to_owned())
}

/// Skips lines up to the next section.
fn skip_section(text: &mut Text) -> Result<(), Fault> {
    while text.peek()?.is_some_and(|line| !line.starts_with(b"ITEM:")) {
        text.next_line()?;
    }
    Ok(())
}

/// The unit of lengths in a style of LAMMPS's units.
fn unit_of(style: &str) -> Unit {
    match style {
        "metal" | "real" => Unit::Angstrom,
        "nano" => Unit::Nanometre,
        "si" => Unit::Metre,
        _ => Unit::Unknown,
    }
}

/// The box: by its bounds, with tilt factors if it is triclinic, or by its vectors.
fn bounds(heading: &str, text: &mut Text) -> Result<Cell, Fault> {
    let words: Vec<&str> = heading.split_whitespace().collect();
    let periodic = periodicity(&words);
    let is_general = words.contains(&"abc");
    let count = if is_general { 4 } else { 2 + usize::from(words.contains(&"xy")) };
    let mut rows = [[0.0; 4]; 3];
    for row in &mut rows {
        let line = text.line();
        let numbers = text.need("the box")?;
        let fault = |problem: String| Fault::line(line, problem);
        let mut fields = Fields::new(numbers);
        for value in &mut row[..count] {
            let field = fields.next().map(|(_, field)| field);
            let number = field.and_then(number).filter(|number| number.abs() <= Particles::FARTHEST);
            *value =
                number.ok_or_else(|| fault(format!("{} has no {count} numbers of a box", quote(numbers))))?;
        }
    }
    let [x, y, z] = rows;
    if is_general {
        let vectors = [x, y, z].map(|row| [row[0], row[1], row[2]]);
        return Ok(Cell { origin: [x[3], y[3], z[3]], vectors, periodic });
    }
    let (xy, xz, yz) = (x[2], y[2], z[2]);
    let tilts = [0.0, xy, xz, xy + xz];
    let least = |values: &[f64]| values.iter().copied().fold(0.0, f64::min);
    let most = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
    let low = [x[0] - least(&tilts), y[0] - least(&[yz]), z[0]];
    let high = [x[1] - most(&tilts), y[1] - most(&[yz]), z[1]];
    let vectors = [[high[0] - low[0], 0.0, 0.0], [xy, high[1] - low[1], 0.0], [xz, yz, high[2] - low[2]]];
    Ok(Cell { origin: low, vectors, periodic })
}

/// Along which axes the box repeats: `pp`. If nothing is said, as by old versions, along all.
fn periodicity(words: &[&str]) -> [bool; 3] {
    let sides: Vec<&&str> = words
        .iter()
        .filter(|word| word.len() == 2 && word.bytes().all(|side| b"pfsm".contains(&side)))
        .collect();
    match sides[..] {
        [x, y, z] => [x, y, z].map(|sides| *sides == "pp"),
        _ => [true; 3],
    }
}

/// The roles of the columns, and whether the coordinates are scaled.
fn layout(columns: &[String], wanted: &Properties) -> Result<(Layout, bool), String> {
    if columns.len() > MOST_COLUMNS {
        return Err(format!("there are more than {MOST_COLUMNS} columns"));
    }
    let has = |name: &str| columns.iter().any(|column| column == name);
    let (axes, is_scaled) =
        *AXES.iter().find(|(axes, _)| axes.iter().all(|axis| has(axis))).ok_or_else(|| {
            "the columns have no coordinates; these are x y z, xs ys zs, xu yu zu or xsu ysu zsu".to_owned()
        })?;
    let mut layout = Layout::default();
    for column in columns {
        let axis = axes.iter().position(|axis| axis == column);
        let role = match column.as_str() {
            _ if axis.is_some() => axis.map(Role::Axis),
            "id" => Some(Role::Id),
            "type" => Some(Role::Label(Kind::Type)),
            "element" => Some(Role::Label(Kind::Element)),
            "mol" => Some(Role::Molecule),
            "radius" => Some(Role::Radius),
            "diameter" if !has("radius") => Some(Role::Diameter),
            _ => None,
        };
        match role.filter(|role| !layout.has(*role)) {
            Some(role) => layout.push(role),
            None => layout.push_property(column, wanted),
        }
    }
    Ok((layout, is_scaled))
}
