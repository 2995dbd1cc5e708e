//! Archives of `NumPy` arrays: positions, and what else there is of each particle, by the names of the arrays.

use crate::cell::cell;
use crate::columns::{role, role_of_vector};
use crate::error::{Fault, Place, quote};
use crate::format::Format;
use crate::layout::{Layout, MOST_COLUMNS, Role, components};
use crate::npy::{Array, Input};
use crate::particles::Particles;
use crate::request::Request;
use crate::table::Table;
use crate::text::Source;
use flate2::read::DeflateDecoder;
use rawzip::{CompressionMethod, RECOMMENDED_BUFFER_SIZE, ReaderAt, ZipArchive, ZipArchiveEntryWayfinder};
use std::io::Read;

/// The most arrays of an archive, and the longest name.
const MOST_ARRAYS: usize = MOST_COLUMNS;
const LONGEST_NAME: usize = 200;

/// An array in the archive.
struct Entry {
    /// Its name without `.npy`, and in lower case.
    shown: String,
    name: String,
    wayfinder: ZipArchiveEntryWayfinder,
    method: CompressionMethod,
}

/// Reads an archive.
pub(crate) fn read(source: &mut dyn Source, request: &Request) -> Result<Particles, Fault> {
    let mut buffer = vec![0; RECOMMENDED_BUFFER_SIZE];
    let archive = ZipArchive::from_seekable(source, &mut buffer).map_err(|error| damaged(&error))?;
    let entries = entries(&archive, &mut buffer)?;
    let names: Vec<String> = entries.iter().map(|entry| entry.name.clone()).collect();
    let mut reader = Reader {
        request,
        names,
        layout: Layout::default(),
        table: Table::default(),
        full: None,
        cell: CellParts::default(),
    };
    for entry in &entries {
        reader.entry(&archive, entry).map_err(|fault| Fault {
            place: Place::File,
            problem: format!(
                "array {}: {}{}",
                quote(entry.shown.as_bytes()),
                in_array(fault.place),
                fault.problem
            ),
        })?;
    }
    reader.finish()
}

fn damaged(error: &rawzip::Error) -> Fault {
    Fault::file(format!("is no archive that can be read: {error}; write one by numpy.savez"))
}

/// A place within an array.
fn in_array(place: Place) -> String {
    match place {
        Place::Byte(byte) => format!("byte {byte}: "),
        _ => String::new(),
    }
}

fn entries<R: ReaderAt>(archive: &ZipArchive<R>, buffer: &mut [u8]) -> Result<Vec<Entry>, Fault> {
    let mut found = Vec::new();
    let mut entries = archive.entries(buffer);
    while let Some(entry) = entries.next_entry().map_err(|error| damaged(&error))? {
        let path = entry.file_path();
        let path: &[u8] = path.as_ref();
        let Some(shown) = path.strip_suffix(b".npy").filter(|name| name.len() <= LONGEST_NAME) else {
            continue;
        };
        let shown = String::from_utf8_lossy(shown).into_owned();
        let name = shown.to_ascii_lowercase();
        found.push(Entry { name, shown, wayfinder: entry.wayfinder(), method: entry.compression_method() });
        if found.len() > MOST_ARRAYS {
            return Err(Fault::file(format!("has more than {MOST_ARRAYS} arrays")));
        }
    }
    Ok(found)
}

/// What the archive says of the cell.
#[derive(Default)]
struct CellParts {
    vectors: Option<[[f64; 3]; 3]>,
    origin: [f64; 3],
    periodic: Option<[bool; 3]>,
}

struct Reader<'a> {
    request: &'a Request,
    /// The names of all arrays.
    names: Vec<String>,
    layout: Layout,
    table: Table,
    full: Option<f32>,
    cell: CellParts,
}

