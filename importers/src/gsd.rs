//! GSD of HOOMD-blue: an index of binary chunks, each a property of a frame
//! (<https://gsd.readthedocs.io/en/stable/file-layer.html> and `schema-hoomd.html` beside it).
//!
//! What a frame does not have it shares with the first one or, if numbers of particles differ or the first has none
//! either, is the default of the schema. The cell is centred at 0.

use crate::binary::fill;
use crate::cell::cell;
use crate::elements::elements_of;
use crate::error::{Fault, no_such_frame, quote};
use crate::format::Format;
use crate::layout::{components, is_wanted};
use crate::particles::{Cell, Labels, Particles, Property};
use crate::request::Request;
use crate::text::Source;
use crate::values::Scalar;
use std::collections::HashMap;
use std::io::SeekFrom;

pub(crate) const MAGIC: u64 = 0x65DF_65DF_65DF_65DF;

const HEADER: usize = 256;
const ENTRY: usize = 32;
/// Bytes of the list of names per allocated entry.
const NAME: usize = 64;
/// The diameter of a particle that the file does not give one.
const DEFAULT_RADIUS: f32 = 0.5;
/// The most columns of a chunk with values per particle that becomes properties.
const MOST_COMPONENTS: u32 = 16;

/// A chunk: an array of `rows` x `columns`.
#[derive(Clone, Copy, Debug)]
struct Chunk {
    frame: u64,
    rows: u64,
    columns: u32,
    location: u64,
    name: u16,
    scalar: Scalar,
}

struct File<'a> {
    source: &'a mut dyn Source,
    length: u64,
    chunks: Vec<Chunk>,
    names: HashMap<String, u16>,
    frames: u64,
}

/// The number of frames.
pub(crate) fn frames(source: &mut dyn Source) -> Result<usize, Fault> {
    let file = File::open(source)?;
    Ok(usize::try_from(file.frames).unwrap_or(usize::MAX))
}

/// Reads a frame.
pub(crate) fn read(source: &mut dyn Source, frame: usize, request: &Request) -> Result<Particles, Fault> {
    let mut file = File::open(source)?;
    if frame as u64 >= file.frames {
        return Err(no_such_frame(frame, usize::try_from(file.frames).unwrap_or(usize::MAX)));
    }
    let count = file.count("particles/N", frame as u64)?;
    let mut frame = Frame { number: frame as u64, count, file: &mut file };
    let mut particles = Particles::new(Format::Gsd);
    frame.check_memory(request)?;
    frame.positions(&mut particles)?;
    frame.types(&mut particles)?;
    frame.bonds(&mut particles)?;
    frame.cell(&mut particles)?;
    frame.properties(request, &mut particles)?;
    Ok(particles)
}

impl<'a> File<'a> {
    /// Reads header, names and index.
    fn open(source: &'a mut dyn Source) -> Result<Self, Fault> {
        let length = source.seek(SeekFrom::End(0)).map_err(|error| Fault::unread(&error))?;
        let mut file = Self { source, length, chunks: Vec::new(), names: HashMap::new(), frames: 0 };
        let header = file.bytes(0, HEADER as u64, "the header")?;
        let word = |at: usize| u64::from_le_bytes(header[at..at + 8].try_into().expect("8 bytes"));
        if word(0) != MAGIC {
            return Err(Fault::byte(0, "is no GSD file: the first eight bytes are not 0x65DF65DF65DF65DF"));
        }
        // The minor version is in the lower half.
        let version = u32::from_le_bytes(header[44..48].try_into().expect("4 bytes")) >> 16;
        if !(1..=2).contains(&version) {
            return Err(Fault::byte(44, format!("is GSD of version {version}; versions 1 and 2 are read")));
        }
        let schema = header[112..176].split(|byte| *byte == 0).next().unwrap_or_default();
        if schema != b"hoomd" {
            return Err(Fault::byte(
                112,
                format!("has the schema {}; particles have \"hoomd\"", quote(schema)),
            ));
        }
        let (index, entries, names, name_entries) = (word(8), word(16), word(24), word(32));
        let names = file.bytes(names, name_entries.saturating_mul(NAME as u64), "the list of names")?;
        file.read_names(&names, version);
        file.read_index(index, entries)?;
        Ok(file)
    }

