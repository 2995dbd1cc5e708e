//! PDB: records of fixed columns (<https://www.wwpdb.org/documentation/file-format>), with what programs made of it for
//! more atoms than the columns hold: hybrid-36 numbers (<http://cci.lbl.gov/hybrid_36/>), and numbers one column wider.

use crate::altloc::{self, Alternative, Residue, packed};
use crate::cell::{by_angles, dot, inverse};
use crate::elements::by_symbol;
use crate::error::{Fault, Place, no_such_frame, quote};
use crate::format::Format;
use crate::layout::{Kind, Layout, Role};
use crate::names;
use crate::particles::{Cell, Particles, title};
use crate::request::Request;
use crate::rows::{most_rows, too_many};
use crate::table::Table;
use crate::text::{Position, Source, Text, number};

/// The columns up to the coordinates' end.
const LEAST: usize = 54;

/// The number of frames: models, or what `END` separates.
pub(crate) fn frames(source: &mut dyn Source) -> Result<usize, Fault> {
    let mut text = Text::new(source, Position::START)?;
    let mut frames = Frames::default();
    while let Some(line) = text.next_line()? {
        frames.see(record(line));
    }
    Ok(frames.count)
}

/// Reads a frame.
pub(crate) fn read(source: &mut dyn Source, frame: usize, request: &Request) -> Result<Particles, Fault> {
    let mut text = Text::new(source, Position::START)?;
    let (mut frames, mut reader) = (Frames::default(), Reader::new(request));
    loop {
        let number = text.line();
        let Some(line) = text.next_line()? else { break };
        let record = record(line);
        frames.see(record);
        let fault = |(column, problem): (usize, String)| Fault {
            place: Place::Column(number, column as u64 + 1),
            problem,
        };
        let is_here = frames.count == frame + 1;
        match record {
            b"ATOM" | b"HETATM" if is_here => reader.atom(line).map_err(fault)?,
            // After the last model they hold for all.
            b"CONECT" if is_here || frames.is_between => reader.bonds(line),
            // Between frames it belongs to the next one; each frame has its own, or that of the one before.
            b"CRYST1" if frames.count <= frame || is_here && !frames.is_between => {
                reader.cell = unit_cell(line).map_err(fault)?;
            }
            b"SCALE1" | b"SCALE2" | b"SCALE3" => reader.scale(line),
            b"TITLE" if reader.title.len() < Particles::TITLE => {
                reader
                    .title
                    .push_str(&String::from_utf8_lossy(line.get(10..).unwrap_or_default().trim_ascii_end()));
            }
            _ => {}
        }
        if reader.table.len() as u64 > reader.most {
            return Err(too_many(&reader.layout, request));
        }
    }
    if frames.count <= frame {
        return Err(match frames.count {
            0 => Fault::file("has no atoms: there is no line that begins with ATOM or HETATM"),
            count => no_such_frame(frame, count),
        });
    }
    Ok(reader.finish())
}

/// The name of a line's record.
fn record(line: &[u8]) -> &[u8] {
    line[..line.len().min(6)].trim_ascii_end()
}

/// Counts frames: each begins with the first atom after a separator.
struct Frames {
    count: usize,
    is_between: bool,
}

impl Default for Frames {
    fn default() -> Self {
        Self { count: 0, is_between: true }
    }
}

impl Frames {
    fn see(&mut self, record: &[u8]) {
        match record {
            b"MODEL" | b"ENDMDL" | b"END" => self.is_between = true,
            b"ATOM" | b"HETATM" if self.is_between => {
                self.count += 1;
                self.is_between = false;
            }
            _ => {}
        }
    }
}

struct Reader {
    layout: Layout,
    table: Table,
    /// The roles of occupancy and B factor.
    others: [Role; 2],
    most: u64,
    alternatives: Vec<Alternative>,
    /// Serial numbers of bonded atoms.
    bonds: Vec<[u64; 2]>,
    cell: Option<Cell>,
    /// Rows that give coordinates along the cell's vectors, and the constant of each.
    scale: [Option<[f64; 4]>; 3],
    title: String,
}

impl Reader {
    fn new(request: &Request) -> Self {
        let (layout, others) = Layout::of_atoms(&request.properties);
        Self {
            table: Table::new(&layout),
            most: most_rows(&layout, request),
            layout,
            others,
            alternatives: Vec::new(),
            bonds: Vec::new(),
            cell: None,
            scale: [None; 3],
            title: String::new(),
        }
    }

