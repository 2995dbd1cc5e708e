//! `NumPy` arrays: (N, 3) positions, (N, 4) positions and radii, or structured with named fields; and trajectories, (frames, N,
//! 3) or (frames, N, 4).
//!
//! The header is read by `npyz`, and the numbers here: that crate reads row by row, and only into types that are known
//! before.

use crate::binary::{Field, Rows, Stored, fill};
use crate::columns::{no_axes, role, role_of_vector};
use crate::error::{Fault, no_such_frame};
use crate::format::Format;
use crate::layout::{Layout, MOST_COLUMNS, Role, components};
use crate::particles::Particles;
use crate::request::{Properties, Request};
use crate::table::Table;
use crate::text::{Source, Stream};
use crate::values::Scalar;
use npyz::{DType, Endianness, NpyHeader, Order, TypeChar};
use std::io::{BufReader, Read};

/// The longest header, and the deepest brackets in it. What parses it is recursive.
const LONGEST_HEADER: usize = 1 << 16;
const DEEPEST: usize = 8;

/// An array of a file, before its numbers.
pub(crate) struct Array {
    dtype: DType,
    pub(crate) shape: Vec<u64>,
    is_fortran: bool,
    /// Bytes before the numbers: those of the header, and of the frames before the one that is read.
    pub(crate) header: u64,
}

/// The number of frames.
pub(crate) fn frames(source: &mut dyn Source) -> Result<usize, Fault> {
    let mut stream = Stream::new(source).map_err(|error| Fault::unread(&error))?;
    let array = Array::header(&mut stream)?;
    Ok(array.frame_shape().map_or(1, |[frames, ..]| usize::try_from(frames).unwrap_or(usize::MAX)))
}

/// Reads the particles of a frame.
pub(crate) fn read(source: &mut dyn Source, number: usize, request: &Request) -> Result<Particles, Fault> {
    let unread = |error: std::io::Error| Fault::unread(&error);
    let mut stream = Stream::new(source).map_err(unread)?;
    let length = stream.length().map_err(unread)?;
    let mut array = Array::header(&mut stream)?;
    if let Some(skipped) = array.take_frame(number)? {
        stream.skip(skipped).map_err(unread)?;
    }
    let mut layout = Layout::default();
    let columns = array.particles(&mut layout, &request.properties)?;
    let mut table = Table::new(&layout);
    let input = Input { stream: &mut stream, left: length.map(|length| length.saturating_sub(array.header)) };
    array.read(&columns, input, &layout, request, &mut table)?;
    let mut particles = Particles::new(Format::Npy);
    table.finish(layout, columns.full, &mut particles);
    Ok(particles)
}

/// The numbers of an array.
pub(crate) struct Input<'a> {
    pub(crate) stream: &'a mut dyn Read,
    /// How many bytes there are, if that is known.
    pub(crate) left: Option<u64>,
}

/// How an array's rows are read.
pub(crate) struct Columns {
    fields: Vec<Field>,
    /// Bytes of a row.
    size: usize,
    /// The number that stands for a colour's full intensity, if the type says so.
    pub(crate) full: Option<f32>,
}

impl Array {
    /// Reads the header.
    pub(crate) fn header(stream: &mut dyn Read) -> Result<Self, Fault> {
        let mut bytes = vec![0; 12];
        fill(stream, &mut bytes[..10], 0)?;
        if !bytes.starts_with(b"\x93NUMPY") {
            return Err(Fault::byte(0, "is no .npy file; write one by numpy.save"));
        }
        let is_first_version = bytes[6] == 1;
        let (begin, length) = if is_first_version {
            (10, usize::from(u16::from_le_bytes([bytes[8], bytes[9]])))
        } else {
            fill(stream, &mut bytes[10..], 10)?;
            (12, u32::from_le_bytes([bytes[8], bytes[9], bytes[10], bytes[11]]) as usize)
        };
        if length > LONGEST_HEADER {
            return Err(Fault::byte(
                8,
                format!("the header has {length} bytes; at most {LONGEST_HEADER} are read"),
            ));
        }
        bytes.truncate(begin);
        // Grows with what is there.
        let read = (&mut *stream).take(length as u64).read_to_end(&mut bytes);
        read.map_err(|error| Fault::unread(&error))?;
        if bytes.len() < begin + length {
            return Err(Fault::byte(
                begin as u64,
                format!("the file ends within the header of {length} bytes"),
            ));
        }
        check_depth(&bytes[begin..])?;
        // The parser's own message takes several lines.
        let wrong = |_| Fault::byte(begin as u64, "the header describes no array; write one by numpy.save");
        let header = NpyHeader::from_reader(bytes.as_slice()).map_err(wrong)?;
        Ok(Self {
            dtype: header.dtype(),
            shape: header.shape().to_vec(),
            is_fortran: header.order() == Order::Fortran,
            header: bytes.len() as u64,
        })
    }

