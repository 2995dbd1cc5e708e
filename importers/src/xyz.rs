//! XYZ and extended XYZ: a count, a comment, and a line per atom; frame after frame.
//!
//! The comment of extended XYZ has pairs of key and value. `Properties=species:S:1:pos:R:3:...` names the columns,
//! `Lattice="..."` has the three vectors of the cell, or the lengths of its edges along the axes, `pbc="T T F"` says along which it repeats, and `Origin="..."` where
//! it begins (<https://github.com/libAtoms/extxyz>).

use crate::cell::cell;
use crate::elements::{element_of, elements_of};
use crate::error::{Fault, quote};
use crate::format::Format;
use crate::layout::{Kind, Layout, MOST_COLUMNS, Role, components};
use crate::particles::{Cell, Labels, Particles, title};
use crate::request::{Properties, Request};
use crate::rows::{self, Separated};
use crate::text::{Fields, Text, integer, number};

/// Skips a frame; `false` if there is none.
pub(crate) fn skip(text: &mut Text) -> Result<bool, Fault> {
    if !text.skip_blank()? {
        return Ok(false);
    }
    let count = count(text)?;
    text.need("the comment of a frame")?;
    let line = text.line();
    match text.skip(count)? {
        skipped if skipped < count => {
            Err(Fault::line(line + skipped, format!("the file ends after {skipped} of {count} particles")))
        }
        _ => Ok(true),
    }
}

/// Reads a frame.
pub(crate) fn read(text: &mut Text, request: &Request) -> Result<Particles, Fault> {
    let count = count(text)?;
    let line = text.line();
    let comment = Comment::new(text.need("the comment of a frame")?).map_err(|p| Fault::line(line, p))?;
    let fault = |problem: String| Fault::line(line, problem);
    let extra = extra_columns(text, &comment)?;
    let layout = layout(&comment, extra, &request.properties).map_err(fault)?;
    let expected = comment.expected();
    let reader = Separated { layout: &layout, expected: &expected, is_exact: comment.properties.is_some() };
    let mut table = rows::read(text, Some(count), &layout, &reader, request)?;
    let mut particles = Particles::new(Format::Xyz);
    particles.cell = comment.cell().map_err(fault)?;
    particles.title.clone_from(&comment.title);
    // Atomic numbers are what they are; species may be anything.
    let species =
        if comment.has_species() { std::mem::take(table.label(Kind::Element)).finish() } else { None };
    let scale = if comment.has_byte_colors { 255.0 } else { 1.0 };
    table.finish(layout, Some(scale), &mut particles);
    if let Some(species) = species {
        name_species(species, &mut particles);
    }
    Ok(particles)
}

/// The count that begins a frame.
fn count(text: &mut Text) -> Result<u64, Fault> {
    let line = text.line();
    let first = text.need("a number of atoms")?;
    let fields: Vec<_> = Fields::new(first).take(2).collect();
    let count = match fields[..] {
        [(_, field)] => integer(field).and_then(|count| u64::try_from(count).ok()),
        _ => None,
    };
    let problem = || format!("{} is no number of atoms, with which a frame of XYZ begins", quote(first));
    count.ok_or_else(|| Fault::line(line, problem()))
}

/// The number of columns beyond symbol and position in the first row of plain XYZ.
fn extra_columns(text: &mut Text, comment: &Comment) -> Result<usize, Fault> {
    if comment.properties.is_some() {
        return Ok(0);
    }
    let first = text.peek()?.unwrap_or_default();
    let numbers =
        Fields::new(first).skip(4).take(MOST_COLUMNS).take_while(|(_, field)| number(field).is_some());
    Ok(numbers.count())
}

/// Elements by species, and types where species are not all symbols.
fn name_species(species: Labels, particles: &mut Particles) {
    let is_symbol = |name: &String| name.parse::<f64>().is_err() && element_of(name) > 0;
    let elements = elements_of(&species, element_of_label);
    particles.elements = particles.elements.take().or(elements);
    if !species.names.iter().all(is_symbol) && particles.types.is_none() {
        particles.types = Some(species);
    }
}

