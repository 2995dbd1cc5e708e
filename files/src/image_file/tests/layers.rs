//! Tests of EXR files with several layers, and of the names that channels have.

use super::{folder, problem};
use crate::image_file::layers::choose;
use crate::image_file::{self, Format, ImageReader, decode_bytes, layer_names, usual_layer};
use exr::math::RoundingMode;
use exr::meta::attribute::{ChannelDescription, SampleType, Text};
use exr::meta::header::Header;
use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Encoding, FlatSamples, Image, Layer, LayerAttributes, Layers, Levels,
    LineOrder, Vec2, WritableImage,
};
use scene::{Film, Rgb, RowReader};
use std::fs;
use std::io::Cursor;
use std::path::Path;

/// The name and the channels of each part of a file.
type Parts<'a> = &'a [(Option<&'a str>, &'a [&'a str])];

/// A file of 2 x 1 pixels with a part for each name and list of channels. The channels of all parts hold 1, 2, 3, ...
fn file(parts: Parts) -> Vec<u8> {
    let mut value = 0.0;
    let mut layers = Layers::new();
    for (name, channels) in parts {
        let list = channels.iter().map(|&channel| {
            value += 1.0;
            AnyChannel::new(channel, FlatSamples::F32(vec![value; 2]))
        });
        let list = list.collect::<Vec<_>>();
        let attributes = name.map_or_else(LayerAttributes::default, LayerAttributes::named);
        layers.push(Layer::new((2, 1), attributes, Encoding::UNCOMPRESSED, AnyChannels::sort(list.into())));
    }
    let mut bytes = Cursor::new(Vec::new());
    let attributes = exr::prelude::ImageAttributes::new(exr::prelude::IntegerBounds::from_dimensions((2, 1)));
    Image::from_layers(attributes, layers).write().non_parallel().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

fn first_pixel(path: &Path, layer: Option<&str>) -> Result<Rgb, String> {
    let mut reader = ImageReader::open(path, layer).map_err(|error| error.to_string())?;
    let mut pixels = [Rgb::ZERO; 2];
    reader.read(&mut pixels).map(|()| pixels[0])
}

#[test]
fn names_of_channels_may_be_in_lower_case() {
    for (channels, expected) in [
        (&["r", "g", "b"][..], Rgb::new(1.0, 2.0, 3.0)),
        (&["r", "g", "b", "a"], Rgb::new(1.0, 2.0, 3.0)),
        (&["R", "G", "B", "r", "g", "b"], Rgb::new(1.0, 2.0, 3.0)),
        (&["y"], Rgb::splat(1.0)),
        (&["Y", "A"], Rgb::splat(1.0)),
        (&["beauty.R", "beauty.G", "beauty.B"], Rgb::new(1.0, 2.0, 3.0)),
    ] {
        let film = decode_bytes(Format::Exr, &file(&[(None, channels)])).unwrap();
        assert_eq!(film.pixels, [expected; 2], "{channels:?}");
    }
}

#[test]
fn layers_are_chosen_by_name() {
    let folder = folder();
    let path = folder.path().join("a.exr");
    let colour: &[&str] = &["R", "G", "B"];
    let in_channels: &[&str] =
        &["diffuse.R", "diffuse.G", "diffuse.B", "depth.Z", "glossy.r", "glossy.g", "glossy.b"];
    // Passes of passes, as of each lamp by itself.
    let nested: &[&str] = &[
        "diffuse.key.R",
        "diffuse.key.G",
        "diffuse.key.B",
        "diffuse.fill.R",
        "diffuse.fill.G",
        "diffuse.fill.B",
    ];
    // Some programs repeat the name of a part in each of its channels.
    let again_left: &[&str] = &["left.R", "left.G", "left.B"];
    let again_right: &[&str] = &["right.R", "right.G", "right.B"];
    let cases: [(Parts, &[(&str, Rgb)]); 4] = [
        (
            &[(Some("left"), again_left), (Some("right"), again_right)],
            &[("left", Rgb::new(1.0, 2.0, 3.0)), ("right", Rgb::new(4.0, 5.0, 6.0))],
        ),
        (
            &[(None, nested)],
            &[("diffuse.key", Rgb::new(1.0, 2.0, 3.0)), ("diffuse.fill", Rgb::new(4.0, 5.0, 6.0))],
        ),
        (
            &[(None, in_channels)],
            &[
                ("diffuse", Rgb::new(1.0, 2.0, 3.0)),
                ("depth", Rgb::splat(4.0)),
                ("glossy", Rgb::new(5.0, 6.0, 7.0)),
            ],
        ),
        (
            &[
                (Some("left"), colour),
                (Some("right"), colour),
                (Some("other"), &["pass.R", "pass.G", "pass.B"]),
            ],
            &[
                ("left", Rgb::new(1.0, 2.0, 3.0)),
                ("right", Rgb::new(4.0, 5.0, 6.0)),
                ("other.pass", Rgb::new(7.0, 8.0, 9.0)),
            ],
        ),
    ];
    for (parts, layers) in cases {
        fs::write(&path, file(parts)).unwrap();
        for (name, expected) in layers {
            assert_eq!(first_pixel(&path, Some(name)), Ok(*expected), "{name}");
        }
        let mut names: Vec<_> = layers.iter().map(|(name, _)| (*name).to_owned()).collect();
        names.sort();
        let mut listed = layer_names(&path).unwrap();
        listed.sort();
        assert_eq!(listed, names);
        for (layer, says) in [
            (None, "has several layers; choose one by its name: "),
            (Some("diffus"), "has no layer `diffus`; it has "),
        ] {
            let line = problem(ImageReader::open(&path, layer));
            assert!(line.contains(says) && names.iter().all(|name| line.contains(name)), "{line}");
        }
    }
}

/// Images are read several times when they are compared.
#[test]
fn a_layer_that_was_chosen_comes_again() {
    let folder = folder();
    let path = folder.path().join("a.exr");
    fs::write(&path, file(&[(None, &["R", "G", "B", "id.R", "id.G", "id.B"])])).unwrap();
    for (layer, expected) in [(None, Rgb::new(1.0, 2.0, 3.0)), (Some("id"), Rgb::new(4.0, 5.0, 6.0))] {
        let mut reader = ImageReader::open(&path, layer).unwrap();
        for _ in 0..2 {
            let mut pixels = [Rgb::ZERO; 2];
            reader.read(&mut pixels).unwrap();
            assert_eq!(pixels, [expected; 2], "{layer:?}");
            reader.rewind().unwrap();
        }
    }
}

#[test]
fn of_many_names_the_first_are_listed() {
    let folder = folder();
    let path = folder.path().join("a.exr");
    // Channels that are no picture; and a layer of each, of which one is asked for that is not there.
    for (end, layer) in [("", None), (".Z", Some("none"))] {
        let told = |count: usize| {
            let names: Vec<String> = (1..=count).map(|number| format!("c{number:02}{end}")).collect();
            let channels: Vec<&str> = names.iter().map(String::as_str).collect();
            fs::write(&path, file(&[(None, channels.as_slice())])).unwrap();
            problem(ImageReader::open(&path, layer))
        };
        let twelve = "c01, c02, c03, c04, c05, c06, c07, c08, c09, c10, c11, c12";
        let (all, more) = (told(12), told(13));
        assert!(all.contains(twelve) && !all.contains("and more"), "{all}");
        assert!(more.contains(&format!("{twelve}, and more")), "{more}");
    }
}

#[test]
fn without_a_name_the_picture_is_chosen() {
    let colour: &[&str] = &["R", "G", "B"];
    // Colour before grey, and what has no name before what has.
    for parts in [
        &[(Some("depth"), &["Z"][..]), (Some("rgb"), colour)][..],
        &[(None, &["R", "G", "B", "id.R", "id.G", "id.B", "Z"][..])],
    ] {
        let film = decode_bytes(Format::Exr, &file(parts)).unwrap();
        let first = if parts.len() == 2 { 2.0 } else { 1.0 };
        assert_eq!(film.pixels[0], Rgb::new(first, first + 1.0, first + 2.0), "{parts:?}");
    }
}

/// What is read if none is chosen; nothing, if one must be.
#[test]
fn the_usual_layer_is_told() {
    let folder = folder();
    let path = folder.path().join("a.exr");
    let colour: &[&str] = &["R", "G", "B"];
    let mixed: &[&str] = &["R", "G", "B", "id.R", "id.G", "id.B"];
    let cases: [(Parts, Option<&str>); 5] = [
        (&[(None, colour)], Some("")),
        (&[(Some("radius"), &["Y"])], Some("radius")),
        (&[(Some("depth"), &["Z"]), (Some("rgb"), colour)], Some("rgb")),
        (&[(None, mixed)], Some("")),
        (&[(Some("left"), colour), (Some("right"), colour)], None),
    ];
    for (parts, expected) in cases {
        fs::write(&path, file(parts)).unwrap();
        assert_eq!(usual_layer(&path).unwrap().as_deref(), expected, "{parts:?}");
    }
    // Of a format without layers it is the image, which has no name.
    let path = folder.path().join("a.pfm");
    image_file::write(&path, &Film::new(2, 1), &image_file::Encoding::default()).unwrap();
    assert_eq!(usual_layer(&path).unwrap().as_deref(), Some(""));
}

/// A tiled image of 8 x 8 pixels and its smaller versions, each pixel of which holds the size of its level.
#[test]
fn of_an_image_at_several_resolutions_the_largest_is_read() {
    let level = |size: u32| FlatSamples::F32(vec![size as f32; (size * size) as usize]);
    let levels = Levels::Mip {
        rounding_mode: RoundingMode::Down,
        level_data: [8, 4, 2, 1].map(level).into_iter().collect(),
    };
    let channels = ["R", "G", "B"].map(|name| AnyChannel::new(name, levels.clone()));
    let blocks = Blocks::Tiles(Vec2(4, 4));
    let encoding = Encoding { blocks, ..Encoding::UNCOMPRESSED };
    let attributes = LayerAttributes::default();
    let layer = Layer::new((8, 8), attributes, encoding, AnyChannels::sort(channels.into_iter().collect()));
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layer(layer).write().non_parallel().to_buffered(&mut bytes).unwrap();
    let film = decode_bytes(Format::Exr, &bytes.into_inner()).unwrap();
    assert_eq!((film.width, film.height), (8, 8));
    assert_eq!(film.pixels, [Rgb::splat(8.0); 64]);
}

/// Rows of 150 x 150 pixels are read in several parts; the blocks are not in the order of rows.
#[test]
fn tall_images_are_read_in_parts() {
    let values: Vec<f32> = (0..150 * 150).map(|i| i as f32).collect();
    for (blocks, line_order) in [
        (Blocks::ScanLines, LineOrder::Increasing),
        (Blocks::ScanLines, LineOrder::Decreasing),
        (Blocks::Tiles(Vec2(40, 24)), LineOrder::Increasing),
        (Blocks::Tiles(Vec2(40, 24)), LineOrder::Decreasing),
        (Blocks::Tiles(Vec2(100, 100)), LineOrder::Increasing),
    ] {
        let channel = AnyChannel::new("Y", FlatSamples::F32(values.clone()));
        let encoding = Encoding { blocks, line_order, ..Encoding::SMALL_LOSSLESS };
        let channels = AnyChannels::sort([channel].into_iter().collect());
        let layer = Layer::new((150, 150), LayerAttributes::default(), encoding, channels);
        let mut bytes = Cursor::new(Vec::new());
        Image::from_layer(layer).write().non_parallel().to_buffered(&mut bytes).unwrap();
        let film = decode_bytes(Format::Exr, &bytes.into_inner()).unwrap();
        assert!(film.pixels.iter().zip(&values).all(|(p, v)| p.x == *v), "{blocks:?} {line_order:?}");
    }
}

/// Each part of a file has a data window of its own.
#[test]
fn a_layer_has_the_size_of_its_part() {
    let folder = folder();
    let path = folder.path().join("a.exr");
    let part = |name: &str, size: (usize, usize)| {
        let values = vec![(size.0 * size.1) as f32; size.0 * size.1];
        let channels =
            AnyChannels::sort([AnyChannel::new("Y", FlatSamples::F32(values))].into_iter().collect());
        Layer::new(size, LayerAttributes::named(name), Encoding::UNCOMPRESSED, channels)
    };
    let layers: Layers<_> = [part("small", (2, 1)), part("large", (4, 3))].into_iter().collect();
    let attributes = exr::prelude::ImageAttributes::new(exr::prelude::IntegerBounds::from_dimensions((4, 3)));
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layers(attributes, layers).write().non_parallel().to_buffered(&mut bytes).unwrap();
    fs::write(&path, bytes.into_inner()).unwrap();
    for (name, [width, height]) in [("small", [2, 1]), ("large", [4, 3])] {
        let mut reader = ImageReader::open(&path, Some(name)).unwrap();
        assert_eq!(reader.size(), [width, height], "{name}");
        let count = width * height;
        let mut pixels = vec![Rgb::ZERO; count as usize];
        reader.read(&mut pixels).unwrap();
        assert!(pixels.iter().all(|pixel| *pixel == Rgb::splat(count as f32)), "{name}: {pixels:?}");
    }
}

/// The decoder takes one sample for each pixel, whichever way there are fewer. Parts that are not read may be as they like.
#[test]
fn every_channel_of_a_layer_has_a_sample_for_every_pixel() {
    let part = |name: &str, sampling: Vec2<usize>| {
        let mut weight = ChannelDescription::named("weight", SampleType::F16);
        weight.sampling = sampling;
        let channels = [ChannelDescription::named("Y", SampleType::F16), weight];
        Header::new(Text::from(name), (4, 2), channels.into_iter().collect())
    };
    let refusal = |headers: &[Header], layer| choose(headers, layer).err();
    for sampling in [Vec2(2, 1), Vec2(1, 2), Vec2(2, 2)] {
        let told = "has a subsampled channel weight; each must have a sample for every pixel";
        assert_eq!(refusal(&[part("a", sampling)], None).as_deref(), Some(told), "{sampling:?}");
        let both = [part("less", sampling), part("whole", Vec2(1, 1))];
        assert_eq!(refusal(&both, Some("less")).as_deref(), Some(told), "{sampling:?}");
        assert_eq!(refusal(&both, Some("whole")), None, "{sampling:?}");
    }
}

/// The names in a file may be of any length, and of any characters.
#[test]
fn names_in_messages_are_short_and_on_their_line() {
    let folder = folder();
    let path = folder.path().join("a.exr");
    fs::write(&path, file(&[(None, &["abcdefghijklmnopqrstuvwxyz", "b\nc"])])).unwrap();
    let line = problem(ImageReader::open(&path, None));
    assert!(line.contains("has channels abcdefghijklmnopqrst, b\\nc; it must have"), "{line}");
}

#[test]
fn coordinates_are_no_picture() {
    let line = decode_bytes(Format::Exr, &file(&[(None, &["X", "Y", "Z"])])).unwrap_err();
    assert!(line.contains("has channels X, Y, Z; it must have R, G and B"), "{line}");
    let line = decode_bytes(Format::Exr, &file(&[(None, &["BY", "RY", "Y"])])).unwrap_err();
    assert!(line.contains("luminance and chroma"), "{line}");
}
