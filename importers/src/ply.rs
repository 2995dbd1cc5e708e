//! Points in the polygon file format: a header in text that names elements and their properties, then their values as
//! text or binary. The elements called `vertex` are the particles; others, such as faces, are skipped.

use crate::binary::{Field, Rows, Stored, fill};
use crate::columns::{no_axes, role};
use crate::error::{Fault, quote};
use crate::format::Format;
use crate::layout::{Layout, MOST_COLUMNS, Role};
use crate::particles::{Particles, title};
use crate::request::Request;
use crate::rows::{self, RowReader};
use crate::table::Table;
use crate::text::{Fields, Position, Source, Stream, Text, integer};
use crate::values::Scalar;
use std::io::{BufReader, Read};

/// The most lines of a header.
const MOST_LINES: u64 = 10_000;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Encoding {
    Ascii,
    Little,
    Big,
}

/// A property of an element.
struct Property {
    name: String,
    /// How the count of a list is stored.
    list: Option<Scalar>,
    /// How a number, or each of the list, is stored.
    scalar: Scalar,
}

struct Element {
    name: String,
    count: u64,
    properties: Vec<Property>,
}

struct Header {
    encoding: Encoding,
    elements: Vec<Element>,
    comment: String,
}

/// Reads the points.
pub(crate) fn read(source: &mut dyn Source, request: &Request) -> Result<Particles, Fault> {
    let mut text = Text::new(source, Position::START)?;
    let header = header(&mut text)?;
    let vertex = header.elements.iter().position(|element| element.name == "vertex");
    let vertex =
        vertex.ok_or_else(|| Fault::file("has no element called vertex; its points are the particles"))?;
    let (before, points) = (&header.elements[..vertex], &header.elements[vertex]);
    let layout = layout(points, request)?;
    let mut particles = Particles::new(Format::Ply);
    particles.title = title(&header.comment);
    let table = if header.encoding == Encoding::Ascii {
        let lines: u64 = before.iter().fold(0, |sum, element| sum.saturating_add(element.count));
        text.skip(lines)?;
        rows::read(&mut text, Some(points.count), &layout, &Line { points, layout: &layout }, request)?
    } else {
        let (at, length) = (text.position().offset, text.bytes_left());
        drop(text);
        let mut stream = Stream::new(source).map_err(|error| Fault::unread(&error))?;
        stream.skip_to(at).map_err(|error| Fault::unread(&error))?;
        binary(&header, vertex, &layout, Input { stream: &mut stream, at, left: length }, request)?
    };
    let full = points.properties.iter().zip(&layout.roles).find(|(_, role)| matches!(role, Role::Color(_)));
    let scale = full.map_or(1.0, |(property, _)| property.scalar.full());
    table.finish(layout, Some(scale as f32), &mut particles);
    Ok(particles)
}

fn header(text: &mut Text) -> Result<Header, Fault> {
    let mut header = Header { encoding: Encoding::Ascii, elements: Vec::new(), comment: String::new() };
    let mut has_format = false;
    loop {
        let number = text.line();
        let line = text.need("end_header")?;
        let fault = |problem: String| Fault::line(number, problem);
        let wrong = || fault(format!("{} is no line of a PLY header", quote(line)));
        if number > MOST_LINES {
            return Err(fault(format!("the header has more than {MOST_LINES} lines; end_header is missing")));
        }
        let shown = String::from_utf8_lossy(line);
        let words: Vec<&str> = shown.split_whitespace().take(6).collect();
        match words[..] {
            ["ply"] if number == 1 => {}
            _ if number == 1 => return Err(fault("is no PLY file: the first line is not ply".into())),
            ["format", encoding, _] => {
                header.encoding = match encoding {
                    "ascii" => Encoding::Ascii,
                    "binary_little_endian" => Encoding::Little,
                    "binary_big_endian" => Encoding::Big,
                    _ => return Err(wrong()),
                };
                has_format = true;
            }
            ["comment" | "obj_info", ..] => {
                if header.comment.is_empty() {
                    header.comment = shown.split_once(' ').map_or(String::new(), |(_, rest)| title(rest));
                }
            }
            ["element", name, count] => {
                let count = integer(count.as_bytes())
                    .and_then(|count| u64::try_from(count).ok())
                    .ok_or_else(wrong)?;
                header.elements.push(Element { name: name.into(), count, properties: Vec::new() });
            }
            ["property", ..] => {
                let element = header
                    .elements
                    .last_mut()
                    .ok_or_else(|| fault("a property before any element".into()))?;
                if element.properties.len() >= MOST_COLUMNS {
                    return Err(fault(format!("an element has more than {MOST_COLUMNS} properties")));
                }
                element.properties.push(property(&words).ok_or_else(wrong)?);
            }
            ["end_header"] if has_format => return Ok(header),
            ["end_header"] => return Err(fault("the header has no line with the format".into())),
            [] => {}
            _ => return Err(wrong()),
        }
    }
}

fn property(words: &[&str]) -> Option<Property> {
    match *words {
        ["property", "list", count, item, name] => {
            let list = scalar(count).filter(|scalar| !matches!(scalar, Scalar::Float(_)))?;
            Some(Property { name: name.into(), list: Some(list), scalar: scalar(item)? })
        }
        ["property", kind, name] => Some(Property { name: name.into(), list: None, scalar: scalar(kind)? }),
        _ => None,
    }
}

