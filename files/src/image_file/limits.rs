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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_within_their_bounds() {
        let side = u64::from(MAX_SIDE);
        assert!(check_size(1, 1).is_ok() && check_size(side, MAX_PIXELS / side).is_ok());
        assert_eq!(check_size(0, 5).unwrap_err(), "has no pixels: it is 0 x 5");
        assert_eq!(check_size(5, 0).unwrap_err(), "has no pixels: it is 5 x 0");
        for (width, height) in [
            (side + 1, 1),
            (1, side + 1),
            (side, MAX_PIXELS / side + 1),
            (u64::from(u32::MAX), u64::from(u32::MAX)),
        ] {
            assert!(
                check_size(width, height)
                    .unwrap_err()
                    .starts_with(&format!("is {width} x {height} pixels; "))
            );
        }
    }

    /// As the documentation of images says.
    #[test]
    fn bounds_are_as_documented() {
        assert_eq!(
            check_size(1, 1 << 21).unwrap_err(),
            "is 1 x 2097152 pixels; at most 268435456 are supported, and 1048576 in a side"
        );
        // 2^22 pixels are read from any file, and else 512 for each byte.
        assert!(check_likely(1 << 22, 0).is_ok() && check_likely((1 << 22) + 1, 0).is_err());
        assert!(check_likely(1 << 23, 1 << 14).is_ok());
        assert_eq!(
            check_likely(1 << 23, (1 << 14) - 1).unwrap_err(),
            "has 16383 bytes, which hardly hold the 8388608 pixels that it announces"
        );
    }

    #[test]
    fn bytes_expand_by_no_more_than_the_format_can() {
        assert!(check_expansion(1000, 10, 100).is_ok() && check_expansion(1099, 10, 100).is_ok());
        let told = "has 10 bytes, which cannot hold the 1100 bytes of pixels that it announces";
        assert_eq!(check_expansion(1100, 10, 100).unwrap_err(), told);
        assert!(check_likely(ANY_RATIO, 0).is_ok());
        let (pixels, length) = (ANY_RATIO * 2, ANY_RATIO * 2 / LIKELY_RATIO);
        assert!(check_likely(pixels, length).is_ok() && check_likely(pixels, length - 1).is_err());
        assert!(check_likely(ANY_RATIO + 1, 0).is_err());
    }

    #[test]
    fn messages_of_decoders_are_one_line_of_bounded_length() {
        assert_eq!(told("PNG", &"a\n  b\u{7}c"), "is no PNG file that can be read: a bc");
        let long = told("PNG", &"x".repeat(1000));
        assert_eq!(long.len(), "is no PNG file that can be read: ".len() + 160);
        assert_eq!(truncated(&io::ErrorKind::UnexpectedEof.into()), "ends too early");
        assert!(truncated(&io::ErrorKind::PermissionDenied.into()).starts_with("cannot be read: "));
    }
}