    /// Reads bytes that must all be there.
    fn bytes(&mut self, at: u64, count: u64, what: &str) -> Result<Vec<u8>, Fault> {
        if at.checked_add(count).is_none_or(|end| end > self.length) {
            let problem =
                format!("{what} of {count} bytes is beyond the end of the file, which has {}", self.length);
            return Err(Fault::byte(at, problem));
        }
        self.source.seek(SeekFrom::Start(at)).map_err(|error| Fault::unread(&error))?;
        let mut bytes = vec![0; count as usize];
        fill(&mut self.source, &mut bytes, at)?;
        Ok(bytes)
    }

    /// Names have 64 bytes each, or since version 2 any length.
    fn read_names(&mut self, bytes: &[u8], version: u32) {
        let first = |bytes: &[u8]| bytes.split(|byte| *byte == 0).next().unwrap_or_default().to_vec();
        let names: Vec<Vec<u8>> = match version {
            1 => bytes.chunks_exact(NAME).map(first).take_while(|name| !name.is_empty()).collect(),
            _ => bytes
                .split(|byte| *byte == 0)
                .take_while(|name| !name.is_empty())
                .map(<[u8]>::to_vec)
                .collect(),
        };
        let numbered = names.iter().zip(0_u16..);
        self.names = numbered.map(|(name, id)| (String::from_utf8_lossy(name).into_owned(), id)).collect();
    }

    fn read_index(&mut self, at: u64, entries: u64) -> Result<(), Fault> {
        let bytes = self.bytes(at, entries.saturating_mul(ENTRY as u64), "the index")?;
        for (number, entry) in bytes.chunks_exact(ENTRY).enumerate() {
            let word = |at: usize| u64::from_le_bytes(entry[at..at + 8].try_into().expect("8 bytes"));
            let location = word(16);
            if location == 0 {
                break;
            }
            let wrong = |problem: String| Fault::byte(at + (number * ENTRY) as u64, problem);
            let columns = u32::from_le_bytes(entry[24..28].try_into().expect("4 bytes"));
            let scalar = scalar(entry[30])
                .ok_or_else(|| wrong(format!("a chunk has type {}, which does not exist", entry[30])))?;
            let chunk = Chunk {
                frame: word(0),
                rows: word(8),
                columns,
                location,
                name: u16::from_le_bytes([entry[28], entry[29]]),
                scalar,
            };
            if self.chunks.last().is_some_and(|last| last.frame > chunk.frame) {
                return Err(wrong("the index is not sorted by frame".into()));
            }
            let size = u128::from(chunk.rows) * u128::from(columns) * scalar.size() as u128;
            if u128::from(location) + size > u128::from(self.length) {
                return Err(wrong(format!(
                    "a chunk of {size} bytes at byte {location} is beyond the end of the file"
                )));
            }
            self.chunks.push(chunk);
        }
        // Every frame has a chunk or is one of those before the last that has.
        let frames = self.chunks.last().map_or(0, |last| last.frame.saturating_add(1));
        if frames > self.chunks.len() as u64 * 1000 + 1000 {
            return Err(Fault::byte(
                at,
                format!("the index speaks of {frames} frames, but has {} chunks", self.chunks.len()),
            ));
        }
        self.frames = frames;
        Ok(())
    }

    /// The chunk of this name that a frame has itself.
    fn own(&self, name: &str, frame: u64) -> Option<Chunk> {
        let id = *self.names.get(name)?;
        let begin = self.chunks.partition_point(|chunk| chunk.frame < frame);
        let of_frame = self.chunks[begin..].iter().take_while(|chunk| chunk.frame == frame);
        of_frame.into_iter().find(|chunk| chunk.name == id).copied()
    }