    fn atom(&mut self, line: &[u8]) -> Result<(), (usize, String)> {
        if line.len() < LEAST {
            let problem = format!(
                "the line has {} columns; the coordinates of an atom end in column {LEAST}",
                line.len()
            );
            return Err((line.len(), problem));
        }
        for axis in 0..3 {
            let column = 30 + 8 * axis;
            let field = line[column..column + 8].trim_ascii();
            self.table.field(Role::Axis(axis), field).map_err(|problem| (column, problem))?;
        }
        let residue = line[17..21].trim_ascii();
        self.table.push_label(Kind::Name, line[12..16].trim_ascii()).map_err(|problem| (12, problem))?;
        self.table.push_label(Kind::Residue, residue).map_err(|problem| (17, problem))?;
        self.table.push_label(Kind::Chain, line[21..22].trim_ascii()).map_err(|problem| (21, problem))?;
        self.table.residue_numbers.push(residue_number(line));
        self.table.elements.push(element(line));
        let last = self.table.ids.last().copied().unwrap_or(0);
        self.table.ids.push(serial(line).unwrap_or(last + 1));
        let [occupancy, b_factor] = [54..60, 60..66].map(|columns| {
            let field = line.get(columns).unwrap_or_default().trim_ascii();
            if field.is_empty() { None } else { number(field) }
        });
        for (role, value) in self.others.into_iter().zip([occupancy, b_factor]) {
            self.table.number(role, value.unwrap_or(f64::NAN)).map_err(|problem| (54, problem))?;
        }
        if line[16] != b' ' {
            self.alternative(line, occupancy.unwrap_or(1.0) as f32, b_factor.unwrap_or(0.0) as f32);
        }
        self.table.end_row(true, false);
        Ok(())
    }

    /// Notes the location of the atom of the row that is being read.
    fn alternative(&mut self, line: &[u8], occupancy: f32, b_factor: f32) {
        let row = self.table.len();
        let index = |kind: Kind| self.table.labels[kind as usize].last();
        let number = self.table.residue_numbers[row];
        let residue = Residue { chain: index(Kind::Chain), number, insertion: packed(&line[26..27]) };
        let (name, residue_name) = (index(Kind::Name), index(Kind::Residue));
        let mark = packed(&line[16..17]);
        self.alternatives.push(Alternative {
            row: row as u32,
            residue,
            residue_name,
            name,
            mark,
            occupancy,
            b_factor,
        });
    }

    /// `CONECT`: an atom, and up to four that are bonded to it.
    fn bonds(&mut self, line: &[u8]) {
        let atom = |index: usize| {
            let field = line.get(6 + 5 * index..line.len().min(11 + 5 * index))?;
            hybrid_36(field, 5).and_then(|serial| u64::try_from(serial).ok())
        };
        let Some(first) = atom(0) else { return };
        self.bonds.extend((1..5).filter_map(atom).map(|other| [first.min(other), first.max(other)]));
    }

    /// A row of the matrix that makes positions coordinates along the cell's vectors.
    fn scale(&mut self, line: &[u8]) {
        let columns = [(10, 20), (20, 30), (30, 40), (45, 55)];
        let numbers = columns.map(|(start, end)| number(line.get(start..end.min(line.len()))?.trim_ascii()));
        if let [Some(x), Some(y), Some(z), Some(shift)] = numbers {
            self.scale[usize::from(line[5] - b'1')] = Some([x, y, z, shift]);
        }
    }

    /// The cell of `CRYST1`, turned and moved as `SCALE` says if that is not how cells usually lie.
    fn placed_cell(&self) -> Option<Cell> {
        /// Of the six decimals of the matrix times the edge of a cell.
        const ROUNDING: f64 = 1e-2;
        let usual = self.cell?;
        let [Some(x), Some(y), Some(z)] = self.scale else { return Some(usual) };
        let rows = [x, y, z];
        let along = |row: [f64; 4], point: [f64; 3]| dot([row[0], row[1], row[2]], point) + row[3];
        let is_usual = (0..3).all(|at| {
            let image = rows.map(|row| along(row, usual.vectors[at]));
            (0..3).all(|axis| (image[axis] - f64::from(u8::from(axis == at))).abs() < ROUNDING)
        });
        let matrix = rows.map(|row| [row[0], row[1], row[2]]);
        let turned = inverse(matrix, rows.map(|row| row[3]), usual.periodic);
        let is_same_size = |cell: &Cell| (cell.volume() / usual.volume() - 1.0).abs() < ROUNDING;
        if is_usual { Some(usual) } else { turned.filter(is_same_size).or(Some(usual)) }
    }

    fn finish(mut self) -> Particles {
        if let Some(keep) = altloc::kept(std::mem::take(&mut self.alternatives), Vec::new(), self.table.len())
        {
            self.table.retain(&keep);
        }
        let mut particles = Particles::new(Format::Pdb);
        particles.bonds = by_serial(&mut self.bonds, &self.table.ids);
        particles.cell = self.placed_cell();
        particles.title = title(&self.title);
        self.table.finish(self.layout, None, &mut particles);
        particles
    }
}

