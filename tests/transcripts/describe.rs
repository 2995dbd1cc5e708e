//! What is told of files that are no text: their kind, and digests of what they hold rather than of compressed bytes.

use crate::normal::normal;
use files::checkpoint::Checkpoint;
use files::image_file::{self, Format, ImageReader};
use scene::RowReader as _;
use std::io::Cursor;
use std::path::Path;

/// A line about the file `name` in `folder` with these `bytes`, and further lines.
pub(crate) fn describe(name: &str, bytes: &[u8], folder: &Path) -> Vec<String> {
    if name.ends_with('/') {
        return vec![String::new()];
    }
    if bytes.starts_with(b"\x89SPPM") {
        return checkpoint(bytes, folder);
    }
    if bytes.starts_with(b"\x93NUMPY") {
        return array(bytes);
    }
    match Format::of_content(&bytes[..bytes.len().min(12)]) {
        Some(format) => image(format, bytes, folder),
        None => vec![format!("{} bytes, digest {}", bytes.len(), digest(bytes))],
    }
}

fn digest(bytes: &[u8]) -> String {
    format!("{:08x}", crc32fast::hash(bytes))
}

/// An image: all samples that it holds, and the note of what made it.
fn image(format: Format, bytes: &[u8], folder: &Path) -> Vec<String> {
    // Readers take files.
    let here = tempfile::tempdir().unwrap();
    let path = here.path().join("image");
    std::fs::write(&path, bytes).unwrap();
    let kind = format.name();
    let size = match ImageReader::open(
        &path,
        image_file::layer_names(&path).unwrap_or_default().first().map(String::as_str),
    ) {
        Ok(image) => image.size().map(|side| side.to_string()).join(" x "),
        Err(error) => return vec![format!("{kind} that cannot be read: {}", error.problem)],
    };
    let samples = match format {
        Format::Png => png_samples(bytes),
        Format::Exr => exr_samples(&path),
        _ => format!("bytes {}", digest(bytes)),
    };
    let mut told = format!("{kind} of {size}, {samples}");
    if let Ok(Some(note)) = image_file::read_note(&path) {
        // One object of JSON; its digest tells whether it is as before, and `sppm info` what it says.
        told.extend([", note ".into(), digest(normal(&note, folder).as_bytes())]);
    }
    vec![told]
}

fn png_samples(bytes: &[u8]) -> String {
    let mut reader = png::Decoder::new(Cursor::new(bytes)).read_info().unwrap();
    let mut samples = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut samples).unwrap();
    let info = reader.info();
    format!("{:?} of {} bits, samples {}", info.color_type, info.bit_depth as u8, digest(&samples))
}

fn exr_samples(path: &Path) -> String {
    use exr::prelude::{FlatSamples, read_first_flat_layer_from_file};
    let image = read_first_flat_layer_from_file(path).unwrap();
    let layer = image
        .layer_data
        .attributes
        .layer_name
        .as_ref()
        .map_or(String::new(), |name| format!("layer {name}, "));
    let channels = image.layer_data.channel_data.list.iter().map(|channel| {
        let FlatSamples::F32(samples) = &channel.sample_data else { panic!("samples that are no f32") };
        let bytes: Vec<u8> = samples.iter().flat_map(|sample| sample.to_le_bytes()).collect();
        format!("{} {}", channel.name, digest(&bytes))
    });
    format!("{layer}{}", channels.collect::<Vec<_>>().join(", "))
}

/// A checkpoint: what it says of its render, and the sums.
fn checkpoint(bytes: &[u8], folder: &Path) -> Vec<String> {
    let length = bytes.len() as u64;
    let read = Checkpoint::read_in(&mut Cursor::new(bytes), length, folder);
    let checkpoint = match read {
        Ok(checkpoint) => checkpoint,
        Err(damage) => {
            return vec![format!("checkpoint that cannot be read: {}", normal(&damage.to_string(), folder))];
        }
    };
    let mut words = Vec::new();
    let taken = checkpoint.sums(&mut Cursor::new(bytes), length, |_, row| {
        words.extend(row.iter().flat_map(|word| word.to_le_bytes()));
    });
    taken.unwrap();
    let account = &checkpoint.account;
    let which = account.which.as_ref().map_or(String::new(), |which| format!(", {which}"));
    let past = checkpoint.past.as_ref().map_or(String::new(), |past| {
        let pixels: Vec<u8> = past
            .film
            .pixels
            .iter()
            .flat_map(|pixel| pixel.to_array().map(f32::to_le_bytes))
            .flatten()
            .collect();
        format!(", image after {} {}", past.iterations, digest(&pixels))
    });
    let text = files::scene_file::to_text(&checkpoint.scene, &checkpoint.scene.settings);
    vec![
        format!(
            "checkpoint after {}{which} of {}, {}, sums {}, photons {}, scene {}{past}",
            account.iterations,
            checkpoint.scene.settings.iterations,
            account.sums,
            digest(&words),
            account.stats.photons,
            digest(normal(&text, folder).as_bytes()),
        ),
        format!("note {}", normal(&checkpoint.note, folder)),
    ]
}

/// A `NumPy` array: its header, and its numbers, which are `f32` and `i32`, in rows.
fn array(bytes: &[u8]) -> Vec<String> {
    let length = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let header = String::from_utf8_lossy(&bytes[10..10 + length]).trim().to_owned();
    let data = &bytes[10 + length..];
    let mut lines = vec![format!("NumPy array {header}")];
    if header.contains("'sphere'") {
        for row in data.chunks_exact(20) {
            let word = |at: usize| [0, 1, 2, 3].map(|i| row[4 * at + i]);
            let number = |at: usize| f32::from_le_bytes(word(at));
            let sphere = i32::from_le_bytes(word(1));
            lines.push(format!(
                "t {}, sphere {sphere}, normal {} {} {}",
                number(0),
                number(2),
                number(3),
                number(4)
            ));
        }
    } else {
        lines[0].extend([", digest ".into(), digest(data)]);
    }
    lines
}
