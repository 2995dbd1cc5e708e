//! Tests of image files: round trips bit for bit, formats of other programs, broken files, and failed writes.

use super::*;
use crate::atomic_file::Output;
use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, FlatSamples, Image, Layer, LayerAttributes, LineOrder,
    Vec2, WritableImage, f16,
};
use proptest::prelude::*;
use scene::srgb;
use std::fs::{self, File};
use std::io::{Cursor, Write};
use std::path::PathBuf;

mod foreign;
mod layers;

const EVERY_FORMAT: [(Format, &str); 6] = [
    (Format::Png, "png"),
    (Format::Exr, "exr"),
    (Format::Pfm, "pfm"),
    (Format::Hdr, "hdr"),
    (Format::Tiff, "tif"),
    (Format::Jpeg, "jpg"),
];

/// Values that formats may not preserve: signed zeros, subnormals, the ends of the range, infinities, NaN.
const EXTREMES: [f32; 12] = [
    0.0,
    -0.0,
    1.0,
    -1.5,
    1e-45,
    -1.1e-38,
    f32::MIN_POSITIVE,
    f32::MAX,
    f32::MIN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::NAN,
];

/// A film with all the extremes in which all pixels differ.
fn extreme_film(width: u32, height: u32) -> Film {
    let value = |i: u32| EXTREMES.get(i as usize).copied().unwrap_or(i as f32 * 0.37 - 1.0);
    let pixels = (0..width * height).map(|i| Rgb::new(value(3 * i), value(3 * i + 1), value(3 * i + 2)));
    Film { width, height, pixels: pixels.collect() }
}

/// A film of values that 8-bit sRGB represents exactly.
fn byte_film(width: u32, height: u32) -> Film {
    let value = |i: u32| srgb::decode_code((i * 7 % 256) as u16, 255);
    let pixels = (0..width * height).map(|i| Rgb::new(value(i), value(i + 50), value(i + 99)));
    Film { width, height, pixels: pixels.collect() }
}

fn bits(film: &Film) -> (u32, u32, Vec<[u32; 3]>) {
    (film.width, film.height, film.pixels.iter().map(|p| p.to_array().map(f32::to_bits)).collect())
}

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().unwrap()
}

