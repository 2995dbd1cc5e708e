//! A corpus of small random scenes, of which one line each is stored: what is in the scene, digests of all that its render shows,
//! and the work that it took.
//!
//! The rows with images show what a change looks like. They are few, so a slip in a rare case may miss all of them; the
//! corpus is for that. Its scenes are those of the equality tests, drawn from fixed seeds, each by itself: a line depends on
//! its number alone. `corpus.txt` holds the lines. Only the reference writes them, by `scripts/bless`, and the fast engine is
//! compared with the same file.

mod render;
mod scenes;

use crate::cases::tell;
use crate::golden::blesses;
use fast::LaneKind;
use rayon::prelude::*;
use render::{Found, Method, found};
use scenes::{Family, Sample, sample};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::{env, fs};

/// The lines, next to this file.
const FILE: &str = "tests/snapshots/corpus.txt";

/// What the file begins with.
const HEADER: &str = "\
# What tests/snapshots/corpus renders: a scene a line. Written by scripts/bless.
# number, kind and settings, what is in it; crc-32 of the scene and of what is rendered; counted work: camera segments, shadow
# rays, visible points, photon segments, deposits, contributions
";

/// So many lines that differ are shown.
const SHOWN: usize = 6;

fn path() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(FILE)
}

/// The stored lines.
fn blessed() -> Vec<String> {
    let text =
        fs::read_to_string(path()).unwrap_or_else(|error| panic!("{FILE}: {error}; scripts/bless makes it"));
    text.lines().filter(|line| !line.starts_with('#')).map(str::to_owned).collect()
}

/// The lines of all samples, by this engine. On all threads: the reference has only one for each.
fn lines(engine: impl Fn(&Sample) -> Found + Sync) -> Vec<String> {
    let numbers: Vec<u32> = (0..Family::total()).collect();
    let line = |number: &u32| {
        let sample = sample(*number);
        let found = engine(&sample);
        format!("{} | scene {:08x} {found}", sample.title(&found), sample.digest())
    };
    numbers.par_iter().with_max_len(1).map(line).collect()
}

/// Says which lines are not as stored, and how to look into each.
fn compare(who: &str, actual: &[String]) {
    let expected = blessed();
    let differing: Vec<u32> = (0..actual.len().max(expected.len()) as u32)
        .filter(|&k| expected.get(k as usize) != actual.get(k as usize))
        .collect();
    if differing.is_empty() {
        return;
    }
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("corpus");
    fs::create_dir_all(&folder).unwrap();
    let mut told = String::new();
    for &number in differing.iter().take(SHOWN) {
        let line = |lines: &[String]| lines.get(number as usize).map_or("none", String::as_str).to_owned();
        write!(told, "\n  blessed {}\n  is now  {}\n", line(&expected), line(actual)).unwrap();
        if number < Family::total() {
            let sample = sample(number);
            let file = folder.join(format!("{number:03}.toml"));
            fs::write(&file, sample.text()).unwrap();
            let method = if sample.method == Method::Path { " --method path" } else { "" };
            writeln!(told, "  to render it: sppm render {}{method}", file.display()).unwrap();
        }
    }
    panic!(
        "{who} renders {} of {} scenes of the corpus unlike {FILE}: {differing:?}\n{told}\n\
         If a scene's own digest differs, another scene is drawn. If what is rendered is meant to change, run scripts/bless \
         and look at git diff; only the reference writes the file.",
        differing.len(),
        actual.len()
    );
}

#[test]
fn reference_renders_the_corpus_as_blessed() {
    let lines = lines(|sample| found(sample, None));
    if blesses() {
        fs::write(path(), format!("{HEADER}{}\n", lines.join("\n"))).unwrap();
    }
    compare("the reference", &lines);
    tell("snapshots", lines.len(), "scenes of the corpus as blessed, by the reference");
}

/// Each scene on one kind of lanes, in turn: that they are alike is tested elsewhere. Every other render is resumed by another
/// engine after the first iteration.
#[test]
fn fast_renders_the_corpus_as_blessed() {
    let lanes = |number: u32| LaneKind::ALL[number as usize % LaneKind::ALL.len()];
    let lines = lines(|sample| found(sample, Some(lanes(sample.number))));
    compare("fast", &lines);
    tell("snapshots", lines.len(), "scenes of the corpus as blessed, by fast");
}

/// Each thing that a scene may have is in enough of them, and light arrives in most.
#[test]
fn the_corpus_has_all_that_scenes_may_have() {
    let blessed = blessed();
    assert_eq!(blessed.len(), Family::total() as usize);
    let of = |what: &str| blessed.iter().filter(|line| line.split(' ').any(|word| word == what)).count();
    for (what, least) in [
        ("glass", 60),
        ("mirror", 60),
        ("glowing-glass", 15),
        ("sky", 30),
        ("lens", 20),
        ("motion", 20),
        ("gaussian", 20),
        ("mitchell", 20),
        ("pilots", 10),
        ("clearance", 30),
        ("samples", 15),
        ("global", 12),
        ("aimed", 15),
        ("guided", 6),
        ("path", 30),
        ("choice", 5),
    ] {
        assert!(of(what) >= least, "{what}: {} scenes, not {least}", of(what));
    }
    let is_dark = |line: &&String| line.ends_with(" 0") && line.contains(" sppm ");
    let dark = blessed.iter().filter(is_dark).count();
    assert!(dark < blessed.len() / 2, "in {dark} scenes no photon counts");
}
