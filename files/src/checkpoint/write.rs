//! Writes checkpoints.

use super::account::{Account, Past};
use super::arrays::Arrays;
use super::sections::{ACCOUNT, FRAME, HEADER, NOTE, PAST, SCENE, SUMS, write_header, write_section};
use crate::scene_file;
use scene::{Iterations, Resumable, Scene, Settings, Sums, TRANSPORT};
use std::io::{self, Write};

/// Everything in a checkpoint that does not come from the engine.
#[derive(Clone, Copy, Debug)]
pub struct Contents<'a> {
    /// The scene, with the settings that are noted. Their number of iterations may be another than the engine's.
    pub scene: &'a Scene,
    /// The scene's digest.
    pub digest: &'a str,
    /// The version of the program that writes.
    pub version: &'a str,
    /// The program's own note.
    pub note: &'a str,
    /// The iterations in the sums, if they are not the first ones.
    pub which: Option<&'a Iterations>,
    /// An earlier image, if the error is estimated.
    pub past: Option<&'a Past>,
}

/// Content bytes of `PAST` for an image of `pixels` pixels.
pub(super) fn past_bytes(pixels: u64) -> u64 {
    4 + 12 * pixels
}

/// Content bytes of `SUMS` for an image of `pixels` pixels.
pub(super) fn sums_bytes(sums: Sums, pixels: u64) -> u64 {
    4 * sums.words() as u64 * pixels
}

/// An upper bound of a checkpoint's bytes, to check for disk space in advance.
pub fn length(scene: &Scene, note: &str, sums: Sums, has_past: bool) -> u64 {
    /// An account is smaller.
    const ACCOUNT_BYTES: u64 = 1 << 12;
    let pixels = scene.settings.pixels() as u64;
    let past = if has_past { past_bytes(pixels) + FRAME } else { 0 };
    let text = scene_file::head_to_text(scene, &scene.settings);
    let texts = text.len() as u64 + note.len() as u64 + ACCOUNT_BYTES;
    HEADER + 4 * FRAME + texts + Arrays::of(scene).bytes() + sums_bytes(sums, pixels) + past
}

/// Writes the checkpoint of a render that is between two iterations.
///
/// # Errors
/// If writing to `out` fails.
pub fn write(out: &mut impl Write, engine: &dyn Resumable, contents: &Contents) -> io::Result<()> {
    let settings = &contents.scene.settings;
    let pixels = engine.settings().pixels() as u64;
    let account = serde_json::to_vec(&Account {
        version: contents.version.into(),
        transport: TRANSPORT,
        scene: contents.digest.into(),
        sums: engine.sums(),
        iterations: engine.iterations(),
        which: contents.which.cloned(),
        stats: *engine.stats(),
    })?;
    let scene = scene_file::head_to_text(contents.scene, settings);
    let arrays = Arrays::of(contents.scene);
    let texts = [(ACCOUNT, &account[..]), (NOTE, contents.note.as_bytes())];
    let sums = sums_bytes(engine.sums(), pixels);
    let past = contents.past.map_or(0, |_| FRAME + past_bytes(pixels));
    let write_text = |out: &mut _, name, text: &[u8]| {
        write_section(out, name, text.len() as u64, |out| out.write_all(text))
    };
    let texts_bytes: u64 = texts.iter().map(|(_, text)| FRAME + text.len() as u64).sum();
    let scene_bytes = FRAME + scene.len() as u64 + arrays.bytes();
    write_header(out, HEADER + scene_bytes + texts_bytes + FRAME + sums + past)?;
    write_text(out, SCENE, scene.as_bytes())?;
    arrays.write(out)?;
    for (name, text) in texts {
        write_text(out, name, text)?;
    }
    write_section(out, SUMS, sums, |out| write_sums(out, engine))?;
    match contents.past {
        Some(past) => write_section(out, PAST, past_bytes(pixels), |out| write_past(out, past)),
        None => Ok(()),
    }
}

fn write_sums(out: &mut impl Write, engine: &dyn Resumable) -> io::Result<()> {
    let Settings { width, height, .. } = *engine.settings();
    let mut words = vec![0; width as usize * engine.sums().words()];
    let mut bytes = Vec::with_capacity(4 * words.len());
    for y in 0..height {
        engine.save_row(y, &mut words);
        bytes.clear();
        bytes.extend(words.iter().flat_map(|word| word.to_le_bytes()));
        out.write_all(&bytes)?;
    }
    Ok(())
}

fn write_past(out: &mut impl Write, past: &Past) -> io::Result<()> {
    out.write_all(&past.iterations.to_le_bytes())?;
    let mut bytes = Vec::new();
    for row in past.film.pixels.chunks(past.film.width as usize) {
        bytes.clear();
        bytes.extend(row.iter().flat_map(|p| p.to_array().map(f32::to_le_bytes)).flatten());
        out.write_all(&bytes)?;
    }
    Ok(())
}
