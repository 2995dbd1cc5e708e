//! Text files, plain or compressed by gzip, in blocks of whole lines.
//!
//! A file is read in pieces of a few mebibytes and never as a whole, so that memory does not depend on its length. (A
//! memory map would need unsafe code, and ends the process if another one shortens the file.)

use crate::error::{Fault, quote};
use flate2::read::MultiGzDecoder;
use std::io::{self, ErrorKind, Read, Seek, SeekFrom};

/// What readers read from: a file, or bytes in memory.
pub(crate) trait Source: Read + Seek {}

impl<T: Read + Seek> Source for T {}

/// Bytes in memory at once. Also the most bytes of a line.
const BLOCK: usize = 1 << 22;
/// The buffer before it grows.
const LEAST: usize = 1 << 16;

/// The first bytes of a gzip file.
pub(crate) const GZIP: [u8; 2] = [0x1f, 0x8b];

/// The decompressed bytes of a source.
pub(crate) enum Stream<'a> {
    Plain(&'a mut dyn Source),
    Gzip(Box<MultiGzDecoder<&'a mut dyn Source>>),
}

impl<'a> Stream<'a> {
    /// Starts at the beginning of `source`.
    pub(crate) fn new(source: &'a mut dyn Source) -> io::Result<Self> {
        source.rewind()?;
        let mut magic = [0; GZIP.len()];
        let is_gzip = source.read_exact(&mut magic).is_ok() && magic == GZIP;
        source.rewind()?;
        Ok(if is_gzip { Self::Gzip(Box::new(MultiGzDecoder::new(source))) } else { Self::Plain(source) })
    }

    /// Goes on to byte `offset` from the beginning.
    pub(crate) fn skip_to(&mut self, offset: u64) -> io::Result<()> {
        match self {
            Self::Plain(source) => source.seek(SeekFrom::Start(offset)).map(drop),
            Self::Gzip(decoder) => io::copy(&mut decoder.take(offset), &mut io::sink()).map(drop),
        }
    }

    /// Leaves out the next `bytes`.
    pub(crate) fn skip(&mut self, bytes: u64) -> io::Result<()> {
        match self {
            Self::Plain(source) => {
                let at = source.stream_position()?;
                source.seek(SeekFrom::Start(at.saturating_add(bytes))).map(drop)
            }
            Self::Gzip(decoder) => io::copy(&mut decoder.take(bytes), &mut io::sink()).map(drop),
        }
    }

    /// The length, if it is known before all is read.
    pub(crate) fn length(&mut self) -> io::Result<Option<u64>> {
        let Self::Plain(source) = self else { return Ok(None) };
        let at = source.stream_position()?;
        let length = source.seek(SeekFrom::End(0))?;
        source.seek(SeekFrom::Start(at))?;
        Ok(Some(length))
    }
}

impl Read for Stream<'_> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        match self {
            Self::Plain(source) => source.read(bytes),
            Self::Gzip(decoder) => decoder.read(bytes).map_err(|error| match error.kind() {
                ErrorKind::UnexpectedEof | ErrorKind::InvalidInput | ErrorKind::InvalidData => {
                    io::Error::new(
                        ErrorKind::InvalidData,
                        format!("the gzip data is damaged or cut off ({error}); try `gzip -t`"),
                    )
                }
                _ => error,
            }),
        }
    }
}

/// Where a line begins in the decompressed text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Position {
    pub(crate) offset: u64,
    /// The number of the line, from 1.
    pub(crate) line: u64,
}

impl Position {
    pub(crate) const START: Self = Self { offset: 0, line: 1 };
}

/// The lines of a text.
pub(crate) struct Text<'a> {
    stream: Stream<'a>,
    length: Option<u64>,
    buffer: Vec<u8>,
    /// What of the buffer is read from the stream and not yet consumed.
    start: usize,
    end: usize,
    /// Where `start` is.
    at: Position,
    is_finished: bool,
}

/// Some whole lines, with their line ends.
pub(crate) struct Block<'t> {
    pub(crate) bytes: &'t [u8],
    /// How many there are.
    pub(crate) lines: u64,
    /// The number of the first, from 1.
    pub(crate) first: u64,
}

impl<'a> Text<'a> {
    /// The text of `source` from `position` on, which an earlier call of [`Text::position`] gave.
    pub(crate) fn new(source: &'a mut dyn Source, position: Position) -> Result<Self, Fault> {
        let unread = |error: io::Error| Fault::unread(&error);
        let mut stream = Stream::new(source).map_err(unread)?;
        let length = stream.length().map_err(unread)?;
        stream.skip_to(position.offset).map_err(unread)?;
        let mut text =
            Self { stream, length, buffer: Vec::new(), start: 0, end: 0, at: position, is_finished: false };
        if position == Position::START {
            text.skip_mark()?;
        }
        Ok(text)
    }

