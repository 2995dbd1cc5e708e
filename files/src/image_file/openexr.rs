//! `OpenEXR`: writes linear `f32` with lossless ZIP compression; reads any flat image in scan lines or tiles.

use super::encoding::NOTE;
use super::layers::{self, Layer};
use super::limits::{Seekable, check_expansion, check_size, told};
use super::opened::{Opened, RowSource};
use super::samples::Sample;
use exr::block::reader::ChunksReader;
use exr::block::writer::ChunksWriter;
use exr::block::{BlockIndex, UncompressedBlock};
use exr::image::write::channels::{ChannelsWriter, WritableChannels};
use exr::meta::attribute::{AttributeValue, SampleType, Text};
use exr::meta::header::{Header, LayerAttributes};
use exr::meta::{BlockDescription, MetaData};
use exr::prelude::{
    Compression, Encoding, Image, Layer as ExrLayer, SpecificChannels, Vec2, WritableImage, f16,
};
use rayon::prelude::*;
use scene::settings::MAX_SIDE;
use scene::{Picture, Rgb, Rgba};
use std::collections::BTreeSet;
use std::io::{self, SeekFrom, Write};

/// Target number of rows that are decoded at once; at least one row of blocks is.
const ROWS_AT_ONCE: usize = 64;

/// The best compression ratio: deflate encodes 258 bytes in at least 2 bits, and PXR24 drops a quarter before that.
const MOST_BYTES_PER_BYTE: u64 = 1032 * 4 / 3;
/// The same for DWA, which keeps two bytes of a constant block of 8x8 `f32` and deflates those.
const MOST_BYTES_PER_BYTE_DWA: u64 = 1032 * 128;

/// An image may have at most this many times the pixels of its display window.
const MOST_OVERSCAN: u64 = 2;
/// Smaller display windows count as this many pixels, so that small images may have any.
const SMALL_FRAME: u64 = 1 << 10;

/// ZIP over 16 lines at a time: the method that most programs write and that is read fastest.
fn encoding() -> Encoding {
    Encoding { compression: Compression::ZIP16, ..Encoding::UNCOMPRESSED }
}

/// `layer` with the note. It is the only custom attribute: several would be written in an arbitrary order.
fn noted(mut layer: LayerAttributes, note: Option<&str>) -> LayerAttributes {
    let note = note.and_then(Text::new_or_none).map(|note| (Text::from(NOTE), AttributeValue::Text(note)));
    layer.other.extend(note);
    layer
}

pub(super) fn write(
    out: &mut (impl Write + io::Seek),
    picture: &Picture<Rgb>,
    note: Option<&str>,
) -> io::Result<()> {
    let size = (picture.width as usize, picture.height as usize);
    let channels = SpecificChannels::rgb(|p: Vec2<usize>| -> (f32, f32, f32) { at(picture, p).into() });
    let layer = noted(LayerAttributes::default(), note);
    write_image(out, &Image::from_layer(ExrLayer::new(size, layer, encoding(), channels))).map_err(into_io)
}

/// Writes `R`, `G`, `B` and `A`; colours are associated, as the format has them.
pub(super) fn write_transparent(
    out: &mut (impl Write + io::Seek),
    picture: &Picture<Rgba>,
    note: Option<&str>,
) -> io::Result<()> {
    let size = (picture.width as usize, picture.height as usize);
    let channels = SpecificChannels::rgba(|p: Vec2<usize>| -> (f32, f32, f32, f32) {
        let Rgba { color, alpha } = at(picture, p);
        (color.x, color.y, color.z, alpha)
    });
    let layer = noted(LayerAttributes::default(), note);
    write_image(out, &Image::from_layer(ExrLayer::new(size, layer, encoding(), channels))).map_err(into_io)
}

