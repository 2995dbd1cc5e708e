//! Formats that are decoded whole, by the crate `image`: JPEG, WebP, QOI and Radiance HDR.

use super::guard::guarded;
use super::limits::{Seekable, check_likely, check_size, told, truncated};
use super::opened::{Opened, RowSource};
use super::samples::{Sample, Samples};
use super::{Format, jpeg};
use image::codecs::{hdr::HdrDecoder, jpeg::JpegDecoder, qoi::QoiDecoder, webp::WebPDecoder};
use image::metadata::Orientation;
use image::{ColorType, ImageDecoder, ImageResult, Limits};
use scene::Rgb;
use scene::settings::MAX_SIDE;
use std::io::SeekFrom;

/// Decoders hold the image in other forms besides, such as the coefficients of a progressive JPEG.
const WORKING_COPIES: u64 = 4;

/// A decoded image, turned upright as its metadata ask.
struct Decoded {
    samples: Samples,
    bytes: Vec<u8>,
    /// Width of the stored image.
    width: usize,
    /// Height of the stored image.
    height: usize,
    orientation: Orientation,
    next: usize,
}

/// Opens an image of `format`, which must be one of those above.
pub(super) fn open<'a>(
    format: Format,
    mut input: Box<dyn Seekable + 'a>,
    length: u64,
) -> Result<Opened<'a>, String> {
    if format == Format::Jpeg {
        jpeg::check_end(&mut input)?;
        input.seek(SeekFrom::Start(0)).map_err(|e| truncated(&e))?;
    }
    guarded(format.name(), || decode_any(format, input, length))
}

fn decode_any<'a>(
    format: Format,
    mut input: Box<dyn Seekable + 'a>,
    length: u64,
) -> Result<Opened<'a>, String> {
    let problem = |e: image::ImageError| told(format.name(), &e);
    match format {
        Format::Jpeg => decode(JpegDecoder::new(input).map_err(problem)?, format, length),
        Format::WebP => decode(WebPDecoder::new(input).map_err(problem)?, format, length),
        Format::Qoi => decode(QoiDecoder::new(input).map_err(problem)?, format, length),
        _ => {
            // The decoder's strict mode knows one of the two signatures, and checks that the colours are RGB.
            let start = input.fill_buf().map_err(|e| truncated(&e))?;
            let strict = !start.starts_with(b"#?RGBE");
            decode(HdrDecoder::with_strictness(input, strict).map_err(problem)?, format, length)
        }
    }
}

fn decode<'a>(mut decoder: impl ImageDecoder, format: Format, length: u64) -> Result<Opened<'a>, String> {
    let (width, height) = decoder.dimensions();
    check_size(width.into(), height.into())?;
    let samples = samples(decoder.color_type()).ok_or_else(|| {
        format!("has pixels of the kind {:?}; they must be grey or RGB", decoder.original_color_type())
    })?;
    let bytes = decoder.total_bytes();
    check_likely(u64::from(width) * u64::from(height), length)?;
    let problem = |e: image::ImageError| told(format.name(), &e);
    decoder.set_limits(limits(bytes)).map_err(problem)?;
    let orientation = decoder.orientation().map_err(problem)?;
    let decoded = Decoded {
        samples,
        bytes: read_image(decoder, bytes).map_err(problem)?,
        width: width as usize,
        height: height as usize,
        orientation,
        next: 0,
    };
    let (width, height) = if decoded.is_on_its_side() { (height, width) } else { (width, height) };
    Ok(Opened { width, height, sample: decoded.samples.sample, rows: Box::new(decoded) })
}

fn read_image(decoder: impl ImageDecoder, bytes: u64) -> ImageResult<Vec<u8>> {
    let mut pixels = vec![0; bytes as usize];
    decoder.read_image(&mut pixels)?;
    Ok(pixels)
}

fn limits(bytes: u64) -> Limits {
    let mut limits = Limits::default();
    limits.max_image_width = Some(MAX_SIDE);
    limits.max_image_height = Some(MAX_SIDE);
    limits.max_alloc = Some(WORKING_COPIES * bytes);
    limits
}