    /// The chunk of this name of a frame, or of the first one.
    fn shared(&self, name: &str, frame: u64) -> Option<Chunk> {
        self.own(name, frame).or_else(|| self.own(name, 0))
    }

    /// The numbers of a chunk.
    fn values(&mut self, chunk: Chunk) -> Result<Vec<f64>, Fault> {
        let count = chunk.rows * u64::from(chunk.columns);
        let bytes = self.bytes(chunk.location, count * chunk.scalar.size() as u64, "a chunk")?;
        Ok(bytes.chunks_exact(chunk.scalar.size()).map(|bytes| chunk.scalar.value(bytes, false)).collect())
    }

    /// A count such as `particles/N`; 0 if there is none.
    fn count(&mut self, name: &str, frame: u64) -> Result<u64, Fault> {
        let Some(chunk) = self.shared(name, frame) else { return Ok(0) };
        let value = self.values(Chunk { rows: chunk.rows.min(1), columns: chunk.columns.min(1), ..chunk })?;
        Ok(value.first().map_or(0, |count| *count as u64))
    }
}

fn scalar(kind: u8) -> Option<Scalar> {
    Some(match kind {
        // 11 are characters, since version 2.
        1 | 11 => Scalar::Unsigned(1),
        2 => Scalar::Unsigned(2),
        3 => Scalar::Unsigned(4),
        4 => Scalar::Unsigned(8),
        5 => Scalar::Signed(1),
        6 => Scalar::Signed(2),
        7 => Scalar::Signed(4),
        8 => Scalar::Signed(8),
        9 => Scalar::Float(4),
        10 => Scalar::Float(8),
        _ => return None,
    })
}

/// A frame that is being read.
struct Frame<'f, 'a> {
    file: &'f mut File<'a>,
    number: u64,
    /// The number of its particles.
    count: u64,
}

impl Frame<'_, '_> {
    /// A chunk with `columns` values for each of `count` things, from this frame or, if that has as many, from the first.
    fn chunk(
        &mut self,
        name: &str,
        counts: &str,
        count: u64,
        columns: Option<u32>,
    ) -> Result<Option<Chunk>, Fault> {
        let own = self.file.own(name, self.number);
        let chunk = match own {
            Some(chunk) => chunk,
            None => match self.file.own(name, 0) {
                Some(first) if self.file.count(counts, 0)? == count => first,
                _ => return Ok(None),
            },
        };
        if chunk.rows != count || columns.is_some_and(|columns| columns != chunk.columns) {
            let problem = format!(
                "{name} is an array of {} x {}, and should be {count} x {}",
                chunk.rows,
                chunk.columns,
                columns.map_or("any".into(), |columns| columns.to_string())
            );
            return Err(Fault::byte(chunk.location, problem));
        }
        Ok(Some(chunk))
    }

    fn of_particles(&mut self, name: &str, columns: u32) -> Result<Option<Chunk>, Fault> {
        self.chunk(&format!("particles/{name}"), "particles/N", self.count, Some(columns))
    }

    fn check_memory(&self, request: &Request) -> Result<(), Fault> {
        // Position, type and radius; and what is made of the chunk while it is read.
        const BYTES: u64 = 24 + 2 + 4 + 1;
        let is_backed =
            self.file.length / 4 >= self.count || self.file.own("particles/position", self.number).is_none();
        if self.count > request.memory / BYTES || self.count > Particles::MOST as u64 {
            return Err(Fault::file(format!(
                "has {} particles, which do not fit into memory; allow more",
                self.count
            )));
        }
        // Particles without positions stand at 0: a number alone makes them.
        if is_backed && self.count.saturating_mul(4) <= self.file.length {
            return Ok(());
        }
        Err(Fault::file(format!("has {} particles, but only {} bytes", self.count, self.file.length)))
    }

