//! Tests of the formats that other programs write: HDR, TIFF, JPEG, WebP and QOI.

use super::{bits, byte_film, crc32, extreme_film, folder, png_bytes, problem};
use crate::image_file::{Encoding, Format, ImageReader, decode_bytes, layer_names, read, write, write_plane};
use image::ImageEncoder;
use image::codecs::{qoi::QoiEncoder, webp::WebPEncoder};
use scene::{Film, Plane, Rgb, RowReader, srgb};
use std::fs;

/// Of the brightest channel of a pixel: half a step of 8 bits that are at least 128.
const HDR_ERROR: f32 = 1.0 / 256.0;
/// The same where a writer rounds down.
const HDR_TRUNCATED: f32 = 2.0 * HDR_ERROR;
/// In codes of 255. At quality 95 a smooth picture is off by less.
const JPEG_ERROR: f64 = 6.0;
/// In codes of 255, for the fixtures, which other programs compressed strongly.
const LOSSY_ERROR: f64 = 30.0;

/// 24 rows of 20 pixels whose codes are `(5 (x + y), 10 y, 12 x)`.
fn slopes() -> Film {
    let value = |code: u32| srgb::decode_code(code as u16, 255);
    Film::from_fn(20, 24, |x, y| Rgb::new(value(5 * (x + y)), value(10 * y), value(12 * x)))
}