fn names_in(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> =
        fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

fn problem(result: Result<impl std::fmt::Debug, ImageError>) -> String {
    let line = result.unwrap_err().to_string();
    assert!(!line.contains('\n') && line.len() < 400, "{line}");
    line
}

#[test]
fn exr_and_pfm_keep_every_bit() {
    let folder = folder();
    for (width, height) in [(1, 1), (7, 3), (1, 100), (100, 1), (48, 27), (33, 65)] {
        let film = extreme_film(width, height);
        for name in ["a.exr", "a.pfm"] {
            let path = folder.path().join(name);
            write(&path, &film, &Encoding { exposure: 3.0, ..Encoding::default() }).unwrap();
            assert_eq!(bits(&read(&path).unwrap()), bits(&film), "{name} {width}x{height}");
        }
    }
    assert_eq!(names_in(folder.path()), ["a.exr", "a.pfm"]);
}

#[test]
fn png_keeps_every_byte() {
    let folder = folder();
    let path = folder.path().join("a.PNG");
    let film = byte_film(31, 17);
    write(&path, &film, &Encoding::default()).unwrap();
    assert_eq!(bits(&read(&path).unwrap()), bits(&film));
}

#[test]
fn planes_are_read_back_and_a_png_is_scaled_to_the_maximum() {
    let folder = folder();
    let plane = Plane { width: 3, height: 2, values: vec![0.0, 1.0, 4.0, 2.0, 0.5, 1e-40] };
    for name in ["a.exr", "a.pfm", "a.png"] {
        let path = folder.path().join(name);
        write_plane(&path, &plane, "radius", &Encoding::default()).unwrap();
        let film = read(&path).unwrap();
        if name == "a.png" {
            let shares = [0.0, 0.25, 1.0, 0.5, 0.125, 0.0];
            let expected = shares.map(|v| srgb::decode_code(srgb::encode_byte(v).into(), 255));
            assert_eq!(film.pixels, expected.map(Rgb::splat));
        } else {
            assert_eq!(bits(&film), bits(&plane.to_film()), "{name}");
        }
    }
    let exr = fs::read(folder.path().join("a.exr")).unwrap();
    assert!(exr.windows(6).any(|w| w == b"radius"));
}

#[test]
fn png_of_a_plane_takes_the_greatest_finite_value_for_white() {
    let folder = folder();
    let path = folder.path().join("a.png");
    let values = vec![f32::INFINITY, 2.0, f32::NAN, 0.5];
    write_plane(&path, &Plane { width: 2, height: 2, values }, "radius", &Encoding::default()).unwrap();
    let quarter = srgb::decode_code(srgb::encode_byte(0.25).into(), 255);
    let expected = [Rgb::ONE, Rgb::ONE, Rgb::new(1.0, 0.0, 1.0), Rgb::splat(quarter)];
    assert_eq!(read(&path).unwrap().pixels, expected);
}

#[test]
fn png_of_a_plane_without_a_positive_value_is_black() {
    let folder = folder();
    let path = folder.path().join("a.png");
    write_plane(
        &path,
        &Plane { width: 2, height: 1, values: vec![0.0, -1.0] },
        "count",
        &Encoding::default(),
    )
    .unwrap();
    assert_eq!(read(&path).unwrap().pixels, [Rgb::ZERO; 2]);
}

#[test]
fn png_applies_exposure_and_marks_nan() {
    let folder = folder();
    let path = folder.path().join("a.png");
    let pixels = vec![
        Rgb::splat(0.125),
        Rgb::new(0.25, f32::INFINITY, f32::NEG_INFINITY),
        Rgb::new(0.0, f32::NAN, 0.0),
        Rgb::splat(-3.0),
    ];
    write(&path, &Film { width: 4, height: 1, pixels }, &Encoding { exposure: 2.0, ..Encoding::default() })
        .unwrap();
    let half = srgb::decode_code(188, 255);
    let expected = [Rgb::splat(half), Rgb::new(1.0, 1.0, 0.0), Rgb::new(1.0, 0.0, 1.0), Rgb::ZERO];
    assert_eq!(read(&path).unwrap().pixels, expected);
}

/// The codes in a file, by the crate `png` alone.
fn codes(path: &Path) -> Vec<u8> {
    let mut reader = ::png::Decoder::new(io::BufReader::new(File::open(path).unwrap())).read_info().unwrap();
    let mut codes = vec![0; reader.output_buffer_size().unwrap()];
    assert_eq!(reader.next_frame(&mut codes).unwrap().color_type, ::png::ColorType::Rgb);
    codes
}

/// So that no viewer has to guess what the codes mean.
#[test]
fn png_files_say_that_they_are_srgb() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    let clear = |_, _| Rgba { color: Rgb::ZERO, alpha: 0.5 };
    let picture = Picture { width: 2, height: 1, pixel: &clear };
    let plane = Plane { width: 2, height: 1, values: vec![0.0, 1.0] };
    write(&path("a.png"), &byte_film(2, 1), &Encoding::default()).unwrap();
    write_transparent(&path("b.png"), &picture, &Encoding::default()).unwrap();
    write_plane(&path("c.png"), &plane, "radius", &Encoding::default()).unwrap();
    for name in ["a.png", "b.png", "c.png"] {
        let file = io::BufReader::new(File::open(path(name)).unwrap());
        assert!(::png::Decoder::new(file).read_info().unwrap().info().srgb.is_some(), "{name}");
    }
}

/// Each code is `255 sRGB(v 2^e)`, rounded: darker, unchanged and brighter, and by parts of a stop.
#[test]
fn png_codes_are_those_of_the_formula_at_every_exposure() {
    let folder = folder();
    let path = folder.path().join("a.png");
    let values: Vec<f32> = (0..3 * 400).map(|i| 1e-5 * 1.015_f32.powi(i)).collect();
    let pixels = values.chunks_exact(3).map(Rgb::from_slice).collect();
    let film = Film { width: 20, height: 20, pixels };
    for exposure in [-6.0_f32, -1.5, 0.0, 0.7, 3.0] {
        write(&path, &film, &Encoding { exposure, ..Encoding::default() }).unwrap();
        let gain = 2_f64.powf(f64::from(exposure));
        let expected: Vec<u8> =
            values.iter().map(|v| (255.0 * srgb::encode(f64::from(*v) * gain)).round() as u8).collect();
        assert_eq!(codes(&path), expected, "{exposure} stops");
        assert!(expected.contains(&0) && expected.contains(&255), "{exposure} stops show no range");
    }
}

#[test]
fn the_same_film_gives_the_same_bytes() {
    let folder = folder();
    let film = extreme_film(40, 30);
    for (_, extension) in EVERY_FORMAT {
        let [a, b] = ["a", "b"].map(|name| {
            let path = folder.path().join(name).with_extension(extension);
            write(&path, &film, &Encoding::default()).unwrap();
            fs::read(path).unwrap()
        });
        assert_eq!(a, b, "{extension}");
    }
}