    /// Skips a byte order mark, and refuses UTF-16.
    fn skip_mark(&mut self) -> Result<(), Fault> {
        while self.end < 3 && self.fill()? {}
        if self.buffer[..self.end].starts_with(b"\xef\xbb\xbf") {
            self.start = 3;
            self.at.offset = 3;
        }
        if self.buffer[..self.end].starts_with(b"\xff\xfe")
            || self.buffer[..self.end].starts_with(b"\xfe\xff")
        {
            return Err(Fault::file("is text in UTF-16; save it in UTF-8"));
        }
        Ok(())
    }

    /// Where the next line begins.
    pub(crate) fn position(&self) -> Position {
        self.at
    }

    /// The number of the next line, from 1.
    pub(crate) fn line(&self) -> u64 {
        self.at.line
    }

    /// The bytes from the next line on, if that is known.
    pub(crate) fn bytes_left(&self) -> Option<u64> {
        self.length.map(|length| length.saturating_sub(self.at.offset))
    }

    /// Moves what is not consumed to the beginning of the buffer.
    fn compact(&mut self) {
        self.buffer.copy_within(self.start..self.end, 0);
        self.end -= self.start;
        self.start = 0;
    }

    /// Makes room in the buffer for `size` bytes, or for the rest of the file if that is known to be shorter.
    fn grow(&mut self, size: usize) {
        // If the length is not known it may be short: room grows with what came.
        let unknown = LEAST.max(usize::try_from(self.at.offset / 4).unwrap_or(size));
        let rest = self.bytes_left().map_or(unknown, |left| usize::try_from(left + 1).unwrap_or(size));
        let size = size.min(rest.max(self.end + 1)).min(BLOCK);
        self.buffer.resize(size.max(self.buffer.len()), 0);
    }

    /// Reads on, and says whether there was more.
    fn fill(&mut self) -> Result<bool, Fault> {
        if self.is_finished {
            return Ok(false);
        }
        self.compact();
        if self.end == BLOCK {
            let begin = quote(&self.buffer);
            let problem = format!(
                "the line that begins with {begin} is longer than {BLOCK} bytes; is this a text file?"
            );
            return Err(Fault::line(self.at.line, problem));
        }
        if self.end == self.buffer.len() {
            self.grow(LEAST.max(2 * self.end));
        }
        loop {
            match self.stream.read(&mut self.buffer[self.end..]) {
                Ok(0) => {
                    self.is_finished = true;
                    return Ok(false);
                }
                Ok(more) => {
                    self.end += more;
                    return Ok(true);
                }
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(Fault::unread(&error)),
            }
        }
    }

    /// Has a whole line in the buffer, and returns its length with its line end; 0 at the end of the text.
    fn have_line(&mut self) -> Result<usize, Fault> {
        let mut seen = 0;
        loop {
            if let Some(newline) = memchr::memchr(b'\n', &self.buffer[self.start + seen..self.end]) {
                return Ok(seen + newline + 1);
            }
            seen = self.end - self.start;
            if !self.fill()? {
                return Ok(seen);
            }
        }
    }

    fn consume(&mut self, bytes: usize, lines: u64) {
        self.start += bytes;
        self.at.offset += bytes as u64;
        self.at.line += lines;
    }

    /// The next line without its end, which stays the next one.
    pub(crate) fn peek(&mut self) -> Result<Option<&[u8]>, Fault> {
        let length = self.have_line()?;
        Ok((length > 0).then(|| trimmed(&self.buffer[self.start..self.start + length])))
    }

    /// The next line without its end.
    pub(crate) fn next_line(&mut self) -> Result<Option<&[u8]>, Fault> {
        let length = self.have_line()?;
        let start = self.start;
        self.consume(length, u64::from(length > 0));
        Ok((length > 0).then(|| trimmed(&self.buffer[start..start + length])))
    }

    /// The next line, which `what` needs.
    pub(crate) fn need(&mut self, what: &str) -> Result<&[u8], Fault> {
        let line = self.at.line;
        self.next_line()?.ok_or_else(|| Fault::line(line, format!("the file ends where {what} should be")))
    }