/// The element of a label such as `Fe`, `C1`, `O_w` or `H+`; 0 if none is evident. A number is a type: programs that
/// write numbers mean their own types more often than atomic numbers.
fn element_of_label(label: &str) -> u8 {
    let letters = label.find(|c: char| !c.is_ascii_alphabetic()).unwrap_or(label.len());
    if letters == 0 { 0 } else { element_of(&label[..letters]) }
}

/// What the comment of a frame says.
struct Comment {
    title: String,
    properties: Option<Vec<Column>>,
    lattice: Option<String>,
    origin: Option<String>,
    pbc: Option<String>,
    has_byte_colors: bool,
}

/// A column or several: `forces:R:3`.
struct Column {
    name: String,
    kind: u8,
    count: usize,
}

impl Comment {
    fn new(line: &[u8]) -> Result<Self, String> {
        let text = String::from_utf8_lossy(line);
        let mut comment = Self {
            title: title(&text),
            properties: None,
            lattice: None,
            origin: None,
            pbc: None,
            has_byte_colors: false,
        };
        // Free text may hold anything, quotation marks too: only what is meant to be extended XYZ is read as such.
        if !["properties", "lattice"].iter().any(|key| has_key(&text, key)) {
            return Ok(comment);
        }
        for (key, value) in pairs(&text)? {
            match key.to_ascii_lowercase().as_str() {
                "properties" => comment.properties = Some(columns(&value)?),
                "lattice" => comment.lattice = Some(value),
                "origin" | "cell_origin" => comment.origin = Some(value),
                "pbc" => comment.pbc = Some(value),
                _ => {}
            }
        }
        let is_byte_color = |column: &Column| is_color(&column.name) && column.kind == b'I';
        comment.has_byte_colors = comment.properties.iter().flatten().any(is_byte_color);
        Ok(comment)
    }

    /// Whether there is a column of symbols or other texts, as plain XYZ has.
    fn has_species(&self) -> bool {
        let is_species = |column: &Column| role_of_text(column) == Some(Role::Label(Kind::Element));
        self.properties.as_ref().is_none_or(|columns| columns.iter().any(is_species))
    }

    /// What a row consists of.
    fn expected(&self) -> String {
        let Some(columns) = &self.properties else { return "a symbol and x, y, z".into() };
        let name = |column: &Column| match column.count {
            1 => column.name.clone(),
            count => format!("{} ({count})", column.name),
        };
        columns.iter().map(name).collect::<Vec<_>>().join(", ")
    }

    fn cell(&self) -> Result<Option<Cell>, String> {
        let Some(lattice) = &self.lattice else { return Ok(None) };
        let wrong = || {
            format!(
                "Lattice={} is no cell; it is nine numbers, three for each vector, or three lengths of edges",
                quote(lattice.as_bytes())
            )
        };
        let numbers = list(lattice).ok_or_else(wrong)?;
        let vectors = match numbers[..] {
            [a, b, c, d, e, f, g, h, i] => [[a, b, c], [d, e, f], [g, h, i]],
            [a, b, c] => [[a, 0.0, 0.0], [0.0, b, 0.0], [0.0, 0.0, c]],
            _ => return Err(wrong()),
        };
        let origin = match &self.origin {
            None => [0.0; 3],
            Some(text) => list(text).and_then(|origin| origin.try_into().ok()).ok_or_else(|| {
                format!("Origin={} is no point; it is three numbers", quote(text.as_bytes()))
            })?,
        };
        let periodic = match &self.pbc {
            None => [true; 3],
            Some(text) => truths(text).ok_or_else(|| {
                format!("pbc={} is wrong; it is \"T T F\" or the like", quote(text.as_bytes()))
            })?,
        };
        Ok(cell(origin, vectors, periodic))
    }
}

fn is_color(name: &str) -> bool {
    matches!(name.to_ascii_lowercase().as_str(), "color" | "colour")
}

