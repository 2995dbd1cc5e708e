//! GROMACS coordinates: a title, a count, a line of fixed columns per atom, the box; frame after frame, in nanometre.

use crate::cell::cell;
use crate::error::{Fault, quote};
use crate::format::Format;
use crate::layout::{Kind, Layout, Role};
use crate::names;
use crate::particles::{Cell, Particles, title};
use crate::request::Request;
use crate::rows::{self, RowReader};
use crate::table::Table;
use crate::text::{Fields, Text, integer, number};

/// Where positions begin, after number and name of the residue, name and number of the atom, of five columns each.
const POSITIONS: usize = 20;
/// The width of a coordinate of the usual three decimals.
const USUAL_WIDTH: usize = 8;
/// Numbers of residues and atoms have five digits, and begin again.
const WRAP: u64 = 100_000;

/// Skips a frame; `false` if there is none.
pub(crate) fn skip(text: &mut Text) -> Result<bool, Fault> {
    if !text.skip_blank()? {
        return Ok(false);
    }
    text.need("the title of a frame")?;
    let count = count(text)?;
    let line = text.line();
    match text.skip(count)? {
        skipped if skipped < count => {
            Err(Fault::line(line + skipped, format!("the file ends after {skipped} of {count} particles")))
        }
        _ => text.need("the box of a frame").map(|_| true),
    }
}

/// Reads a frame.
pub(crate) fn read(text: &mut Text, request: &Request) -> Result<Particles, Fault> {
    let mut particles = Particles::new(Format::Gro);
    particles.title = title(&String::from_utf8_lossy(text.need("the title of a frame")?));
    let count = count(text)?;
    let mut layout = Layout::default();
    (0..3).for_each(|axis| layout.push(Role::Axis(axis)));
    for role in [Role::Label(Kind::Residue), Role::Label(Kind::Name), Role::Molecule, Role::Id] {
        layout.push(role);
    }
    let first = text.peek()?.unwrap_or_default();
    let width = width(first);
    let mut reader = FixedColumns { width, velocities: [Role::Skip; 3] };
    if first.trim_ascii_end().len() >= POSITIONS + 5 * width && count > 0 {
        reader.velocities =
            ["velocity_x", "velocity_y", "velocity_z"].map(|name| layout.property(name, &request.properties));
        reader.velocities.iter().for_each(|&role| layout.push(role));
    }
    let mut table = rows::read(text, Some(count), &layout, &reader, request)?;
    unwrap(&mut table.ids, |id| *id, |id, turns| id + turns);
    unwrap(
        &mut table.residue_numbers,
        |number| *number as u64,
        |number, turns| number.saturating_add(turns as i32),
    );
    table.finish(layout, None, &mut particles);
    let line = text.line();
    particles.cell =
        box_of(text.need("the box of a frame")?).map_err(|problem| Fault::line(line, problem))?;
    Ok(particles)
}

fn count(text: &mut Text) -> Result<u64, Fault> {
    let line = text.line();
    let second = text.need("the number of atoms")?;
    let count = integer(second.trim_ascii()).and_then(|count| u64::try_from(count).ok());
    let problem =
        || format!("{} is no number of atoms, which the second line of a frame of GRO is", quote(second));
    count.ok_or_else(|| Fault::line(line, problem()))
}

/// The width of a coordinate: the distance of two decimal points.
fn width(line: &[u8]) -> usize {
    let mut points = memchr::memchr_iter(b'.', line.get(POSITIONS..).unwrap_or_default());
    match (points.next(), points.next()) {
        (Some(first), Some(second)) => second - first,
        _ => USUAL_WIDTH,
    }
}

/// Numbers of five digits, as if they had more.
fn unwrap<T: Copy>(column: &mut [T], of: impl Fn(&T) -> u64, with: impl Fn(T, u64) -> T) {
    let (mut turns, mut last) = (0, 0);
    for number in column {
        let this = of(number);
        if this < WRAP && this + WRAP / 2 < last {
            turns += WRAP;
        }
        last = this;
        *number = with(*number, turns);
    }
}

struct FixedColumns {
    width: usize,
    velocities: [Role; 3],
}

impl FixedColumns {
    fn field<'l>(&self, line: &'l [u8], index: usize) -> (usize, &'l [u8]) {
        let start = (POSITIONS + index * self.width).min(line.len());
        (start, line[start..line.len().min(start + self.width)].trim_ascii())
    }
}

impl RowReader for FixedColumns {
    fn read(&self, line: &[u8], table: &mut Table) -> Result<(), (usize, String)> {
        if line.len() < POSITIONS + 2 * self.width + 1 {
            let problem = format!(
                "the line has {} columns; {POSITIONS} of names and numbers and three coordinates of {} are needed",
                line.len(),
                self.width
            );
            return Err((line.len(), problem));
        }
        let (residue, name) = (line[5..10].trim_ascii(), line[10..15].trim_ascii());
        table.residue_numbers.push(five_digits(line, 0)? as i32);
        table.push_label(Kind::Residue, residue).map_err(|problem| (5, problem))?;
        table.push_label(Kind::Name, name).map_err(|problem| (10, problem))?;
        table.ids.push(five_digits(line, 15)?);
        table.elements.push(names::element(name, residue));
        let roles = (0..3).map(Role::Axis).chain(self.velocities);
        for (index, role) in roles.enumerate().filter(|(_, role)| *role != Role::Skip) {
            let (column, field) = self.field(line, index);
            table.field(role, field).map_err(|problem| (column, problem))?;
        }
        table.end_row(true, false);
        Ok(())
    }
}

/// A number of five columns from `column` on; stars and blanks, of programs that had no room, are 0.
fn five_digits(line: &[u8], column: usize) -> Result<u64, (usize, String)> {
    let field = line[column..column + 5].trim_ascii();
    if field.iter().all(|&byte| byte == b'*') {
        return Ok(0);
    }
    let number = integer(field).and_then(|number| u64::try_from(number).ok());
    number.ok_or_else(|| (column, format!("{} is no number of five columns", quote(field))))
}

/// The box: three lengths, or all nine components as GROMACS orders them. All zeros stand for none, as does a blank line.
fn box_of(line: &[u8]) -> Result<Option<Cell>, String> {
    let wrong = || format!("{} is no box; it is three numbers or nine", quote(line));
    let numbers: Option<Vec<f64>> = Fields::new(line)
        .take(10)
        .map(|(_, field)| number(field).filter(|number| number.is_finite()))
        .collect();
    let vectors = match numbers.ok_or_else(wrong)?[..] {
        [] => return Ok(None),
        [x, y, z] => [[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, z]],
        [ax, by, cz, ay, az, bx, bz, cx, cy] => [[ax, ay, az], [bx, by, bz], [cx, cy, cz]],
        _ => return Err(wrong()),
    };
    Ok(cell([0.0; 3], vectors, [true; 3]))
}
