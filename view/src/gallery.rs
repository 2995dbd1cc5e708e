//! Image files to look at: one in all its layers, or two to compare.

use crate::hub::{Hub, MAX_LAYERS, show};
use crate::picture::{Caption, Picture, of_film};
use axum::body::Bytes;
use files::image_file::{self, ImageReader};
use scene::{Film, RowReader};
use serde_json::json;
use std::path::Path;
use std::sync::Arc;

/// The image file `path`, in the form in which the page loads it to compare with.
///
/// # Errors
/// If it cannot be read.
pub(crate) fn other(path: &Path) -> Result<(String, Bytes), String> {
    Ok((name_of(path), of_film(&read(path, None)?, 0, caption(path)?)))
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
        None => names.into_iter().map(Some).take(MAX_LAYERS).collect(),
    };
    // A picture without a name comes first, where there is one beside those with names.
    if layer.is_none() && ImageReader::open(path, None).is_ok() {
        names.insert(0, None);
        names.truncate(MAX_LAYERS);
    }
    let caption = caption(path)?;
    let mut layers = Vec::new();
    for (number, name) in names.iter().enumerate() {
        let film = read(path, name.as_deref())?;
        layers.push((number as u32, of_film(&film, number as u32, caption)));
    }
    let titles: Vec<&str> = names.iter().map(|name| name.as_deref().unwrap_or("image")).collect();
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
