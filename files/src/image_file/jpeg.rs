//! JPEG: writes 8-bit sRGB; checks that a file is complete, as decoders show what there is of a cut one.

use super::encoding::Encoding;
use super::limits::{Seekable, truncated};
use super::shown;
use image::codecs::jpeg::JpegEncoder;
use image::{GenericImageView, ImageError};
use scene::{Picture, Rgb};
use std::io::{self, Read, Write};

/// Of 100: artefacts are hard to see, and files are a third of a PNG's.
const QUALITY: u8 = 95;

/// The picture as the encoder asks for it, block by block, so that it is never in memory.
struct Codes<'a>(Picture<'a, [u8; 3]>);

impl GenericImageView for Codes<'_> {
    type Pixel = image::Rgb<u8>;

    fn dimensions(&self) -> (u32, u32) {
        (self.0.width, self.0.height)
    }

    fn get_pixel(&self, x: u32, y: u32) -> Self::Pixel {
        image::Rgb(self.0.pixel.at(x, y))
    }
}

pub(super) fn write(out: &mut impl Write, picture: &Picture<Rgb>, encoding: &Encoding) -> io::Result<()> {
    let codes = shown::codes(picture, encoding);
    let codes = Codes(Picture { width: picture.width, height: picture.height, pixel: &codes });
    JpegEncoder::new_with_quality(out, QUALITY).encode_image(&codes).map_err(|e| match e {
        ImageError::IoError(e) => e,
        other => io::Error::other(other),
    })
}

/// Writes the values as a grey image in which the greatest finite value is white.
pub(super) fn write_values(out: &mut impl Write, values: &Picture<f32>) -> io::Result<()> {
    let scale = shown::greatest(values);
    let pixel = |x, y| Rgb::splat(values.pixel.at(x, y) / scale);
    write(out, &Picture { width: values.width, height: values.height, pixel: &pixel }, &Encoding::default())
}

/// The marker that ends an image, and the one that begins its entropy-coded pixels.
const END: u8 = 0xd9;
const SCAN: u8 = 0xda;

/// Checks that the image in `input` is followed by its end marker.
pub(super) fn check_end(input: &mut dyn Seekable) -> Result<(), String> {
    let cut = || "ends too early".to_owned();
    let mut word = [0; 2];
    input.read_exact(&mut word).map_err(|e| truncated(&e))?;
    // Segments before the pixels may hold whole images, such as a thumbnail: they are skipped by their length.
    loop {
        input.read_exact(&mut word).map_err(|e| truncated(&e))?;
        let [0xff, marker] = word else { return Ok(()) }; // for the decoder to judge
        if marker == SCAN {
            break;
        }
        input.read_exact(&mut word).map_err(|e| truncated(&e))?;
        let length = u16::from_be_bytes(word).saturating_sub(2);
        let skipped = io::copy(&mut input.take(length.into()), &mut io::sink()).map_err(|e| truncated(&e))?;
        if skipped < length.into() {
            return Err(cut());
        }
    }
    let mut was_escape = false;
    loop {
        let bytes = input.fill_buf().map_err(|e| truncated(&e))?;
        if bytes.is_empty() {
            return Err(cut());
        }
        for &byte in bytes {
            if was_escape && byte == END {
                return Ok(());
            }
            was_escape = byte == 0xff;
        }
        let length = bytes.len();
        input.consume(length);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::{BufReader, Cursor};

    #[test]
    fn the_end_is_found_in_whatever_pieces_a_file_is_read() {
        let pixel = |x: u32, y: u32| Rgb::new(x as f32 / 9.0, y as f32 / 7.0, 0.5);
        let mut whole = Vec::new();
        write(&mut whole, &Picture { width: 9, height: 7, pixel: &pixel }, &Encoding::default()).unwrap();
        let cut = &whole[..whole.len() - 1];
        for at_once in 1..64 {
            let check = |bytes: &[u8]| check_end(&mut BufReader::with_capacity(at_once, Cursor::new(bytes)));
            assert_eq!(check(&whole), Ok(()), "{at_once} bytes at once");
            assert_eq!(check(cut), Err("ends too early".into()), "{at_once} bytes at once");
        }
    }
}