    /// The shape of a trajectory; `None` for one frame.
    fn frame_shape(&self) -> Option<[u64; 3]> {
        match self.shape[..] {
            [frames, rows, columns @ (3 | 4)] if matches!(self.dtype, DType::Plain(_)) => {
                Some([frames, rows, columns])
            }
            _ => None,
        }
    }

    /// Makes of a trajectory its frame `number`. Returns the bytes that stand before it, behind the header.
    fn take_frame(&mut self, number: usize) -> Result<Option<u64>, Fault> {
        let Some([frames, rows, columns]) = self.frame_shape() else {
            return if number == 0 { Ok(None) } else { Err(no_such_frame(number, 1)) };
        };
        if number as u64 >= frames {
            return Err(no_such_frame(number, usize::try_from(frames).unwrap_or(usize::MAX)));
        }
        if self.is_fortran && frames > 1 {
            return Err(self.fault(format!(
                "has shape {} in Fortran order, in which frames are mixed: save numpy.ascontiguousarray(array)",
                self.shown_shape()
            )));
        }
        let size = self.stored(&self.dtype)?.0.size() as u64;
        let all = rows.checked_mul(columns).and_then(|n| n.checked_mul(size)?.checked_mul(number as u64));
        let skipped = all.ok_or_else(|| self.fault("has more numbers than any file"))?;
        self.header = self.header.saturating_add(skipped);
        self.shape = vec![rows, columns];
        Ok(Some(skipped))
    }

    fn fault(&self, problem: impl Into<String>) -> Fault {
        Fault::byte(self.header, problem)
    }

    /// The shape as Python shows it.
    fn shown_shape(&self) -> String {
        let sizes: Vec<String> = self.shape.iter().map(u64::to_string).collect();
        format!("({})", sizes.join(", "))
    }

    /// The columns of an array that has all of the particles.
    pub(crate) fn particles(&self, layout: &mut Layout, wanted: &Properties) -> Result<Columns, Fault> {
        if matches!(self.dtype, DType::Record(_)) {
            return self.record(layout, wanted);
        }
        match self.shape[..] {
            [_, 3] => self.columns(&[0, 1, 2].map(Role::Axis), layout),
            [_, 4] => {
                // An archive may have told radii before.
                let fourth = if layout.has(Role::Radius) { Role::Skip } else { Role::Radius };
                self.columns(&[Role::Axis(0), Role::Axis(1), Role::Axis(2), fourth], layout)
            }
            [3 | 4, _] => Err(self.fault(format!(
                "has shape {}, and should have {}: save array.T",
                self.shown_shape(),
                "(N, 3) or (N, 4)"
            ))),
            _ => Err(self.fault(format!(
                "has shape {}; particles are (N, 3), (N, 4) with radii, frames of these, or structured with x, y and z",
                self.shown_shape()
            ))),
        }
    }

    /// Columns of these roles, of an array with numbers or texts.
    pub(crate) fn columns(&self, roles: &[Role], layout: &mut Layout) -> Result<Columns, Fault> {
        let (stored, is_big_endian) = self.stored(&self.dtype)?;
        let field = |(index, &role): (usize, &Role)| Field {
            offset: index * stored.size(),
            stored,
            role,
            is_big_endian,
        };
        let fields: Vec<Field> = roles.iter().enumerate().map(field).collect();
        layout.roles.extend(roles);
        Ok(Columns { size: stored.size() * roles.len(), full: full(&fields), fields })
    }