/// A PNG file of one row, made directly by the `png` crate.
fn png_bytes(
    color: ::png::ColorType,
    depth: ::png::BitDepth,
    width: u32,
    row: &[u8],
    palette: &[u8],
) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = ::png::Encoder::new(&mut bytes, width, 1);
    encoder.set_color(color);
    encoder.set_depth(depth);
    if !palette.is_empty() {
        encoder.set_palette(palette);
    }
    encoder.write_header().unwrap().write_image_data(row).unwrap();
    bytes
}

#[test]
fn png_of_every_kind_is_read() {
    use ::png::{BitDepth, ColorType};
    let v = |c| srgb::decode_code(c, 255);
    let wide = |c| srgb::decode_code(c, 65535);
    let grey = |c| Rgb::splat(v(c));
    for (color, depth, width, row, palette, expected) in [
        (ColorType::Grayscale, BitDepth::Eight, 2, &[10, 200][..], &[][..], vec![grey(10), grey(200)]),
        (ColorType::Grayscale, BitDepth::One, 2, &[0b0100_0000], &[], vec![grey(0), grey(255)]),
        (ColorType::Grayscale, BitDepth::Sixteen, 1, &[0x12, 0x34], &[], vec![Rgb::splat(wide(0x1234))]),
        (ColorType::GrayscaleAlpha, BitDepth::Eight, 2, &[10, 0, 20, 255], &[], vec![grey(10), grey(20)]),
        (ColorType::Rgb, BitDepth::Eight, 1, &[1, 2, 3], &[], vec![Rgb::new(v(1), v(2), v(3))]),
        (ColorType::Rgba, BitDepth::Eight, 1, &[1, 2, 3, 0], &[], vec![Rgb::new(v(1), v(2), v(3))]),
        (
            ColorType::Rgba,
            BitDepth::Sixteen,
            1,
            &[0, 1, 0xff, 0xff, 0x80, 0, 9, 9],
            &[],
            vec![Rgb::new(wide(1), wide(65535), wide(0x8000))],
        ),
        (
            ColorType::Indexed,
            BitDepth::Eight,
            2,
            &[1, 0],
            &[5, 6, 7, 8, 9, 10],
            vec![Rgb::new(v(8), v(9), v(10)), Rgb::new(v(5), v(6), v(7))],
        ),
    ] {
        let film = decode_bytes(Format::Png, &png_bytes(color, depth, width, row, palette)).unwrap();
        assert_eq!(film, Film { width, height: 1, pixels: expected }, "{color:?} {depth:?}");
    }
}

/// One colour takes less than a three hundredth of its pixels, and is no less a picture.
#[test]
fn png_of_one_colour_is_read() {
    let mut bytes = Vec::new();
    let mut encoder = ::png::Encoder::new(&mut bytes, 1024, 1024);
    encoder.set_color(::png::ColorType::Grayscale);
    encoder.set_depth(::png::BitDepth::Eight);
    encoder.set_compression(::png::Compression::High);
    encoder.write_header().unwrap().write_image_data(&vec![0; 1 << 20]).unwrap();
    assert!(bytes.len() < (1 << 20) / 300, "{} bytes are no strong compression", bytes.len());
    let film = decode_bytes(Format::Png, &bytes).unwrap();
    assert!((film.width, film.height) == (1024, 1024) && film.pixels.iter().all(|p| *p == Rgb::ZERO));
}

/// An EXR file of 5 x 4 pixels with the given channels, its data window off the origin.
fn exr_bytes(channels: Vec<AnyChannel<FlatSamples>>, compression: Compression, blocks: Blocks) -> Vec<u8> {
    exr_bytes_in(LineOrder::Increasing, channels, compression, blocks)
}

