//! Rows of binary numbers, all of one size.

use crate::error::Fault;
use crate::layout::{Layout, Role};
use crate::request::Request;
use crate::rows::{most_rows, too_many};
use crate::table::Table;
use crate::values::Scalar;
use std::io::{ErrorKind, Read};

/// How a field is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Stored {
    Number(Scalar),
    /// Bytes of text, padded with NUL.
    Bytes(usize),
    /// Characters of text as 32-bit numbers, padded with NUL.
    Characters(usize),
}

impl Stored {
    pub(crate) fn size(self) -> usize {
        match self {
            Self::Number(scalar) => scalar.size(),
            Self::Bytes(size) => size,
            Self::Characters(count) => 4 * count,
        }
    }
}

/// A field of a row.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Field {
    /// Where it begins in the row.
    pub(crate) offset: usize,
    pub(crate) stored: Stored,
    pub(crate) role: Role,
    pub(crate) is_big_endian: bool,
}

impl Field {
    /// Takes the field of the row `bytes`.
    #[inline]
    pub(crate) fn take(&self, bytes: &[u8], table: &mut Table) -> Result<(), String> {
        let bytes = &bytes[self.offset..];
        match self.stored {
            Stored::Number(scalar) => table.number(self.role, scalar.value(bytes, self.is_big_endian)),
            Stored::Bytes(size) => table.field(self.role, until_nul(&bytes[..size])),
            Stored::Characters(count) => {
                table.field(self.role, characters(&bytes[..4 * count], self.is_big_endian).as_bytes())
            }
        }
    }
}

fn until_nul(bytes: &[u8]) -> &[u8] {
    bytes.split(|byte| *byte == 0).next().unwrap_or(bytes)
}

fn characters(bytes: &[u8], is_big_endian: bool) -> String {
    let of = |bytes: &[u8]| Scalar::Unsigned(4).value(bytes, is_big_endian) as u32;
    let numbers = bytes.chunks_exact(4).map(of).take_while(|number| *number > 0);
    numbers.map(|number| char::from_u32(number).unwrap_or(char::REPLACEMENT_CHARACTER)).collect()
}

/// The rows of a file.
pub(crate) struct Rows<'a> {
    pub(crate) fields: &'a [Field],
    pub(crate) size: usize,
    pub(crate) count: u64,
    /// Where the first begins in the file, for messages.
    pub(crate) at: u64,
    /// The bytes from there on, if that is known.
    pub(crate) available: Option<u64>,
}

/// Bytes read at a time.
const BLOCK: usize = 1 << 18;

impl Rows<'_> {
    /// Refuses a count that the file or the memory cannot hold.
    pub(crate) fn check(&self, layout: &Layout, request: &Request) -> Result<(), Fault> {
        let bytes = self.count.checked_mul(self.size as u64);
        if self.available.is_some_and(|available| bytes.is_none_or(|bytes| bytes > available)) {
            let problem = format!(
                "the file is too short for the {} rows of {} bytes it announces: it has {} bytes from here on",
                self.count,
                self.size,
                self.available.unwrap_or(0)
            );
            return Err(Fault::byte(self.at, problem));
        }
        if self.count > most_rows(layout, request) { Err(too_many(layout, request)) } else { Ok(()) }
    }

    /// Reads all rows.
    pub(crate) fn read(&self, stream: &mut dyn Read, table: &mut Table) -> Result<(), Fault> {
        let has = |is: fn(&Role) -> bool| self.fields.iter().any(|field| is(&field.role));
        let has_axes = has(|role| matches!(role, Role::Axis(_)));
        let has_colors = has(|role| matches!(role, Role::Color(_)));
        let per_block = (BLOCK / self.size.max(1)).max(1);
        let mut buffer = Vec::new();
        let mut done = 0;
        while done < self.count {
            let rows = usize::try_from(self.count - done).unwrap_or(per_block).min(per_block);
            buffer.resize(rows * self.size, 0);
            fill(stream, &mut buffer, self.at + done * self.size as u64)?;
            for (index, row) in buffer.chunks_exact(self.size.max(1)).enumerate() {
                for field in self.fields {
                    field.take(row, table).map_err(|problem| {
                        let number = done + index as u64;
                        let byte = self.at + number * self.size as u64 + field.offset as u64;
                        Fault::byte(byte, format!("row {number}: {problem}"))
                    })?;
                }
                table.end_row(has_axes, has_colors);
            }
            if done == 0 && self.available.is_some() {
                table.reserve_total(self.count as usize);
            }
            done += rows as u64;
        }
        Ok(())
    }
}

/// Reads exactly as many bytes.
pub(crate) fn fill(stream: &mut dyn Read, buffer: &mut [u8], at: u64) -> Result<(), Fault> {
    stream.read_exact(buffer).map_err(|error| match error.kind() {
        ErrorKind::UnexpectedEof => Fault::byte(at, "the file ends within the rows that begin here"),
        _ => Fault::unread(&error),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Place;

    /// Rows and bytes are told as they are counted in the file, also where many blocks come before.
    #[test]
    fn what_is_wrong_far_behind_is_found_where_it_is() {
        const SIZE: usize = 1 << 12;
        const BAD: u64 = 200;
        const _: () = assert!(BAD as usize * SIZE > 3 * BLOCK);
        let field = |axis| Field {
            offset: 8 + 4 * axis,
            stored: Stored::Number(Scalar::Float(4)),
            role: Role::Axis(axis),
            is_big_endian: false,
        };
        let fields = [0, 1, 2].map(field);
        let rows = Rows { fields: &fields, size: SIZE, count: 256, at: 77, available: None };
        let mut bytes = vec![0; 256 * SIZE];
        let read = |bytes: &[u8]| rows.read(&mut &bytes[..], &mut Table::new(&Layout::default()));
        assert!(read(&bytes).is_ok());
        let at = BAD as usize * SIZE + 12;
        bytes[at..at + 4].copy_from_slice(&f32::NAN.to_le_bytes());
        let Fault { place, problem } = read(&bytes).unwrap_err();
        assert_eq!(problem, "row 200: the coordinate is NaN; coordinates are finite numbers");
        assert_eq!(place, Place::Byte(77 + at as u64));
    }
}
