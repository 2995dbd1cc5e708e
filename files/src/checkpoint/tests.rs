//! Tests of checkpoints: writing and reading them, damaged files, generations and the lock.

use super::sections::{
    ACCOUNT, FRAME, GLOW, HEADER, MATERIALS, MOTION, NOTE, Name, PAST, SCENE, SPHERES, SUMS,
};
use super::*;
use crate::atomic_file::Output;
use crate::scene_file;
use scene::settings::MAX_DEPOSITS;
use scene::{
    Engine, Film, Iterations, Probe, Progress, Resumable, Rgb, Scene, Settings, Stats, Stop, Sums, TRANSPORT,
};
use std::fs;
use std::io::{self, Cursor, Write as _};
use tempfile::TempDir;

/// An engine that stores words and does not render.
struct Memory {
    progress: Progress,
    sums: Sums,
    words: Vec<u32>,
}

impl Memory {
    /// An engine with valid words, all different.
    fn new(settings: Settings, sums: Sums) -> Self {
        let radius_squared = settings.initial_radius * settings.initial_radius;
        let word = |i: usize| match (sums, i % 8) {
            (Sums::Photons, 6) => (i as f32).to_bits(),
            (Sums::Photons, 7) => (radius_squared / (1.0 + i as f32)).to_bits(),
            _ => (i as u32).wrapping_mul(0x9e37_79b9),
        };
        let words = (0..settings.pixels() * sums.words()).map(word).collect();
        let stats = Stats { photons: u64::MAX, camera_seconds: 0.1, ..Stats::default() };
        Self { progress: Progress { settings, iterations: 3, next: 3, stats }, sums, words }
    }

    fn blank(settings: Settings, sums: Sums) -> Self {
        let words = vec![0; settings.pixels() * sums.words()];
        Self { progress: Progress::new(&settings), sums, words }
    }

    fn row(&mut self, y: u32) -> &mut [u32] {
        let length = self.progress.settings.width as usize * self.sums.words();
        &mut self.words[y as usize * length..][..length]
    }
}

impl Engine for Memory {
    fn progress(&self) -> &Progress {
        &self.progress
    }
    fn iterate_unless(&mut self, _: &Stop) -> bool {
        true
    }
    fn probe(&self, _: u32, _: u32) -> Probe {
        Probe::default()
    }
}

impl Resumable for Memory {
    fn sums(&self) -> Sums {
        self.sums
    }
    fn save_row(&self, y: u32, words: &mut [u32]) {
        words.copy_from_slice(&self.words[y as usize * words.len()..][..words.len()]);
    }
    fn load_row(&mut self, y: u32, words: &[u32]) {
        self.row(y).copy_from_slice(words);
    }
    fn go_on_after(&mut self, iterations: u32, stats: Stats) {
        self.progress.go_on_after(iterations, stats);
    }
    fn skip_to(&mut self, next: u32) {
        self.progress.next = next;
    }
}

fn scene() -> Scene {
    let scene = crate::builtin::scene("cornell").unwrap();
    Scene { settings: Settings { width: 5, height: 3, iterations: 7, ..scene.settings }, ..scene }
}

/// A checkpoint as bytes.
fn bytes(engine: &Memory, digest: &str, past: Option<&Past>) -> Vec<u8> {
    let contents = Contents { scene: &scene(), digest, version: "1.2.3", note: "{}", which: None, past };
    let mut bytes = Vec::new();
    write(&mut bytes, engine, &contents).unwrap();
    bytes
}

fn whole(sums: Sums, past: Option<&Past>) -> Vec<u8> {
    bytes(&Memory::new(scene().settings, sums), &scene_file::digest(&scene()), past)
}

fn read(bytes: &[u8]) -> Result<Checkpoint, Damage> {
    Checkpoint::read(&mut Cursor::new(bytes), bytes.len() as u64)
}

fn past() -> Past {
    let pixels = (0..15).map(|i| Rgb::new(i as f32, -0.5, f32::MAX)).collect();
    Past { iterations: 2, film: Film { width: 5, height: 3, pixels } }
}