fn exr_bytes_in(
    line_order: LineOrder,
    channels: Vec<AnyChannel<FlatSamples>>,
    compression: Compression,
    blocks: Blocks,
) -> Vec<u8> {
    let encoding = exr::prelude::Encoding { compression, blocks, line_order };
    let layer = LayerAttributes::default().with_position(Vec2(-2, 7));
    let image = Image::from_layer(Layer::new((5, 4), layer, encoding, AnyChannels::sort(channels.into())));
    let mut bytes = Cursor::new(Vec::new());
    image.write().non_parallel().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

fn floats(offset: f32) -> FlatSamples {
    FlatSamples::F32((0..20).map(|i| i as f32 + offset).collect())
}

#[test]
fn exr_of_every_kind_is_read() {
    let halves = FlatSamples::F16((0..20).map(|i| f16::from_f32(i as f32 + 0.25)).collect());
    let words = FlatSamples::U32((0..20).collect());
    let colour = || {
        let alpha = AnyChannel::new("A", floats(0.0));
        let (r, g) = (AnyChannel::new("R", floats(0.5)), AnyChannel::new("G", halves.clone()));
        vec![alpha, r, g, AnyChannel::new("B", words.clone())]
    };
    let expected: Vec<_> = (0..20).map(|i| i as f32).map(|v| Rgb::new(v + 0.5, v + 0.25, v)).collect();
    for compression in [
        Compression::Uncompressed,
        Compression::RLE,
        Compression::ZIP1,
        Compression::ZIP16,
        Compression::PIZ,
        Compression::PXR24,
    ] {
        for blocks in [Blocks::ScanLines, Blocks::Tiles(Vec2(3, 2))] {
            for order in [LineOrder::Increasing, LineOrder::Decreasing] {
                let bytes = exr_bytes_in(order, colour(), compression, blocks);
                let film = decode_bytes(Format::Exr, &bytes).unwrap();
                assert_eq!((film.width, film.height), (5, 4));
                assert_eq!(film.pixels, expected, "{compression:?} {blocks:?} {order:?}");
            }
        }
    }
}

/// A tile may be larger than its image, but not than any image: what is read at once is as large.
#[test]
fn exr_tiles_are_no_larger_than_images_can_be() {
    let channels = vec![AnyChannel::new("Y", floats(0.0))];
    let whole = exr_bytes(channels, Compression::Uncompressed, Blocks::Tiles(Vec2(3, 2)));
    let name = b"tiles\0tiledesc\0";
    let at = whole.windows(name.len()).position(|window| window == name).unwrap() + name.len() + 4;
    for (side, expected) in [(0, "1048577 x 2"), (4, "3 x 1048577")] {
        let mut bytes = whole.clone();
        bytes[at + side..][..4].copy_from_slice(&(scene::settings::MAX_SIDE + 1).to_le_bytes());
        let problem = decode_bytes(Format::Exr, &bytes).unwrap_err();
        assert_eq!(problem, format!("has tiles of {expected} pixels; each side must be from 1 to 1048576"));
    }
}

#[test]
fn exr_of_one_channel_is_grey() {
    let expected: Vec<_> = (0..20).map(|i| Rgb::splat(i as f32)).collect();
    for names in [&["Y"][..], &["Y", "A"], &["radius"]] {
        let channels = names.iter().map(|&n| AnyChannel::new(n, floats(0.0))).collect();
        let film =
            decode_bytes(Format::Exr, &exr_bytes(channels, Compression::ZIP16, Blocks::ScanLines)).unwrap();
        assert_eq!(film.pixels, expected, "{names:?}");
    }
}

#[test]
fn exr_without_colours_names_its_channels() {
    for names in [&["R", "G"][..], &["Y", "RY", "BY"], &["U", "V"]] {
        let channels = names.iter().map(|&n| AnyChannel::new(n, floats(0.0))).collect();
        let bytes = exr_bytes(channels, Compression::ZIP16, Blocks::ScanLines);
        let problem = decode_bytes(Format::Exr, &bytes).unwrap_err();
        assert!(
            names.iter().all(|n| problem.contains(n)) && problem.contains("must have R, G and B"),
            "{problem}"
        );
    }
}

/// The note of a scene of many balls is most of a small picture.
#[test]
fn a_note_may_be_longer_than_the_rest_of_the_file() {
    let folder = folder();
    let path = folder.path().join("a.png");
    for length in [1, 300, 30_000, 60_000, 100_000, 1 << 20] {
        let note: String = ('a'..='z').cycle().take(length).collect();
        let encoding = Encoding { note: Some(&note), ..Encoding::default() };
        write(&path, &byte_film(2, 2), &encoding).unwrap();
        assert_eq!(read_note(&path).unwrap(), Some(note));
    }
}

#[test]
fn a_note_is_read_back_and_changes_no_pixel() {
    let folder = folder();
    let note: String = (1..128).map(char::from).cycle().take(5000).collect();
    let encoding = Encoding { note: Some(&note), ..Encoding::default() };
    for (format, extension) in EVERY_FORMAT {
        let path = folder.path().join("a").with_extension(extension);
        write(&path, &byte_film(9, 20), &Encoding::default()).unwrap();
        let film = read(&path).unwrap();
        assert_eq!(read_note(&path).unwrap(), None);
        write(&path, &byte_film(9, 20), &encoding).unwrap();
        let bytes = fs::read(&path).unwrap();
        let expected = matches!(format, Format::Png | Format::Exr).then(|| note.clone());
        assert_eq!(decode_note_bytes(format, &bytes).unwrap(), expected);
        assert_eq!(decode_bytes(format, &bytes).unwrap(), film);
        write(&path, &byte_film(9, 20), &encoding).unwrap();
        assert_eq!(fs::read(&path).unwrap(), bytes);
    }
}

/// Other programs write texts of their own, before ours or after.
#[test]
fn texts_of_other_programs_are_no_note() {
    let (ours, theirs) = ((encoding::NOTE, "ours"), ("Software", "theirs"));
    for (texts, expected) in [
        (&[theirs][..], None),
        (&[theirs, ours], Some("ours")),
        (&[ours, theirs], Some("ours")),
        (&[theirs, ("Comment", "more"), ours, theirs], Some("ours")),
    ] {
        let mut bytes = Vec::new();
        let mut encoder = ::png::Encoder::new(&mut bytes, 1, 1);
        for (keyword, text) in texts {
            encoder.add_text_chunk((*keyword).into(), (*text).into()).unwrap();
        }
        encoder.write_header().unwrap().write_image_data(&[0]).unwrap();
        assert_eq!(decode_note_bytes(Format::Png, &bytes).unwrap().as_deref(), expected, "{texts:?}");
    }
}

#[test]
fn unknown_extensions_are_refused() {
    for name in ["a.gif", "a", "png", ".png", "a.png.", ""] {
        let line = problem(Format::from_path(Path::new(name)));
        assert!(line.contains(".png, .jpg, .exr, .pfm, .hdr or .tif"), "{line}");
    }
    for (format, extension) in EVERY_FORMAT {
        let upper = extension.to_uppercase();
        assert_eq!(Format::from_path(Path::new(&format!("/a.b/c.{upper}"))), Ok(format));
    }
}

#[test]
fn missing_and_unsuitable_files_are_rejected() {
    let folder = folder();
    let here = |name: &str| folder.path().join(name);
    fs::create_dir(here("folder.png")).unwrap();
    fs::write(here("text.png"), "not a picture").unwrap();
    fs::write(here("text.exr"), "not a picture").unwrap();
    fs::write(here("empty.exr"), "").unwrap();
    for (name, says) in [
        ("missing.png", "there is no such file"),
        ("folder.png", "this is a directory; name an image file"),
        ("text.png", "no PNG file"),
        ("text.exr", "no EXR file"),
        ("empty.exr", "no EXR file"),
    ] {
        let line = problem(read(&here(name)));
        assert!(line.contains(says) && line.contains(name), "{line}");
    }
}

#[test]
fn sizes_larger_than_the_file_allows_are_rejected() {
    // A PNG header with a valid checksum that states 16384 x 16384 pixels.
    let mut png = png_bytes(::png::ColorType::Rgb, ::png::BitDepth::Eight, 1, &[0; 3], &[]);
    png[16..24].copy_from_slice(&[0, 0, 0x40, 0, 0, 0, 0x40, 0]);
    let crc = crc32(&png[12..29]);
    png[29..33].copy_from_slice(&crc.to_be_bytes());
    let problem = decode_bytes(Format::Png, &png).unwrap_err();
    assert!(problem.contains("cannot hold the 805322752 bytes"), "{problem}");

    let mut exr = exr_bytes(vec![AnyChannel::new("Y", floats(0.0))], Compression::ZIP16, Blocks::ScanLines);
    let window = exr.windows(10).position(|w| w == b"dataWindow").unwrap() + 10 + 1 + 6 + 4;
    assert_eq!(exr[window..window + 4], (-2_i32).to_le_bytes());
    exr[window + 8..window + 12].copy_from_slice(&16381_i32.to_le_bytes());
    exr[window + 12..window + 16].copy_from_slice(&16390_i32.to_le_bytes());
    let problem = decode_bytes(Format::Exr, &exr).unwrap_err();
    assert!(problem.contains("16384 x 16384 pixels for a display window of 20"), "{problem}");
    // The same with a display window of that size.
    let frame = exr.windows(13).position(|w| w == b"displayWindow").unwrap() + 13 + 1 + 6 + 4;
    exr.copy_within(window..window + 16, frame);
    let problem = decode_bytes(Format::Exr, &exr).unwrap_err();
    assert!(problem.contains("cannot hold the 1073741824 bytes"), "{problem}");
    // An image may have twice the pixels of its display window, whose rows begin at 7, but no more.
    for (last_row, told) in
        [(8198_i32, "cannot hold the 1073741824 bytes"), (8197, "for a display window of")]
    {
        exr[frame + 12..frame + 16].copy_from_slice(&last_row.to_le_bytes());
        let problem = decode_bytes(Format::Exr, &exr).unwrap_err();
        assert!(problem.contains(told), "{last_row}: {problem}");
    }
}

#[test]
fn riff_files_are_webp_images_only_if_they_say_so() {
    assert_eq!(Format::of_content(b"RIFF\x10\0\0\0WEBP"), Some(Format::WebP));
    assert_eq!(Format::of_content(b"RIFF\x10\0\0\0WAVE"), None);
    assert_eq!(Format::of_content(b"FORM\x10\0\0\0WEBP"), None);
    assert_eq!(Format::of_content(b"RIFF"), None);
}

/// The CRC-32 of PNG chunks, computed bit by bit.
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |c, _| if c & 1 == 1 { (c >> 1) ^ 0xedb8_8320 } else { c >> 1 })
    })
}