    /// The columns of a structured array.
    fn record(&self, layout: &mut Layout, wanted: &Properties) -> Result<Columns, Fault> {
        let DType::Record(record) = &self.dtype else { return Err(self.fault("is not structured")) };
        if !matches!(self.shape[..], [_] | [_, 1]) {
            return Err(self.fault(format!(
                "has shape {}; structured arrays of particles have (N,)",
                self.shown_shape()
            )));
        }
        let names: Vec<String> = record.iter().map(|field| field.name.to_ascii_lowercase()).collect();
        let (mut fields, mut size) = (Vec::new(), 0_usize);
        for (field, name) in record.iter().zip(&names) {
            let (count, of) = flat(&field.dtype).ok_or_else(|| self.fault("has a field too large"))?;
            if is_padding(of) {
                size = size.saturating_add(count.saturating_mul(of.num_bytes().unwrap_or(usize::MAX)));
                continue;
            }
            let (stored, is_big_endian) = self.stored(of)?;
            for role in roles(name, &field.name, count, stored, &names, layout, wanted) {
                fields.push(Field { offset: size, stored, role, is_big_endian });
                layout.push(role);
                size = size.saturating_add(stored.size());
            }
            if fields.len() > MOST_COLUMNS {
                return Err(self.fault(format!("has more than {MOST_COLUMNS} columns")));
            }
        }
        if !(0..3).all(|axis| layout.has(Role::Axis(axis))) {
            return Err(self.fault(no_axes(&names)));
        }
        if size > LONGEST_HEADER {
            return Err(self.fault(format!("has rows of more than {LONGEST_HEADER} bytes")));
        }
        fields.retain(|field| field.role != Role::Skip);
        Ok(Columns { full: full(&fields), fields, size })
    }

    /// How values of a type are stored, and whether the most significant byte is the first.
    fn stored(&self, dtype: &DType) -> Result<(Stored, bool), Fault> {
        let wrong = || {
            // It has quotes of its own.
            let shown = dtype.descr();
            self.fault(format!("is of dtype {shown}, which is not read; use array.astype(\"f4\")"))
        };
        let DType::Plain(plain) = dtype else { return Err(wrong()) };
        let size = usize::try_from(plain.size_field()).map_err(|_| wrong())?;
        let stored = match (plain.type_char(), size) {
            (TypeChar::Float, 4 | 8) => Stored::Number(Scalar::Float(size)),
            (TypeChar::Int, 1 | 2 | 4 | 8) => Stored::Number(Scalar::Signed(size)),
            (TypeChar::Uint, 1 | 2 | 4 | 8) | (TypeChar::Bool, 1) => Stored::Number(Scalar::Unsigned(size)),
            (TypeChar::ByteStr, 1..=1024) => Stored::Bytes(size),
            (TypeChar::UnicodeStr, 1..=1024) => Stored::Characters(size),
            _ => return Err(wrong()),
        };
        Ok((stored, plain.endianness() == Endianness::Big))
    }

    /// Reads the rows.
    pub(crate) fn read(
        &self,
        columns: &Columns,
        input: Input,
        layout: &Layout,
        request: &Request,
        table: &mut Table,
    ) -> Result<(), Fault> {
        let count = self.shape.first().copied().unwrap_or(1);
        let rows = Rows {
            fields: &columns.fields,
            size: columns.size,
            count,
            at: self.header,
            available: input.left,
        };
        rows.check(layout, request)?;
        if self.is_fortran && columns.fields.len() > 1 && self.shape.len() > 1 {
            return self.by_columns(columns, input.stream, table);
        }
        rows.read(&mut BufReader::with_capacity(1 << 16, input.stream), table)
    }

