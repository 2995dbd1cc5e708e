//! Tables with a header: fields separated by commas, semicolons, tabs or blanks.

use crate::columns::{no_axes, role};
use crate::error::{Fault, Place, quote};
use crate::format::Format;
use crate::layout::{Layout, MOST_COLUMNS, Role, is_wanted};
use crate::particles::Particles;
use crate::request::{Properties, Request};
use crate::rows::{self, RowReader};
use crate::table::{Table, property};
use crate::text::{Fields, Position, Source, Text, number};
use csv_core::{ReadRecordResult, ReaderBuilder};

/// The separators, in the order in which they are looked for.
const SEPARATORS: [u8; 3] = [b'\t', b';', b','];

/// Whether a line may be the header of a table of particles.
pub(crate) fn looks_like_header(line: &[u8]) -> bool {
    Header::new(line).is_ok_and(|header| {
        let roles: Vec<_> = header.names.iter().map(|name| role(name, &header.names)).collect();
        (0..3).all(|axis| roles.contains(&Some(Role::Axis(axis))))
    })
}

/// Reads a table.
pub(crate) fn read(source: &mut dyn Source, request: &Request) -> Result<Particles, Fault> {
    let mut text = Text::new(source, Position::START)?;
    if !text.skip_blank()? {
        return Err(Fault::file("is empty; the first line names the columns, such as x,y,z,radius"));
    }
    let line = text.line();
    let first = text.need("the names of the columns")?;
    let header = Header::new(first).map_err(|problem| Fault::line(line, problem))?;
    let mut layout = Layout::default();
    while text.peek()?.is_some_and(is_skipped) {
        text.next_line()?;
    }
    let example = text.peek()?.unwrap_or_default();
    let example = header.split(example).unwrap_or_default();
    for (index, (name, shown)) in header.names.iter().zip(&header.shown).enumerate() {
        let value = example.get(index).map(Vec::as_slice).unwrap_or_default();
        let is_number = value.is_empty() || number(value).is_some() || with_point(value).is_some();
        match role(name, &header.names).filter(|role| !layout.has(*role)) {
            // Other tables have texts for ids.
            Some(Role::Id | Role::Molecule) if !value.iter().all(u8::is_ascii_digit) => {
                layout.push(Role::Skip);
            }
            Some(role) => layout.push(role),
            None if is_number || may_be_number(value, shown, request) => {
                layout.push_property(shown, &request.properties);
            }
            None => layout.push(Role::Skip),
        }
    }
    if !(0..3).all(|axis| layout.has(Role::Axis(axis))) {
        return Err(Fault { place: Place::Line(line), problem: no_axes(&header.shown) });
    }
    let reader = Row { header: &header, layout: &layout };
    let table = rows::read(&mut text, None, &layout, &reader, request)?;
    let mut particles = Particles::new(Format::Csv);
    table.finish(layout, None, &mut particles);
    Ok(particles)
}

/// Whether a column that begins with this value, which is no number, may be one of numbers: if it is a truth value, or is
/// missing in the first row and asked for by its name. (A column of texts may begin with a missing one too.)
fn may_be_number(value: &[u8], name: &str, request: &Request) -> bool {
    let is_word = value.len() > 1 && property(value).is_ok();
    let is_asked_for =
        matches!(request.properties, Properties::Named(_)) && is_wanted(name, &request.properties);
    match value {
        b"NA" | b"." | b"?" => is_asked_for,
        _ => is_word,
    }
}

/// Whether a line below the names is blank or a comment.
fn is_skipped(line: &[u8]) -> bool {
    line.trim_ascii().is_empty() || line.starts_with(b"#")
}

struct Header {
    /// What separates fields; `None` for white space.
    separator: Option<u8>,
    /// The names as they are, and in lower case.
    shown: Vec<String>,
    names: Vec<String>,
}

impl Header {
    fn new(line: &[u8]) -> Result<Self, String> {
        // As NumPy writes it.
        let line = line.trim_ascii_start();
        let line = line.strip_prefix(b"#").unwrap_or(line).trim_ascii();
        let separator = SEPARATORS.into_iter().find(|separator| line.contains(separator));
        let mut header = Self { separator, shown: Vec::new(), names: Vec::new() };
        let fields = header.split(line)?;
        if fields.len() > MOST_COLUMNS {
            return Err(format!("there are {} columns; at most {MOST_COLUMNS} are read", fields.len()));
        }
        if fields.iter().all(|field| number(field).is_some()) {
            return Err("the first line has numbers; it should name the columns, such as x,y,z,radius".into());
        }
        // A unit in brackets after the name is no part of it.
        let plain = |field: &Vec<u8>| {
            let text = String::from_utf8_lossy(field);
            text.split(['[', '(']).next().unwrap_or_default().trim().to_owned()
        };
        header.shown = fields.iter().map(plain).collect();
        header.names = header.shown.iter().map(|name| name.to_ascii_lowercase()).collect();
        Ok(header)
    }