    fn positions(&mut self, particles: &mut Particles) -> Result<(), Fault> {
        let count = self.count as usize;
        particles.positions = match self.of_particles("position", 3)? {
            None => vec![[0.0; 3]; count],
            Some(chunk) => {
                let mut positions = Vec::with_capacity(count);
                self.each(chunk, |row, values| {
                    let position = [values[0], values[1], values[2]];
                    if position.iter().all(|number| number.abs() <= Particles::FARTHEST) {
                        positions.push(position);
                        return Ok(());
                    }
                    Err(format!(
                        "particle {row} is at {position:?}; coordinates are finite, at most {:e}",
                        Particles::FARTHEST
                    ))
                })?;
                positions
            }
        };
        particles.radii = Some(match self.of_particles("diameter", 1)? {
            None => vec![DEFAULT_RADIUS; count],
            Some(chunk) => {
                let mut radii = Vec::with_capacity(count);
                self.each(chunk, |row, values| {
                    radii.push(0.5 * values[0] as f32);
                    let is_right = (0.0..=Particles::FARTHEST).contains(&values[0]);
                    if is_right {
                        Ok(())
                    } else {
                        Err(format!("particle {row} has a diameter of {}", values[0]))
                    }
                })?;
                radii
            }
        });
        Ok(())
    }

    /// Calls `take` with the values of each row of a chunk, which is read in blocks.
    fn each(
        &mut self,
        chunk: Chunk,
        mut take: impl FnMut(u64, &[f64]) -> Result<(), String>,
    ) -> Result<(), Fault> {
        const BLOCK: u64 = 1 << 14;
        let row_size = chunk.scalar.size() as u64 * u64::from(chunk.columns);
        let mut done = 0;
        while done < chunk.rows {
            let rows = BLOCK.min(chunk.rows - done);
            let block = Chunk { rows, location: chunk.location + done * row_size, ..chunk };
            let values = self.file.values(block)?;
            for (row, values) in values.chunks_exact(chunk.columns as usize).enumerate() {
                let row = done + row as u64;
                take(row, values).map_err(|problem| Fault::byte(chunk.location + row * row_size, problem))?;
            }
            done += rows;
        }
        Ok(())
    }

    fn types(&mut self, particles: &mut Particles) -> Result<(), Fault> {
        let mut labels = Labels { names: vec!["A".into()], index: Vec::new() };
        if let Some(chunk) = self.file.shared("particles/types", self.number) {
            labels.names = self.type_names(chunk)?;
        }
        labels.index = match self.of_particles("typeid", 1)? {
            None => vec![0; self.count as usize],
            Some(chunk) => {
                let mut index = Vec::with_capacity(self.count as usize);
                let known = labels.names.len() as f64;
                self.each(chunk, |row, values| {
                    index.push(values[0] as u16);
                    let is_known = (0.0..known).contains(&values[0]);
                    if is_known {
                        Ok(())
                    } else {
                        Err(format!("particle {row} has type {} of {known}", values[0]))
                    }
                })?;
                index
            }
        };
        // Types are called A and B as a rule: only where all are symbols are they elements.
        let symbol = |name: &str| crate::elements::by_symbol(name).filter(|_| is_capitalized(name));
        if labels.names.iter().all(|name| symbol(name).is_some()) {
            particles.elements = elements_of(&labels, |name| symbol(name).unwrap_or(0));
        }
        if !labels.index.is_empty() {
            particles.types = Some(labels);
        }
        Ok(())
    }

    /// The names of types, one in each row, padded with NUL.
    fn type_names(&mut self, chunk: Chunk) -> Result<Vec<String>, Fault> {
        if chunk.scalar.size() != 1 || chunk.rows > Labels::MOST as u64 {
            return Err(Fault::byte(chunk.location, "particles/types is no list of names"));
        }
        let bytes =
            self.file.bytes(chunk.location, chunk.rows * u64::from(chunk.columns), "particles/types")?;
        let name = |row: &[u8]| {
            String::from_utf8_lossy(row.split(|byte| *byte == 0).next().unwrap_or_default()).into_owned()
        };
        Ok(bytes.chunks_exact((chunk.columns as usize).max(1)).map(name).collect())
    }