    /// The numbers of an array of at most nine, row by row.
    pub(crate) fn numbers(&self, stream: &mut dyn Read) -> Result<Vec<f64>, Fault> {
        let (Stored::Number(scalar), is_big_endian) = self.stored(&self.dtype)? else {
            return Err(self.fault("has texts instead of numbers"));
        };
        let count = self.shape.iter().product::<u64>().min(9) as usize;
        let mut bytes = vec![0; count * scalar.size()];
        fill(stream, &mut bytes, self.header)?;
        let numbers = bytes.chunks_exact(scalar.size()).map(|bytes| scalar.value(bytes, is_big_endian));
        let numbers: Vec<f64> = numbers.collect();
        if self.is_fortran && count == 9 {
            return Ok((0..9).map(|at| numbers[at % 3 * 3 + at / 3]).collect());
        }
        Ok(numbers)
    }

    /// Reads an array whose columns follow each other.
    fn by_columns(&self, columns: &Columns, stream: &mut dyn Read, table: &mut Table) -> Result<(), Fault> {
        const BLOCK: usize = 1 << 14;
        let mut at = self.header;
        for field in &columns.fields {
            let size = field.stored.size();
            let (mut left, mut row, mut buffer) = (self.shape[0], 0_usize, Vec::new());
            while left > 0 {
                let rows = usize::try_from(left).unwrap_or(BLOCK).min(BLOCK);
                buffer.resize(rows * size, 0);
                fill(stream, &mut buffer, at)?;
                for bytes in buffer.chunks_exact(size) {
                    let Stored::Number(scalar) = field.stored else {
                        return Err(self.fault("has texts in several columns"));
                    };
                    let value = scalar.value(bytes, field.is_big_endian);
                    table
                        .number_of_column(field.role, row, value)
                        .map_err(|problem| Fault::byte(at, format!("row {row}: {problem}")))?;
                    at += size as u64;
                    row += 1;
                }
                left -= rows as u64;
            }
        }
        Ok(())
    }
}

/// The roles of a field's values.
fn roles(
    name: &str,
    shown: &str,
    count: usize,
    stored: Stored,
    names: &[String],
    layout: &mut Layout,
    wanted: &Properties,
) -> Vec<Role> {
    let is_new = |role: &Role| !layout.has(*role);
    if let Some(first) = role_of_vector(name, count).filter(is_new) {
        let of = |index: usize| match first {
            Role::Axis(_) => Role::Axis(index),
            _ if index < 3 => Role::Color(index),
            _ => Role::Skip,
        };
        return (0..count).map(of).collect();
    }
    match (role(name, names).filter(is_new), stored) {
        (Some(role), _) if count == 1 => vec![role],
        (_, Stored::Number(_)) if count <= MOST_COLUMNS => {
            components(shown, count).iter().map(|name| layout.property(name, wanted)).collect()
        }
        _ => vec![Role::Skip; count.min(MOST_COLUMNS + 1)],
    }
}

fn full(fields: &[Field]) -> Option<f32> {
    let color = fields.iter().find(|field| matches!(field.role, Role::Color(_)))?;
    match color.stored {
        Stored::Number(scalar @ (Scalar::Unsigned(_) | Scalar::Signed(_))) => Some(scalar.full() as f32),
        _ => None,
    }
}

/// The number of values of a field, and the type of each.
fn flat(dtype: &DType) -> Option<(usize, &DType)> {
    match dtype {
        DType::Array(count, of) => {
            let (inner, of) = flat(of)?;
            Some((
                inner.checked_mul(usize::try_from(*count).ok()?).filter(|count| *count <= LONGEST_HEADER)?,
                of,
            ))
        }
        _ => Some((1, dtype)),
    }
}

/// Bytes that `NumPy` leaves between fields.
fn is_padding(dtype: &DType) -> bool {
    matches!(dtype, DType::Plain(plain) if plain.type_char() == TypeChar::RawData)
}

/// Refuses a header whose brackets are nested deeper than those of any array.
fn check_depth(header: &[u8]) -> Result<(), Fault> {
    let (mut depth, mut deepest) = (0_usize, 0);
    for byte in header {
        match byte {
            b'(' | b'[' | b'{' => depth += 1,
            b')' | b']' | b'}' => depth = depth.saturating_sub(1),
            _ => {}
        }
        deepest = deepest.max(depth);
    }
    if deepest > DEEPEST {
        Err(Fault::byte(10, "the header describes no array; write one by numpy.save"))
    } else {
        Ok(())
    }
}