    /// The fields of a line.
    fn split(&self, line: &[u8]) -> Result<Vec<Vec<u8>>, String> {
        let Some(separator) = self.separator else {
            return Ok(Fields::new(line).map(|(_, field)| field.to_vec()).collect());
        };
        let unquoted = Unquoted::new(line, separator).map_err(|(_, problem)| problem)?;
        Ok(unquoted.fields().map(<[u8]>::to_vec).collect())
    }
}

struct Row<'a> {
    header: &'a Header,
    layout: &'a Layout,
}

impl RowReader for Row<'_> {
    fn read(&self, line: &[u8], table: &mut Table) -> Result<(), (usize, String)> {
        if is_skipped(line) {
            return Ok(());
        }
        let Some(separator) = self.header.separator else {
            let mut fields = Fields::new(line).map(|(_, field)| field);
            return self.take(|| fields.next(), table);
        };
        if !line.contains(&b'"') {
            let mut fields = line.split(|byte| *byte == separator).map(<[u8]>::trim_ascii);
            return self.take(|| fields.next(), table);
        }
        let unquoted = Unquoted::new(line, separator)?;
        let mut fields = unquoted.fields();
        self.take(|| fields.next(), table)
    }
}

impl Row<'_> {
    /// Takes the fields that `next` gives.
    fn take<'f>(
        &self,
        mut next: impl FnMut() -> Option<&'f [u8]>,
        table: &mut Table,
    ) -> Result<(), (usize, String)> {
        let roles = &self.layout.roles;
        let mut has_colors = false;
        for (index, &role) in roles.iter().enumerate() {
            let named = |problem: String| (0, format!("column {}: {problem}", self.header.shown[index]));
            let Some(field) = next() else {
                return Err((
                    0,
                    format!(
                        "the line has {index} of {} fields; the next is {}",
                        roles.len(),
                        self.header.shown[index]
                    ),
                ));
            };
            has_colors |= matches!(role, Role::Color(_));
            let point = if field.contains(&b',') && !matches!(role, Role::Label(_)) {
                with_point(field)
            } else {
                None
            };
            match point {
                Some(value) => table.number(role, value).map_err(named)?,
                None => table.field(role, field).map_err(named)?,
            }
        }
        if let Some(field) = next().filter(|field| !field.is_empty()) {
            return Err((
                0,
                format!("{} is beyond the {} columns that the first line names", quote(field), roles.len()),
            ));
        }
        table.end_row(true, has_colors);
        Ok(())
    }
}

/// The fields of a line, some of which are quoted.
struct Unquoted {
    bytes: Vec<u8>,
    /// Where each field ends.
    ends: Vec<usize>,
}

impl Unquoted {
    fn new(line: &[u8], separator: u8) -> Result<Self, (usize, String)> {
        let mut reader = ReaderBuilder::new().delimiter(separator).build();
        let mut all = Self { bytes: vec![0; line.len() + 1], ends: vec![0; MOST_COLUMNS + 1] };
        let (mut read, mut written, mut ended) = (0, 0, 0);
        loop {
            let (result, input, output, ends) =
                reader.read_record(&line[read..], &mut all.bytes[written..], &mut all.ends[ended..]);
            (read, written, ended) = (read + input, written + output, ended + ends);
            match result {
                // The next call is told of the end by an empty input.
                ReadRecordResult::InputEmpty => {}
                ReadRecordResult::OutputEndsFull | ReadRecordResult::OutputFull => {
                    return Err((0, format!("the line has more than {MOST_COLUMNS} fields")));
                }
                ReadRecordResult::Record | ReadRecordResult::End => break,
            }
        }
        all.ends.truncate(ended);
        Ok(all)
    }

    fn fields(&self) -> impl Iterator<Item = &[u8]> {
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        starts.zip(&self.ends).map(|(start, &end)| self.bytes[start..end].trim_ascii())
    }
}

/// A number with a decimal comma.
fn with_point(field: &[u8]) -> Option<f64> {
    let mut copy = [0; 40];
    let copy = copy.get_mut(..field.len())?;
    copy.copy_from_slice(field);
    *copy.iter_mut().find(|byte| **byte == b',')? = b'.';
    number(copy)
}