#[test]
fn what_is_written_is_read() {
    for sums in [Sums::Photons, Sums::Paths] {
        for past in [None, Some(past())] {
            let bytes = whole(sums, past.as_ref());
            let checkpoint = read(&bytes).unwrap();
            assert_eq!(checkpoint.scene, scene());
            assert_eq!((checkpoint.past.as_ref(), &checkpoint.note[..]), (past.as_ref(), "{}"));
            let engine = Memory::new(scene().settings, sums);
            let account = Account {
                version: "1.2.3".into(),
                transport: TRANSPORT,
                scene: scene_file::digest(&scene()),
                sums,
                iterations: 3,
                which: None,
                stats: engine.progress.stats,
            };
            assert_eq!(checkpoint.account, account);
            let mut again = Memory::blank(scene().settings, sums);
            checkpoint.restore(&mut Cursor::new(&bytes), &mut again).unwrap();
            assert_eq!(
                (again.words, again.progress.iterations, again.progress.stats),
                (engine.words, 3, engine.progress.stats)
            );
            let estimate = length(&scene(), "{}", sums, past.is_some());
            assert!((estimate - 4096..=estimate).contains(&(bytes.len() as u64)));
        }
    }
}

/// Whatever is long in a checkpoint: the name of its scene, its spheres, its note.
#[test]
fn lengths_are_of_all_that_is_written() {
    let scene = scene();
    let named = Scene { name: "a".repeat(20_000), ..scene.clone() };
    let many = Scene { spheres: (0..1000).map(|_| scene.spheres[0]).collect(), ..scene.clone() };
    let long = "n".repeat(20_000);
    for (scene, note) in [(&named, "{}"), (&many, "{}"), (&scene, long.as_str())] {
        let engine = Memory::new(scene.settings, Sums::Photons);
        let contents = Contents { scene, digest: "a", version: "1", note, which: None, past: None };
        let mut bytes = Vec::new();
        write(&mut bytes, &engine, &contents).unwrap();
        let told = length(scene, note, Sums::Photons, false);
        assert!((told - 4096..=told).contains(&(bytes.len() as u64)), "{told} for {}", bytes.len());
    }
}

/// What is told of a file's length differs between kinds of sums, and with an earlier image, by as much as the file does.
#[test]
fn lengths_differ_as_files_do() {
    let past = past();
    let both = |sums, past: Option<&Past>| {
        let told = length(&scene(), "{}", sums, past.is_some()) as i64;
        (told, whole(sums, past).len() as i64)
    };
    let (told, long) = both(Sums::Photons, None);
    for (sums, past) in [
        (Sums::Photons, Some(&past)),
        (Sums::Paths, None),
        (Sums::Paths, Some(&past)),
        (Sums::Exact, None),
        (Sums::Exact, Some(&past)),
    ] {
        let (more, longer) = both(sums, past);
        // The account names the kind of sums.
        assert!((more - told - (longer - long)).abs() < 16, "{sums}, {past:?}: {more} of {longer}");
    }
}

#[test]
fn the_format_is_as_documented() {
    let bytes = whole(Sums::Photons, Some(&past()));
    assert_eq!(bytes[..8], *b"\x89SPPM\r\n\x1a");
    assert_eq!(bytes[8..12], FORMAT.to_le_bytes());
    assert_eq!(bytes[12..20], (bytes.len() as u64).to_le_bytes());
    assert_eq!(bytes[20..24], crc32fast::hash(&bytes[..20]).to_le_bytes());
    let mut at = HEADER as usize;
    for name in [SCENE, MATERIALS, SPHERES, GLOW, MOTION, ACCOUNT, NOTE, SUMS, PAST] {
        assert_eq!(bytes[at..at + 4], name.0);
        let length = u64::from_le_bytes(bytes[at + 4..at + 12].try_into().unwrap()) as usize;
        let end = at + 12 + length;
        assert_eq!(bytes[end..end + 4], crc32fast::hash(&bytes[at..end]).to_le_bytes());
        at += FRAME as usize + length;
    }
    assert_eq!(at, bytes.len());
}

/// Each by what it is for a user.
#[test]
fn damaged_sections_are_named() {
    let bytes = whole(Sums::Photons, Some(&past()));
    let mut at = HEADER as usize;
    for words in [
        "its scene",
        "its materials",
        "its spheres",
        "its lamps",
        "its velocities",
        "its account",
        "its note",
        "its sums",
        "its earlier image",
    ] {
        let length = u64::from_le_bytes(bytes[at + 4..at + 12].try_into().unwrap()) as usize;
        at += FRAME as usize + length;
        let mut broken = bytes.clone();
        broken[at - 1] ^= 1; // of the checksum
        let line = read(&broken).unwrap_err().to_string();
        assert_eq!(line, format!("is damaged: the checksum of {words} does not match"));
    }
    assert_eq!(at, bytes.len());
}

