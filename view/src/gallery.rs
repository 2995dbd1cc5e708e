//! Image files to look at: one in all its layers, or two to compare.

use crate::hub::{Hub, MAX_LAYERS, show};
use crate::picture::{Caption, Picture, of_film};
use axum::body::Bytes;
use files::image_file::{self, ImageReader};
use scene::{Film, RowReader};
use serde_json::json;
use std::path::Path;
use std::sync::Arc;

/// The image file `path`, or the layer of that name, in the form in which the page loads it to compare with.
///
/// # Errors
/// If it cannot be read.
pub(crate) fn other(path: &Path, layer: Option<&str>) -> Result<(String, Bytes), String> {
    Ok((name_of(path), of_film(&read(path, layer)?, 0, caption(path)?)))
}

/// A hub that shows the image file `path`, and `others` to compare it with.
///
/// # Errors
/// If the file cannot be read.
pub(crate) fn open(path: &Path, layer: Option<&str>, others: Vec<(String, Bytes)>) -> Result<Hub, String> {
    let names = image_file::layer_names(path).map_err(|error| error.to_string())?;
    let hub = Hub::new(false, others);
    let mut names: Vec<Option<String>> = match layer {
        Some(layer) => vec![Some(layer.into())],
        None => usual_first(path, names)?,
    };
    names.truncate(MAX_LAYERS);
    let caption = caption(path)?;
    let mut layers = Vec::new();
    for (number, name) in names.iter().enumerate() {
        let film = read(path, name.as_deref())?;
        layers.push((number as u32, of_film(&film, number as u32, caption)));
    }
    let titles: Vec<&str> = names.iter().map(|name| title(name.as_deref())).collect();
    show(
        &hub.scene,
        &json!({
            "type": "scene",
            "mode": "files",
            "name": name_of(path),
            "layers": titles,
            "others": hub.others.iter().map(|(name, _)| name).collect::<Vec<_>>(),
        }),
    );
    hub.pictures.send_replace(Some(Arc::new(Picture::new(layers))));
    Ok(hub)
}

/// The layers of the file to show, of which some have these `names`: first what is read without a choice (`None`), unless it is
/// the only layer and has a name; then a layer without a name, if it is another one.
fn usual_first(path: &Path, names: Vec<String>) -> Result<Vec<Option<String>>, String> {
    let usual = image_file::usual_layer(path).map_err(|error| error.to_string())?;
    let mut shown: Vec<Option<String>> = names.into_iter().map(Some).collect();
    if usual.as_deref() != Some("") && ImageReader::open(path, Some("")).is_ok() {
        shown.insert(0, Some(String::new()));
    }
    if usual.is_some() && shown != [usual] {
        shown.insert(0, None);
    }
    Ok(shown)
}

/// What the page calls a layer; the one that is read without a choice is the image.
fn title(layer: Option<&str>) -> &str {
    match layer {
        None => "image",
        Some("") => "without a name",
        Some(name) => name,
    }
}

fn read(path: &Path, layer: Option<&str>) -> Result<Film, String> {
    let mut reader = ImageReader::open(path, layer).map_err(|error| error.to_string())?;
    let [width, height] = reader.size();
    let mut film = Film::new(width, height);
    reader.read(&mut film.pixels)?;
    Ok(film)
}

fn caption(path: &Path) -> Result<Caption, String> {
    let opened = ImageReader::open(path, None);
    let first = || image_file::layer_names(path).ok().and_then(|names| names.into_iter().next());
    let reader = opened.or_else(|_| ImageReader::open(path, first().as_deref()));
    let whole = reader.map_err(|error| error.to_string())?.size();
    Ok(Caption { version: 1, iterations: 0, whole, number: 1 })
}

