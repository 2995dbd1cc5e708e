//! The header and the sections of a checkpoint file, each with its checksum.

use super::account::FORMAT;
use super::damage::Damage;
use crc32fast::Hasher;
use std::io::{self, Read, Write};

pub(super) const MAGIC: [u8; 8] = *b"\x89SPPM\r\n\x1a";
/// Bytes of the header.
pub(super) const HEADER: u64 = 24;
/// Bytes of a section besides its content: name, length and checksum.
pub(super) const FRAME: u64 = 16;

/// The name of a section: in the file, and in messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Name(pub(super) [u8; 4], pub(super) &'static str);

pub(super) const SCENE: Name = Name(*b"SCEN", "its scene");
pub(super) const MATERIALS: Name = Name(*b"MATL", "its materials");
pub(super) const SPHERES: Name = Name(*b"BALL", "its spheres");
pub(super) const GLOW: Name = Name(*b"GLOW", "its lamps");
pub(super) const MOTION: Name = Name(*b"MOVE", "its velocities");
pub(super) const ACCOUNT: Name = Name(*b"RNDR", "its account");
pub(super) const NOTE: Name = Name(*b"NOTE", "its note");
pub(super) const SUMS: Name = Name(*b"SUMS", "its sums");
pub(super) const PAST: Name = Name(*b"PAST", "its earlier image");

pub(super) fn write_header(out: &mut impl Write, length: u64) -> io::Result<()> {
    let mut header = MAGIC.to_vec();
    header.extend(FORMAT.to_le_bytes());
    header.extend(length.to_le_bytes());
    header.extend(crc32fast::hash(&header).to_le_bytes());
    out.write_all(&header)
}

/// Checks the header of a file of `length` bytes, and returns the format version.
pub(super) fn read_header(input: &mut impl Read, length: u64) -> Result<u32, Damage> {
    let mut header = [0; HEADER as usize];
    let has = length.min(HEADER) as usize;
    input.read_exact(&mut header[..has])?;
    let begun = has.min(MAGIC.len());
    if header[..begun] != MAGIC[..begun] || begun == 0 {
        return Err(Damage::NoCheckpoint);
    }
    if length < HEADER {
        return Err(Damage::Truncated { has: length, length: HEADER });
    }
    let word = |at: usize| u32::from_le_bytes(std::array::from_fn(|i| header[at + i]));
    if word(20) != crc32fast::hash(&header[..20]) {
        return Err(Damage::Flipped { section: "its header" });
    }
    let stated = u64::from(word(12)) | u64::from(word(16)) << 32;
    match word(8) {
        1..=FORMAT if length < stated => Err(Damage::Truncated { has: length, length: stated }),
        1..=FORMAT if length > stated => Err(Damage::Appended { has: length, length: stated }),
        version @ 1..=FORMAT => Ok(version),
        found => Err(Damage::Version { found }),
    }
}

/// Writes a section; `fill` writes its content of `length` bytes.
pub(super) fn write_section<W: Write>(
    out: &mut W,
    name: Name,
    length: u64,
    fill: impl FnOnce(&mut Summed<&mut W>) -> io::Result<()>,
) -> io::Result<()> {
    let mut summed = Summed::new(out);
    summed.write_all(&name.0)?;
    summed.write_all(&length.to_le_bytes())?;
    fill(&mut summed)?;
    let Summed { inner, hasher } = summed;
    inner.write_all(&hasher.finalize().to_le_bytes())
}

/// A reader or writer that computes the checksum of what passes through.
pub(super) struct Summed<T> {
    inner: T,
    hasher: Hasher,
}

impl<T> Summed<T> {
    fn new(inner: T) -> Self {
        Self { inner, hasher: Hasher::new() }
    }
}

impl<T: Write> Write for Summed<T> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let count = self.inner.write(bytes)?;
        self.hasher.update(&bytes[..count]);
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}

impl<T: Read> Read for Summed<T> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let count = self.inner.read(bytes)?;
        self.hasher.update(&bytes[..count]);
        Ok(count)
    }
}

/// A section that is being read.
pub(super) struct Section<R> {
    name: Name,
    /// Bytes of the content.
    pub(super) length: u64,
    content: io::Take<Summed<R>>,
}

impl<R: Read> Section<R> {
    /// Begins to read the next section, which must be `name`. `left` is how many bytes of the file are left.
    pub(super) fn begin(input: R, name: Name, left: u64) -> Result<Self, Damage> {
        let flipped = Err(Damage::Flipped { section: name.1 });
        if left < FRAME {
            return flipped;
        }
        let mut summed = Summed::new(input);
        let mut frame = [0; 12];
        summed.read_exact(&mut frame)?;
        let [tag @ .., _, _, _, _, _, _, _, _] = frame;
        let length = u64::from_le_bytes(std::array::from_fn(|i| frame[4 + i]));
        // With a wrong name or length, the position of the checksum is unknown.
        if tag != name.0 || length > left - FRAME {
            return flipped;
        }
        Ok(Self { name, length, content: summed.take(length) })
    }

    /// Reads the whole content of at most `most` bytes, and verifies its checksum.
    pub(super) fn read_all(mut self, most: u64) -> Result<Vec<u8>, Damage> {
        if self.length > most {
            return Err(self.invalid(format!("has {} bytes; at most {most} are read", self.length)));
        }
        let mut content = vec![0; self.length as usize];
        self.content.read_exact(&mut content)?;
        self.end()?;
        Ok(content)
    }

