//! Reads checkpoints.

use super::account::{Account, Past};
use super::arrays;
use super::damage::Damage;
use super::sections::{ACCOUNT, FRAME, HEADER, NOTE, Name, PAST, SCENE, SUMS, Section, read_header};
use super::write::{past_bytes, sums_bytes};
use crate::scene_file;
use scene::settings::MAX_ITERATIONS;
use scene::{Film, Resumable, Rgb, Scene, Settings, Sums, TRANSPORT};
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

/// Limit on the bytes of an account or a note, far more than a valid one has.
const MOST_TEXT: u64 = 1 << 24;

/// A checkpoint that was read and verified. Its sums stay in the file until [`Self::restore`] loads them.
#[derive(Clone, Debug, PartialEq)]
pub struct Checkpoint {
    /// The scene, with the settings of the render.
    pub scene: Scene,
    /// The progress of the render.
    pub account: Account,
    /// The note of the program that wrote it.
    pub note: String,
    /// The earlier image, if there is one.
    pub past: Option<Past>,
    /// Offset of the section of sums.
    sums_at: u64,
}

/// What stands in a checkpoint before its sums.
struct Head {
    scene: Scene,
    account: Account,
    note: String,
    sums_at: u64,
}

impl Head {
    /// Reads and verifies it. `input` is then at the sums. The files of particles of its scene may be in `folder`.
    fn read(input: &mut (impl Read + Seek), length: u64, folder: &Path) -> Result<Self, Damage> {
        input.seek(SeekFrom::Start(0))?;
        let version = read_header(input, length)?;
        let mut at = HEADER;
        let scene = read_scene(input, version, &mut at, length, folder)?;
        let account_text = text(input, ACCOUNT, &mut at, length, MOST_TEXT)?;
        let note = text(input, NOTE, &mut at, length, MOST_TEXT)?;
        let account = parse_account(&account_text, &scene)?;
        Ok(Self { scene, account, note, sums_at: at })
    }
}

impl Checkpoint {
    /// Reads a file of `length` bytes and verifies all of it.
    ///
    /// # Errors
    /// If the file is damaged or invalid, of another format version, or cannot be read.
    pub fn read(input: &mut (impl Read + Seek), length: u64) -> Result<Self, Damage> {
        Self::read_in(input, length, Path::new(""))
    }

    /// As [`Self::read`]; the files of particles of its scene may have been moved to `folder`.
    ///
    /// # Errors
    /// As [`Self::read`], or if a file of particles is missing, has changed, or cannot be read.
    pub fn read_in(input: &mut (impl Read + Seek), length: u64, folder: &Path) -> Result<Self, Damage> {
        let Head { scene, account, note, sums_at } = Head::read(input, length, folder)?;
        let after = read_sums(&mut *input, (&scene.settings, &account), sums_at, length, |_, _| {})?;
        let past = match length - after {
            0 => None,
            left => Some(read_past(&mut *input, left, &scene.settings, &account)?),
        };
        Ok(Self { scene, account, note, past, sums_at })
    }

    /// Reads and verifies what stands before the sums, which are left to [`Self::sums`].
    ///
    /// # Errors
    /// As [`Self::read_in`].
    pub fn read_head(input: &mut (impl Read + Seek), length: u64, folder: &Path) -> Result<Self, Damage> {
        let Head { scene, account, note, sums_at } = Head::read(input, length, folder)?;
        Ok(Self { scene, account, note, past: None, sums_at })
    }

    /// Reads the sums from the file of `length` bytes that the checkpoint was read from, and passes the words of each row to
    /// `take`, from the top. They are verified as they are read, so what was taken counts only if there is no error.
    ///
    /// # Errors
    /// If they are damaged or invalid, or the file has changed.
    pub fn sums(
        &self,
        input: &mut (impl Read + Seek),
        length: u64,
        take: impl FnMut(u32, &[u32]),
    ) -> Result<(), Damage> {
        input.seek(SeekFrom::Start(self.sums_at))?;
        read_sums(input, (&self.scene.settings, &self.account), self.sums_at, length, take)?;
        Ok(())
    }