#[test]
fn an_inconsistent_film_is_not_written() {
    let folder = folder();
    for film in [Film::new(0, 3), Film { width: 2, height: 2, pixels: vec![Rgb::ZERO; 3] }] {
        for (_, extension) in EVERY_FORMAT {
            let line = problem(write(
                &folder.path().join("a").with_extension(extension),
                &film,
                &Encoding::default(),
            ));
            assert!(line.contains("pixels"), "{line}");
        }
    }
    assert!(names_in(folder.path()).is_empty());
}

#[test]
fn an_inconsistent_plane_is_not_written() {
    let folder = folder();
    let plane = Plane { width: 2, height: 3, values: vec![0.0; 5] };
    for (_, extension) in EVERY_FORMAT {
        let path = folder.path().join("a").with_extension(extension);
        let line = problem(write_plane(&path, &plane, "radius", &Encoding::default()));
        assert!(line.ends_with(": cannot hold 5 pixels as an image of 2 x 3"), "{line}");
    }
    assert!(names_in(folder.path()).is_empty());
}

#[test]
fn a_failed_write_leaves_the_old_file_and_nothing_else() {
    let folder = folder();
    let path = folder.path().join("a.png");
    fs::write(&path, "old").unwrap();
    let full = |out: &mut Output| {
        out.write_all(&[0; 10_000])?;
        Err(io::Error::from(io::ErrorKind::StorageFull))
    };
    let line = problem(atomic_file::replace(&path, full));
    assert!(line.contains("a.png: cannot be written: no storage space"), "{line}");
    assert_eq!(fs::read_to_string(&path).unwrap(), "old");
    assert_eq!(names_in(folder.path()), ["a.png"]);
}