#[test]
fn every_flipped_bit_is_found() {
    for sums in [Sums::Photons, Sums::Paths] {
        let mut bytes = whole(sums, Some(&past()));
        for bit in 0..8 * bytes.len() {
            bytes[bit / 8] ^= 1 << (bit % 8);
            let damage = read(&bytes).unwrap_err();
            let is_told = match bit / 8 {
                0..8 => matches!(damage, Damage::NoCheckpoint),
                8..24 => matches!(damage, Damage::Flipped { section: "its header" }),
                _ => matches!(damage, Damage::Flipped { section } if section != "its header"),
            };
            assert!(is_told, "bit {bit}: {damage}");
            bytes[bit / 8] ^= 1 << (bit % 8);
        }
    }
}

#[test]
fn every_cut_is_found() {
    let bytes = whole(Sums::Photons, None);
    for length in 0..bytes.len() {
        let damage = read(&bytes[..length]).unwrap_err();
        assert!(
            matches!((length, &damage), (0, Damage::NoCheckpoint) | (1.., Damage::Truncated { .. })),
            "{length}: {damage}"
        );
    }
    let mut longer = bytes.clone();
    longer.push(0);
    assert!(matches!(read(&longer), Err(Damage::Appended { .. })));
}

/// A scene with a lamp that is a sphere of every kind of material, one that moves, and a sky.
fn varied() -> Scene {
    let text = "background = [0.1, 0.2, 0.3]\n[camera]\neye = [0, 0, 10]\ntarget = [0, 0, 0]\n\
        vertical_fov_degrees = 40\nshutter = [0, 1]\n[materials.white]\ntype = \"diffuse\"\nalbedo = [0.5, 0.5, 0.5]\n\
        [[sphere]]\ncenter = [0, 3, 0]\nradius = 1\nmaterial = \"white\"\nemission = [1, 1, 1]\n\
        [[sphere]]\ncenter = [0, 0, 0]\nradius = 1\nvelocity = [0, 0.5, 0]\n\
        material = { type = \"dielectric\", albedo = [1, 1, 1], ior = 1.5 }\n\
        [[sphere]]\ncenter = [3, 0, 0]\nradius = 1\nmaterial = { type = \"specular\", albedo = [1, 0.5, 1] }\n";
    let scene = scene_file::parse("version-1.toml", text).unwrap();
    let settings =
        Settings { width: 4, height: 3, iterations: 2, photons_per_iteration: 100, ..scene.settings };
    Scene { name: "v1".into(), settings, ..scene }
}

#[test]
fn every_kind_of_sphere_and_material_is_read_back() {
    let scene = varied();
    let engine =
        Memory { progress: Progress::new(&scene.settings), ..Memory::new(scene.settings, Sums::Photons) };
    let digest = scene_file::digest(&scene);
    let contents =
        Contents { scene: &scene, digest: &digest, version: "1.2.3", note: "", which: None, past: None };
    let mut bytes = Vec::new();
    write(&mut bytes, &engine, &contents).unwrap();
    assert_eq!(read(&bytes).unwrap().scene, scene);
}

/// The file was written by the last version of the program that wrote the scene as text.
#[test]
fn a_file_of_version_1_is_read() {
    let bytes = include_bytes!("../../../fixtures/checkpoints/version-1.sppm");
    assert_eq!(bytes[8..12], 1_u32.to_le_bytes());
    let checkpoint = read(bytes).unwrap();
    assert_eq!(checkpoint.scene, varied());
    assert_eq!(checkpoint.account.iterations, 2);
    assert_eq!(checkpoint.account.transport, 1);
}

/// Its light was chosen by another rule: sums of both would be an image of neither.
#[test]
fn sums_of_another_light_transport_are_not_restored() {
    let bytes = include_bytes!("../../../fixtures/checkpoints/version-1.sppm");
    let checkpoint = read(bytes).unwrap();
    let mut engine = Memory::blank(varied().settings, Sums::Photons);
    let line = checkpoint.restore(&mut Cursor::new(bytes), &mut engine).unwrap_err().to_string();
    assert!(
        line.starts_with("was begun by version 1 of the light transport (sppm 0.1.0), and this"),
        "{line}"
    );
    assert_eq!(engine.progress.iterations, 0);
}