fn name_of(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::HEADER;
    use crate::rgb9e5;
    use files::image_file::Encoding;
    use serde_json::Value;
    use std::fs;

    /// An EXR file of one pixel with these channels, in alphabetical order, which hold 1, 2, 3 ...
    fn exr(channels: &[&str]) -> Vec<u8> {
        let word = |value: i32| value.to_le_bytes().to_vec();
        let float = 1_f32.to_le_bytes();
        let list = channels.iter().flat_map(|name| {
            [name.as_bytes(), &[0], &word(2), &[0; 4], &word(1), &word(1)].concat() // 32 bits, every pixel
        });
        let list: Vec<u8> = list.chain([0]).collect();
        let mut file = [word(20_000_630), word(2)].concat();
        for (name, kind, value) in [
            ("channels", "chlist", &list[..]),
            ("compression", "compression", &[0]),
            ("dataWindow", "box2i", &[0; 16]),
            ("displayWindow", "box2i", &[0; 16]),
            ("lineOrder", "lineOrder", &[0]),
            ("pixelAspectRatio", "float", &float),
            ("screenWindowCenter", "v2f", &[0; 8]),
            ("screenWindowWidth", "float", &float),
        ] {
            file.extend(
                [name.as_bytes(), &[0], kind.as_bytes(), &[0], &word(value.len() as i32), value].concat(),
            );
        }
        file.push(0);
        let line = file.len() as u64 + 8;
        file.extend(line.to_le_bytes());
        file.extend([word(0), word(4 * channels.len() as i32)].concat());
        file.extend((1..=channels.len()).flat_map(|value| (value as f32).to_le_bytes()));
        file
    }

    /// The titles of the layers that are shown, each with the red of the first pixel.
    fn shown(path: &Path, layer: Option<&str>) -> Vec<(String, f32)> {
        let hub = open(path, layer, Vec::new()).unwrap();
        let scene: Value = serde_json::from_str(&hub.scene.borrow()).unwrap();
        let titles: Vec<String> = serde_json::from_value(scene["layers"].clone()).unwrap();
        let picture = hub.pictures.borrow().clone().unwrap();
        assert!(!picture.has(titles.len() as u32));
        let layers = titles.into_iter().zip(0..).map(|(title, number)| {
            let bytes = picture.layer(number).unwrap();
            let word = |at: usize| u32::from_le_bytes(bytes[at..][..4].try_into().unwrap());
            (title, rgb9e5::decode(word(HEADER))[0] * f32::from_bits(word(32)))
        });
        layers.collect()
    }

    /// The channels of a file, the layer that is asked for, and those that are shown.
    type Case<'a> = (&'a [&'a str], Option<&'a str>, &'a [(&'a str, f32)]);

    /// It is called "image".
    #[test]
    fn what_is_read_without_a_choice_comes_first_and_a_layer_that_was_asked_for_is_alone() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let grey_and_colour = ["a.Y", "b.B", "b.G", "b.R"];
        let grey_beside = |named: &[&'static str]| [&["Y"], named].concat();
        let (beside_one, beside_two) =
            (grey_beside(&["b.B", "b.G", "b.R"]), grey_beside(&["b.B", "b.G", "b.R", "c.B", "c.G", "c.R"]));
        let cases: [Case; 10] = [
            // A layer without a name is shown also where another is read, or must be chosen.
            (&beside_one, None, &[("image", 4.0), ("without a name", 1.0), ("b", 4.0)]),
            (&beside_two, None, &[("without a name", 1.0), ("b", 4.0), ("c", 7.0)]),
            (&["B", "G", "R"], None, &[("image", 3.0)]),
            (&["Y", "a.Y", "b.Y"], None, &[("image", 1.0), ("a", 2.0), ("b", 3.0)]),
            (&["Y", "a.Y", "b.Y"], Some("b"), &[("b", 3.0)]),
            // None is without a name; then only one in colour is read without a choice.
            (&["a.Y", "b.Y"], None, &[("a", 1.0), ("b", 2.0)]),
            (&grey_and_colour, None, &[("image", 4.0), ("a", 1.0), ("b", 4.0)]),
            (&grey_and_colour, Some("b"), &[("b", 4.0)]),
            // The only layer is not shown twice.
            (&["a.Y"], None, &[("a", 1.0)]),
            (&["a.Y"], Some("a"), &[("a", 1.0)]),
        ];
        for (channels, layer, expected) in cases {
            fs::write(&path, exr(channels)).unwrap();
            let expected: Vec<_> = expected.iter().map(|(title, red)| ((*title).to_owned(), *red)).collect();
            assert_eq!(shown(&path, layer), expected, "{channels:?}, {layer:?}");
        }
        // It is shown also of more layers than are shown at once; the last of them can be asked for.
        let names: Vec<String> = (0..MAX_LAYERS).map(|i| format!("l{i:02}.Y")).collect();
        let channels: Vec<&str> = ["Y"].into_iter().chain(names.iter().map(String::as_str)).collect();
        fs::write(&path, exr(&channels)).unwrap();
        let layers = shown(&path, None);
        assert_eq!(
            (layers.len(), &layers[0], &layers[1].0),
            (MAX_LAYERS, &("image".into(), 1.0), &"l00".into())
        );
        assert_eq!(shown(&path, Some("l63")), [("l63".into(), 65.0)]);
        // Other formats have no layers.
        let path = folder.path().join("a.pfm");
        image_file::write(&path, &Film::from_fn(2, 1, |_, _| scene::Rgb::ONE), &Encoding::default()).unwrap();
        assert_eq!(shown(&path, None), [("image".into(), 1.0)]);
    }
}