#[test]
fn the_old_file_stays_until_the_new_one_is_complete() {
    let folder = folder();
    let path = folder.path().join("a.png");
    fs::write(&path, "old").unwrap();
    atomic_file::replace(&path, |out| {
        out.write_all(b"new")?;
        out.flush()?;
        assert_eq!(fs::read_to_string(&path).unwrap(), "old");
        // A process that is killed now leaves nothing behind.
        #[cfg(target_os = "linux")]
        assert_eq!(names_in(folder.path()), ["a.png"]);
        Ok(())
    })
    .unwrap();
    assert_eq!(fs::read_to_string(&path).unwrap(), "new");
    assert_eq!(names_in(folder.path()), ["a.png"]);
}

#[test]
fn targets_that_cannot_be_written_are_found_in_advance() {
    let folder = folder();
    let here = |name: &str| folder.path().join(name);
    fs::create_dir(here("folder.png")).unwrap();
    fs::write(here("file"), "").unwrap();
    fs::write(here("locked.png"), "old").unwrap();
    let mut permissions = fs::metadata(here("locked.png")).unwrap().permissions();
    permissions.set_readonly(true);
    fs::set_permissions(here("locked.png"), permissions).unwrap();
    let before = names_in(folder.path());
    for (name, says) in [
        ("folder.png", "is a folder"),
        ("missing/a.png", "does not exist; make it first"),
        ("file/a.png", "is not a folder"),
        ("a.png/", "names a folder"),
        ("locked.png", "read-only"),
        ("a.gif", ".png, .jpg, .exr, .pfm, .hdr or .tif"),
        (&format!("{}.png", "x".repeat(300)), "too long"),
    ] {
        let path = here(name);
        let line = problem(check_writable(&path).map_err(|e| {
            let short = ImageError::new(Path::new("?"), &e.problem);
            assert_eq!(e.path, path);
            short
        }));
        assert!(line.contains(says), "{name}: {line}");
        assert!(write(&path, &Film::new(1, 1), &Encoding::default()).is_err());
    }
    check_writable(&here("fine.png")).unwrap();
    assert_eq!(names_in(folder.path()), before);
}