/// The largest difference of the sRGB codes.
fn worst_code(a: &Film, b: &Film) -> f64 {
    assert_eq!((a.width, a.height), (b.width, b.height));
    let code = |v: f32| 255.0 * srgb::encode(v.into());
    let values =
        |film: &Film| film.pixels.iter().flat_map(scene::Vec3::to_array).map(code).collect::<Vec<_>>();
    values(a).iter().zip(values(b)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// The 8-bit codes of a film.
fn codes(film: &Film) -> Vec<u8> {
    film.pixels.iter().flat_map(scene::Vec3::to_array).map(|v| srgb::encode_byte(v.into())).collect()
}

fn written(film: &Film, name: &str) -> Vec<u8> {
    let folder = folder();
    let path = folder.path().join(name);
    write(&path, film, &Encoding::default()).unwrap();
    fs::read(path).unwrap()
}

pub(super) fn webp() -> Vec<u8> {
    let (film, mut bytes) = (slopes(), Vec::new());
    let encoder = WebPEncoder::new_lossless(&mut bytes);
    encoder.encode(&codes(&film), 20, 24, image::ExtendedColorType::Rgb8).unwrap();
    bytes
}

pub(super) fn qoi() -> Vec<u8> {
    let (film, mut bytes) = (slopes(), Vec::new());
    let encoder = QoiEncoder::new(&mut bytes);
    encoder.write_image(&codes(&film), 20, 24, image::ExtendedColorType::Rgb8).unwrap();
    bytes
}

pub(super) const LOSSY_WEBP: &[u8] = include_bytes!("lossy.webp");
pub(super) const PROGRESSIVE_JPEG: &[u8] = include_bytes!("progressive.jpg");

#[test]
fn tiff_keeps_every_bit() {
    for (width, height) in [(1, 1), (7, 3), (1, 100), (100, 1), (300, 70), (9000, 3)] {
        let film = extreme_film(width, height);
        let read = decode_bytes(Format::Tiff, &written(&film, "a.tif")).unwrap();
        assert_eq!(bits(&read), bits(&film), "{width} x {height}");
    }
}

#[test]
fn hdr_keeps_eight_bits() {
    for (width, height) in [(1, 1), (7, 3), (8, 5), (300, 7), (40_000, 1)] {
        let film = Film::from_fn(width, height, |x, y| {
            let scale = (f64::from((x * 7 + y) % 120) - 60.0).exp2() as f32;
            Rgb::new(1.0 + x as f32 % 5.0, 0.7, (y % 3) as f32 * 0.01) * scale
        });
        let read = decode_bytes(Format::Hdr, &written(&film, "a.hdr")).unwrap();
        assert_eq!((read.width, read.height), (width, height));
        for (a, b) in film.pixels.iter().zip(&read.pixels) {
            let error = (*a - *b).abs().max_element();
            assert!(error <= HDR_ERROR * a.max_element(), "{a} became {b}");
        }
    }
}

#[test]
fn hdr_holds_what_is_out_of_its_range_as_near_as_it_can() {
    let pixels = vec![
        Rgb::new(-1.0, 2.0, f32::NAN),
        Rgb::splat(f32::INFINITY),
        Rgb::splat(1e-45),
        Rgb::new(f32::MAX, 0.0, -0.0),
    ];
    let film = Film { width: 4, height: 1, pixels };
    let read = decode_bytes(Format::Hdr, &written(&film, "a.hdr")).unwrap();
    let greatest = 255.0 * 119_f32.exp2();
    let expected = [Rgb::new(0.0, 2.0, 0.0), Rgb::splat(greatest), Rgb::ZERO, Rgb::new(greatest, 0.0, 0.0)];
    assert_eq!(read.pixels, expected);
}

#[test]
fn jpeg_shows_what_png_does() {
    let film = slopes();
    let read = decode_bytes(Format::Jpeg, &written(&film, "a.jpeg")).unwrap();
    let worst = worst_code(&read, &film);
    assert!(worst > 0.0 && worst <= JPEG_ERROR, "{worst}");
    let folder = folder();
    let path = folder.path().join("a.jpg");
    let brighter = Encoding { exposure: 1.0, ..Encoding::default() };
    write(&path, &film, &brighter).unwrap();
    let doubled = Film { pixels: film.pixels.iter().map(|&p| p * 2.0).collect(), ..film };
    assert!(worst_code(&crate::image_file::read(&path).unwrap(), &doubled) <= JPEG_ERROR);
}

#[test]
fn planes_are_written_as_grey() {
    let folder = folder();
    let plane = Plane { width: 4, height: 1, values: vec![0.0, 1.0, 4.0, 2.0] };
    for name in ["a.tif", "a.hdr", "a.jpg"] {
        let path = folder.path().join(name);
        write_plane(&path, &plane, "radius", &Encoding::default()).unwrap();
        let film = read(&path).unwrap();
        if name == "a.jpg" {
            let shares =
                Film { pixels: plane.to_film().pixels.iter().map(|&p| p / 4.0).collect(), ..plane.to_film() };
            assert!(worst_code(&film, &shares) <= JPEG_ERROR, "{:?}", film.pixels);
        } else {
            assert_eq!(bits(&film), bits(&plane.to_film()), "{name}");
        }
    }
}

#[test]
fn lossless_formats_are_read_exactly() {
    for (format, bytes) in [(Format::WebP, webp()), (Format::Qoi, qoi())] {
        assert_eq!(bits(&decode_bytes(format, &bytes).unwrap()), bits(&slopes()), "{format:?}");
    }
}

#[test]
fn lossy_files_of_other_programs_are_read() {
    for (format, bytes) in [(Format::WebP, LOSSY_WEBP), (Format::Jpeg, PROGRESSIVE_JPEG)] {
        let worst = worst_code(&decode_bytes(format, bytes).unwrap(), &slopes());
        assert!(worst <= LOSSY_ERROR, "{format:?}: {worst}");
    }
}

/// The inputs of the fuzz targets, which `OpenCV` wrote.
#[test]
fn files_of_opencv_are_read() {
    let seeds = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../fuzz/seeds");
    let linear = Film::from_fn(20, 24, |x, y| {
        Rgb::new(5.0 * (x + y) as f32, 10.0 * y as f32, 12.0 * x as f32) / 255.0
    });
    for name in ["tiff/lzw8.tif", "tiff/lzw16.tif", "webp/lossless.webp", "qoi/slopes.qoi"] {
        assert_eq!(bits(&read(&seeds.join(name)).unwrap()), bits(&slopes()), "{name}");
    }
    assert!(worst_code(&read(&seeds.join("jpeg/baseline.jpg")).unwrap(), &slopes()) <= LOSSY_ERROR);
    for (name, most) in [("tiff/float.tif", 0.0), ("hdr/slopes.hdr", HDR_TRUNCATED)] {
        let film = read(&seeds.join(name)).unwrap();
        let worst = film
            .pixels
            .iter()
            .zip(&linear.pixels)
            .map(|(a, b)| (*a - *b).abs().max_element() / b.max_element().max(1e-3));
        let worst = worst.fold(0.0, f32::max);
        assert!(worst <= most + f32::EPSILON, "{name}: {worst}");
    }
}

#[test]
fn the_content_decides_and_not_the_name() {
    let folder = folder();
    for (name, bytes) in [
        ("a.png", webp()),
        ("b.exr", qoi()),
        ("c", written(&slopes(), "a.png")),
        ("d.jpg", written(&slopes(), "a.tif")),
        ("e.pfm", written(&slopes(), "a.exr")),
        ("f.txt", written(&slopes(), "a.pfm")),
    ] {
        let path = folder.path().join(name);
        fs::write(&path, bytes).unwrap();
        assert_eq!(bits(&read(&path).unwrap()), bits(&slopes()), "{name}");
    }
    let path = folder.path().join("note.txt");
    fs::write(&path, "not a picture").unwrap();
    let line = problem(read(&path));
    assert!(line.contains("is no image: neither PNG, JPEG"), "{line}");
}

#[test]
fn what_cannot_be_written_says_why() {
    let folder = folder();
    for (name, says) in [
        ("a.webp", "WebP, which can be read but not written"),
        ("a.qoi", "QOI, which can be read but not written"),
        ("a.gif", ".gif; it must be .png"),
    ] {
        let line = problem(write(&folder.path().join(name), &slopes(), &Encoding::default()));
        assert!(line.contains(says), "{line}");
    }
}

#[test]
fn only_exr_has_layers() {
    let folder = folder();
    let path = folder.path().join("a.tif");
    write(&path, &slopes(), &Encoding::default()).unwrap();
    let line = problem(ImageReader::open(&path, Some("diffuse")));
    assert!(line.contains("TIFF file, which has no layers"), "{line}");
    assert_eq!(layer_names(&path).unwrap(), [""; 0]);
}

#[test]
fn rows_are_those_of_the_whole_image_and_come_again() {
    let folder = folder();
    for name in ["a.png", "a.exr", "a.pfm", "a.tif", "a.hdr", "a.jpg"] {
        let path = folder.path().join(name);
        write(&path, &byte_film(37, 201), &Encoding::default()).unwrap();
        let whole = read(&path).unwrap();
        let mut reader = ImageReader::open(&path, None).unwrap();
        assert_eq!((reader.size(), reader.is_linear()), ([37, 201], !matches!(name, "a.png" | "a.jpg")));
        for _ in 0..2 {
            let mut rows = Vec::new();
            for some in [1, 100, 3, 97] {
                let mut part = vec![Rgb::ZERO; 37 * some];
                reader.read(&mut part).unwrap();
                rows.extend(part);
            }
            assert!(rows == whole.pixels, "{name}");
            reader.rewind().unwrap();
        }
    }
}

/// Radiance is compared otherwise than codes of sRGB, and of 16 bits otherwise than of 8.
#[test]
fn what_a_file_stores_is_told() {
    let seeds = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../fuzz/seeds");
    let folder = folder();
    let wide = folder.path().join("wide.png");
    let (grey, sixteen) = (png::ColorType::Grayscale, png::BitDepth::Sixteen);
    fs::write(&wide, png_bytes(grey, sixteen, 1, &[0x12, 0x34], &[])).unwrap();
    for (path, samples) in [
        (wide, "16 bits of sRGB"),
        (seeds.join("tiff/lzw8.tif"), "8 bits of sRGB"),
        (seeds.join("tiff/lzw16.tif"), "16 bits of sRGB"),
        (seeds.join("tiff/float.tif"), "linear floats"),
        (seeds.join("hdr/slopes.hdr"), "linear floats"),
        (seeds.join("qoi/slopes.qoi"), "8 bits of sRGB"),
    ] {
        let reader = ImageReader::open(&path, None).unwrap();
        assert_eq!(reader.samples().to_string(), samples, "{}", path.display());
        assert_eq!(reader.is_linear(), samples == "linear floats", "{}", path.display());
    }
}

/// Some faults show only when rows are read: of two images that are compared, it is told whose they are.
#[test]
fn faults_among_the_rows_are_told_of_their_file() {
    let folder = folder();
    for name in ["a.png", "a.exr"] {
        let path = folder.path().join(name);
        let whole = written(&byte_film(37, 201), name);
        fs::write(&path, &whole[..whole.len() - 100]).unwrap();
        let mut reader = ImageReader::open(&path, None).unwrap();
        let line = reader.read(&mut vec![Rgb::ZERO; 37 * 201]).unwrap_err();
        assert!(line.starts_with(&format!("{}: is no ", path.display())), "{line}");
    }
}

/// As where the image of a render that goes on is compared.
#[test]
fn an_image_that_is_replaced_by_one_of_another_size_is_not_read_on() {
    let folder = folder();
    let path = folder.path().join("a.pfm");
    write(&path, &byte_film(4, 3), &Encoding::default()).unwrap();
    let mut reader = ImageReader::open(&path, None).unwrap();
    write(&path, &slopes(), &Encoding::default()).unwrap();
    let line = reader.rewind().unwrap_err();
    assert!(line.contains("a.pfm: was replaced by an image of another size"), "{line}");
    // One of the same size is read anew.
    reader.rewind().unwrap();
    write(&path, &byte_film(20, 24), &Encoding::default()).unwrap();
    reader.rewind().unwrap();
    let mut pixels = vec![Rgb::ZERO; 480];
    reader.read(&mut pixels).unwrap();
    assert!(pixels == byte_film(20, 24).pixels);
}

/// The bytes of a PNG file in the passes of Adam7, which the `png` crate does not write: 8-bit RGB, in blocks that are not
/// compressed.
fn interlaced(film: &Film) -> Vec<u8> {
    /// Of each pass: the first column and row, and the steps between columns and rows.
    const PASSES: [[usize; 4]; 7] =
        [[0, 0, 8, 8], [4, 0, 8, 8], [0, 4, 4, 8], [2, 0, 4, 4], [0, 2, 2, 4], [1, 0, 2, 2], [0, 1, 1, 2]];
    let (width, height) = (film.width as usize, film.height as usize);
    let mut raw = Vec::new();
    for [left, top, across, down] in PASSES.into_iter().filter(|[left, ..]| *left < width) {
        for y in (top..height).step_by(down) {
            raw.push(0); // no filter
            for x in (left..width).step_by(across) {
                raw.extend(film.pixels[y * width + x].to_array().map(|v| srgb::encode_byte(v.into())));
            }
        }
    }
    let mut stream = vec![0x78, 0x01];
    let blocks = raw.chunks(0xffff);
    let last = blocks.len() - 1;
    for (number, block) in blocks.enumerate() {
        let length = block.len() as u16;
        stream.push(u8::from(number == last));
        stream.extend(length.to_le_bytes());
        stream.extend((!length).to_le_bytes());
        stream.extend(block);
    }
    let (a, b) = raw.iter().fold((1, 0), |(a, b), &byte| {
        let a = (a + u32::from(byte)) % 65521;
        (a, (b + a) % 65521)
    });
    stream.extend((b << 16 | a).to_be_bytes());
    let mut bytes = b"\x89PNG\r\n\x1a\n".to_vec();
    let header = [film.width.to_be_bytes(), film.height.to_be_bytes()].concat();
    for (name, content) in
        [(b"IHDR", [&header[..], &[8, 2, 0, 0, 1]].concat()), (b"IDAT", stream), (b"IEND", vec![])]
    {
        let named = [&name[..], &content].concat();
        bytes.extend((content.len() as u32).to_be_bytes());
        bytes.extend(&named);
        bytes.extend(crc32(&named).to_be_bytes());
    }
    bytes
}

#[test]
fn interlaced_png_files_are_read_by_rows_too() {
    let folder = folder();
    let path = folder.path().join("a.png");
    let film = byte_film(37, 21);
    fs::write(&path, interlaced(&film)).unwrap();
    assert_eq!(bits(&read(&path).unwrap()), bits(&film));
    let mut reader = ImageReader::open(&path, None).unwrap();
    let mut rows = Vec::new();
    for some in [1, 7, 13] {
        let mut part = vec![Rgb::ZERO; 37 * some];
        reader.read(&mut part).unwrap();
        rows.extend(part);
    }
    assert!(rows == film.pixels);
}

#[test]
fn a_cut_jpeg_is_refused_even_if_its_thumbnail_is_whole() {
    let whole = written(&slopes(), "a.jpg");
    // A segment with application data that holds a whole JPEG file.
    let mut with_thumbnail = whole[..2].to_vec();
    with_thumbnail.extend([0xff, 0xe5]);
    with_thumbnail.extend(u16::try_from(whole.len() + 2).unwrap().to_be_bytes());
    with_thumbnail.extend(&whole);
    with_thumbnail.extend(&whole[2..]);
    for bytes in [whole, with_thumbnail] {
        decode_bytes(Format::Jpeg, &bytes).unwrap();
        for length in [bytes.len() - 1, bytes.len() - 50, bytes.len() - 200] {
            let line = decode_bytes(Format::Jpeg, &bytes[..length]).unwrap_err();
            assert!(line.contains("ends too early"), "{line}");
        }
    }
}

/// The stored JPEG with EXIF metadata that state an orientation.
fn turned(orientation: u8) -> Vec<u8> {
    let whole = written(&slopes(), "a.jpg");
    let exif = [
        b"Exif\0\0II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0".as_slice(),
        &[orientation, 0, 0, 0, 0, 0, 0, 0],
    ]
    .concat();
    let length = u16::try_from(exif.len() + 2).unwrap().to_be_bytes();
    [&whole[..2], &[0xff, 0xe1], &length, &exif, &whole[2..]].concat()
}

#[test]
fn a_turned_jpeg_is_shown_upright() {
    let stored = decode_bytes(Format::Jpeg, &turned(1)).unwrap();
    let (w, h) = (stored.width as usize, stored.height as usize);
    let at = |x: usize, y: usize| stored.pixels[y * w + x];
    // The meaning of the EXIF values, in terms of where the stored row 0 and column 0 are shown.
    for orientation in 1..=8 {
        let film = decode_bytes(Format::Jpeg, &turned(orientation)).unwrap();
        let is_on_its_side = orientation > 4;
        assert_eq!((film.width, film.height), if is_on_its_side { (24, 20) } else { (20, 24) });
        for (i, pixel) in film.pixels.iter().enumerate() {
            let (x, y) = (i % film.width as usize, i / film.width as usize);
            let expected = match orientation {
                1 => at(x, y),
                2 => at(w - 1 - x, y),         // column 0 at the right
                3 => at(w - 1 - x, h - 1 - y), // row 0 at the bottom, column 0 at the right
                4 => at(x, h - 1 - y),         // row 0 at the bottom
                5 => at(y, x),                 // row 0 at the left, column 0 at the top
                6 => at(y, h - 1 - x),         // row 0 at the right, column 0 at the top
                7 => at(w - 1 - y, h - 1 - x), // row 0 at the right, column 0 at the bottom
                _ => at(w - 1 - y, x),         // row 0 at the left, column 0 at the bottom
            };
            assert_eq!(*pixel, expected, "orientation {orientation}, ({x}, {y})");
        }
    }
}

/// A TIFF file with these entries, of 32 bits for places and lengths and else of 16, and `pixels` at offset 8, where strips or tiles begin.
pub(super) fn tiff(entries: &[(u16, &[u32])], pixels: &[u8]) -> Vec<u8> {
    let mut bytes = b"II*\0".to_vec();
    bytes.extend((8 + pixels.len() as u32).to_le_bytes());
    bytes.extend(pixels);
    let directory = bytes.len() + 2 + 12 * entries.len() + 4;
    let mut values = Vec::new();
    bytes.extend((entries.len() as u16).to_le_bytes());
    for (tag, all) in entries {
        let is_place = matches!(tag, 273 | 279 | 324 | 325);
        let mut field: Vec<u8> = if is_place {
            all.iter().flat_map(|v| v.to_le_bytes()).collect()
        } else {
            all.iter().flat_map(|v| (*v as u16).to_le_bytes()).collect()
        };
        bytes.extend(tag.to_le_bytes());
        bytes.extend(if is_place { 4_u16 } else { 3 }.to_le_bytes());
        bytes.extend((all.len() as u32).to_le_bytes());
        if field.len() > 4 {
            bytes.extend((directory as u32 + values.len() as u32).to_le_bytes());
            values.append(&mut field);
        } else {
            field.resize(4, 0);
            bytes.append(&mut field);
        }
    }
    bytes.extend([0; 4]);
    bytes.extend(values);
    bytes
}

/// 20 x 2 grey pixels in two tiles; see [`tiles`].
pub(super) fn tiled() -> Vec<u8> {
    tiles(2)
}

/// Rows of 20 grey pixels of 16 bits in tiles of 16 x 16, two beside each other; the value of each is `100 (x + 10 y)`.
fn tiles(height: u16) -> Vec<u8> {
    let tile = |left: u16, top: u16| {
        let value = move |i: u16| 100 * (left + i % 16 + 10 * (top + i / 16));
        (0..256).flat_map(move |i| value(i).to_le_bytes())
    };
    let tops = (0..height).step_by(16);
    let pixels: Vec<u8> = tops.flat_map(|top| tile(0, top).chain(tile(16, top))).collect();
    let places: Vec<u32> = (8..8 + pixels.len() as u32).step_by(512).collect();
    let lengths: Vec<u32> = vec![512; places.len()];
    tiff(
        &[
            (256, &[20]),
            (257, &[height.into()]),
            (258, &[16]),
            (259, &[1]),
            (262, &[1]),
            (277, &[1]),
            (322, &[16]),
            (323, &[16]),
            (324, &places),
            (325, &lengths),
        ],
        &pixels,
    )
}

/// In one row of tiles, and in several, of which the last is short.
#[test]
fn tiff_in_tiles_is_read() {
    for height in [2, 20, 40] {
        let film = decode_bytes(Format::Tiff, &tiles(height)).unwrap();
        let expected = Film::from_fn(20, height.into(), |x, y| {
            Rgb::splat(srgb::decode_code((100 * (x + 10 * y)) as u16, u16::MAX))
        });
        assert_eq!(bits(&film), bits(&expected), "{height}");
    }
}

/// A tile may be larger than its image, but not than any image, whichever side it is.
#[test]
fn tiff_tiles_are_no_larger_than_images_can_be() {
    let most = scene::settings::MAX_SIDE;
    let whole = tiled();
    // The height of tiles: tag 323, as 16 bits, and as 32 bits that are more.
    let entry = [&323_u16.to_le_bytes()[..], &[3, 0, 1, 0, 0, 0, 16, 0, 0, 0]].concat();
    let at = whole.windows(entry.len()).position(|window| window == entry).unwrap();
    for (side, is_refused) in [(most, false), (most + 1, true)] {
        let mut bytes = whole.clone();
        bytes[at + 2] = 4;
        bytes[at + 8..at + 12].copy_from_slice(&side.to_le_bytes());
        let told = format!("has tiles of {side} pixels in a side; it must be from 1 to {most}");
        assert_eq!(decode_bytes(Format::Tiff, &bytes) == Err(told), is_refused, "{side}");
    }
}

#[test]
fn tiff_of_a_plane_for_each_channel_is_refused() {
    let entries: &[(u16, &[u32])] = &[
        (256, &[2]),
        (257, &[1]),
        (258, &[8, 8, 8]),
        (259, &[1]),
        (262, &[2]),
        (273, &[8, 10, 12]),
        (277, &[3]),
        (278, &[1]),
        (279, &[2, 2, 2]),
        (284, &[2]),
    ];
    let line = decode_bytes(Format::Tiff, &tiff(entries, &[1, 2, 3, 4, 5, 6])).unwrap_err();
    assert_eq!(line, "stores each channel apart; the samples of a pixel must be together");
}

#[test]
fn tiff_of_other_kinds_is_read_or_refused_with_a_reason() {
    let strip = |kind: u32, samples: u32, bits: u32, format: u32, more: &[(u16, &[u32])], pixels: &[u8]| {
        let (bits, length) = (vec![bits; samples as usize], pixels.len() as u32);
        let format = vec![format; samples as usize];
        let mut entries: Vec<(u16, &[u32])> = vec![
            (256, &[2]),
            (257, &[1]),
            (258, &bits),
            (259, &[1]),
            (262, std::slice::from_ref(&kind)),
            (273, &[8]),
            (277, std::slice::from_ref(&samples)),
            (278, &[1]),
            (279, std::slice::from_ref(&length)),
            (339, &format),
        ];
        entries.extend(more);
        entries.sort_unstable_by_key(|(tag, _)| *tag);
        decode_bytes(Format::Tiff, &tiff(&entries, pixels))
    };
    let v = |code| srgb::decode_code(code, 255);
    let grey = |codes: [u16; 2]| codes.map(|c| Rgb::splat(v(c))).to_vec();
    let palette: Vec<u32> = (0..768).collect();
    // Black is zero, white is zero, colour with alpha, and doubles.
    assert_eq!(strip(1, 1, 8, 1, &[], &[10, 200]).unwrap().pixels, grey([10, 200]));
    assert_eq!(strip(0, 1, 8, 1, &[], &[10, 200]).unwrap().pixels, grey([245, 55]));
    let rgba = strip(2, 4, 8, 1, &[(338, &[2])], &[1, 2, 3, 0, 4, 5, 6, 9]).unwrap();
    assert_eq!(rgba.pixels, [Rgb::new(v(1), v(2), v(3)), Rgb::new(v(4), v(5), v(6))]);
    let doubles: Vec<u8> = [0.5_f64, -7.0].into_iter().flat_map(f64::to_le_bytes).collect();
    assert_eq!(strip(1, 1, 64, 3, &[], &doubles).unwrap().pixels, [Rgb::splat(0.5), Rgb::splat(-7.0)]);
    // Grey with alpha, and halves.
    assert_eq!(strip(1, 2, 8, 1, &[(338, &[2])], &[10, 0, 200, 255]).unwrap().pixels, grey([10, 200]));
    let halves: Vec<u8> = [0x3800_u16, 0xc700].into_iter().flat_map(u16::to_le_bytes).collect();
    assert_eq!(strip(1, 1, 16, 3, &[], &halves).unwrap().pixels, [Rgb::splat(0.5), Rgb::splat(-7.0)]);
    // What is turned or mirrored is not shown as if it were upright.
    assert_eq!(strip(1, 1, 8, 1, &[(274, &[1])], &[10, 200]).unwrap().pixels, grey([10, 200]));
    for orientation in 2..=8 {
        let line = strip(1, 1, 8, 1, &[(274, &[orientation])], &[1, 2]).unwrap_err();
        assert!(line.contains(&format!("orientation {orientation};")), "{line}");
    }
    for (result, says) in [
        (strip(2, 3, 8, 1, &[(284, &[2])], &[1; 6]), "inconsistent"),
        (strip(3, 1, 8, 1, &[(320, &palette)], &[1, 2]), "RGBPalette"),
        (strip(5, 4, 8, 1, &[], &[1; 8]), "CMYK"),
        (strip(1, 1, 1, 1, &[], &[1]), "Gray(1)"),
        (strip(1, 1, 32, 2, &[], &[1; 8]), "integers other than"),
    ] {
        let line = result.unwrap_err();
        assert!(line.to_lowercase().contains(&says.to_lowercase()), "{line}");
    }
}

#[test]
fn sizes_that_a_file_cannot_hold_are_refused() {
    let mut qoi = qoi();
    qoi[4..12].copy_from_slice(&[0, 0, 0x40, 0, 0, 0, 0x40, 0]); // 16384 x 16384
    let mut hdr = written(&slopes(), "a.hdr");
    let size = hdr.windows(9).position(|w| w == b"-Y 24 +X ").unwrap();
    hdr.splice(size..size + 11, *b"-Y 16384 +X 16384");
    for (format, bytes) in [(Format::Qoi, qoi), (Format::Hdr, hdr)] {
        let line = decode_bytes(format, &bytes).unwrap_err();
        assert!(line.contains("hardly hold the 268435456 pixels"), "{format:?}: {line}");
    }
    let entries: &[(u16, &[u32])] = &[
        (256, &[4096]),
        (257, &[2048]),
        (258, &[8]),
        (259, &[1]),
        (262, &[1]),
        (273, &[8]),
        (277, &[1]),
        (278, &[2048]),
        (279, &[4]),
    ];
    let line = decode_bytes(Format::Tiff, &tiff(entries, &[1, 2, 3, 4])).unwrap_err();
    assert!(line.contains("hardly hold the 8388608 pixels"), "{line}");
}
