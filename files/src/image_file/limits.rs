//! What decoders read from, and the limits that keep broken files from costing memory.

use crate::atomic_file::reason;
use scene::settings::{MAX_PIXELS, MAX_SIDE};
use std::io::{self, BufRead, Seek};

/// The input of a decoder.
pub(super) trait Seekable: BufRead + Seek + Send {}

impl<T: BufRead + Seek + Send> Seekable for T {}

pub(super) fn check_size(width: u64, height: u64) -> Result<(), String> {
    if width == 0 || height == 0 {
        return Err(format!("has no pixels: it is {width} x {height}"));
    }
    if width.max(height) > u64::from(MAX_SIDE) || width * height > MAX_PIXELS {
        return Err(format!(
            "is {width} x {height} pixels; at most {MAX_PIXELS} are supported, and {MAX_SIDE} in a side"
        ));
    }
    Ok(())
}

/// Rejects a file of `length` bytes that claims to decompress to `bytes` bytes, if that exceeds the format's best
/// compression ratio. A corrupt size in a header thus never leads to a large allocation.
pub(super) fn check_expansion(bytes: u64, length: u64, most_bytes_per_byte: u64) -> Result<(), String> {
    if bytes / most_bytes_per_byte > length {
        return Err(format!(
            "has {length} bytes, which cannot hold the {bytes} bytes of pixels that it announces"
        ));
    }
    Ok(())
}

/// Images up to this many pixels may be compressed to anything: some formats need no bits at all for equal pixels.
const ANY_RATIO: u64 = 1 << 22;
/// Pixels per byte of larger images. What people have is far below.
const LIKELY_RATIO: u64 = 512;

/// As [`check_expansion`], for formats without a bound on their compression.
pub(super) fn check_likely(pixels: u64, length: u64) -> Result<(), String> {
    if pixels > ANY_RATIO && pixels / LIKELY_RATIO > length {
        return Err(format!("has {length} bytes, which hardly hold the {pixels} pixels that it announces"));
    }
    Ok(())
}

pub(super) fn truncated(e: &io::Error) -> String {
    match e.kind() {
        io::ErrorKind::UnexpectedEof => "ends too early".into(),
        _ => format!("cannot be read: {}", reason(e)),
    }
}

/// A decoder's message as one line of bounded length.
pub(super) fn told(format: &str, e: &impl ToString) -> String {
    const LONGEST: usize = 160;
    let text = e.to_string();
    let line: String = text.split_whitespace().collect::<Vec<_>>().join(" ");
    let line: String = line.chars().filter(|c| !c.is_control()).take(LONGEST).collect();
    format!("is no {format} file that can be read: {line}")
}