#[test]
fn a_control_character_does_not_break_the_line() {
    let line = problem(Format::from_path(Path::new("a\nb.jp\ng")));
    assert!(line.starts_with("a\\nb.jp\\ng: "), "{line}");
}

#[cfg(unix)]
mod unix {
    use super::*;
    use std::os::unix::fs::{PermissionsExt, symlink};

    fn mode(path: &Path) -> u32 {
        fs::metadata(path).unwrap().permissions().mode() & 0o777
    }

    #[test]
    fn permissions_are_the_default_or_those_of_the_replaced_file() {
        let folder = folder();
        let [plain, ours] = ["plain", "ours.pfm"].map(|name| folder.path().join(name));
        File::create(&plain).unwrap();
        write(&ours, &Film::new(1, 1), &Encoding::default()).unwrap();
        assert_eq!(mode(&ours), mode(&plain));
        for wanted in [0o600, 0o666, 0o640] {
            fs::set_permissions(&ours, fs::Permissions::from_mode(wanted)).unwrap();
            write(&ours, &Film::new(1, 1), &Encoding::default()).unwrap();
            assert_eq!(mode(&ours), wanted);
        }
    }

    #[test]
    fn a_link_stays_a_link() {
        let folder = folder();
        let [link, early, circle]: [PathBuf; 3] =
            ["link.pfm", "early.pfm", "circle.pfm"].map(|name| folder.path().join(name));
        let real = folder.path().join("there").join("real.pfm");
        fs::create_dir(real.parent().unwrap()).unwrap();
        fs::write(&real, "old").unwrap();
        symlink("there/real.pfm", &link).unwrap();
        write(&link, &byte_film(3, 2), &Encoding::default()).unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(read(&real).unwrap(), byte_film(3, 2));

        // A link may be there before its file.
        symlink("there/new.pfm", &early).unwrap();
        write(&early, &byte_film(3, 2), &Encoding::default()).unwrap();
        assert!(fs::symlink_metadata(&early).unwrap().is_symlink());
        assert_eq!(read(&folder.path().join("there/new.pfm")).unwrap(), byte_film(3, 2));

        symlink("circle.pfm", &circle).unwrap();
        assert!(problem(check_writable(&circle)).contains("links lead in a circle"));
    }

    #[test]
    fn devices_are_rejected() {
        let folder = folder();
        let link = folder.path().join("null.png");
        symlink("/dev/null", &link).unwrap();
        assert!(problem(check_writable(&link)).contains("device"));
        assert!(problem(read(&link)).contains("this is a pipe or a device; name an image file"));
    }
}