/// A later version is another as well.
#[test]
fn sums_are_of_this_light_transport_alone() {
    let mut checkpoint = read(&whole(Sums::Paths, None)).unwrap();
    checkpoint.check_transport().unwrap();
    for other in [TRANSPORT - 1, TRANSPORT + 1] {
        checkpoint.account.transport = other;
        let damage = checkpoint.check_transport().unwrap_err();
        assert!(matches!(damage, Damage::Transport { found, .. } if found == other), "{damage}");
    }
}

/// Only sums that can be merged may be of other iterations than the first, and of as many as they say, within the render.
#[test]
fn sums_are_of_the_iterations_that_are_named() {
    let with = |sums: Sums, which: Iterations| {
        let engine = Memory::blank(scene().settings, sums);
        let engine = Memory { progress: Progress { iterations: 3, ..engine.progress }, ..engine };
        let digest = scene_file::digest(&scene());
        let contents = Contents {
            scene: &scene(),
            digest: &digest,
            version: "1",
            note: "",
            which: Some(&which),
            past: None,
        };
        let mut bytes = Vec::new();
        write(&mut bytes, &engine, &contents).unwrap();
        read(&bytes).map(|checkpoint| checkpoint.account.done())
    };
    let some = |start: u32, end: u32| Iterations::from(start..end);
    let ranges = |text: &str| serde_json::from_str::<Iterations>(text).unwrap();
    assert_eq!(with(Sums::Exact, some(4, 7)).unwrap(), some(4, 7));
    assert_eq!(with(Sums::Exact, ranges("[[0, 1], [5, 7]]")).unwrap(), ranges("[[0, 1], [5, 7]]"));
    let wrong = [
        (Sums::Photons, some(4, 7)),
        (Sums::Exact, some(5, 8)),
        (Sums::Exact, some(4, 6)),
        (Sums::Exact, some(0, 4)),
        // Ranges that touch, that are out of order, and one that is empty.
        (Sums::Exact, ranges("[[4, 5], [5, 7]]")),
        (Sums::Exact, ranges("[[5, 7], [0, 1]]")),
        (Sums::Exact, ranges("[[2, 2], [4, 7]]")),
    ];
    for (sums, which) in wrong {
        let line = with(sums, which.clone()).unwrap_err().to_string();
        assert!(line.contains("iterations that cannot be those of its sums"), "{sums:?} of {which}: {line}");
    }
}

/// A part of a render goes on after its last iteration, however many were left out before.
#[test]
fn a_part_goes_on_after_its_last_iteration() {
    let next = |which: Option<Iterations>| {
        let blank = Memory::blank(scene().settings, Sums::Exact);
        let engine = Memory { progress: Progress { iterations: 3, ..blank.progress }, ..blank };
        let digest = scene_file::digest(&scene());
        let contents = Contents {
            scene: &scene(),
            digest: &digest,
            version: "1",
            note: "",
            which: which.as_ref(),
            past: None,
        };
        let mut bytes = Vec::new();
        write(&mut bytes, &engine, &contents).unwrap();
        let mut again = Memory::blank(scene().settings, Sums::Exact);
        read(&bytes).unwrap().restore(&mut Cursor::new(&bytes), &mut again).unwrap();
        (again.progress.iterations, again.progress.next)
    };
    assert_eq!(next(None), (3, 3));
    assert_eq!(next(Some((2..5).into())), (3, 5));
}

/// Rows of materials and spheres that no scene has are rejected even if all checksums match.
#[test]
fn invalid_spheres_are_rejected() {
    let bytes = whole(Sums::Photons, None);
    let start = |name: Name| bytes.windows(4).position(|window| window == name.0).unwrap();
    let length = |at: usize| u64::from_le_bytes(bytes[at + 4..at + 12].try_into().unwrap()) as usize;
    let cases = [
        (MATERIALS, 0, 3, "its materials cannot be used: row 0 is not valid"),
        (MATERIALS, 4, 2_f32.to_bits(), "albedo of material 1 is outside [0, 1]"),
        (SPHERES, 0, f32::NAN.to_bits(), "center of sphere 1 must be finite numbers from -1e15 to 1e15"),
        (SPHERES, 12, 0, "radius of sphere 1 must be above 0 (from 1e-15 to 1e15)"),
        (SPHERES, 16, 99, "material of sphere 1 is index 99 of"),
        (GLOW, 0, 99, "its lamps cannot be used: row 0 is not valid"),
        (GLOW, 4, (-1_f32).to_bits(), "is outside [0, 1e15]"),
    ];
    for (name, offset, word, expected) in cases {
        let at = start(name);
        let mut bytes = bytes.clone();
        forge(&mut bytes, [at, at + 12 + offset, at + FRAME as usize + length(at)], word);
        let line = read(&bytes).unwrap_err().to_string();
        assert!(line.contains(expected), "{line}");
    }
}