    /// Checks that the sums are of the light transport that this program computes.
    ///
    /// # Errors
    /// [`Damage::Transport`] if they are of another version.
    pub fn check_transport(&self) -> Result<(), Damage> {
        let Account { transport, version, .. } = &self.account;
        if *transport == TRANSPORT {
            return Ok(());
        }
        let program = version.chars().take(16).flat_map(char::escape_debug).collect();
        Err(Damage::Transport { found: *transport, program })
    }

    /// Loads the checkpoint into `engine`, a render of the same scene and settings that has not begun. `input` is the
    /// file that the checkpoint was read from.
    ///
    /// # Errors
    /// If the sums are of another version of the light transport, if the file has changed since it was read, or if the
    /// engine uses another algorithm. `engine` may then be partly loaded and must not be used.
    pub fn restore(&self, input: &mut (impl Read + Seek), engine: &mut dyn Resumable) -> Result<(), Damage> {
        self.check_transport()?;
        let (settings, sums) = (&self.scene.settings, self.account.sums);
        if engine.sums() != sums {
            return Err(invalid(ACCOUNT, format!("is of {sums}, and the engine's is of {}", engine.sums())));
        }
        input.seek(SeekFrom::Start(self.sums_at))?;
        let left = FRAME + sums_bytes(sums, settings.pixels() as u64);
        let mut section = begin_sums(input, settings, sums, self.sums_at, self.sums_at + left)?;
        for_each_row(&mut section, settings, sums, |y, words| engine.load_row(y, words))?;
        section.end()?;
        engine.go_on_after(self.account.iterations, self.account.stats);
        if sums == Sums::Exact {
            engine.skip_to(self.account.done().end());
        }
        Ok(())
    }
}

fn invalid(section: Name, problem: impl Into<String>) -> Damage {
    Damage::Invalid { section: section.1, problem: problem.into() }
}

/// Reads the text section at offset `at` of a file of `length` bytes, and advances `at` to the next section.
fn text(input: &mut impl Read, name: Name, at: &mut u64, length: u64, most: u64) -> Result<String, Damage> {
    let section = Section::begin(input, name, length - *at)?;
    *at += FRAME + section.length;
    String::from_utf8(section.read_all(most)?).map_err(|_| invalid(name, "is not UTF-8"))
}

/// Reads the sections of the scene, the first at offset `at`, and advances `at` beyond them.
fn read_scene(
    input: &mut impl Read,
    version: u32,
    at: &mut u64,
    length: u64,
    folder: &Path,
) -> Result<Scene, Damage> {
    let text = text(input, SCENE, at, length, scene_file::MAX_BYTES)?;
    let unusable = |problem: String| invalid(SCENE, format!("cannot be used: {problem}"));
    if version == 1 {
        return scene_file::parse("scene", &text).map_err(|error| unusable(error.to_string()));
    }
    let (materials, spheres) = arrays::read(input, at, length)?;
    let scene = scene_file::with_spheres("scene", &text, materials, spheres, &[folder]);
    let scene = scene.map_err(|error| unusable(error.to_string()))?;
    scene.check().map_err(|flaw| unusable(flaw.to_string()))?;
    Ok(scene)
}

fn parse_account(text: &str, scene: &Scene) -> Result<Account, Damage> {
    let account: Account =
        serde_json::from_str(text).map_err(|error| invalid(ACCOUNT, format!("cannot be used: {error}")))?;
    if !scene_file::is_digest_of(&account.scene, scene) {
        let ours = scene_file::digest(scene);
        let theirs = account.scene.chars().take(64).flat_map(char::escape_debug).collect();
        return Err(Damage::OtherScene { theirs, ours });
    }
    let iterations = account.iterations;
    if iterations > MAX_ITERATIONS.min(scene.settings.iterations) {
        let all = scene.settings.iterations;
        return Err(invalid(ACCOUNT, format!("has {iterations} iterations, of {all} that were asked for")));
    }
    if let Some(which) = &account.which {
        let is_of =
            which.is_valid() && which.end() <= scene.settings.iterations && which.count() == iterations;
        if !is_of || account.sums != Sums::Exact {
            return Err(invalid(ACCOUNT, "has iterations that cannot be those of its sums"));
        }
    }
    Ok(account)
}

