//! Tells the format of a file.

use crate::error::Fault;
use crate::format::Format;
use crate::text::{self, Fields, Source, Stream, integer, number};
use crate::{delimited, gsd};
use scene::text::list;
use std::io::Read as _;
use std::path::Path;

/// The bytes that are looked at to tell a format.
const HEAD: usize = 4096;

/// The format of a file by its content and, where that does not tell, by its name.
pub(crate) fn format_of(path: &Path, source: &mut dyn Source) -> Result<Format, Fault> {
    let mut head = Vec::new();
    let read = Stream::new(source).and_then(|stream| stream.take(HEAD as u64).read_to_end(&mut head));
    read.map_err(|error| Fault::unread(&error))?;
    let by_name = Format::of_name(path);
    by_signature(&head).or(by_name).or_else(|| by_shape(&head)).ok_or_else(|| {
        if let Some(compressor) = compressor(&head) {
            return Fault::file(format!("is compressed by {compressor}; decompress it first, or use gzip"));
        }
        let names = Format::ALL.map(Format::name);
        Fault::file(format!("is in no known format of particles; these are {}", list(&names)))
    })
}

/// By bytes that no other format begins with.
fn by_signature(head: &[u8]) -> Option<Format> {
    let signatures: [(&[u8], Format); 6] = [
        (&gsd::MAGIC.to_le_bytes(), Format::Gsd),
        (b"\x93NUMPY", Format::Npy),
        (b"PK\x03\x04", Format::Npz),
        (b"ply\n", Format::Ply),
        (b"ply\r\n", Format::Ply),
        (b"ITEM: ", Format::Dump),
    ];
    signatures.into_iter().find(|(bytes, _)| head.starts_with(bytes)).map(|(_, format)| format)
}

/// By what the first lines look like.
fn by_shape(head: &[u8]) -> Option<Format> {
    const RECORDS: [&[u8]; 9] =
        [b"HEADER", b"ATOM  ", b"HETATM", b"CRYST1", b"MODEL ", b"REMARK", b"TITLE ", b"COMPND", b"OBSLTE"];
    let mut lines = text::lines(head).take(3);
    let [first, second, third] = std::array::from_fn(|_| lines.next().unwrap_or_default());
    let is_count = |line: &[u8]| integer(line.trim_ascii()).is_some_and(|count| count >= 0);
    let is_number = |field: Option<(usize, &[u8])>| field.is_some_and(|(_, field)| number(field).is_some());
    if RECORDS.iter().any(|record| first.starts_with(record)) {
        Some(Format::Pdb)
    } else if first.starts_with(b"data_") {
        Some(Format::Mmcif)
    } else if is_count(first) && is_number(Fields::new(third).nth(1)) {
        Some(Format::Xyz)
    } else if is_count(second) && third.len() > 20 && is_number(Fields::new(&third[20..]).next()) {
        Some(Format::Gro)
    } else {
        delimited::looks_like_header(first).then_some(Format::Csv)
    }
}

/// The program that compressed a file, if it is one that is not read.
fn compressor(head: &[u8]) -> Option<&'static str> {
    let all: [(&[u8], &str); 4] = [
        (b"\x28\xb5\x2f\xfd", "zstd"),
        (b"\xfd7zXZ\0", "xz"),
        (b"BZh", "bzip2"),
        (b"\x04\x22\x4d\x18", "lz4"),
    ];
    all.into_iter().find(|(magic, _)| head.starts_with(magic)).map(|(_, name)| name)
}