    /// Some whole lines, at most `most`; `None` at the end of the text.
    pub(crate) fn block(&mut self, most: u64) -> Result<Option<Block<'_>>, Fault> {
        // What is buffered goes first: a short frame must not cost moving the buffer.
        if memchr::memchr(b'\n', &self.buffer[self.start..self.end]).is_none() {
            self.compact();
            self.grow(BLOCK);
            while self.end < self.buffer.len() && self.fill()? {}
        }
        let buffered = &self.buffer[self.start..self.end];
        let whole = match memchr::memrchr(b'\n', buffered) {
            _ if self.is_finished => buffered.len(),
            Some(last) => last + 1,
            None => self.have_line()?,
        };
        if whole == 0 {
            return Ok(None);
        }
        let (bytes, lines) = first_lines(&self.buffer[self.start..self.start + whole], most);
        let (start, first) = (self.start, self.at.line);
        self.consume(bytes, lines);
        Ok(Some(Block { bytes: &self.buffer[start..start + bytes], lines, first }))
    }

    /// Skips `count` lines, and says how many there were.
    pub(crate) fn skip(&mut self, count: u64) -> Result<u64, Fault> {
        let mut skipped = 0;
        while skipped < count {
            match self.block(count - skipped)? {
                Some(block) => skipped += block.lines,
                None => break,
            }
        }
        Ok(skipped)
    }

    /// Skips blank lines, and says whether anything comes after them.
    pub(crate) fn skip_blank(&mut self) -> Result<bool, Fault> {
        while let Some(line) = self.peek()? {
            if !line.iter().all(u8::is_ascii_whitespace) {
                return Ok(true);
            }
            self.next_line()?;
        }
        Ok(false)
    }
}

/// The length of the first `most` lines of `bytes`, and how many lines there are in them.
fn first_lines(bytes: &[u8], most: u64) -> (usize, u64) {
    let mut lines = 0;
    for newline in memchr::memchr_iter(b'\n', bytes) {
        lines += 1;
        if lines == most {
            return (newline + 1, lines);
        }
    }
    let ends = bytes.last() == Some(&b'\n');
    (bytes.len(), lines + u64::from(!ends))
}

/// A line without its end, `\n` or `\r\n`.
pub(crate) fn trimmed(line: &[u8]) -> &[u8] {
    let line = line.strip_suffix(b"\n").unwrap_or(line);
    line.strip_suffix(b"\r").unwrap_or(line)
}

/// The lines of a block, without their ends.
pub(crate) fn lines(bytes: &[u8]) -> impl Iterator<Item = &[u8]> {
    let mut rest = bytes;
    std::iter::from_fn(move || {
        if rest.is_empty() {
            return None;
        }
        let end = memchr::memchr(b'\n', rest).map_or(rest.len(), |newline| newline + 1);
        let (line, after) = rest.split_at(end);
        rest = after;
        Some(trimmed(line))
    })
}

/// The fields of a line, separated by white space, with their columns, from 0.
pub(crate) struct Fields<'l> {
    line: &'l [u8],
    at: usize,
}

impl<'l> Fields<'l> {
    pub(crate) fn new(line: &'l [u8]) -> Self {
        Self { line, at: 0 }
    }

    /// The column after the last field, from 0.
    pub(crate) fn column(&self) -> usize {
        self.at
    }
}

