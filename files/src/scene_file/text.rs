//! The text of files and streams, of which no more is read than is allowed.

use super::error::{Fault, FileError};
use crate::atomic_file::reason;
use crate::input;
use std::fs::File;
use std::io::{self, ErrorKind, Read};
use std::path::Path;

/// Larger files are rejected.
pub const MAX_BYTES: u64 = 1 << 32;

/// Opens the file `path`, which messages call a `kind`; also returns its length.
pub(super) fn open(path: &Path, kind: &str) -> Result<(File, u64), FileError> {
    let opened = input::open(path, &format!("a {kind} is a file"));
    opened.map_err(|problem| FileError::unread(&path.to_string_lossy(), &problem))
}

/// The text of the file `path`, which messages call a `kind`.
pub(super) fn load_text(path: &Path, kind: &str) -> Result<String, FileError> {
    let (file, length) = open(path, kind)?;
    read_text(&path.to_string_lossy(), kind, file, length)
}

/// The text of `input`, which messages call `name` and a `kind`. It has `length` bytes, if that is known.
pub(super) fn read_text(name: &str, kind: &str, input: impl Read, length: u64) -> Result<String, FileError> {
    let unread = |message: &str| FileError::unread(name, message);
    let bytes = read_bytes(input, length, MAX_BYTES).map_err(|e| match e.kind() {
        ErrorKind::FileTooLarge => {
            unread(&format!("is too large; a {kind} file has at most {MAX_BYTES} bytes"))
        }
        _ => unread(&format!("cannot be read: {}", reason(&e))),
    })?;
    String::from_utf8(bytes).map_err(|error| {
        let (valid, rest) = error.as_bytes().split_at(error.utf8_error().valid_up_to());
        let message = format!("byte 0x{:02x} is not UTF-8; a {kind} file is UTF-8 text", rest[0]);
        let text = String::from_utf8_lossy(valid);
        FileError::in_text(name, &text, &Fault::new(valid.len(), message))
    })
}

/// At most `most` bytes of `input`. They are counted again while they are read, as the length may not be known, or change.
fn read_bytes(input: impl Read, length: u64, most: u64) -> io::Result<Vec<u8>> {
    /// Bytes that are read at a time, after the system has granted room for them.
    const STEP: usize = 1 << 20;
    let mut bytes = Vec::new();
    let mut input = input.take(most + 1);
    let grant = |bytes: &mut Vec<u8>, more: usize| {
        bytes.try_reserve(more).map_err(|_| io::Error::from(ErrorKind::OutOfMemory))
    };
    if length > most {
        return Err(ErrorKind::FileTooLarge.into());
    }
    grant(&mut bytes, length as usize + STEP)?;
    while input.by_ref().take(STEP as u64 / 2).read_to_end(&mut bytes)? > 0 {
        grant(&mut bytes, STEP)?;
    }
    if bytes.len() as u64 > most { Err(ErrorKind::FileTooLarge.into()) } else { Ok(bytes) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn room_is_made_for_a_file_and_for_little_more() {
        /// What may be granted at once without a file to fill it.
        const LITTLE: usize = 3 << 20;
        for (length, told) in [(0, 0), (1000, 1000), (5 << 20, 5 << 20), (5 << 20, 0)] {
            let bytes = read_bytes(&vec![b'#'; length][..], told, MAX_BYTES).unwrap();
            assert_eq!(bytes.len(), length);
            assert!(bytes.capacity() <= 2 * length + LITTLE, "{length}: {}", bytes.capacity());
        }
    }

    /// Also where the length is not known, or is less than there is.
    #[test]
    fn as_many_bytes_as_are_allowed_are_read_and_no_more() {
        const MOST: u64 = 1000;
        let kind = |length: usize, told: u64| {
            read_bytes(&vec![b'#'; length][..], told, MOST).map(|bytes| bytes.len()).map_err(|e| e.kind())
        };
        assert_eq!(kind(1000, 1000), Ok(1000));
        assert_eq!(kind(1000, 0), Ok(1000));
        for (length, told) in [(0, 1001), (1001, 1001), (1001, 0), (1001, 1000), (5000, 0)] {
            assert_eq!(kind(length, told), Err(ErrorKind::FileTooLarge), "{length}, {told}");
        }
        // No more is taken of a stream than shows that it is too long.
        let mut stream = &[b'#'; 5000][..];
        read_bytes(&mut stream, 0, MOST).unwrap_err();
        assert_eq!(stream.len() as u64, 5000 - MOST - 1);
    }
}
