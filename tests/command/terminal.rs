//! Progress on terminals of any width: it never wraps, leaves nothing behind, and shows that something is going on.

use crate::sandbox::Sandbox;
use rustix::process::{Pid, Signal, kill_process};
use rustix::pty::{OpenptFlags, grantpt, ioctl_tiocgptpeer, openpt, unlockpt};
use rustix::termios::{Winsize, tcsetwinsize};
use std::fs::File;
use std::io::{Read, Write};
use std::os::fd::OwnedFd;
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

/// What takes longer has failed.
const PATIENCE: Duration = Duration::from_secs(40);

/// A terminal of so many columns, and what it shows.
struct Terminal {
    master: File,
    columns: usize,
    rows: Vec<String>,
    row: usize,
    column: usize,
    /// The rows that were left because they were full.
    wrapped: Vec<String>,
    /// All that was written.
    log: String,
}

impl Terminal {
    /// The terminal, and the end of it that a command writes to.
    fn new(columns: usize) -> (Self, OwnedFd) {
        let flags = OpenptFlags::RDWR | OpenptFlags::NOCTTY;
        let master = openpt(flags).unwrap();
        grantpt(&master).unwrap();
        unlockpt(&master).unwrap();
        let size = Winsize { ws_row: 24, ws_col: columns as u16, ws_xpixel: 0, ws_ypixel: 0 };
        tcsetwinsize(&master, size).unwrap();
        let peer = ioctl_tiocgptpeer(&master, flags).unwrap();
        let (rows, wrapped) = (vec![String::new()], Vec::new());
        let master = File::from(master);
        (Self { master, columns, rows, row: 0, column: 0, wrapped, log: String::new() }, peer)
    }

    /// Reads what `child` writes until `is_enough`, or else to its end. Returns whether it was enough.
    fn watch(&mut self, is_enough: impl Fn(&Self) -> bool) -> bool {
        let began = Instant::now();
        let mut bytes = [0; 4096];
        loop {
            if is_enough(self) {
                return true;
            }
            assert!(began.elapsed() < PATIENCE, "{:?}", &self.log[..self.log.len().min(1000)]);
            // Reading fails once nobody has the other end.
            match self.master.read(&mut bytes) {
                Ok(count) if count > 0 => self.show(&String::from_utf8_lossy(&bytes[..count])),
                _ => return false,
            }
        }
    }

    /// Does what a terminal does with `text`.
    fn show(&mut self, text: &str) {
        self.log.push_str(text);
        let mut rest = text.chars();
        while let Some(c) = rest.next() {
            match c {
                '\r' => self.column = 0,
                '\n' => self.down(),
                '\u{1b}' => {
                    let sequence: String = rest.by_ref().skip(1).take_while_inclusive().collect();
                    self.control(&sequence);
                }
                c => self.put(c),
            }
        }
    }

    fn control(&mut self, sequence: &str) {
        let (number, letter) = sequence.split_at(sequence.len() - 1);
        let row = &mut self.rows[self.row];
        match letter {
            "K" if number == "2" => row.clear(),
            "K" => row.truncate(self.column),
            "A" => self.row -= number.parse::<usize>().unwrap_or(1).min(self.row),
            "G" => self.column = number.parse::<usize>().unwrap_or(1) - 1,
            "m" | "h" | "l" => {}
            _ => panic!("unknown control sequence {sequence:?}"),
        }
    }

    fn put(&mut self, c: char) {
        if self.column == self.columns {
            self.wrapped.push(self.rows[self.row].clone());
            self.down();
            self.column = 0;
        }
        let row = &mut self.rows[self.row];
        let padded: String = row.chars().chain(std::iter::repeat(' ')).take(self.column).collect();
        *row = padded.chars().chain([c]).chain(row.chars().skip(self.column + 1)).collect();
        self.column += 1;
    }

    fn down(&mut self) {
        self.row += 1;
        if self.row == self.rows.len() {
            self.rows.push(String::new());
        }
    }

    /// What is left on the screen, with wrapped lines joined.
    fn text(&self) -> String {
        self.rows.concat().trim().into()
    }
}