/// Bonds between rows, by bonds between serial numbers. Those of atoms that are not there are left out.
fn by_serial(bonds: &mut Vec<[u64; 2]>, serials: &[u64]) -> Vec<[u32; 2]> {
    if bonds.is_empty() {
        return Vec::new();
    }
    bonds.sort_unstable();
    bonds.dedup();
    let mut order: Vec<u32> = (0..serials.len() as u32).collect();
    order.sort_by_key(|&row| serials[row as usize]);
    let row = |serial: u64| {
        let at = order.partition_point(|&row| serials[row as usize] < serial);
        order.get(at).copied().filter(|&row| serials[row as usize] == serial)
    };
    let pairs = bonds.iter().filter_map(|&[a, b]| Some([row(a)?, row(b)?]));
    let mut rows: Vec<_> = pairs.filter(|[a, b]| a != b).map(|[a, b]| [a.min(b), a.max(b)]).collect();
    rows.sort_unstable();
    rows
}

/// The number of the atom; `None` where a program had no room for it.
fn serial(line: &[u8]) -> Option<u64> {
    // A sixth digit goes into the column that is blank otherwise.
    let number = if line[11].is_ascii_digit() { decimal(&line[6..12]) } else { hybrid_36(&line[6..11], 5) };
    number.and_then(|number| u64::try_from(number).ok())
}

/// The number of the residue; 0 where a program had no room for it.
fn residue_number(line: &[u8]) -> i32 {
    let number = if line[26].is_ascii_digit() { decimal(&line[22..27]) } else { hybrid_36(&line[22..26], 4) };
    number.and_then(|number| i32::try_from(number).ok()).unwrap_or(0)
}

fn decimal(field: &[u8]) -> Option<i64> {
    crate::text::integer(field.trim_ascii())
}

/// A number of `width` columns: decimal, and beyond that in base 36 with upper-case and then with lower-case letters.
fn hybrid_36(field: &[u8], width: u32) -> Option<i64> {
    let field = field.trim_ascii();
    let first = *field.first()?;
    if !first.is_ascii_alphabetic() {
        return decimal(field);
    }
    let is_upper = first.is_ascii_uppercase();
    let is_one_case = field.iter().all(|byte| {
        byte.is_ascii_digit() || (byte.is_ascii_alphabetic() && byte.is_ascii_uppercase() == is_upper)
    });
    if field.len() != width as usize || !is_one_case {
        return None;
    }
    let value = i64::from_str_radix(std::str::from_utf8(field).ok()?, 36).ok()?;
    let (digit, decimals) = (36_i64.pow(width - 1), 10_i64.pow(width));
    Some(value + decimals + if is_upper { -10 * digit } else { 16 * digit })
}

/// The element by its columns or, where these are empty or hold something else, by the name of the atom.
fn element(line: &[u8]) -> u8 {
    let columns = line.get(76..line.len().min(78)).unwrap_or_default().trim_ascii();
    match columns {
        b"C" => 6,
        b"H" => 1,
        b"O" => 8,
        b"N" => 7,
        _ => std::str::from_utf8(columns).ok().and_then(by_symbol).unwrap_or_else(|| {
            let name = [line[12], line[13], line[14], line[15]];
            names::element_by_columns(name, &line[17..21])
        }),
    }
}

/// The cell of `CRYST1`. The unit cube stands for none.
fn unit_cell(line: &[u8]) -> Result<Option<Cell>, (usize, String)> {
    let mut numbers = [0.0; 6];
    let columns = [(6, 15), (15, 24), (24, 33), (33, 40), (40, 47), (47, 54)];
    for (value, (start, end)) in numbers.iter_mut().zip(columns) {
        let field = line.get(start.min(line.len())..end.min(line.len())).unwrap_or_default().trim_ascii();
        let problem = || (start, format!("{} is no length or angle of a cell", quote(field)));
        *value = number(field).filter(|number| number.is_finite()).ok_or_else(problem)?;
    }
    let [a, b, c, alpha, beta, gamma] = numbers;
    let is_none = [a, b, c] == [1.0; 3];
    Ok(if is_none { None } else { by_angles([a, b, c], [alpha, beta, gamma]) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hybrid_36_continues_decimal_numbers() {
        let of = |text: &str, width| hybrid_36(text.as_bytes(), width);
        assert_eq!([of("99999", 5), of("A0000", 5), of("A0001", 5)], [99_999, 100_000, 100_001].map(Some));
        // The limits that the definition gives.
        assert_eq!(
            [of("ZZZZZ", 5), of("a0000", 5), of("zzzzz", 5)],
            [43_770_015, 43_770_016, 87_440_031].map(Some)
        );
        assert_eq!(
            [of("A000", 4), of("ZZZZ", 4), of("a000", 4), of("zzzz", 4)],
            [10_000, 1_223_055, 1_223_056, 2_436_111].map(Some)
        );
        assert_eq!([of("  -9", 4), of("   7", 4)], [-9, 7].map(Some));
        assert_eq!([of("*****", 5), of("A000", 5), of("Aa000", 5), of("", 4), of("1A000", 5)], [None; 5]);
    }
}