impl Reader<'_> {
    fn entry<R: ReaderAt>(&mut self, archive: &ZipArchive<R>, entry: &Entry) -> Result<(), Fault> {
        let zipped = archive.get_entry(entry.wayfinder).map_err(|error| damaged(&error))?;
        let compressed = zipped.reader();
        let is_stored = entry.method == CompressionMethod::STORE;
        let mut stream: Box<dyn Read> = if is_stored {
            Box::new(zipped.verifying_reader(compressed))
        } else if entry.method == CompressionMethod::DEFLATE {
            Box::new(zipped.verifying_reader(DeflateDecoder::new(compressed)))
        } else {
            return Err(Fault::file("is compressed by a method that NumPy does not use"));
        };
        let array = Array::header(&mut stream)?;
        // Of compressed data the archive's word on the length is not trusted.
        let (begin, end) = zipped.compressed_data_range();
        let left = is_stored.then(|| end.saturating_sub(begin).saturating_sub(array.header));
        if self.is_cell(entry, &array, &mut stream)? {
            return Ok(());
        }
        let already = self.layout.roles.len();
        if !self.columns(entry, &array, Input { stream: &mut stream, left })? {
            return Ok(());
        }
        if self.layout.roles.len() > MOST_COLUMNS || already > MOST_COLUMNS {
            return Err(Fault::file(format!("there are more than {MOST_COLUMNS} columns")));
        }
        // The checksum is compared at the end.
        let mut rest = [0; 1];
        let rest = stream.read(&mut rest).map_err(|error| Fault::unread(&error))?;
        if rest > 0 { Err(Fault::file("has more bytes than its shape says")) } else { Ok(()) }
    }

    /// Reads an array of particles' columns. Says whether it was one.
    fn columns(&mut self, entry: &Entry, array: &Array, input: Input) -> Result<bool, Fault> {
        let is_only = self.names.len() == 1;
        let count = match array.shape[..] {
            [_] => 1,
            [_, columns @ 1..=16] => columns as usize,
            _ if is_only => 0,
            _ => return Ok(false),
        };
        let is_new = |role: &Role| !self.layout.has(*role);
        let vector = role_of_vector(&entry.name, count.min(3))
            .or_else(|| role_of_vector(&entry.name, count))
            .filter(is_new);
        let columns = match vector {
            Some(Role::Axis(_)) => array.particles(&mut self.layout, &self.request.properties)?,
            _ if is_only => array.particles(&mut self.layout, &self.request.properties)?,
            Some(_) => {
                let roles: Vec<Role> = (0..count)
                    .map(|channel| if channel < 3 { Role::Color(channel) } else { Role::Skip })
                    .collect();
                array.columns(&roles, &mut self.layout)?
            }
            None => {
                let roles = self.roles(entry, count);
                if roles.iter().all(|role| *role == Role::Skip) {
                    return Ok(false);
                }
                array.columns(&roles, &mut self.layout)?
            }
        };
        self.table.properties.resize_with(self.layout.properties().len(), Vec::new);
        self.full = self.full.or(columns.full);
        array.read(&columns, input, &self.layout, self.request, &mut self.table)?;
        Ok(true)
    }

    /// The roles of an array with one number per particle or several.
    fn roles(&mut self, entry: &Entry, count: usize) -> Vec<Role> {
        let role = role(&entry.name, &self.names).filter(|role| count == 1 && !self.layout.has(*role));
        if let Some(role) = role {
            return vec![role];
        }
        let names = components(&entry.shown, count);
        names.iter().map(|name| self.layout.property(name, &self.request.properties)).collect()
    }

    /// Reads an array that describes the cell. Says whether it was one.
    fn is_cell(&mut self, entry: &Entry, array: &Array, stream: &mut dyn Read) -> Result<bool, Fault> {
        let numbers = match (entry.name.as_str(), &array.shape[..]) {
            ("cell" | "box" | "lattice", [3] | [3, 3]) | ("origin" | "cell_origin" | "pbc", [3]) => {
                array.numbers(stream)?
            }
            _ => return Ok(false),
        };
        match (entry.name.as_str(), &numbers[..]) {
            ("pbc", &[x, y, z]) => self.cell.periodic = Some([x, y, z].map(|side| side != 0.0)),
            ("origin" | "cell_origin", &[x, y, z]) => self.cell.origin = [x, y, z],
            (_, &[x, y, z]) => self.cell.vectors = Some([[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, z]]),
            (_, &[a, b, c, d, e, f, g, h, i]) => self.cell.vectors = Some([[a, b, c], [d, e, f], [g, h, i]]),
            _ => {}
        }
        Ok(true)
    }

    fn finish(self) -> Result<Particles, Fault> {
        if !self.layout.has(Role::Axis(0)) {
            let shown: Vec<&str> = self.names.iter().take(12).map(String::as_str).collect();
            let shown = if shown.is_empty() { "none".into() } else { shown.join(", ") };
            let problem = format!("has no array called positions, xyz or centers; it has {shown}");
            return Err(Fault::file(problem));
        }
        if let Some(length) = self.table.other_length() {
            let problem =
                format!("has {} positions, but another column has {length} values", self.table.len());
            return Err(Fault::file(problem));
        }
        let mut particles = Particles::new(Format::Npz);
        let CellParts { vectors, origin, periodic } = self.cell;
        particles.cell = vectors.and_then(|vectors| cell(origin, vectors, periodic.unwrap_or([true; 3])));
        self.table.finish(self.layout, self.full, &mut particles);
        Ok(particles)
    }
}