/// Sets the four bytes at `at`, then recomputes the checksum of the section or header from `start` to `end`.
fn forge(bytes: &mut [u8], [start, at, end]: [usize; 3], word: u32) {
    bytes[at..at + 4].copy_from_slice(&word.to_le_bytes());
    let checksum = crc32fast::hash(&bytes[start..end - 4]);
    bytes[end - 4..end].copy_from_slice(&checksum.to_le_bytes());
}

#[test]
fn another_version_is_reported() {
    let mut bytes = whole(Sums::Photons, None);
    forge(&mut bytes, [0, 8, 24], 4);
    let line = read(&bytes).unwrap_err().to_string();
    assert_eq!(line, "has format 4; this version of sppm reads formats up to 3");
}

#[test]
fn sums_of_another_scene_are_rejected() {
    let bytes = bytes(&Memory::new(scene().settings, Sums::Photons), "0123abcd", None);
    let line = read(&bytes).unwrap_err().to_string();
    let ours = scene_file::digest(&scene());
    assert_eq!(
        line,
        format!("has the sums of another scene: they belong to 0123abcd, and its scene is {ours}")
    );
}

/// An image of another size has another number of pixels.
#[test]
fn sums_of_another_size_are_rejected() {
    let narrow = Settings { width: 4, ..scene().settings };
    let bytes = bytes(&Memory::new(narrow, Sums::Photons), &scene_file::digest(&scene()), None);
    let line = read(&bytes).unwrap_err().to_string();
    assert_eq!(line, "is wrong: its sums has 384 bytes where the image takes 480");
}

/// The iterations that are done set the bound, not those that were asked for.
#[test]
fn exact_sums_are_no_larger_than_their_iterations_allow() {
    let with = |photons: u64| {
        let blank = Memory::blank(scene().settings, Sums::Exact);
        let mut engine = Memory { progress: Progress { iterations: 3, ..blank.progress }, ..blank };
        let last = engine.words.len() - 2;
        engine.words[last..].copy_from_slice(&[photons as u32, (photons >> 32) as u32]);
        read(&bytes(&engine, &scene_file::digest(&scene()), None)).map_err(|damage| damage.to_string())
    };
    assert_eq!(with(3 * MAX_DEPOSITS).unwrap().account.iterations, 3);
    let line = with(3 * MAX_DEPOSITS + 1).unwrap_err();
    assert!(line.contains("whose count of photons is too large for its iterations"), "{line}");
}

#[test]
fn a_note_that_is_no_text_is_rejected() {
    let mut bytes = whole(Sums::Paths, None);
    let start = bytes.windows(4).position(|window| window == NOTE.0).unwrap();
    // Its two bytes; the others are the checksum, which is computed anew.
    forge(&mut bytes, [start, start + 12, start + FRAME as usize + 2], u32::MAX);
    assert_eq!(read(&bytes).unwrap_err().to_string(), "is wrong: its note is not UTF-8");
}

/// Another program may write to the file between the two.
#[test]
fn sums_that_change_after_they_were_read_are_not_restored() {
    let mut bytes = whole(Sums::Paths, None);
    let checkpoint = read(&bytes).unwrap();
    let last = bytes.len() - 5;
    bytes[last] ^= 1;
    let mut engine = Memory::blank(scene().settings, Sums::Paths);
    let damage = checkpoint.restore(&mut Cursor::new(&bytes), &mut engine).unwrap_err();
    assert!(matches!(damage, Damage::Flipped { section: "its sums" }), "{damage}");
    assert_eq!(engine.progress.iterations, 0);
}

