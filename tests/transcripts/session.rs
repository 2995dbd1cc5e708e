//! Sessions: what is typed, and what comes of it.
//!
//! ```text
//! # A title, or more lines of it
//! @ copy fixtures/particles/water.pdb          a file of the repository
//! @ write mine.toml                            a file of the lines that follow
//! | [camera]
//! $ sppm render mine.toml < in > out           words may be in single or double quotes
//! $ rm FILE; mkdir DIR; cp A B; head FILE N; flip FILE N; append FILE TEXT
//! ? 2                                          the exit code, unless it is 0
//! > ...                                        standard output
//! ! ...                                        standard error
//! + file  what it is                           a new file; ~ a changed one; - one that is gone
//! |   its text
//! ```

use crate::describe::describe;
use crate::normal::normal;
use rustix::process::{Pid, Signal, kill_process};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs::{self, File};
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;
use tempfile::TempDir;

/// Lines of a text that are shown; a longer one is told by its digest.
const MOST_LINES: usize = 260;

/// What takes longer does not end.
const LONGEST: Duration = Duration::from_mins(1);

/// A title and steps.
#[derive(Default)]
pub(crate) struct Session {
    head: String,
    steps: Vec<Step>,
}

/// What is typed.
pub(crate) enum Step {
    Copy(String),
    Write(String, Vec<String>),
    Run(String),
    Blank,
}

/// The sessions of a transcript, without what came of them.
pub(crate) fn read(text: &str) -> Vec<Session> {
    let mut sessions = vec![Session::default()];
    let mut takes_lines = false;
    for line in text.lines() {
        let session = sessions.last_mut().unwrap();
        if line.starts_with('#') {
            if session.steps.is_empty() {
                session.head.extend([line, "\n"]);
            } else {
                sessions.push(Session { head: format!("{line}\n"), steps: Vec::new() });
            }
            continue;
        }
        if let (true, Some(content), Some(Step::Write(_, lines))) =
            (takes_lines, line.strip_prefix('|'), session.steps.last_mut())
        {
            lines.push(content.strip_prefix(' ').unwrap_or(content).to_owned());
            continue;
        }
        takes_lines = false;
        if let Some(command) = line.strip_prefix("$ ") {
            session.steps.push(Step::Run(command.into()));
        } else if let Some(path) = line.strip_prefix("@ copy ") {
            session.steps.push(Step::Copy(path.into()));
        } else if let Some(name) = line.strip_prefix("@ write ") {
            session.steps.push(Step::Write(name.into(), Vec::new()));
            takes_lines = true;
        } else if line.is_empty() {
            session.steps.push(Step::Blank);
        }
    }
    sessions
}

/// The words of a command line, with the files that it reads and writes.
pub(crate) fn words(line: &str) -> Vec<String> {
    let (mut words, mut word, mut quote) = (Vec::new(), None::<String>, None);
    for c in line.chars() {
        match quote {
            Some(open) if c == open => quote = None,
            None if c == '\'' || c == '"' => {
                quote = Some(c);
                word.get_or_insert_default();
            }
            None if c == ' ' => words.extend(word.take()),
            Some(_) | None => word.get_or_insert_default().push(c),
        }
    }
    words.extend(word);
    words
}

impl Session {
    /// The command lines.
    pub(crate) fn commands(&self) -> impl Iterator<Item = &str> {
        self.steps
            .iter()
            .filter_map(|step| if let Step::Run(line) = step { Some(line.as_str()) } else { None })
    }

    /// The text of the session with what comes of it.
    pub(crate) fn run(&self) -> String {
        let folder = TempDir::new().unwrap();
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        let mut text = self.head.clone();
        let mut before = contents(folder.path());
        for step in &self.steps {
            match step {
                Step::Blank => text.push('\n'),
                Step::Copy(path) => {
                    let _ = writeln!(text, "@ copy {path}");
                    let from = root.join(path);
                    fs::copy(&from, folder.path().join(from.file_name().unwrap())).unwrap();
                    before = contents(folder.path());
                }
                Step::Write(name, lines) => {
                    let _ = writeln!(text, "@ write {name}");
                    for line in lines {
                        let _ = writeln!(text, "{}", format!("| {line}").trim_end());
                    }
                    fs::write(
                        folder.path().join(name),
                        lines.join("\n") + if lines.is_empty() { "" } else { "\n" },
                    )
                    .unwrap();
                    before = contents(folder.path());
                }
                Step::Run(line) => {
                    let _ = writeln!(text, "$ {line}");
                    run(line, folder.path(), &mut text);
                    let after = contents(folder.path());
                    tell_files(&before, &after, folder.path(), &mut text);
                    before = after;
                }
            }
        }
        text
    }
}

/// Runs a command line in `folder`, and tells in `text` what it prints and its exit code.
fn run(line: &str, folder: &Path, text: &mut String) {
    let mut words = words(line);
    let mut files = [None, None];
    for (sign, file) in ["<", ">"].into_iter().zip(&mut files) {
        if let Some(at) = words.iter().position(|word| word == sign) {
            *file = words.drain(at..at + 2).nth(1);
        }
    }
    let variables: Vec<(String, String)> = std::iter::from_fn(|| {
        let (name, value) = words.first()?.split_once('=')?;
        let variable = (name.to_owned(), value.to_owned());
        words.remove(0);
        Some(variable)
    })
    .collect();
    let [input, output] = files;
    if words[0] != "sppm" {
        return prepare(&words, folder);
    }
    let mut command = Command::new(env!("CARGO_BIN_EXE_sppm"));
    // What the person who runs the tests has set must not matter.
    command.env_remove("SPPM_VIEW_TOKEN").env_remove("SPPM_PYTHON").env("NO_COLOR", "1");
    command.args(&words[1..]).current_dir(folder).envs(variables);
    command.stdin(input.map_or_else(Stdio::null, |name| File::open(folder.join(name)).unwrap().into()));
    let out = ended(command);
    match out.status.code() {
        Some(0) => {}
        code => _ = writeln!(text, "? {}", code.map_or("a signal".into(), |code| code.to_string())),
    }
    if let Some(name) = output {
        fs::write(folder.join(name), &out.stdout).unwrap();
    } else {
        tell(">", &out.stdout, folder, text);
    }
    tell("!", &out.stderr, folder, text);
}