/// Writes one channel `Y`, which every viewer shows, in a layer called `name`.
pub(super) fn write_values(
    out: &mut (impl Write + io::Seek),
    values: &Picture<f32>,
    name: &str,
    note: Option<&str>,
) -> io::Result<()> {
    let size = (values.width as usize, values.height as usize);
    let channels =
        SpecificChannels::build().with_channel("Y").with_pixel_fn(|p: Vec2<usize>| (at(values, p),));
    let layer = Text::new_or_none(name).map_or_else(LayerAttributes::default, LayerAttributes::named);
    let layer = noted(layer, note);
    write_image(out, &Image::from_layer(ExrLayer::new(size, layer, encoding(), channels))).map_err(into_io)
}

/// Writes the same file as the crate's own writer, but compresses blocks on the current rayon pool, as many at a time
/// as it has threads. The crate would start its own threads.
fn write_image<'a>(
    out: &mut (impl Write + io::Seek),
    image: &'a Image<ExrLayer<impl WritableChannels<'a>>>,
) -> exr::error::UnitResult {
    let headers = image.write().infer_meta_data();
    exr::block::write(out, headers, true, |meta, chunks| {
        let header = &meta.headers[0];
        let pixels = image.layer_data.channel_data.create_writer(header);
        let pack = |&(number, index): &(usize, BlockIndex)| {
            let data = pixels.extract_uncompressed_block(header, index);
            Ok((number, UncompressedBlock { index, data }.compress_to_chunk(&meta.headers)?))
        };
        let blocks: Vec<_> = meta.enumerate_ordered_header_block_indices().collect();
        for some in blocks.chunks(rayon::current_num_threads()) {
            let packed: exr::error::Result<Vec<_>> = some.par_iter().map(pack).collect();
            packed?.into_iter().try_for_each(|(number, chunk)| chunks.write_chunk(number, chunk))?;
        }
        Ok(())
    })
}

fn at<T>(picture: &Picture<T>, p: Vec2<usize>) -> T {
    picture.pixel.at(p.x() as u32, p.y() as u32)
}

pub(super) fn read_note(input: &mut (impl Seekable + ?Sized), length: u64) -> Result<Option<String>, String> {
    let meta = read_meta(input, length)?;
    let mut notes = meta.headers.iter().filter_map(|header| header.own_attributes.other.get(NOTE.as_bytes()));
    Ok(notes.find_map(|note| match note {
        AttributeValue::Text(text) => Some(text.to_string()),
        _ => None,
    }))
}

/// The names of the layers that can be read.
pub(super) fn layer_names(input: &mut (impl Seekable + ?Sized), length: u64) -> Result<Vec<String>, String> {
    Ok(layers::names(&read_meta(input, length)?.headers))
}

/// The name of the layer that is read if none is chosen.
pub(super) fn usual_layer(
    input: &mut (impl Seekable + ?Sized),
    length: u64,
) -> Result<Option<String>, String> {
    Ok(layers::usual(&read_meta(input, length)?.headers))
}

/// Opens an image, or the layer of that name.
pub(super) fn open<'a>(
    mut input: Box<dyn Seekable + 'a>,
    length: u64,
    layer: Option<&str>,
) -> Result<Opened<'a>, String> {
    let meta = read_meta(&mut input, length)?;
    let layer = layers::choose(&meta.headers, layer)?;
    let header = &meta.headers[layer.header];
    let Vec2(width, height) = header.layer_size;
    let block = match header.blocks {
        BlockDescription::Tiles(tiles) => tiles.tile_size.height(),
        BlockDescription::ScanLines => header.compression.scan_lines_per_block(),
    };
    let at_once = block * (ROWS_AT_ONCE / block).max(1);
    let held = Vec::new();
    let rows = BlockRows { input, meta, layer, width, height, at_once, held, next: 0 };
    Ok(Opened { width: width as u32, height: height as u32, sample: Sample::Float, rows: Box::new(rows) })
}

/// Reads the headers and checks all of them.
fn read_meta(input: &mut (impl Seekable + ?Sized), length: u64) -> Result<MetaData, String> {
    let meta = MetaData::read_from_buffered(input, false).map_err(|e| problem(&e))?;
    meta.headers.iter().try_for_each(|header| check_header(header, length))?;
    Ok(meta)
}