/// Small valid files: one of each format, EXR files with various compressions, and a palette PNG.
fn specimens() -> Vec<(Format, Vec<u8>)> {
    let folder = folder();
    let mut all: Vec<_> = EVERY_FORMAT
        .iter()
        .map(|&(format, extension)| {
            let path = folder.path().join("a").with_extension(extension);
            write(&path, &byte_film(9, 20), &Encoding::default()).unwrap();
            (format, fs::read(path).unwrap())
        })
        .collect();
    for compression in [
        Compression::Uncompressed,
        Compression::RLE,
        Compression::PIZ,
        Compression::PXR24,
        Compression::B44,
        Compression::DWAA(None),
    ] {
        for blocks in [Blocks::ScanLines, Blocks::Tiles(Vec2(3, 2))] {
            let halves = FlatSamples::F16((0..20).map(|i| f16::from_f32(i as f32)).collect());
            let channels = ["R", "G", "B"].map(|n| AnyChannel::new(n, halves.clone()));
            all.push((Format::Exr, exr_bytes(channels.to_vec(), compression, blocks)));
        }
    }
    let grey = png_bytes(::png::ColorType::Indexed, ::png::BitDepth::Two, 4, &[0b0001_1011], &[7; 12]);
    all.push((Format::Png, grey));
    all.push((Format::WebP, foreign::webp()));
    all.push((Format::WebP, foreign::LOSSY_WEBP.to_vec()));
    all.push((Format::Jpeg, foreign::PROGRESSIVE_JPEG.to_vec()));
    all.push((Format::Qoi, foreign::qoi()));
    all.push((Format::Tiff, foreign::tiled()));
    all
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 20_000, ..ProptestConfig::default() })]

    /// However a file is truncated or overwritten, reading gives a film of the stated size or a one-line error.
    #[test]
    fn broken_files_are_errors(
        which in 0_usize..24,
        cut in proptest::option::of(0.0..1.0),
        edits in proptest::collection::vec((0.0..1.0, any::<u8>()), 0..6),
        word in proptest::option::of((0.0..1.0, prop_oneof![Just(-1), Just(0), Just(i32::MAX), Just(i32::MIN), any::<i32>()])),
    ) {
        thread_local!(static SPECIMENS: Vec<(Format, Vec<u8>)> = specimens());
        let (format, mut bytes) = SPECIMENS.with(|all| all[which % all.len()].clone());
        let place = |share: f64, length: usize| (share * length as f64) as usize;
        for (share, byte) in edits {
            let i = place(share, bytes.len());
            bytes[i] = byte;
        }
        if let Some((share, word)) = word {
            let i = place(share, bytes.len() - 4);
            bytes[i..i + 4].copy_from_slice(&word.to_le_bytes());
        }
        if let Some(share) = cut {
            bytes.truncate(place(share, bytes.len()));
        }
        match decode_bytes(format, &bytes) {
            Ok(film) => prop_assert_eq!(film.pixels.len() as u64, u64::from(film.width) * u64::from(film.height)),
            Err(line) => {
                let line = ImageError::new(Path::new("a"), line).to_string();
                prop_assert!(!line.contains('\n') && line.len() < 400, "{}", line);
            }
        }
    }
}

#[test]
fn codes_in_memory_are_those_of_a_png_file() {
    let film = extreme_film(13, 9);
    let pixel = |x: u32, y: u32| film.pixels[(y * 13 + x) as usize];
    let picture = Picture { width: 13, height: 9, pixel: &pixel };
    let encoding = Encoding { exposure: 0.5, tone: Tone::default(), seed: 3, note: None };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    write_picture(&path, &picture, &encoding).unwrap();
    assert_eq!(super::codes(&picture, &encoding).as_flattened(), codes(&path));
}

/// PNG holds the colour of what covers a pixel, TIFF what it adds to the pixel; both tell how much it covers.
#[test]
fn alpha_is_written_as_each_format_has_it() {
    let half = Rgba { color: Rgb::new(0.25, 0.0, 0.5), alpha: 0.5 };
    let pixels =
        [half, Rgba { color: Rgb::ZERO, alpha: 0.0 }, Rgba { color: Rgb::splat(f32::NAN), alpha: 0.5 }];
    let pixel = |x: u32, _| pixels[x as usize];
    let picture = Picture { width: 3, height: 1, pixel: &pixel };
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    for name in ["a.png", "a.tif", "a.exr"] {
        write_transparent(&path(name), &picture, &Encoding::default()).unwrap();
    }
    let png = fs::read(path("a.png")).unwrap();
    let mut reader = ::png::Decoder::new(Cursor::new(png)).read_info().unwrap();
    assert_eq!(reader.output_color_type(), (::png::ColorType::Rgba, ::png::BitDepth::Eight));
    // Linear 0.5 is code 188 of sRGB.
    let row = reader.next_row().unwrap().unwrap().data().to_vec();
    assert_eq!(row, [188, 0, 255, 128, 0, 0, 0, 0, 255, 0, 255, 255]);
    assert_eq!(codes_with_alpha(&picture, &Encoding::default()).as_flattened(), row);
    let tif = fs::read(path("a.tif")).unwrap();
    let mut decoder = ::tiff::decoder::Decoder::new(Cursor::new(tif)).unwrap();
    // Associated alpha.
    let extra = decoder.get_tag_u16_vec(::tiff::tags::Tag::ExtraSamples).unwrap();
    assert_eq!(extra, [1]);
    let ::tiff::decoder::DecodingResult::F32(samples) = decoder.read_image().unwrap() else { panic!() };
    assert_eq!((&samples[..8], samples[11]), (&[0.25, 0.0, 0.5, 0.5, 0.0, 0.0, 0.0, 0.0][..], 0.5));
    for name in ["a.tif", "a.exr"] {
        assert_eq!(read(&path(name)).unwrap().pixels[..2], [half.color, Rgb::ZERO], "{name}");
    }
    assert!(write_transparent(&path("a.pfm"), &picture, &Encoding::default()).is_err());
}