fn scalar(name: &str) -> Option<Scalar> {
    Some(match name {
        "char" | "int8" => Scalar::Signed(1),
        "uchar" | "uint8" => Scalar::Unsigned(1),
        "short" | "int16" => Scalar::Signed(2),
        "ushort" | "uint16" => Scalar::Unsigned(2),
        "int" | "int32" => Scalar::Signed(4),
        "uint" | "uint32" => Scalar::Unsigned(4),
        "float" | "float32" => Scalar::Float(4),
        "double" | "float64" => Scalar::Float(8),
        _ => return None,
    })
}

/// The roles of a point's properties.
fn layout(points: &Element, request: &Request) -> Result<Layout, Fault> {
    let names: Vec<String> =
        points.properties.iter().map(|property| property.name.to_ascii_lowercase()).collect();
    let mut layout = Layout::default();
    for (property, name) in points.properties.iter().zip(&names) {
        match role(name, &names).filter(|role| !layout.has(*role)) {
            _ if property.list.is_some() => layout.push(Role::Skip),
            Some(role) => layout.push(role),
            None => layout.push_property(&property.name, &request.properties),
        }
    }
    if !(0..3).all(|axis| layout.has(Role::Axis(axis))) {
        return Err(Fault::file(no_axes(&names)));
    }
    Ok(layout)
}

/// A point on a line of text.
struct Line<'a> {
    points: &'a Element,
    layout: &'a Layout,
}

impl RowReader for Line<'_> {
    fn read(&self, line: &[u8], table: &mut Table) -> Result<(), (usize, String)> {
        let mut fields = Fields::new(line);
        let mut has_colors = false;
        for (property, &role) in self.points.properties.iter().zip(&self.layout.roles) {
            let Some((column, field)) = fields.next() else {
                return Err((
                    fields.column(),
                    format!("the line ends where {} should be", quote(property.name.as_bytes())),
                ));
            };
            has_colors |= matches!(role, Role::Color(_));
            if property.list.is_none() {
                table.field(role, field).map_err(|problem| (column, problem))?;
                continue;
            }
            let count = integer(field).and_then(|count| usize::try_from(count).ok());
            let count = count.ok_or_else(|| (column, format!("{} is no length of a list", quote(field))))?;
            if count > 0 && fields.nth(count - 1).is_none() {
                return Err((fields.column(), "the line ends within a list".into()));
            }
        }
        if let Some((column, field)) = fields.next() {
            return Err((
                column,
                format!("{} is beyond the {} properties", quote(field), self.points.properties.len()),
            ));
        }
        table.end_row(true, has_colors);
        Ok(())
    }
}

/// The binary part of a file.
struct Input<'a> {
    stream: &'a mut dyn Read,
    /// Where it is.
    at: u64,
    /// The bytes that are left, if that is known.
    left: Option<u64>,
}

fn binary(
    header: &Header,
    vertex: usize,
    layout: &Layout,
    input: Input,
    request: &Request,
) -> Result<Table, Fault> {
    let is_big_endian = header.encoding == Encoding::Big;
    let (mut at, mut stream) = (input.at, BufReader::with_capacity(1 << 16, input.stream));
    let end = input.left.map(|left| at + left);
    for element in &header.elements[..vertex] {
        for _ in 0..element.count {
            walk(element, is_big_endian, &mut stream, &mut at, |_, _| Ok(()))?;
        }
    }
    let points = &header.elements[vertex];
    let mut table = Table::new(layout);
    let (mut fields, mut size) = (Vec::new(), 0);
    for (property, &role) in points.properties.iter().zip(&layout.roles) {
        let stored = Stored::Number(property.scalar);
        fields.push(Field { offset: size, stored, role, is_big_endian });
        // At least the count of a list.
        size += property.list.unwrap_or(property.scalar).size();
    }
    let rows = Rows {
        fields: &fields,
        size,
        count: points.count,
        at,
        available: end.map(|end| end.saturating_sub(at)),
    };
    rows.check(layout, request)?;
    if points.properties.iter().all(|property| property.list.is_none()) {
        rows.read(&mut stream, &mut table)?;
        return Ok(table);
    }
    let has_colors = layout.roles.iter().any(|role| matches!(role, Role::Color(_)));
    for number in 0..points.count {
        let begin = at;
        walk(points, is_big_endian, &mut stream, &mut at, |index, value| {
            table.number(layout.roles[index], value)
        })
        .map_err(|fault| Fault {
            problem: format!("row {number}, which begins at byte {begin}: {}", fault.problem),
            ..fault
        })?;
        table.end_row(true, has_colors);
    }
    Ok(table)
}

/// Reads an element with lists, property by property, and gives its numbers to `take`.
fn walk(
    element: &Element,
    is_big_endian: bool,
    stream: &mut dyn Read,
    at: &mut u64,
    mut take: impl FnMut(usize, f64) -> Result<(), String>,
) -> Result<(), Fault> {
    let mut bytes = [0; 8];
    let mut next = |scalar: Scalar, at: &mut u64, stream: &mut dyn Read| {
        let bytes = &mut bytes[..scalar.size()];
        fill(stream, bytes, *at)?;
        *at += bytes.len() as u64;
        Ok(scalar.value(bytes, is_big_endian))
    };
    for (index, property) in element.properties.iter().enumerate() {
        if let Some(list) = property.list {
            let begin = *at;
            let count = next(list, at, stream)?;
            if count < 0.0 {
                return Err(Fault::byte(begin, format!("a list has a length of {count}")));
            }
            for _ in 0..count as u64 {
                next(property.scalar, at, stream)?;
            }
        } else {
            let begin = *at;
            let value = next(property.scalar, at, stream)?;
            take(index, value).map_err(|problem| Fault::byte(begin, problem))?;
        }
    }
    Ok(())
}