trait UntilLetter: Iterator<Item = char> {
    /// The characters up to and with the first letter.
    fn take_while_inclusive(self) -> impl Iterator<Item = char>;
}

impl<I: Iterator<Item = char>> UntilLetter for I {
    fn take_while_inclusive(mut self) -> impl Iterator<Item = char> {
        let mut is_over = false;
        std::iter::from_fn(move || {
            let c = if is_over { None } else { self.next() };
            is_over = c.is_some_and(|c| c.is_ascii_alphabetic());
            c
        })
    }
}

/// Starts `command` with its standard error on a terminal of so many columns.
fn start(command: &mut Command, columns: usize) -> (Child, Terminal) {
    let (terminal, peer) = Terminal::new(columns);
    let child = command.stderr(peer).stdout(Stdio::null()).spawn().unwrap();
    command.stderr(Stdio::null()); // closes our copy of the terminal's end
    (child, terminal)
}

fn bar_lengths(terminal: &Terminal) -> Vec<usize> {
    let mut lengths: Vec<usize> =
        terminal.log.split('[').map(|text| text.chars().take_while(|c| *c == '#').count()).collect();
    lengths.sort_unstable();
    lengths.dedup();
    lengths
}

#[test]
fn progress_fits_on_every_terminal_and_leaves_nothing_behind() {
    let args = [
        "render",
        "cornell",
        "--quality=paper",
        "--width=64",
        "--height=48",
        "--photons=20000",
        "--time=1500ms",
        "--threads=1",
    ];
    // All at once, as each takes its time.
    thread::scope(|scope| {
        for columns in [120, 80, 40, 20, 7] {
            scope.spawn(move || {
                let sandbox = Sandbox::new();
                let (mut child, mut terminal) = start(&mut sandbox.command(args), columns);
                terminal.watch(|_| false);
                assert_eq!(child.wait().unwrap().code(), Some(0));
                check_progress(&terminal, columns);
            });
        }
    });
}

/// What a terminal of so many columns has shown of a render that time has ended.
fn check_progress(terminal: &Terminal, columns: usize) {
    let text = terminal.text();
    assert!(text.starts_with("wrote cornell.png: ") && text.contains("time is up"), "{columns}: {text:?}");
    // Only the message at the end may take more than a row.
    let first = terminal.wrapped.first();
    assert!(
        first.is_none_or(|row| "wrote cornell.png".starts_with(&row[..row.len().min(17)])),
        "{columns}: {first:?}"
    );
    // The time goal is told by the clock.
    let log = &terminal.log;
    assert!(!log.contains("1073741824") && !log.contains("y left"), "{columns}: {log:?}");
    assert!(columns < 20 || log.contains("s left"), "{columns}: {log:?}");
    // Each iteration tells what it took.
    assert!(columns < 100 || log.contains(" photons/s  mean radius "), "{columns}: {log:?}");
}

/// The bar makes room for them.
#[test]
fn messages_appear_above_the_bar() {
    let sandbox = Sandbox::new();
    let args = [
        "render",
        "cornell",
        "--quality=paper",
        "--width=64",
        "--height=48",
        "--photons=20000",
        "--time=1s",
        "--every=100ms",
        "--verbose",
    ];
    let (mut child, mut terminal) = start(&mut sandbox.command(args), 100);
    assert!(terminal.watch(|terminal| terminal.log.contains("] ")), "no bar: {:?}", terminal.log);
    terminal.watch(|_| false);
    assert_eq!(child.wait().unwrap().code(), Some(0));
    let saved = terminal.rows.iter().filter(|row| row.starts_with("saved after ")).count();
    assert!(saved >= 3, "{:?}", terminal.rows);
    let is_whole = |row: &String| !row.contains("photons/s") && !row.contains(" elapsed");
    assert!(terminal.rows.iter().all(is_whole), "{:?}", terminal.rows);
}

