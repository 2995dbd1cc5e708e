//! Portable float maps: a text header, then `f32` samples, in rows from the bottom to the top.
//!
//! The header is `PF` (RGB) or `Pf` (grey), width, height, and a scale. The sign of the scale gives the byte order
//! (negative: little-endian); its absolute value multiplies the samples. We write little-endian with scale 1, which
//! preserves every bit.

use super::limits::{Seekable, check_size, truncated};
use super::opened::{Opened, RowSource};
use super::rows::{First, Rows};
use super::samples::Sample;
use scene::{Picture, Rgb};
use std::io::{self, BufRead, Read, SeekFrom, Write};

/// Limit on the length of a word in the header, with white space; valid ones are shorter.
const LONGEST_TOKEN: u64 = 32;

pub(super) fn write(out: &mut impl Write, picture: &Picture<Rgb>) -> io::Result<()> {
    write_pixels(out, "PF", picture, |pixel| {
        let mut bytes = [0; 12];
        for (bytes, sample) in bytes.chunks_exact_mut(4).zip(pixel.to_array()) {
            bytes.copy_from_slice(&sample.to_le_bytes());
        }
        bytes
    })
}

pub(super) fn write_values(out: &mut impl Write, values: &Picture<f32>) -> io::Result<()> {
    write_pixels(out, "Pf", values, f32::to_le_bytes)
}

fn write_pixels<T, const BYTES: usize>(
    out: &mut impl Write,
    magic: &str,
    picture: &Picture<T>,
    encode: impl Fn(T) -> [u8; BYTES] + Sync,
) -> io::Result<()> {
    writeln!(out, "{magic}\n{} {}\n-1.0", picture.width, picture.height)?;
    Rows(picture).write(First::Bottom, encode, |rows| out.write_all(rows))
}

/// Opens a map in a file of `length` bytes.
pub(super) fn open<'a>(mut input: Box<dyn Seekable + 'a>, length: u64) -> Result<Opened<'a>, String> {
    let header = Header::read(&mut input)?;
    check_size(header.width, header.height)?;
    let (width, height) = (header.width as u32, header.height as u32);
    let row_bytes = width as usize * header.channels * 4;
    let expected = header.bytes + row_bytes as u64 * u64::from(height);
    if length != expected {
        return Err(format!("has {length} bytes; a map of {width} x {height} pixels has {expected}"));
    }
    let rows = MapRows { input, left: header.height, header, row_bytes };
    Ok(Opened { width, height, sample: Sample::Float, rows: Box::new(rows) })
}

/// The rows of a map, which its file holds from the bottom to the top.
struct MapRows<'a> {
    input: Box<dyn Seekable + 'a>,
    header: Header,
    row_bytes: usize,
    /// Rows that have not been read: the first of the file.
    left: u64,
}

impl RowSource for MapRows<'_> {
    fn read(&mut self, pixels: &mut [Rgb]) -> Result<(), String> {
        let rows = pixels.chunks_exact_mut(self.header.width as usize);
        self.left -= rows.len() as u64;
        let start = self.header.bytes + self.left * self.row_bytes as u64;
        self.input.seek(SeekFrom::Start(start)).map_err(|e| truncated(&e))?;
        let mut bytes = vec![0; self.row_bytes];
        for row in rows.rev() {
            self.input.read_exact(&mut bytes).map_err(|e| truncated(&e))?;
            for (pixel, sample) in row.iter_mut().zip(bytes.chunks_exact(4 * self.header.channels)) {
                *pixel = self.header.pixel(sample);
            }
        }
        Ok(())
    }
}

struct Header {
    channels: usize,
    width: u64,
    height: u64,
    little_endian: bool,
    scale: f32,
    /// Length of the header.
    bytes: u64,
}

impl Header {
    fn read(input: &mut impl BufRead) -> Result<Self, String> {
        let mut bytes = 0;
        let mut next = || token(input, &mut bytes);
        let channels = match next()?.as_str() {
            "PF" => 3,
            "Pf" => 1,
            _ => return Err("is no PFM file: it must begin with PF or Pf".into()),
        };
        let mut side = |name| {
            let text = next()?;
            text.parse()
                .map_err(|_| format!("its {name} is `{}`; it must be a whole number", text.escape_debug()))
        };
        let (width, height) = (side("width")?, side("height")?);
        let text = next()?;
        let scale: f32 = text.parse().unwrap_or(f32::NAN);
        if !scale.is_normal() {
            let text = text.escape_debug();
            return Err(format!(
                "its scale is `{text}`; it must be a finite number other than 0, such as -1.0"
            ));
        }
        Ok(Self { channels, width, height, little_endian: scale < 0.0, scale: scale.abs(), bytes })
    }

