//! Transcripts: sessions of commands with all that they print, the code that they exit with, and the files that they leave.
//!
//! Each file in `text` holds the sessions of one subcommand, which a person can read, run and review. A session runs in a
//! folder of its own; `#` is its title, `@` prepares a file, `$` is a command (`session.rs` has the whole notation). What
//! follows a command is written by `scripts/bless` and compared here, but for what depends on the clock, the machine and
//! the version (`normal.rs`). Pictures and other files that are no text are told by digests (`describe.rs`).
//!
//! Transcripts show that something has changed, not whether it was right: that was judged by eye when they were written.

mod coverage;
mod describe;
mod normal;
mod session;

use session::{Session, read};
use similar::TextDiff;
use std::fs;
use std::path::{Path, PathBuf};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/transcripts/text")
}

/// The transcripts, each with its path.
fn all() -> Vec<(PathBuf, String)> {
    let mut paths: Vec<PathBuf> =
        fs::read_dir(folder()).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    paths.into_iter().map(|path| (path.clone(), fs::read_to_string(path).unwrap())).collect()
}

/// Runs the sessions of `text/NAME.txt`, and compares what comes of them with what is there; or writes it, to bless it.
fn check(name: &str) {
    let path = folder().join(format!("{name}.txt"));
    let expected = fs::read_to_string(&path).unwrap();
    let sessions = read(&expected);
    // Sessions wait for the disk more than they compute.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(4).build().unwrap();
    let actual: String = pool.install(|| {
        use rayon::prelude::*;
        sessions.par_iter().map(Session::run).collect::<Vec<_>>().concat()
    });
    if actual == expected {
        return;
    }
    if std::env::var("INSTA_UPDATE").is_ok_and(|update| update == "always") {
        fs::write(&path, actual).unwrap();
        return;
    }
    let diff = TextDiff::from_lines(&expected, &actual);
    panic!(
        "tests/transcripts/text/{name}.txt is another now. If it should be, look at each line, run `scripts/bless`, and look at \
         `git diff`.\n{}",
        diff.unified_diff().context_radius(4).header("expected", "actual")
    );
}

macro_rules! transcripts {
    ($($name:ident)*) => {
        $(#[test]
        fn $name() {
            check(stringify!($name));
        })*

        #[test]
        fn every_transcript_is_a_test() {
            let files: Vec<_> = all().iter().map(|(path, _)| path.file_stem().unwrap().to_owned()).collect();
            let mut tests = vec![$(stringify!($name)),*];
            tests.sort_unstable();
            assert_eq!(files, tests);
        }
    };
}

transcripts! { compare export frames help info ladder merge messages particles render resume scenes trace tune usage verify view }