fn samples(color: ColorType) -> Option<Samples> {
    let sample = match color {
        ColorType::L8 | ColorType::La8 | ColorType::Rgb8 | ColorType::Rgba8 => Sample::Byte,
        ColorType::L16 | ColorType::La16 | ColorType::Rgb16 | ColorType::Rgba16 => Sample::NativeWord,
        ColorType::Rgb32F | ColorType::Rgba32F => Sample::Float,
        _ => return None,
    };
    Some(Samples::new(sample, usize::from(color.channel_count())))
}

impl Decoded {
    fn is_on_its_side(&self) -> bool {
        use Orientation::{Rotate90, Rotate90FlipH, Rotate270, Rotate270FlipH};
        matches!(self.orientation, Rotate90 | Rotate270 | Rotate90FlipH | Rotate270FlipH)
    }

    /// Column and row in the stored image of a pixel of the upright one.
    fn stored(&self, x: usize, y: usize) -> (usize, usize) {
        let (right, bottom) = (self.width - 1, self.height - 1);
        match self.orientation {
            Orientation::NoTransforms => (x, y),
            Orientation::FlipHorizontal => (right - x, y),
            Orientation::FlipVertical => (x, bottom - y),
            Orientation::Rotate180 => (right - x, bottom - y),
            Orientation::Rotate90 => (y, bottom - x),
            Orientation::Rotate270 => (right - y, x),
            Orientation::Rotate90FlipH => (y, x),
            Orientation::Rotate270FlipH => (right - y, bottom - x),
        }
    }
}

impl RowSource for Decoded {
    fn read(&mut self, pixels: &mut [Rgb]) -> Result<(), String> {
        let width = if self.is_on_its_side() { self.height } else { self.width };
        let size = self.samples.bytes_per_pixel();
        for row in pixels.chunks_exact_mut(width) {
            for (x, pixel) in row.iter_mut().enumerate() {
                let (x, y) = self.stored(x, self.next);
                *pixel = self.samples.pixel(&self.bytes[size * (y * self.width + x)..][..size]);
            }
            self.next += 1;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [Orientation; 8] = [
        Orientation::NoTransforms,
        Orientation::FlipHorizontal,
        Orientation::FlipVertical,
        Orientation::Rotate90,
        Orientation::Rotate180,
        Orientation::Rotate270,
        Orientation::Rotate90FlipH,
        Orientation::Rotate270FlipH,
    ];

    /// As the library that reads them turns them, of which this holds no copy.
    #[test]
    fn images_are_turned_upright() {
        let (width, height) = (5_usize, 3_usize);
        let bytes: Vec<u8> = (0..15).map(|k| 10 + 7 * k).collect();
        for orientation in ALL {
            let samples = Samples::new(Sample::Byte, 1);
            let expected = {
                let grey = image::GrayImage::from_raw(5, 3, bytes.clone()).unwrap();
                let mut turned = image::DynamicImage::from(grey);
                turned.apply_orientation(orientation);
                turned
            };
            let mut decoded = Decoded { samples, bytes: bytes.clone(), width, height, orientation, next: 0 };
            let is_turned = expected.width() == 3;
            assert_eq!(decoded.is_on_its_side(), is_turned, "{orientation:?}");
            let mut pixels = [Rgb::ZERO; 15];
            // Row by row.
            let (first, rest) = pixels.split_at_mut(expected.width() as usize);
            decoded.read(first).unwrap();
            decoded.read(rest).unwrap();
            let upright: Vec<Rgb> = expected
                .as_bytes()
                .iter()
                .map(|code| Rgb::splat(scene::srgb::decode_code((*code).into(), 255)))
                .collect();
            assert_eq!(pixels[..], upright, "{orientation:?}");
        }
    }

    #[test]
    fn samples_are_as_many_as_the_channels() {
        let of = |color| samples(color).map(|samples| (samples.sample, samples.per_pixel));
        assert_eq!(of(ColorType::L8), Some((Sample::Byte, 1)));
        assert_eq!(of(ColorType::Rgba8), Some((Sample::Byte, 4)));
        assert_eq!(of(ColorType::La16), Some((Sample::NativeWord, 2)));
        assert_eq!(of(ColorType::Rgb16), Some((Sample::NativeWord, 3)));
        assert_eq!(of(ColorType::Rgb32F), Some((Sample::Float, 3)));
        let limits = limits(1000);
        assert_eq!((limits.max_alloc, limits.max_image_width), (Some(4000), Some(MAX_SIDE)));
    }
}