fn is_radius(column: &Column) -> bool {
    matches!(column.name.to_ascii_lowercase().as_str(), "radius" | "radii") && column.count == 1
}

/// The layout of a frame's rows.
fn layout(comment: &Comment, extra: usize, wanted: &Properties) -> Result<Layout, String> {
    let mut layout = Layout::default();
    let Some(columns) = &comment.properties else {
        layout.push(Role::Label(Kind::Element));
        (0..3).for_each(|axis| layout.push(Role::Axis(axis)));
        (5..5 + extra).for_each(|column| layout.push_property(&format!("column_{column}"), wanted));
        // Rows may end early: what nobody asked for is not needed.
        while layout.roles.last() == Some(&Role::Skip) {
            layout.roles.pop();
        }
        return Ok(layout);
    };
    for column in columns {
        push_column(column, comment, wanted, &mut layout);
    }
    if layout.roles.len() > MOST_COLUMNS {
        return Err(format!(
            "Properties names {} columns; at most {MOST_COLUMNS} are read",
            layout.roles.len()
        ));
    }
    if !(0..3).all(|axis| layout.has(Role::Axis(axis))) {
        return Err("Properties has no positions; these are pos:R:3".into());
    }
    Ok(layout)
}

fn push_column(column: &Column, comment: &Comment, wanted: &Properties, layout: &mut Layout) {
    let name = column.name.to_ascii_lowercase();
    let is_new = |role: &Role| !layout.has(*role);
    let role = match (name.as_str(), column.count) {
        ("pos" | "position" | "positions", 3) => Some(Role::Axis(0)),
        ("color" | "colour", 3) => Some(Role::Color(0)),
        _ if is_radius(column) => Some(Role::Radius),
        ("diameter", 1) if !comment.properties.iter().flatten().any(is_radius) => Some(Role::Diameter),
        ("id", 1) if column.kind == b'I' => Some(Role::Id),
        ("mol" | "molecule" | "molid", 1) if column.kind == b'I' => Some(Role::Molecule),
        ("z" | "numbers" | "atomic_number", 1) if column.kind == b'I' && !comment.has_species() => {
            Some(Role::Label(Kind::Element))
        }
        ("type" | "types", 1) => Some(Role::Label(Kind::Type)),
        _ => role_of_text(column),
    };
    match role.filter(is_new) {
        Some(Role::Axis(_)) => (0..3).for_each(|axis| layout.push(Role::Axis(axis))),
        Some(Role::Color(_)) => (0..3).for_each(|channel| layout.push(Role::Color(channel))),
        Some(role) => layout.push(role),
        None if column.kind == b'S' => (0..column.count).for_each(|_| layout.push(Role::Skip)),
        None => {
            for name in components(&column.name, column.count) {
                layout.push_property(&name, wanted);
            }
        }
    }
}

/// The role of a column of text.
fn role_of_text(column: &Column) -> Option<Role> {
    if column.kind != b'S' || column.count != 1 {
        return None;
    }
    let kind = match column.name.to_ascii_lowercase().as_str() {
        "species" | "symbol" | "symbols" | "element" | "elements" => Kind::Element,
        "name" | "atom_name" | "atomtypes" => Kind::Name,
        "resname" | "residue" | "residuenames" => Kind::Residue,
        "chain" => Kind::Chain,
        _ => return None,
    };
    Some(Role::Label(kind))
}

/// The columns that `Properties` names.
fn columns(text: &str) -> Result<Vec<Column>, String> {
    let parts: Vec<&str> = text.split(':').collect();
    let column = |part: &[&str]| {
        let [name, kind @ ("S" | "R" | "I" | "L"), count] = *part else { return None };
        let count = count.parse().ok().filter(|count| (1..=MOST_COLUMNS).contains(count))?;
        Some(Column { name: name.into(), kind: kind.as_bytes()[0], count })
    };
    parts
        .chunks(3)
        .take(MOST_COLUMNS + 1)
        .map(|part| {
            column(part).ok_or_else(|| {
                let wrong = quote(part.join(":").as_bytes());
                format!("{wrong} in Properties is no column; one is name:type:count with type S, R, I or L")
            })
        })
        .collect()
}

