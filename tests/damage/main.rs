//! Damages checkpoints, scene files and images. Readers must reject them with a one-line error or read them correctly
//! where a checksum covers them, and must use at most twice the memory that the undamaged file takes.
//!
//! This is a separate binary with a single test because it measures the memory of the whole process.

#[path = "../shared/cases.rs"]
mod cases;

use files::checkpoint::{Checkpoint, Contents, write};
use files::image_file::{self, Encoding, Format, decode_bytes, decode_note_bytes};
use files::scene_file;
use peak_alloc::PeakAlloc;
use scene::rng::{Family, Stream, StreamKey};
use scene::{Engine, Film, Settings};
use std::collections::BTreeSet;
use std::io::Cursor;

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// Damaged variants per file, unless `SPPM_DAMAGES` gives another number.
const DAMAGES: u32 = 400;
/// Additional memory allowed for error messages and for allocations that are rounded up.
const SLACK: usize = 1 << 13;

/// A reader: returns a short summary of what was read, or an error message.
type Reader = fn(&[u8]) -> Result<String, String>;

/// An undamaged file.
struct Specimen {
    name: &'static str,
    bytes: Vec<u8>,
    read: Reader,
    /// Whether checksums cover all that is read, so that damage must be detected or have no effect.
    is_summed: bool,
    /// The memory that reading may take, if the size of the file does not bound it.
    most: Option<usize>,
}

/// Of formats that compress equal pixels to nothing, images of up to 2^22 pixels are read from files of any length: 12
/// bytes for each pixel, as many again for the rows that are held, and what the decoder works with.
const MOST_OF_ANY_FILE: usize = 40 << 22;

fn read_checkpoint(bytes: &[u8]) -> Result<String, String> {
    let checkpoint =
        Checkpoint::read(&mut Cursor::new(bytes), bytes.len() as u64).map_err(|e| e.to_string())?;
    Ok(checkpoint.scene.name)
}

fn read_scene(bytes: &[u8]) -> Result<String, String> {
    let text = std::str::from_utf8(bytes).map_err(|e| e.to_string())?;
    scene_file::parse("a.toml", text).map(|scene| scene.name).map_err(|e| e.to_string())
}

/// A checksum of the pixels. Also reads the note, without checking its content.
fn read_image(format: Format, bytes: &[u8]) -> Result<String, String> {
    let _ = decode_note_bytes(format, bytes)?;
    let film = decode_bytes(format, bytes)?;
    assert_eq!(film.pixels.len() as u64, u64::from(film.width) * u64::from(film.height));
    let values = film.pixels.iter().flat_map(scene::Vec3::to_array);
    let sum = values.fold(0_u64, |sum, v| sum.rotate_left(7) ^ u64::from(v.to_bits()));
    Ok(format!("{} x {} {sum:x}", film.width, film.height))
}

/// An image file, noisy in one half and black in the other, like a render after few iterations.
fn image(extension: &str) -> Vec<u8> {
    let (mut numbers, mut film) = (StreamKey::new(1, Family::Path, 0).stream(0), Film::new(96, 64));
    for pixel in &mut film.pixels[..96 * 32] {
        *pixel = scene::Rgb::new(numbers.next_f32(), numbers.next_f32(), 3.0 * numbers.next_f32());
    }
    let folder = tempfile::TempDir::new().unwrap();
    let path = folder.path().join("a").with_extension(extension);
    let note = "{\"a\": \"text\"}".repeat(50);
    image_file::write(&path, &film, &Encoding { note: Some(&note), ..Encoding::default() }).unwrap();
    std::fs::read(path).unwrap()
}

fn checkpoint() -> Vec<u8> {
    let scene = files::builtin::scene("cornell").unwrap();
    let settings = Settings { width: 48, height: 32, photons_per_iteration: 1000, ..scene.settings };
    let scene = scene::Scene { settings, ..scene };
    let mut engine = fast::Sppm::new(&scene, &settings);
    engine.iterate();
    let digest = scene_file::digest(&scene);
    let contents =
        Contents { scene: &scene, digest: &digest, version: "1", note: "{}", which: None, past: None };
    let mut bytes = Vec::new();
    write(&mut bytes, &engine, &contents).unwrap();
    bytes
}