/// Values that no engine writes are rejected even if all checksums match.
#[test]
fn invalid_content_is_rejected() {
    let bytes = whole(Sums::Photons, None);
    let end = bytes.len();
    let start = end - 16 - 4 * 8 * 15;
    let pixel = start + 12 + 5 * 32;
    for (word, value) in [(6, -1.0), (6, f32::NAN), (6, f32::INFINITY), (7, 0.0), (7, 5.0), (7, f32::NAN)] {
        let mut bytes = bytes.clone();
        forge(&mut bytes, [start, pixel + 4 * word, end], value.to_bits());
        let damage = read(&bytes).unwrap_err();
        assert!(matches!(damage, Damage::Invalid { section: "its sums", .. }), "{damage}");
    }
    let mut iterations = Memory::new(scene().settings, Sums::Photons);
    iterations.progress.iterations = 8;
    let damage = read(&self::bytes(&iterations, &scene_file::digest(&scene()), None)).unwrap_err();
    assert!(damage.to_string().contains("8 iterations, of 7"), "{damage}");
    let late = Past { iterations: 4, ..past() };
    let damage = read(&whole(Sums::Photons, Some(&late))).unwrap_err();
    assert!(matches!(damage, Damage::Invalid { section: "its earlier image", .. }), "{damage}");
}

/// From the first iteration to the last that is done.
#[test]
fn an_earlier_image_is_of_some_iteration_that_is_done() {
    let of = |iterations: u32| read(&whole(Sums::Photons, Some(&Past { iterations, ..past() })));
    for iterations in 1..=3 {
        assert_eq!(of(iterations).unwrap().past.unwrap().iterations, iterations);
    }
    for iterations in [0, 4] {
        let line = of(iterations).unwrap_err().to_string();
        assert!(line.contains(&format!("its earlier image is of iteration {iterations}, of 3")), "{line}");
    }
}

#[test]
fn an_engine_of_another_algorithm_is_rejected() {
    let bytes = whole(Sums::Photons, None);
    let mut engine = Memory::blank(scene().settings, Sums::Paths);
    let damage = read(&bytes).unwrap().restore(&mut Cursor::new(&bytes), &mut engine).unwrap_err();
    assert!(damage.to_string().contains("photon mapping, and the engine's is of path tracing"), "{damage}");
}

fn store() -> (TempDir, Store) {
    let folder = TempDir::new().unwrap();
    let store = Store::new(folder.path().join("a.sppm"));
    (folder, store)
}

fn save(store: &Store, iterations: u32) {
    let mut engine = Memory::new(scene().settings, Sums::Photons);
    engine.progress.iterations = iterations;
    let bytes = bytes(&engine, &scene_file::digest(&scene()), None);
    store.save(|out: &mut Output| out.write_all(&bytes)).unwrap();
}

fn iterations(store: &Store) -> Option<(u32, bool)> {
    let loaded = store.load().unwrap()?;
    Some((loaded.checkpoint.account.iterations, loaded.fallback.is_some()))
}

fn names(folder: &TempDir) -> Vec<String> {
    let name = |entry: io::Result<fs::DirEntry>| entry.unwrap().file_name().into_string().unwrap();
    let mut names: Vec<_> = fs::read_dir(folder.path()).unwrap().map(name).collect();
    names.sort();
    names
}

#[test]
fn two_generations_are_kept() {
    let (folder, store) = store();
    assert_eq!(iterations(&store), None);
    for done in 1..5 {
        save(&store, done);
        assert_eq!(iterations(&store), Some((done, false)));
    }
    assert_eq!(names(&folder), ["a.sppm", "a.sppm.1"]);
    assert_eq!(iterations(&Store::new(store.previous())), Some((3, false)));
    store.remove().unwrap();
    assert_eq!(names(&folder), [""; 0]);
    store.remove().unwrap();
}

#[test]
fn a_damaged_generation_falls_back_to_the_older_one() {
    let (_folder, store) = store();
    (1..3).for_each(|done| save(&store, done));
    let bytes = fs::read(store.path()).unwrap();
    fs::write(store.path(), &bytes[..bytes.len() - 1]).unwrap();
    let loaded = store.load().unwrap().unwrap();
    assert_eq!((loaded.checkpoint.account.iterations, &loaded.path), (1, &store.previous()));
    assert!(loaded.fallback.unwrap().problem.contains("cut short"));

    fs::write(store.previous(), "nothing").unwrap();
    let line = store.load().unwrap_err().to_string();
    assert!(
        line.contains("cut short") && line.contains("and the older generation is no checkpoint"),
        "{line}"
    );

    // What is wrong with both is told once.
    fs::write(store.path(), "nothing").unwrap();
    let line = store.load().unwrap_err().to_string();
    assert!(line.contains("is no checkpoint") && !line.contains("older"), "{line}");

    fs::remove_file(store.path()).unwrap();
    save(&store, 6);
    save(&store, 7);
    fs::remove_file(store.path()).unwrap();
    assert_eq!(iterations(&store), Some((6, true)));
    store.fall_back().unwrap();
    assert_eq!(iterations(&store), Some((6, false)));

    let mut newer = fs::read(store.path()).unwrap();
    forge(&mut newer, [0, 8, 24], 4);
    save(&store, 7);
    fs::write(store.path(), newer).unwrap();
    assert!(store.load().unwrap_err().problem.contains("format 4"));
}