/// Whether `key`, a word of its own in any case, has a value in `text`. After blanks that must look like one: in free text an
/// equals sign may mean anything.
fn has_key(text: &str, key: &str) -> bool {
    let text = text.to_ascii_lowercase();
    let begins = |at: &usize| *at == 0 || text.as_bytes()[at - 1].is_ascii_whitespace();
    let has_value = |at: usize| {
        let rest = &text[at + key.len()..];
        let Some(value) = rest.trim_start().strip_prefix('=') else { return false };
        let value = value.trim_start();
        let word = value.split_whitespace().next().unwrap_or_default();
        rest.starts_with('=') || value.starts_with(['"', '{', '[']) || word.contains(':')
    };
    text.match_indices(key).map(|(at, _)| at).filter(begins).any(has_value)
}

/// Pairs of key and value; words without a value are left out.
fn pairs(text: &str) -> Result<Vec<(String, String)>, String> {
    let mut pairs = Vec::new();
    let mut rest = text.trim_start();
    while !rest.is_empty() {
        let end = rest.find(|c: char| c == '=' || c.is_whitespace()).unwrap_or(rest.len());
        let key = rest[..end].trim_matches('"');
        rest = rest[end..].trim_start();
        let Some(value) = rest.strip_prefix('=') else { continue };
        let (value, after) = value_of(value.trim_start()).ok_or_else(|| {
            format!(
                "the value of {} has no end: a quotation mark or bracket is missing",
                quote(key.as_bytes())
            )
        })?;
        pairs.push((key.to_owned(), value));
        rest = after.trim_start();
    }
    Ok(pairs)
}

/// The value that begins `text`: bare, quoted, or in braces or brackets; and what comes after it.
fn value_of(text: &str) -> Option<(String, &str)> {
    match text.chars().next() {
        Some('"') => quoted(&text[1..]),
        Some('{') => text[1..].split_once('}').map(|(value, rest)| (value.to_owned(), rest)),
        Some('[') => {
            let mut depth = 0_i64;
            let close = text.find(|c| {
                depth += i64::from(c == '[') - i64::from(c == ']');
                depth == 0
            })?;
            Some((text[..=close].to_owned(), &text[close + 1..]))
        }
        _ => {
            let (value, rest) = text.split_at(text.find(char::is_whitespace).unwrap_or(text.len()));
            Some((value.to_owned(), rest))
        }
    }
}

/// A text up to its closing quotation mark, in which a backslash takes the next character as it is.
fn quoted(text: &str) -> Option<(String, &str)> {
    let (mut value, mut chars) = (String::new(), text.char_indices());
    while let Some((at, c)) = chars.next() {
        match c {
            '"' => return Some((value, &text[at + 1..])),
            '\\' => value.push(chars.next()?.1),
            _ => value.push(c),
        }
    }
    None
}

/// Numbers separated by spaces, commas or brackets.
fn list(text: &str) -> Option<Vec<f64>> {
    let parts = text.split(|c: char| c.is_whitespace() || matches!(c, ',' | '[' | ']'));
    parts
        .filter(|part| !part.is_empty())
        .map(|part| number(part.as_bytes()).filter(|v| v.is_finite()))
        .collect()
}

/// Three truth values.
fn truths(text: &str) -> Option<[bool; 3]> {
    let parts = text
        .split(|c: char| c.is_whitespace() || matches!(c, ',' | '[' | ']'))
        .filter(|part| !part.is_empty());
    let truth = |part: &str| match part {
        "T" | "True" | "true" | "TRUE" | "1" => Some(true),
        "F" | "False" | "false" | "FALSE" | "0" => Some(false),
        _ => None,
    };
    parts.map(truth).collect::<Option<Vec<_>>>()?.try_into().ok()
}
