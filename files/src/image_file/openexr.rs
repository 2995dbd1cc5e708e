//! `OpenEXR`: writes linear `f32` with lossless ZIP compression; reads any flat image in scan lines or tiles.

use super::encoding::NOTE;
use super::limits::{Seekable, check_expansion, check_size};
use crate::atomic_file::reason;
use exr::block::writer::ChunksWriter;
use exr::block::{BlockIndex, UncompressedBlock};
use exr::image::write::channels::{ChannelsWriter, WritableChannels};
use exr::meta::attribute::{AttributeValue, ChannelDescription, Text};
use exr::meta::header::{Header, LayerAttributes};
use exr::meta::{BlockDescription, MetaData};
use exr::prelude::{
    Compression, Encoding, Image, Layer, ReadChannels, ReadLayers, ReadSpecificChannel, SpecificChannels,
    Vec2, WritableImage,
};
use rayon::prelude::*;
use scene::settings::MAX_SIDE;
use scene::{Film, Picture, Rgb};
use std::io::{self, SeekFrom, Write};

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
    write_image(out, &Image::from_layer(Layer::new(size, layer, encoding(), channels))).map_err(into_io)
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
    write_image(out, &Image::from_layer(Layer::new(size, layer, encoding(), channels))).map_err(into_io)
}

/// Writes the same file as the crate's own writer, but compresses blocks on the current rayon pool, as many at a time
/// as it has threads. The crate would start its own threads.
fn write_image<'a>(
    out: &mut (impl Write + io::Seek),
    image: &'a Image<Layer<impl WritableChannels<'a>>>,
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
    (picture.pixel)(p.x() as u32, p.y() as u32)
}

pub(super) fn read_note(input: &mut impl Seekable, length: u64) -> Result<Option<String>, String> {
    let meta = MetaData::read_from_buffered(&mut *input, false).map_err(|e| problem(&e))?;
    for header in &meta.headers {
        check_header(header, length)?;
    }
    let mut notes = meta.headers.iter().filter_map(|header| header.own_attributes.other.get(NOTE.as_bytes()));
    Ok(notes.find_map(|note| match note {
        AttributeValue::Text(text) => Some(text.to_string()),
        _ => None,
    }))
}

pub(super) fn read(input: &mut impl Seekable, length: u64) -> Result<Film, String> {
    let channels =
        inspect(&MetaData::read_from_buffered(&mut *input, false).map_err(|e| problem(&e))?, length)?;
    input.seek(SeekFrom::Start(0)).map_err(|e| e.to_string())?;
    match channels {
        Channels::Rgb => read_rgb(input),
        Channels::Grey(name) => read_grey(input, name),
    }
    .map_err(|e| problem(&e))
}

fn read_rgb(input: &mut impl Seekable) -> exr::error::Result<Film> {
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .specific_channels()
        .required("R")
        .required("G")
        .required("B")
        .collect_pixels(black, |film, p, rgb: (f32, f32, f32)| set(film, p, rgb.into()))
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(input)?;
    Ok(image.layer_data.channel_data.pixels)
}

fn read_grey(input: &mut impl Seekable, name: Text) -> exr::error::Result<Film> {
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .specific_channels()
        .required(name)
        .collect_pixels(black, |film, p, (y,): (f32,)| set(film, p, Rgb::splat(y)))
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(input)?;
    Ok(image.layer_data.channel_data.pixels)
}

fn black<T>(size: Vec2<usize>, _: &T) -> Film {
    Film::new(size.width() as u32, size.height() as u32)
}

fn set(film: &mut Film, p: Vec2<usize>, pixel: Rgb) {
    film.pixels[p.y() * film.width as usize + p.x()] = pixel;
}

/// The channels to read.
enum Channels {
    Rgb,
    Grey(Text),
}

/// Checks the headers and selects the channels to read.
fn inspect(meta: &MetaData, length: u64) -> Result<Channels, String> {
    for header in &meta.headers {
        check_header(header, length)?;
    }
    let has = |h: &Header, name: &str| h.channels.list.iter().any(|c| c.name.eq(name));
    // The first suitable layer, which is the one that the crate's reader picks.
    let first = |needed: &[&str]| meta.headers.iter().find(|h| needed.iter().all(|name| has(h, name)));
    let (layer, channels) = if let Some(layer) = first(&["R", "G", "B"]) {
        (layer, Channels::Rgb)
    } else if let Some(layer) = first(&["Y"]).filter(|h| !has(h, "RY") && !has(h, "BY")) {
        (layer, Channels::Grey(Text::from("Y")))
    } else if let [layer] = &meta.headers[..]
        && let [only] = &layer.channels.list[..]
    {
        (layer, Channels::Grey(only.name.clone()))
    } else {
        let names = names(meta);
        return Err(format!(
            "has channels {names}; it must have R, G and B, or Y without RY and BY, or a single one"
        ));
    };
    whole(&layer.channels.list)?;
    Ok(channels)
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

/// Rejects subsampled channels: the decoder assumes one sample per pixel.
fn whole(channels: &[ChannelDescription]) -> Result<(), String> {
    match channels.iter().find(|c| c.sampling != Vec2(1, 1)) {
        Some(c) => {
            let name = shown(&c.name);
            Err(format!("has a subsampled channel {name}; each must have a sample for every pixel"))
        }
        None => Ok(()),
    }
}

/// The names of the first channels, for messages.
fn names(meta: &MetaData) -> String {
    const MOST: usize = 12;
    let all = || meta.headers.iter().flat_map(|h| &h.channels.list);
    let names: Vec<String> = all().take(MOST).map(|c| shown(&c.name)).collect();
    let more = if all().nth(MOST).is_some() { ", and more" } else { "" };
    format!("{}{more}", names.join(", "))
}

/// A channel's name for messages: shortened, and escaped so that the message stays on one line.
fn shown(name: &Text) -> String {
    const LONGEST: usize = 20;
    name.to_string().chars().take(LONGEST).flat_map(char::escape_debug).collect()
}

fn problem(e: &exr::error::Error) -> String {
    format!("is no EXR file that can be read: {}", reason(e))
}

fn into_io(e: exr::error::Error) -> io::Error {
    match e {
        exr::error::Error::Io(e) => e,
        other => io::Error::other(other),
    }
}