#[test]
fn a_write_that_fails_changes_nothing() {
    let (folder, store) = store();
    (1..3).for_each(|done| save(&store, done));
    let failed = store.save(|out| {
        out.write_all(&vec![0; 100_000])?;
        Err(io::ErrorKind::StorageFull.into())
    });
    assert!(failed.is_err());
    assert_eq!(iterations(&store), Some((2, false)));
    assert_eq!(iterations(&Store::new(store.previous())), Some((1, false)));
    assert_eq!(names(&folder), ["a.sppm", "a.sppm.1"]);
}

/// A process that is killed after it has linked the older generation leaves one file under both names.
#[test]
fn a_save_separates_generations_that_are_the_same_file() {
    let (folder, store) = store();
    save(&store, 1);
    fs::hard_link(store.path(), store.previous()).unwrap();
    save(&store, 2);
    assert_eq!(iterations(&store), Some((2, false)));
    assert_eq!(iterations(&Store::new(store.previous())), Some((1, false)));
    assert_eq!(names(&folder), ["a.sppm", "a.sppm.1"]);
}

/// They may be on another file system than the link.
#[cfg(unix)]
#[test]
fn both_generations_are_where_a_link_leads() {
    let (folder, store) = store();
    fs::create_dir(folder.path().join("there")).unwrap();
    std::os::unix::fs::symlink("there/b.sppm", store.path()).unwrap();
    let there = || {
        let entries = fs::read_dir(folder.path().join("there")).unwrap();
        let mut names: Vec<_> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    };
    for done in 1..4 {
        save(&store, done);
        assert_eq!(iterations(&store), Some((done, false)));
    }
    assert_eq!(names(&folder), ["a.sppm", "there"]);
    assert_eq!(there(), ["b.sppm", "b.sppm.1"]);
    fs::write(store.path(), "nothing").unwrap();
    assert_eq!(iterations(&store), Some((2, true)));
    store.fall_back().unwrap();
    assert_eq!(iterations(&store), Some((2, false)));
    assert!(store.path().is_symlink());
    save(&store, 3);
    store.remove().unwrap();
    assert!(store.path().is_symlink() && !store.exists());
    assert_eq!(there(), [""; 0]);
}

/// A checkpoint names files of particles by where they were; all may be moved together.
#[test]
fn particles_are_found_beside_a_checkpoint_that_was_moved() {
    let folder = TempDir::new().unwrap();
    let [from, to] = ["from", "to"].map(|name| folder.path().join(name));
    fs::create_dir(&from).unwrap();
    fs::write(from.join("a.xyz"), "3\n\nO 0 0 0\nH 1 0 0\nH 0 1 0\n").unwrap();
    let settings = "[settings]\nwidth = 5\nheight = 3\niterations = 7\n";
    let text = format!("[stage]\n[[particles]]\nfile = \"a.xyz\"\n{settings}");
    fs::write(from.join("a.toml"), text).unwrap();
    let scene = scene_file::load(&from.join("a.toml")).unwrap();
    let (engine, digest) = (Memory::new(scene.settings, Sums::Paths), scene_file::digest(&scene));
    let contents =
        Contents { scene: &scene, digest: &digest, version: "1", note: "", which: None, past: None };
    Store::new(from.join("a.sppm")).save(|out| write(out, &engine, &contents)).unwrap();
    fs::rename(&from, &to).unwrap();
    let load = || Store::new(to.join("a.sppm")).load();
    let imports = load().unwrap().unwrap().checkpoint.scene.imports;
    assert_eq!((imports.len(), &imports[0].file), (1, &to.join("a.xyz")));
    // Another file of that name is not taken for it.
    fs::write(to.join("a.xyz"), "1\n\nO 0 0 0\n").unwrap();
    let line = load().unwrap_err().to_string();
    assert!(line.contains("a.xyz has changed"), "{line}");
}