#[test]
fn a_long_first_iteration_shows_how_far_it_is() {
    // Sizes for which an iteration of one thread takes long enough to be watched.
    for (engine, size) in [
        ("fast", ["--width=3000", "--height=2000", "--photons=30000000"]),
        ("reference", ["--width=1500", "--height=1000", "--photons=2000000"]),
        ("path", ["--width=6000", "--height=4000", "--photons=1"]),
    ] {
        let sandbox = Sandbox::new();
        let args = ["render", "cornell", "--quality=paper", "-n=1", "--threads=1", "--engine", engine];
        let (mut child, mut terminal) = start(&mut sandbox.command(args.iter().chain(&size)), 100);
        let grows = |terminal: &Terminal| bar_lengths(terminal).len() >= 3;
        assert!(terminal.watch(grows), "{engine}: {:?}", terminal.log);
        let _ = kill_process(Pid::from_child(&child), Signal::TERM);
        terminal.watch(|_| false);
        child.wait().unwrap();
    }
}

#[test]
fn reading_a_scene_is_shown_and_then_cleared() {
    let sandbox = Sandbox::new();
    let args =
        ["render", "-", "--quality=paper", "--width=16", "--height=12", "--iterations=1", "--photons=100"];
    let (mut child, mut terminal) = start(sandbox.command(args).stdin(Stdio::piped()), 60);
    assert!(terminal.watch(|terminal| terminal.log.contains("reading standard input")), "{:?}", terminal.log);
    let scene = files::builtin::find("cornell").unwrap().text;
    child.stdin.take().unwrap().write_all(scene.as_bytes()).unwrap();
    terminal.watch(|_| false);
    assert_eq!(child.wait().unwrap().code(), Some(0));
    assert!(terminal.text().starts_with("wrote stdin.png: 1 iteration"), "{:?}", terminal.text());
}

/// However long it takes.
#[test]
fn nothing_is_shown_of_reading_where_no_progress_is() {
    for option in ["--quiet", "--log-format=json"] {
        let sandbox = Sandbox::new();
        let args =
            ["render", "-", "--quality=paper", "--width=16", "--height=12", "-n=1", "--photons=100", option];
        let (mut child, mut terminal) = start(sandbox.command(args).stdin(Stdio::piped()), 60);
        // Twice as long as what is mentioned.
        thread::sleep(Duration::from_millis(600));
        let scene = files::builtin::find("cornell").unwrap().text;
        child.stdin.take().unwrap().write_all(scene.as_bytes()).unwrap();
        terminal.watch(|_| false);
        assert_eq!(child.wait().unwrap().code(), Some(0));
        assert!(!terminal.log.contains("reading"), "{:?}", terminal.log);
    }
}

#[test]
fn quiet_renders_and_logs_in_json_draw_nothing() {
    // Lines of progress are instead of the bar.
    for (option, time) in [
        ("--quiet", "--time=700ms"),
        ("--log-format=json", "--time=700ms"),
        ("--progress=json", "--time=250ms"),
    ] {
        let sandbox = Sandbox::new();
        let args = ["render", "cornell", "--quality=paper", "--width=64", "--height=48", time, option];
        let (mut child, mut terminal) = start(&mut sandbox.command(args), 80);
        terminal.watch(|_| false);
        assert_eq!(child.wait().unwrap().code(), Some(0));
        assert!(!terminal.log.contains('\u{1b}'), "{:?}", terminal.log);
    }
}

/// An image on a terminal would be noise.
#[test]
fn a_terminal_takes_no_image_and_gives_no_scene() {
    let sandbox = Sandbox::new();
    let (mut terminal, peer) = Terminal::new(80);
    let output = sandbox
        .command(["render", "cornell", "--quality=paper", "-o", "exr:-"])
        .stdout(peer)
        .output()
        .unwrap();
    let line = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{line}");
    assert!(line.starts_with("error: --output: standard output is a terminal"), "{line}");
    assert!(line.ends_with("redirect it, as by `> image.exr`\n"), "{line}");
    terminal.watch(|_| false);
    assert_eq!(terminal.log, "");

    let (_terminal, peer) = Terminal::new(80);
    let output = sandbox.command(["render", "-"]).stdin(peer).output().unwrap();
    let line = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{line}");
    assert!(line.starts_with("error: -: standard input is a terminal; pipe a scene into it"), "{line}");
}