/// The rows of a layer, decoded some blocks at a time, on all threads.
struct BlockRows<'a> {
    input: Box<dyn Seekable + 'a>,
    meta: MetaData,
    layer: Layer,
    width: usize,
    height: usize,
    /// Rows that are decoded together: whole blocks.
    at_once: usize,
    /// The rows that are decoded, among which `next` is unless it is the first of the next ones.
    held: Vec<Rgb>,
    next: usize,
}

impl RowSource for BlockRows<'_> {
    fn read(&mut self, pixels: &mut [Rgb]) -> Result<(), String> {
        for row in pixels.chunks_exact_mut(self.width) {
            if self.next.is_multiple_of(self.at_once) {
                self.hold().map_err(|e| problem(&e))?;
            }
            row.copy_from_slice(&self.held[self.next % self.at_once * self.width..][..self.width]);
            self.next += 1;
        }
        Ok(())
    }
}

impl BlockRows<'_> {
    /// Decodes the rows from `next` on.
    fn hold(&mut self) -> exr::error::Result<()> {
        let rows = self.next..self.height.min(self.next + self.at_once);
        self.held.clear();
        self.held.resize(rows.len() * self.width, Rgb::ZERO);
        self.input.seek(SeekFrom::Start(0))?;
        let is_wanted = |block: &BlockIndex| {
            let Vec2(_, top) = block.pixel_position;
            block.layer == self.layer.header && block.level == Vec2(0, 0) && rows.contains(&top)
        };
        let reader = exr::block::read(&mut self.input, false)?;
        let mut chunks = reader.filter_chunks(false, |_, _, block| is_wanted(&block))?;
        let mut places = BTreeSet::new();
        loop {
            let some: Vec<_> =
                chunks.by_ref().take(rayon::current_num_threads()).collect::<Result<_, _>>()?;
            if some.is_empty() {
                break;
            }
            let unpack = |chunk| UncompressedBlock::decompress_chunk(chunk, &self.meta, false);
            let blocks: Vec<_> = some.into_par_iter().map(unpack).collect::<Result<_, _>>()?;
            // A damaged table may lead to other blocks.
            for block in blocks.iter().filter(|block| is_wanted(&block.index)) {
                places.insert((block.index.pixel_position.x(), block.index.pixel_position.y()));
                copy(
                    block,
                    &self.meta.headers[self.layer.header],
                    self.layer.channels,
                    &mut self.held,
                    self.width,
                    rows.start,
                );
            }
        }
        if places.len() == chunks.expected_chunk_count() {
            return Ok(());
        }
        Err(exr::error::Error::Invalid("table of blocks".into()))
    }
}

/// Copies the channels of a block into `pixels`, rows of `width` of which the first is row `top` of the image.
fn copy(
    block: &UncompressedBlock,
    header: &Header,
    channels: [usize; 3],
    pixels: &mut [Rgb],
    width: usize,
    top: usize,
) {
    for line in block.lines(&header.channels) {
        let Vec2(x, y) = line.location.position;
        let row = &mut pixels[(y - top) * width + x..][..line.location.sample_count];
        let kind = header.channels.list[line.location.channel].sample_type;
        for (colour, _) in channels.iter().enumerate().filter(|(_, number)| **number == line.location.channel)
        {
            for (pixel, bytes) in row.iter_mut().zip(line.value.chunks_exact(kind.bytes_per_sample())) {
                pixel[colour] = sample(kind, bytes);
            }
        }
    }
}

/// A sample in the machine's byte order.
fn sample(kind: SampleType, bytes: &[u8]) -> f32 {
    let word = || std::array::from_fn(|k| bytes[k]);
    match kind {
        SampleType::F16 => f16::from_bits(u16::from_ne_bytes([bytes[0], bytes[1]])).to_f32(),
        SampleType::F32 => f32::from_ne_bytes(word()),
        SampleType::U32 => u32::from_ne_bytes(word()) as f32,
    }
}

