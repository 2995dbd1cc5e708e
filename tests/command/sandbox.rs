//! Runs the command in a temporary folder, one for each test.

use scene::Film;
use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use tempfile::TempDir;

/// Options of a render that takes milliseconds.
pub(crate) const TINY: [&str; 8] =
    ["--width", "16", "--height", "12", "--iterations", "2", "--photons", "500"];

/// A temporary folder that the command runs in.
pub(crate) struct Sandbox {
    folder: TempDir,
}

/// Exit code and output of a command.
#[derive(Debug)]
pub(crate) struct Ended {
    pub(crate) code: Option<i32>,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

/// The command `program`, which heeds signals. A script that runs the tests in the background may have them ignored, and
/// what the tests start would inherit that.
pub(crate) fn heeding_signals(program: &str) -> Command {
    /// HUP, INT and TERM in the mask of ignored signals.
    const ENDING: u64 = 1 | 1 << 1 | 1 << 14;
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let ignored = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0);
    if ignored & ENDING == 0 {
        return Command::new(program);
    }
    let mut command = Command::new("env");
    command.args(["--default-signal=HUP,INT,TERM", program]);
    command
}

impl Sandbox {
    pub(crate) fn new() -> Self {
        Self { folder: TempDir::new().unwrap() }
    }

    /// The command, prepared to run in this folder.
    pub(crate) fn command<S: AsRef<OsStr>>(&self, args: impl IntoIterator<Item = S>) -> Command {
        let mut command = heeding_signals(env!("CARGO_BIN_EXE_sppm"));
        command.args(args).current_dir(self.folder.path()).stdin(Stdio::null());
        command
    }

    /// Runs the command to its end.
    pub(crate) fn run<S: AsRef<OsStr>>(&self, args: impl IntoIterator<Item = S>) -> Ended {
        let output = self.command(args).output().unwrap();
        Ended {
            code: output.status.code(),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: String::from_utf8(output.stderr).unwrap(),
        }
    }

    /// Runs `sppm render` with `args` and the options of [`TINY`], and expects it to succeed.
    pub(crate) fn render(&self, args: &[&str]) -> Ended {
        let ended = self.run(["render", "--quality=paper"].iter().chain(args).chain(&TINY));
        assert_eq!(ended.code, Some(0), "{args:?}: {ended:?}");
        ended
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub(crate) fn write(&self, name: &str, text: &str) {
        fs::write(self.path(name), text).unwrap();
    }

    pub(crate) fn bytes(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    pub(crate) fn image(&self, name: &str) -> Film {
        files::image_file::read(&self.path(name)).unwrap()
    }

    pub(crate) fn json(&self, name: &str) -> serde_json::Value {
        serde_json::from_slice(&self.bytes(name)).unwrap()
    }

    /// The relative paths of all files in the folder, with their bytes. Paths of folders end in a slash.
    pub(crate) fn contents(&self) -> BTreeMap<String, Vec<u8>> {
        let mut found = BTreeMap::new();
        collect(self.folder.path(), "", &mut found);
        found
    }

    /// The names of [`Self::contents`].
    pub(crate) fn names(&self) -> Vec<String> {
        self.contents().into_keys().collect()
    }
}

fn collect(folder: &Path, prefix: &str, found: &mut BTreeMap<String, Vec<u8>>) {
    for entry in fs::read_dir(folder).unwrap() {
        let entry = entry.unwrap();
        let name = format!("{prefix}{}", entry.file_name().to_string_lossy());
        if entry.file_type().unwrap().is_dir() {
            collect(&entry.path(), &format!("{name}/"), found);
            found.insert(format!("{name}/"), Vec::new());
        } else {
            found.insert(name, fs::read(entry.path()).unwrap());
        }
    }
}

impl Ended {
    /// Expects exit code 2, and as the only output a one-line error that contains all of `words`.
    pub(crate) fn refused(&self, words: &[&str]) {
        assert_eq!(self.code, Some(2), "{self:?}");
        self.said_one_line("error: ", words);
    }

    /// Expects as the only output a line on standard error that begins with `start` and contains all of `words`.
    pub(crate) fn said_one_line(&self, start: &str, words: &[&str]) {
        assert_eq!(self.stdout, "", "{self:?}");
        assert!(!self.stderr.contains("os error"), "{self:?}");
        assert!(self.stderr.starts_with(start), "{self:?}");
        assert!(self.stderr.ends_with('\n') && self.stderr.lines().count() == 1, "{self:?}");
        for word in words {
            assert!(self.stderr.contains(word), "no {word:?} in {self:?}");
        }
    }
}