/// Runs a command to its end. One that does not end is killed: its page is open, say, where it should have been refused.
fn ended(mut command: Command) -> Output {
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let (is_over, over) = channel::<()>();
    let id = Pid::from_child(&child);
    let guard = thread::spawn(move || {
        if over.recv_timeout(LONGEST) == Err(RecvTimeoutError::Timeout) {
            let _ = kill_process(id, Signal::KILL);
        }
    });
    let out = child.wait_with_output().unwrap();
    drop(is_over);
    guard.join().unwrap();
    out
}

/// What sessions do to files.
fn prepare(words: &[String], folder: &Path) {
    let path = |at: usize| folder.join(&words[at]);
    let number = |at: usize| words[at].parse::<usize>().unwrap();
    let change = |change: &dyn Fn(&mut Vec<u8>)| {
        let mut bytes = fs::read(path(1)).unwrap();
        change(&mut bytes);
        fs::write(path(1), bytes).unwrap();
    };
    match words[0].as_str() {
        "rm" => fs::remove_file(path(1)).unwrap(),
        "mkdir" => fs::create_dir(path(1)).unwrap(),
        "cp" => _ = fs::copy(path(1), path(2)).unwrap(),
        "head" => change(&|bytes| bytes.truncate(number(2))),
        "flip" => change(&|bytes| bytes[number(2)] ^= 0x10),
        "append" => change(&|bytes| bytes.extend(words[2].bytes())),
        "chop" => change(&|bytes| _ = bytes.pop()),
        "rays" => rays(&path(1), &words[2..]),
        other => panic!("there is no command {other}"),
    }
}

/// Writes rays for `sppm trace`: numbers, six of each.
fn rays(path: &Path, numbers: &[String]) {
    use npyz::WriterBuilder as _;
    let numbers: Vec<f32> = numbers.iter().map(|word| word.parse().unwrap()).collect();
    let shape = [numbers.len() as u64 / 6, 6];
    let options = npyz::WriteOptions::new().default_dtype().shape(&shape);
    let mut writer = options.writer(File::create(path).unwrap()).begin_nd().unwrap();
    writer.extend(numbers).unwrap();
    writer.finish().unwrap();
}

/// Tells what was printed, each line after `mark`.
fn tell(mark: &str, bytes: &[u8], folder: &Path, text: &mut String) {
    if bytes.is_empty() {
        return;
    }
    let Some(printed) = as_text(bytes) else {
        let _ = writeln!(text, "{mark} {}", describe("out", bytes, folder).join("; "));
        return;
    };
    let printed = normal(printed, folder);
    if printed.lines().count() > MOST_LINES {
        let _ = writeln!(text, "{mark} {}", digest_of(&printed));
        return;
    }
    for line in printed.lines() {
        let _ = writeln!(text, "{}", format!("{mark} {line}").trim_end());
    }
    if !printed.ends_with('\n') {
        let _ = writeln!(text, "{mark}\\");
    }
}

/// The text that bytes are, if they are one.
fn as_text(bytes: &[u8]) -> Option<&str> {
    std::str::from_utf8(bytes).ok().filter(|text| !text.contains('\0'))
}

/// A text that is too long to be shown.
fn digest_of(text: &str) -> String {
    format!("{} lines, digest {:08x}", text.lines().count(), crc32fast::hash(text.as_bytes()))
}

/// Tells which files are new, others, or gone.
fn tell_files(
    before: &BTreeMap<String, Vec<u8>>,
    after: &BTreeMap<String, Vec<u8>>,
    folder: &Path,
    text: &mut String,
) {
    for (name, bytes) in after.iter().filter(|(name, bytes)| before.get(*name) != Some(bytes)) {
        let mark = if before.contains_key(name) { "~" } else { "+" };
        let shown = normal(name, folder);
        match as_text(bytes) {
            Some(content) if !name.ends_with('/') => {
                let content = normal(content, folder);
                if content.lines().count() > MOST_LINES {
                    let _ = writeln!(text, "{mark} {shown}  {}", digest_of(&content));
                } else {
                    let _ = writeln!(text, "{mark} {shown}");
                    for line in content.lines() {
                        let _ = writeln!(text, "{}", format!("|   {line}").trim_end());
                    }
                    if !content.is_empty() && !content.ends_with('\n') {
                        let _ = writeln!(text, "|\\");
                    }
                }
            }
            _ => {
                let told = describe(name, bytes, folder);
                let _ = writeln!(text, "{}", format!("{mark} {shown}  {}", told[0]).trim_end());
                for line in &told[1..] {
                    let _ = writeln!(text, "|   {line}");
                }
            }
        }
    }
    for name in before.keys().filter(|name| !after.contains_key(*name)) {
        let _ = writeln!(text, "- {}", normal(name, folder));
    }
}

/// All files in a folder with their bytes, and folders, whose names end in a slash.
fn contents(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    collect(folder, "", &mut found);
    found
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