/// Rejects deep images, and headers whose image could not fit into the file.
fn check_header(header: &Header, length: u64) -> Result<(), String> {
    if header.deep {
        return Err("is a deep image; it must be a flat one".into());
    }
    let (width, height) = (header.layer_size.width() as u64, header.layer_size.height() as u64);
    check_size(width, height)?;
    if let BlockDescription::Tiles(tiles) = header.blocks {
        let (x, y) = (tiles.tile_size.width(), tiles.tile_size.height());
        if x.max(y) > MAX_SIDE as usize || x.min(y) == 0 {
            return Err(format!("has tiles of {x} x {y} pixels; each side must be from 1 to {MAX_SIDE}"));
        }
    }
    // If the image is far larger than its display window, one of the two is corrupt. Reject it, so that a single
    // corrupt number cannot lead to a large allocation.
    let frame = header.shared_attributes.display_window.size.area() as u64;
    if width * height > MOST_OVERSCAN * frame.max(SMALL_FRAME) {
        return Err(format!(
            "has {width} x {height} pixels for a display window of {frame}; one of them is wrong"
        ));
    }
    let bytes: u64 = header.channels.list.iter().map(|c| c.sample_type.bytes_per_sample() as u64).sum();
    let most = match header.compression {
        Compression::DWAA(_) | Compression::DWAB(_) => MOST_BYTES_PER_BYTE_DWA,
        _ => MOST_BYTES_PER_BYTE,
    };
    check_expansion(width * height * bytes, length, most)
}

fn problem(e: &exr::error::Error) -> String {
    told("EXR", e)
}

fn into_io(e: exr::error::Error) -> io::Error {
    match e {
        exr::error::Error::Io(e) => e,
        other => io::Error::other(other),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn header(width: usize, height: usize, compression: Compression) -> Header {
        use exr::meta::attribute::{ChannelDescription, Text};
        let channel = ChannelDescription::new(Text::from("Y"), SampleType::F32, true);
        let header = Header::new(Text::from("image"), (width, height), std::iter::once(channel).collect());
        Header { compression, ..header }
    }

    /// What is compressed as far as the format can is read, and what claims more is not.
    #[test]
    fn files_hold_what_they_announce() {
        let pixels = 1 << 20;
        for (compression, most) in [
            (Compression::ZIP16, MOST_BYTES_PER_BYTE),
            (Compression::DWAA(None), MOST_BYTES_PER_BYTE_DWA),
            (Compression::DWAB(None), MOST_BYTES_PER_BYTE_DWA),
        ] {
            let header = header(1 << 10, 1 << 10, compression);
            let least = 4 * pixels / most;
            assert!(check_header(&header, least).is_ok(), "{compression:?}");
            assert!(check_header(&header, least - 1).is_err(), "{compression:?}");
        }
    }

    /// One of the two windows may be corrupt; but of small ones each may have any size.
    #[test]
    fn images_may_be_larger_than_what_is_shown_of_them() {
        let told = |side: usize, shown: usize| {
            let mut header = header(side, side, Compression::ZIP16);
            header.shared_attributes.display_window.size = Vec2(shown, shown);
            check_header(&header, 1 << 30).err()
        };
        assert_eq!([told(45, 4), told(45, 32), told(56, 40)], [None, None, None]);
        for (side, shown) in [(46, 4), (46, 32), (57, 40)] {
            let frame = shown * shown;
            let expected =
                format!("has {side} x {side} pixels for a display window of {frame}; one of them is wrong");
            assert_eq!(told(side, shown), Some(expected));
        }
    }

    #[test]
    fn deep_images_are_refused() {
        let header = Header { deep: true, ..header(4, 4, Compression::ZIP16) };
        assert_eq!(check_header(&header, 1 << 30).unwrap_err(), "is a deep image; it must be a flat one");
    }

    /// By the method that most programs write.
    #[test]
    fn what_is_written_is_compressed() {
        let pixel = |_, _| Rgb::ONE;
        let mut bytes = io::Cursor::new(Vec::new());
        write(&mut bytes, &Picture { width: 64, height: 64, pixel: &pixel }, None).unwrap();
        let bytes = bytes.into_inner();
        let meta = MetaData::read_from_buffered(&bytes[..], false).unwrap();
        assert_eq!(meta.headers[0].compression, Compression::ZIP16);
        assert!(bytes.len() < 64 * 64 * 12 / 4, "{}", bytes.len());
    }
}