    /// The pixel stored as `bytes`.
    fn pixel(&self, bytes: &[u8]) -> Rgb {
        let sample = |i: usize| {
            let i = i % self.channels; // grey: the same for all three
            let word = std::array::from_fn(|k| bytes[4 * i + k]);
            let v = if self.little_endian { f32::from_le_bytes(word) } else { f32::from_be_bytes(word) };
            // A multiplication by 1 might change the bits of a NaN.
            if self.scale == 1.0 { v } else { v * self.scale }
        };
        Rgb::new(sample(0), sample(1), sample(2))
    }
}

/// Reads a word and the one white-space character after it; adds their length to `bytes`.
fn token(input: &mut impl BufRead, bytes: &mut u64) -> Result<String, String> {
    let mut word = Vec::new();
    for byte in input.by_ref().take(LONGEST_TOKEN).bytes() {
        let byte = byte.map_err(|e| truncated(&e))?;
        *bytes += 1;
        if !byte.is_ascii_whitespace() {
            word.push(byte);
        } else if !word.is_empty() {
            return Ok(String::from_utf8_lossy(&word).into_owned());
        }
    }
    Err("its header is broken: it must be PF or Pf, width, height and scale, such as `PF 512 384 -1.0`"
        .into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::vec3;
    use scene::Film;
    use std::io::Cursor;

    fn parse(bytes: &[u8]) -> Result<Film, String> {
        open(Box::new(Cursor::new(bytes)), bytes.len() as u64)?.film()
    }

    #[test]
    fn known_bytes_out() {
        let pixels = [vec3(1.0, 2.0, -0.0), vec3(0.5, 0.0, 4.0)];
        let mut bytes = Vec::new();
        write(&mut bytes, &Picture { width: 1, height: 2, pixel: &|_, y| pixels[y as usize] }).unwrap();
        let mut expected = b"PF\n1 2\n-1.0\n".to_vec();
        for word in [0x3f00_0000_u32, 0, 0x4080_0000, 0x3f80_0000, 0x4000_0000, 0x8000_0000] {
            expected.extend(word.to_le_bytes()); // the lower row first
        }
        assert_eq!(bytes, expected);
    }

    #[test]
    fn grey_big_endian_and_scaled_in() {
        let mut bytes = b"Pf\n2 1 2.5\n".to_vec();
        bytes.extend(4.0_f32.to_be_bytes());
        bytes.extend((-8.0_f32).to_be_bytes());
        let film = parse(&bytes).unwrap();
        assert_eq!((film.width, film.height), (2, 1));
        assert_eq!(film.pixels, [Rgb::splat(10.0), Rgb::splat(-20.0)]);
    }

    /// Told are the file's own length and the one that it should have.
    #[test]
    fn maps_are_as_long_as_their_pixels() {
        for (bytes, expected) in [(b"PF\n2 3\n-1.0\n0123", 84), (b"Pf\n2 3\n-1.0\n0123", 36)] {
            let told = format!("has 16 bytes; a map of 2 x 3 pixels has {expected}");
            assert_eq!(parse(bytes).unwrap_err(), told);
        }
    }

    #[test]
    fn broken_headers_are_refused() {
        for (bytes, says) in [
            (&b""[..], "header"),
            (b"P6\n1 1\n255\n", "PF or Pf"),
            (b"PF\n-1 1\n-1.0\n", "width"),
            (b"PF\n1 x\n-1.0\n", "height"),
            (b"PF\n0 1\n-1.0\n", "no pixels"),
            (b"PF\n1 1\n0\n", "scale"),
            (b"PF\n1 1\nnan\n", "scale"),
            (b"PF\n1 1\n-inf\n", "scale"),
            (b"PF\n1 1\n-1.0", "header"),
            (b"PF\n1 1\n-1.0\nshort", "bytes"),
            (b"PF\n1 1\n-1.0\n0123456789abcdef", "bytes"),
            (b"PF\n16384 16384\n-1.0\n", "bytes"),
            (b"PF\n4294967295 4294967295\n-1.0\n", "at most"),
            (b"PF\n18446744073709551615 18446744073709551615\n-1.0\n", "at most"),
        ] {
            let problem = parse(bytes).unwrap_err();
            assert!(problem.contains(says), "{}: {problem}", bytes.escape_ascii());
        }
    }
}