/// Reads the section of sums at offset `at` of a file of `length` bytes, checks every pixel, and passes each row to `take`.
/// Returns the offset after it.
fn read_sums(
    input: &mut impl Read,
    (settings, account): (&Settings, &Account),
    at: u64,
    length: u64,
    mut take: impl FnMut(u32, &[u32]),
) -> Result<u64, Damage> {
    let Account { sums: kind, iterations, .. } = *account;
    let mut sums = begin_sums(input, settings, kind, at, length)?;
    let after = at + FRAME + sums.length;
    let mut fault = None;
    for_each_row(&mut sums, settings, kind, |y, words| {
        let mut pixels = words.chunks_exact(kind.words());
        fault =
            fault.or_else(|| pixels.find_map(|words| kind.fault(words, settings.initial_radius, iterations)));
        take(y, words);
    })?;
    sums.end()?;
    fault.map_or(Ok(after), |fault| Err(invalid(SUMS, fault)))
}

/// Begins to read the section of sums at offset `at` of a file of `length` bytes.
fn begin_sums<R: Read>(
    input: R,
    settings: &Settings,
    sums: Sums,
    at: u64,
    length: u64,
) -> Result<Section<R>, Damage> {
    let section = Section::begin(input, SUMS, length - at)?;
    let (has, expected) = (section.length, sums_bytes(sums, settings.pixels() as u64));
    if has == expected {
        Ok(section)
    } else {
        Err(section.refuse(format!("has {has} bytes where the image takes {expected}")))
    }
}

/// Reads the sums and passes each row of words to `take`, from the top.
fn for_each_row<R: Read>(
    section: &mut Section<R>,
    settings: &Settings,
    sums: Sums,
    mut take: impl FnMut(u32, &[u32]),
) -> Result<(), Damage> {
    let mut words = vec![0; settings.width as usize * sums.words()];
    let mut bytes = vec![0; 4 * words.len()];
    for y in 0..settings.height {
        section.read_exact(&mut bytes)?;
        for (word, bytes) in words.iter_mut().zip(bytes.as_chunks().0) {
            *word = u32::from_le_bytes(*bytes);
        }
        take(y, &words);
    }
    Ok(())
}

/// Reads the earlier image, which must be the last section.
fn read_past(
    input: &mut impl Read,
    left: u64,
    settings: &Settings,
    account: &Account,
) -> Result<Past, Damage> {
    let mut section = Section::begin(input, PAST, left)?;
    let (has, expected) = (section.length, past_bytes(settings.pixels() as u64));
    if has != expected || left != FRAME + has {
        return Err(section.refuse(format!("has {has} bytes where it takes {expected}")));
    }
    let mut word = [0; 4];
    section.read_exact(&mut word)?;
    let iterations = u32::from_le_bytes(word);
    let mut film = Film::new(settings.width, settings.height);
    let mut bytes = vec![0; 12 * settings.width as usize];
    for row in film.pixels.chunks_exact_mut(settings.width as usize) {
        section.read_exact(&mut bytes)?;
        for (pixel, bytes) in row.iter_mut().zip(bytes.chunks_exact(12)) {
            let channel = |c: usize| f32::from_le_bytes(std::array::from_fn(|i| bytes[4 * c + i]));
            *pixel = Rgb::new(channel(0), channel(1), channel(2));
        }
    }
    section.end()?;
    if !(1..=account.iterations).contains(&iterations) {
        return Err(invalid(PAST, format!("is of iteration {iterations}, of {}", account.iterations)));
    }
    Ok(Past { iterations, film })
}