impl<'l> Iterator for Fields<'l> {
    type Item = (usize, &'l [u8]);

    #[inline]
    fn next(&mut self) -> Option<Self::Item> {
        let is_blank = |byte: &u8| *byte <= b' ';
        let rest = &self.line[self.at..];
        let begin = self.at + rest.iter().position(|byte| !is_blank(byte))?;
        let rest = &self.line[begin..];
        self.at = begin + rest.iter().position(is_blank).unwrap_or(rest.len());
        Some((begin, &self.line[begin..self.at]))
    }
}

/// A number, in the notation of C or of Fortran (`1.5D-3`).
#[inline]
pub(crate) fn number(field: &[u8]) -> Option<f64> {
    fast_float2::parse(field).ok().or_else(|| of_fortran(field))
}

fn of_fortran(field: &[u8]) -> Option<f64> {
    let mut copy = [0; 40];
    let copy = copy.get_mut(..field.len())?;
    copy.copy_from_slice(field);
    let exponent = copy.iter_mut().find(|byte| matches!(byte, b'd' | b'D'))?;
    *exponent = b'e';
    fast_float2::parse(&*copy).ok()
}

/// A whole number.
#[inline]
pub(crate) fn integer(field: &[u8]) -> Option<i64> {
    std::str::from_utf8(field).ok()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::{Cursor, Write as _};

    fn all(bytes: &[u8]) -> Vec<String> {
        let mut source = Cursor::new(bytes);
        let mut text = Text::new(&mut source, Position::START).unwrap();
        let mut all = Vec::new();
        while let Some(line) = text.next_line().unwrap() {
            all.push(String::from_utf8(line.to_vec()).unwrap());
        }
        assert_eq!(text.line(), all.len() as u64 + 1);
        all
    }

    #[test]
    fn lines_have_any_end() {
        assert_eq!(all(b""), [""; 0]);
        assert_eq!(all(b"a"), ["a"]);
        assert_eq!(all(b"\xef\xbb\xbfa\r\n\nb\n"), ["a", "", "b"]);
    }

    /// A place counts the mark, which is no part of the first line, so that a line is found there again.
    #[test]
    fn places_after_a_byte_order_mark_are_found_again() {
        for bytes in [&b"\xef\xbb\xbffirst\nsecond\nthird"[..], b"first\nsecond\nthird"] {
            let mut source = Cursor::new(bytes);
            let mut text = Text::new(&mut source, Position::START).unwrap();
            assert_eq!(text.skip(1).unwrap(), 1);
            let place = text.position();
            assert_eq!(place.offset as usize, bytes.len() - b"second\nthird".len());
            let mut again = Text::new(&mut source, place).unwrap();
            assert_eq!(again.next_line().unwrap(), Some(&b"second"[..]));
        }
    }

    #[test]
    fn blocks_and_skipped_lines_are_counted_across_the_buffer() {
        let bytes = b"0123456789 0123456789\n".repeat(3 * BLOCK / 22);
        let mut source = Cursor::new(&bytes);
        let mut text = Text::new(&mut source, Position::START).unwrap();
        let count = (bytes.len() / 22) as u64;
        assert_eq!(text.skip(count / 2).unwrap(), count / 2);
        let middle = text.position();
        assert_eq!((middle.line, middle.offset), (count / 2 + 1, count / 2 * 22));
        let mut left = 0;
        while let Some(block) = text.block(1000).unwrap() {
            assert!(block.lines <= 1000 && block.bytes.len() as u64 == 22 * block.lines);
            left += block.lines;
        }
        assert_eq!(left, count - count / 2);
        let mut again = Text::new(&mut source, middle).unwrap();
        assert_eq!(again.skip(u64::MAX).unwrap(), left);
    }

    #[test]
    fn gzip_is_read_on_from_a_position_and_damage_is_told() {
        let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        encoder.write_all(&b"one\ntwo\nthree\n".repeat(1000)).unwrap();
        let bytes = encoder.finish().unwrap();
        let mut source = Cursor::new(&bytes);
        let mut text = Text::new(&mut source, Position::START).unwrap();
        assert_eq!(text.skip(1501).unwrap(), 1501);
        let position = text.position();
        assert_eq!(Text::new(&mut source, position).unwrap().next_line().unwrap(), Some(&b"two"[..]));
        // Compressed files that are joined are one, as `cat a.gz b.gz` and programs that compress in pieces make them.
        let mut joined = Cursor::new(bytes.repeat(2));
        assert_eq!(Text::new(&mut joined, Position::START).unwrap().skip(u64::MAX).unwrap(), 6000);
        let mut cut = Cursor::new(&bytes[..bytes.len() - 9]);
        let fault = Text::new(&mut cut, Position::START).unwrap().skip(9999).unwrap_err();
        assert!(fault.problem.contains("gzip data is damaged or cut off"), "{}", fault.problem);
    }

    #[test]
    fn a_line_without_end_is_refused() {
        let bytes = vec![b'a'; BLOCK + 1];
        let mut source = Cursor::new(&bytes);
        let fault = Text::new(&mut source, Position::START).unwrap().next_line().unwrap_err();
        assert!(fault.problem.contains("is longer than"), "{}", fault.problem);
        let fault = Text::new(&mut source, Position::START).unwrap().block(9).err().unwrap();
        assert!(fault.problem.contains("is longer than"), "{}", fault.problem);
    }

    #[test]
    fn numbers_are_those_of_c_and_fortran() {
        let of = |text: &str| number(text.as_bytes());
        assert_eq!([of("1.5"), of("-2e3"), of("1.0D-1"), of("+.5")], [1.5, -2000.0, 0.1, 0.5].map(Some));
        assert_eq!([of("1.5x"), of(""), of("--1"), of("0x10")], [None; 4]);
        assert_eq!(of("1e999"), Some(f64::INFINITY));
    }

    #[test]
    fn fields_know_their_columns() {
        let fields: Vec<_> = Fields::new(b"  ab\tc \r").collect();
        assert_eq!(fields, [(2, &b"ab"[..]), (5, b"c")]);
    }
}