fn specimens() -> Vec<Specimen> {
    let scene = |name: &'static str| {
        let bytes = files::builtin::find(name).unwrap().text.as_bytes().to_vec();
        Specimen { name, bytes, read: read_scene, is_summed: false, most: None }
    };
    let image = |name, extension: &str, read: Reader| Specimen {
        name,
        bytes: image(extension),
        read,
        is_summed: extension == "png",
        most: (!matches!(extension, "png" | "exr" | "pfm")).then_some(MOST_OF_ANY_FILE),
    };
    vec![
        Specimen {
            name: "checkpoint",
            bytes: checkpoint(),
            read: read_checkpoint,
            is_summed: true,
            most: None,
        },
        scene("cornell"),
        scene("surgery"),
        scene("motion"),
        image("PNG", "png", |bytes| read_image(Format::Png, bytes)),
        image("EXR", "exr", |bytes| read_image(Format::Exr, bytes)),
        image("PFM", "pfm", |bytes| read_image(Format::Pfm, bytes)),
        image("HDR", "hdr", |bytes| read_image(Format::Hdr, bytes)),
        image("TIFF", "tif", |bytes| read_image(Format::Tiff, bytes)),
        image("JPEG", "jpg", |bytes| read_image(Format::Jpeg, bytes)),
    ]
}

/// Reads a file in memory; returns the result and the peak memory used in addition to `bytes`.
fn measured(read: Reader, bytes: &[u8]) -> (Result<String, String>, usize) {
    let before = MEMORY.current_usage();
    MEMORY.reset_peak_usage();
    let result = read(bytes);
    (result, MEMORY.peak_usage().saturating_sub(before))
}

/// Flips some bits, truncates, or overwrites a word. In half of the cases this is near the beginning, where sizes are
/// stored. Returns a description.
fn damage(bytes: &mut Vec<u8>, numbers: &mut Stream) -> String {
    let length = bytes.len();
    let span = if numbers.next_u32().is_multiple_of(2) { length.min(600) } else { length };
    let at = numbers.next_u32() as usize % span;
    match numbers.next_u32() % 8 {
        0 => {
            bytes.truncate(at);
            format!("cut after {at} of {length} bytes")
        }
        1 if at + 4 <= length => {
            let words = [0, u32::MAX, i32::MAX as u32, 1 << 31, 1 << 20, numbers.next_u32()];
            let word = words[numbers.next_u32() as usize % words.len()];
            bytes[at..at + 4].copy_from_slice(&word.to_le_bytes());
            format!("{word:#x} at {at}")
        }
        more => {
            // One bit at `at`, others anywhere.
            let others = (0..more / 3).map(|_| numbers.next_u32() as usize % (8 * length));
            let mut bits: BTreeSet<usize> = others.collect();
            bits.insert(8 * at + numbers.next_u32() as usize % 8);
            for bit in &bits {
                bytes[bit / 8] ^= 1 << (bit % 8);
            }
            format!("bits {bits:?} flipped")
        }
    }
}

#[test]
fn damaged_files_are_rejected_with_bounded_memory() {
    let asked = std::env::var("SPPM_DAMAGES").ok().map(|damages| damages.parse::<u32>().expect("a number"));
    let (mut faults, mut all) = (Vec::new(), 0);
    for specimen in specimens() {
        let Specimen { name, bytes, read, is_summed, most } = specimen;
        // Read once before measuring, as the first time fills tables that are kept.
        read(&bytes).unwrap();
        let (whole, honest) = measured(read, &bytes);
        let whole = whole.unwrap();
        let (mut refused, mut worst) = (0, 0);
        let damages = asked.unwrap_or(DAMAGES);
        for number in 0..damages {
            let mut numbers = StreamKey::new(2, Family::Path, 0).stream(number);
            let mut damaged = bytes.clone();
            let what = damage(&mut damaged, &mut numbers);
            let (result, peak) = measured(read, &damaged);
            worst = worst.max(peak);
            if peak > most.unwrap_or(2 * honest + SLACK) {
                faults.push(format!(
                    "{name}, {what}: {peak} bytes, where the whole file takes {honest}: {result:?}"
                ));
            }
            match result {
                Err(line) => {
                    refused += 1;
                    let is_line = !line.is_empty() && line.len() < 600 && !line.contains(char::is_control);
                    assert!(is_line, "{name}, {what}: {line:?}");
                }
                Ok(read) if is_summed && read != whole => {
                    faults.push(format!("{name}, {what}: was taken for whole"));
                }
                Ok(_) => {}
            }
        }
        all += damages as usize;
        println!(
            "{name}: {refused} of {damages} damages refused; {worst} bytes at worst, the whole file {honest} ({whole:.20})"
        );
    }
    assert!(
        faults.is_empty(),
        "{} faults, the first of them:\n{}",
        faults.len(),
        faults[..faults.len().min(20)].join("\n")
    );
    cases::tell("damage", all, "damaged files");
}
