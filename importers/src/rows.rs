//! Rows of text, a particle on each line, read block by block on all threads.

use crate::error::{Fault, Place, quote};
use crate::layout::{Layout, Role};
use crate::particles::Particles;
use crate::request::Request;
use crate::table::Table;
use crate::text::{Block, Fields, Text, lines};
use rayon::prelude::*;
use scene::text::mebibytes;

/// The bytes that a thread takes at a time.
const PIECE: usize = 1 << 16;
/// Room made for more rows than the first ones let expect, so that columns need not grow by half for the last of them.
const EXCESS: f64 = 1.02;

/// Reads a line of a format into a row.
pub(crate) trait RowReader: Sync {
    /// Adds the particle of `line`, if there is one on it.
    ///
    /// # Errors
    /// The column, from 0, and what is wrong there.
    fn read(&self, line: &[u8], table: &mut Table) -> Result<(), (usize, String)>;
}

/// Reads the next `count` lines, or all that are left.
pub(crate) fn read(
    text: &mut Text,
    count: Option<u64>,
    layout: &Layout,
    reader: &impl RowReader,
    request: &Request,
) -> Result<Table, Fault> {
    let most = most_rows(layout, request);
    if let Some(count) = count {
        check_room(count, text, layout, most)?;
    }
    let (mut table, mut left, begin) = (Table::new(layout), count.unwrap_or(u64::MAX), text.position());
    while left > 0 {
        let Some(block) = text.block(left)? else {
            let Some(count) = count else { break };
            let problem = format!("the file ends after {} of {count} particles", count - left);
            return Err(Fault::line(text.line(), problem));
        };
        left -= block.lines;
        read_block(&block, layout, reader, &mut table)?;
        if table.len() as u64 > most {
            return Err(too_many(layout, request));
        }
        if left > 0 && block.first == begin.line {
            let done = (text.position().offset - begin.offset).max(1);
            let rest = text.bytes_left().unwrap_or(0);
            let expected = table.len() as f64 * (1.0 + EXCESS * (rest as f64 / done as f64));
            let total = (expected as u64 + 1).min(count.unwrap_or(u64::MAX)).min(most);
            table.reserve_total(total as usize);
        }
    }
    Ok(table)
}

/// The most rows that the memory allows.
pub(crate) fn most_rows(layout: &Layout, request: &Request) -> u64 {
    (request.memory / layout.bytes_per_row()).min(Particles::MOST as u64)
}

/// The error for more than [`most_rows`].
pub(crate) fn too_many(layout: &Layout, request: &Request) -> Fault {
    let most = most_rows(layout, request);
    Fault::file(format!(
        "has more than the {most} particles that fit into {}, at {} bytes each; allow more memory",
        mebibytes(request.memory),
        layout.bytes_per_row()
    ))
}

/// Refuses a count that the rest of the file cannot hold or that memory cannot, before reading it all.
fn check_room(count: u64, text: &Text, layout: &Layout, most: u64) -> Result<(), Fault> {
    // A line has a character and its end, which the last may lack.
    let line = text.line();
    if text.bytes_left().is_some_and(|left| count.saturating_mul(2) > left.saturating_add(1)) {
        return Err(Fault::line(
            line,
            format!("the file is too short for the {count} particles it announces"),
        ));
    }
    if count > most {
        let bytes = mebibytes(count.saturating_mul(layout.bytes_per_row()));
        return Err(Fault::line(line, format!("{count} particles need {bytes}; allow more memory")));
    }
    Ok(())
}

fn read_block(
    block: &Block,
    layout: &Layout,
    reader: &impl RowReader,
    table: &mut Table,
) -> Result<(), Fault> {
    let fault = |bytes_before: &[u8], line: u64, (column, problem): (usize, String)| {
        let before = memchr::memchr_iter(b'\n', bytes_before).count() as u64;
        Fault { place: Place::Column(block.first + before + line, column as u64 + 1), problem }
    };
    if block.bytes.len() <= PIECE || rayon::current_num_threads() == 1 {
        return read_piece(block.bytes, reader, table).map_err(|(line, problem)| fault(b"", line, problem));
    }
    let read = |piece: &[u8]| {
        let mut rows = Table::new(layout);
        read_piece(piece, reader, &mut rows).map(|()| rows)
    };
    let tables: Vec<_> = pieces(block.bytes).into_par_iter().map(|piece| (piece, read(piece))).collect();
    let mut done = 0;
    for (piece, rows) in tables {
        let problem = match rows {
            Ok(mut rows) => table.append(&mut rows).map_err(|problem| (0, (0, problem))),
            Err(problem) => Err(problem),
        };
        problem.map_err(|(line, problem)| fault(&block.bytes[..done], line, problem))?;
        done += piece.len();
    }
    Ok(())
}

/// The text in pieces that end with a line.
fn pieces(bytes: &[u8]) -> Vec<&[u8]> {
    let (mut all, mut rest) = (Vec::new(), bytes);
    while rest.len() > PIECE {
        let end = memchr::memchr(b'\n', &rest[PIECE..]).map_or(rest.len(), |newline| PIECE + newline + 1);
        let (piece, after) = rest.split_at(end);
        all.push(piece);
        rest = after;
    }
    all.push(rest);
    all
}

/// Reads lines; an error has the line in the piece, from 0.
fn read_piece(
    bytes: &[u8],
    reader: &impl RowReader,
    table: &mut Table,
) -> Result<(), (u64, (usize, String))> {
    for (index, line) in lines(bytes).enumerate() {
        reader.read(line, table).map_err(|problem| (index as u64, problem))?;
    }
    Ok(())
}

/// Rows of fields separated by white space, in the order of a layout.
pub(crate) struct Separated<'a> {
    pub(crate) layout: &'a Layout,
    /// What a row consists of, for messages.
    pub(crate) expected: &'a str,
    /// Whether fields beyond the layout's are an error.
    pub(crate) is_exact: bool,
}

impl RowReader for Separated<'_> {
    #[inline]
    fn read(&self, line: &[u8], table: &mut Table) -> Result<(), (usize, String)> {
        let mut fields = Fields::new(line);
        let mut has_colors = false;
        for (index, &role) in self.layout.roles.iter().enumerate() {
            let Some((column, field)) = fields.next() else {
                let problem =
                    format!("the line has {index} of {} fields: {}", self.layout.roles.len(), self.expected);
                return Err((fields.column(), problem));
            };
            table.field(role, field).map_err(|problem| (column, problem))?;
            has_colors |= matches!(role, Role::Color(_));
        }
        if self.is_exact
            && let Some((column, field)) = fields.next()
        {
            let problem = format!(
                "{} is beyond the {} fields: {}",
                quote(field),
                self.layout.roles.len(),
                self.expected
            );
            return Err((column, problem));
        }
        table.end_row(true, has_colors);
        Ok(())
    }
}