    /// Reads the next bytes of the content.
    pub(super) fn read_exact(&mut self, bytes: &mut [u8]) -> Result<(), Damage> {
        Ok(self.content.read_exact(bytes)?)
    }

    /// Verifies the checksum, once all of the content has been read.
    pub(super) fn end(self) -> Result<(), Damage> {
        let section = self.name.1;
        let Summed { mut inner, hasher } = self.content.into_inner();
        let mut checksum = [0; 4];
        inner.read_exact(&mut checksum)?;
        if u32::from_le_bytes(checksum) == hasher.finalize() {
            Ok(())
        } else {
            Err(Damage::Flipped { section })
        }
    }

    /// The error for a section of the wrong length: a checksum mismatch, or `problem` if the checksum matches.
    pub(super) fn refuse(mut self, problem: String) -> Damage {
        let invalid = self.invalid(problem);
        let skipped = io::copy(&mut self.content, &mut io::sink()).map_err(Damage::from);
        skipped.and_then(|_| self.end()).err().unwrap_or(invalid)
    }

    fn invalid(&self, problem: impl Into<String>) -> Damage {
        Damage::Invalid { section: self.name.1, problem: problem.into() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn section(content: &[u8]) -> Vec<u8> {
        let mut bytes = Vec::new();
        write_section(&mut bytes, NOTE, content.len() as u64, |out| out.write_all(content)).unwrap();
        assert_eq!(bytes.len() as u64, FRAME + content.len() as u64);
        bytes
    }

    fn begin(bytes: &[u8], name: Name, left: u64) -> Result<Section<&[u8]>, Damage> {
        Section::begin(bytes, name, left)
    }

    #[test]
    fn a_section_is_read_up_to_its_bound() {
        let bytes = section(b"12345");
        let read = |most| begin(&bytes, NOTE, bytes.len() as u64).unwrap().read_all(most);
        assert_eq!((read(5).unwrap(), read(6).unwrap()), (b"12345".to_vec(), b"12345".to_vec()));
        assert!(read(4).unwrap_err().to_string().contains("has 5 bytes; at most 4 are read"));
        assert!(begin(&section(b""), NOTE, FRAME).unwrap().read_all(0).unwrap().is_empty());
    }

    /// Every flipped bit is found, whether of name, length, content or checksum.
    #[test]
    fn a_section_that_has_changed_is_refused() {
        let bytes = section(b"12345");
        let read = |bytes: &[u8]| {
            begin(bytes, NOTE, bytes.len() as u64).and_then(|section| section.read_all(1 << 20))
        };
        assert!(read(&bytes).is_ok());
        for bit in 0..8 * bytes.len() {
            let mut broken = bytes.clone();
            broken[bit / 8] ^= 1 << (bit % 8);
            assert!(read(&broken).is_err(), "{bit}");
        }
        let left = bytes.len() as u64;
        assert!(begin(&bytes, SUMS, left).is_err() && begin(&bytes, NOTE, left - 1).is_err());
        assert!(begin(&bytes, NOTE, FRAME - 1).is_err() && begin(&bytes, NOTE, left + 1).is_ok());
        assert!(read(&bytes[..bytes.len() - 1]).is_err());
    }

    /// Of a wrong length the fault is told, unless the section has changed.
    #[test]
    fn refusals_tell_the_fault_of_what_is_whole() {
        let mut bytes = section(b"12345");
        let refuse = |bytes: &[u8]| begin(bytes, NOTE, bytes.len() as u64).unwrap().refuse("is odd".into());
        assert!(matches!(refuse(&bytes), Damage::Invalid { section: "its note", .. }));
        bytes[13] ^= 1;
        assert!(matches!(refuse(&bytes), Damage::Flipped { section: "its note" }));
    }

    #[test]
    fn headers_tell_whether_a_file_is_whole() {
        let mut header = Vec::new();
        write_header(&mut header, 100).unwrap();
        let read = |bytes: &[u8], length| read_header(&mut &bytes[..], length);
        assert_eq!(read(&header, 100).unwrap(), FORMAT);
        assert!(matches!(read(&header, 99), Err(Damage::Truncated { has: 99, length: 100 })));
        assert!(matches!(read(&header, 101), Err(Damage::Appended { has: 101, length: 100 })));
        assert!(matches!(read(&header[..9], 9), Err(Damage::Truncated { has: 9, length: HEADER })));
        assert!(matches!(read(&header[..23], 23), Err(Damage::Truncated { has: 23, length: HEADER })));
        assert!(matches!(read(&header, 24), Err(Damage::Truncated { has: 24, length: 100 })));
        assert!(matches!(read(b"", 0), Err(Damage::NoCheckpoint)));
        assert!(matches!(read(&header[..1], 1), Err(Damage::Truncated { has: 1, .. })));
        assert!(matches!(read(&[0; 24], 24), Err(Damage::NoCheckpoint)));
        for byte in 8..24 {
            let mut broken = header.clone();
            broken[byte] ^= 1;
            assert!(matches!(read(&broken, 100), Err(Damage::Flipped { section: "its header" })), "{byte}");
        }
        let mut later = header[..8].to_vec();
        later.extend((FORMAT + 1).to_le_bytes());
        later.extend(100_u64.to_le_bytes());
        later.extend(crc32fast::hash(&later).to_le_bytes());
        assert!(matches!(read(&later, 100), Err(Damage::Version { found }) if found == FORMAT + 1));
    }
}