    fn bonds(&mut self, particles: &mut Particles) -> Result<(), Fault> {
        let count = self.file.count("bonds/N", self.number)?;
        let Some(chunk) = self.chunk("bonds/group", "bonds/N", count, Some(2))? else { return Ok(()) };
        let (mut bonds, most) = (Vec::with_capacity(count as usize), self.count as f64);
        self.each(chunk, |row, values| {
            if !values.iter().all(|value| (0.0..most).contains(value)) {
                return Err(format!(
                    "bond {row} joins {} and {}; there are {most} particles",
                    values[0], values[1]
                ));
            }
            let [a, b] = [values[0] as u32, values[1] as u32];
            if a != b {
                bonds.push([a.min(b), a.max(b)]);
            }
            Ok(())
        })?;
        bonds.sort_unstable();
        bonds.dedup();
        particles.bonds = bonds;
        Ok(())
    }

    fn cell(&mut self, particles: &mut Particles) -> Result<(), Fault> {
        let is_flat = match self.file.shared("configuration/dimensions", self.number) {
            Some(chunk) if chunk.rows * u64::from(chunk.columns) == 1 => self.file.values(chunk)?[0] == 2.0,
            _ => false,
        };
        let Some(chunk) = self.file.shared("configuration/box", self.number) else { return Ok(()) };
        if chunk.rows * u64::from(chunk.columns) != 6 {
            return Err(Fault::byte(chunk.location, "configuration/box has not six numbers"));
        }
        let numbers = self.file.values(chunk)?;
        let [x, y, z, xy, xz, yz] = [0, 1, 2, 3, 4, 5].map(|at| numbers[at]);
        // Boxes of two dimensions may have no height.
        let z = if is_flat && z == 0.0 { 1.0 } else { z };
        let vectors = [[x, 0.0, 0.0], [xy * y, y, 0.0], [xz * z, yz * z, z]];
        let origin = [0, 1, 2].map(|axis| -0.5 * (vectors[0][axis] + vectors[1][axis] + vectors[2][axis]));
        let found: Option<Cell> = cell(origin, vectors, [true, true, !is_flat]);
        particles.cell = found;
        Ok(())
    }

    /// What else there is of each particle.
    fn properties(&mut self, request: &Request, particles: &mut Particles) -> Result<(), Fault> {
        const KNOWN: [&str; 6] = ["N", "types", "typeid", "position", "diameter", "type_shapes"];
        let plain = |name: &str| {
            let rest = name.strip_prefix("particles/").or_else(|| name.strip_prefix("log/particles/"))?;
            (!rest.is_empty() && !KNOWN.contains(&rest)).then(|| rest.to_owned())
        };
        let mut names: Vec<(String, String)> =
            self.file.names.keys().filter_map(|name| Some((plain(name)?, name.clone()))).collect();
        names.sort_unstable();
        for (shown, name) in names {
            let chunk = self.file.own(&name, self.number).or_else(|| self.file.own(&name, 0));
            let Some(chunk) = chunk.filter(|chunk| (1..=MOST_COMPONENTS).contains(&chunk.columns)) else {
                continue;
            };
            if chunk.rows != self.count {
                continue;
            }
            let components = components(&shown, chunk.columns as usize);
            particles.available.extend(components.iter().cloned());
            for (column, name) in
                components.into_iter().enumerate().filter(|(_, name)| is_wanted(name, &request.properties))
            {
                let mut values = Vec::with_capacity(self.count as usize);
                self.each(chunk, |_, row| {
                    values.push(row[column] as f32);
                    Ok(())
                })?;
                particles.properties.push(Property { name, values });
            }
        }
        Ok(())
    }
}

fn is_capitalized(name: &str) -> bool {
    name.bytes().enumerate().all(|(at, byte)| byte.is_ascii_uppercase() == (at == 0))
}
