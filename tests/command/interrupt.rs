//! Ctrl-C and SIGTERM, and files that turn out not to be writable.

use crate::running::{LONG, Running};
use crate::sandbox::Sandbox;
use rustix::process::Signal;
use std::fs;
use std::process::Stdio;

#[test]
fn ctrl_c_writes_the_image_after_the_last_whole_iteration() {
    let sandbox = Sandbox::new();
    let out = ["-o", "a.exr", "--stats", "s.json"];
    let running = Running::start(&mut sandbox.command(LONG.iter().chain(&out)));
    running.send(Signal::INT);
    let ended = running.end();
    assert_eq!(ended.code, Some(130));
    let stats = sandbox.json("s.json");
    let done = stats["iterations"].as_u64().unwrap().to_string();
    let says = format!("interrupted: wrote a.exr and s.json after {done} of 100000000 iterations in ");
    ended.said_one_line(&says, &[]);
    assert_eq!(stats["interrupted"], true);

    let mut again = LONG;
    again[9] = &done;
    let ended = sandbox.run(again.iter().chain(&["-o", "b.exr"]));
    assert_eq!(ended.code, Some(0), "{ended:?}");
    assert!(sandbox.bytes("a.exr") == sandbox.bytes("b.exr"), "not the image after {done} iterations");
}

#[test]
fn sigterm_also_writes_the_image() {
    let sandbox = Sandbox::new();
    let running = Running::start(&mut sandbox.command(LONG));
    running.send(Signal::TERM);
    let ended = running.end();
    assert_eq!(ended.code, Some(143));
    ended.said_one_line("interrupted: wrote cornell.png after ", &[]);
    assert_eq!(sandbox.image("cornell.png").pixels.len(), 16 * 12);
}

#[test]
fn before_the_first_iteration_is_over_there_is_nothing_to_write() {
    let sandbox = Sandbox::new();
    let mut large = LONG;
    (large[5], large[7]) = ("6000", "4000");
    let running = Running::start(&mut sandbox.command(large));
    running.send(Signal::INT);
    let ended = running.end();
    assert_eq!(ended.code, Some(130));
    ended.said_one_line("interrupted: not one iteration was over, so nothing is written", &[]);
    assert_eq!(sandbox.names(), [""; 0]);
}

#[test]
fn a_second_ctrl_c_leaves_no_incomplete_file() {
    let sandbox = Sandbox::new();
    sandbox.write("cornell.png", "old");
    let running = Running::start(&mut sandbox.command(LONG));
    running.send(Signal::INT);
    running.send(Signal::INT);
    assert_eq!(running.end().code, Some(130));
    let bytes = sandbox.bytes("cornell.png");
    assert!(bytes == b"old" || sandbox.image("cornell.png").pixels.len() == 16 * 12, "torn");
}

/// Where nobody reads what it writes, it would wait for ever.
#[test]
fn a_second_signal_of_another_kind_ends_at_once_too() {
    for signals in [[Signal::INT, Signal::TERM], [Signal::TERM, Signal::INT], [Signal::TERM, Signal::HUP]] {
        let sandbox = Sandbox::new();
        let mut large = LONG;
        (large[5], large[7]) = ("256", "128");
        let mut command = sandbox.command(large.iter().chain(&["-o", "-"]));
        let running = Running::start_writing(&mut command, Stdio::piped(), "method path");
        for signal in signals {
            running.send(signal);
        }
        // If both wait for the process to go on, either may be handled first.
        let codes = signals.map(|signal| Some(128 + signal.as_raw()));
        let code = running.end_at_once();
        assert!(codes.contains(&code), "{signals:?}: {code:?}");
    }
}

#[test]
fn an_image_that_cannot_be_written_is_written_elsewhere() {
    let sandbox = Sandbox::new();
    for folder in ["out", "tmp"] {
        fs::create_dir(sandbox.path(folder)).unwrap();
    }
    let out = ["-o", "out/a.exr", "--stats", "s.json"];
    let mut command = sandbox.command(LONG.iter().chain(&out));
    let running = Running::start(command.env("TMPDIR", sandbox.path("tmp")));
    fs::remove_dir_all(sandbox.path("out")).unwrap();
    running.send(Signal::INT);
    let ended = running.end();
    assert_eq!(ended.code, Some(1));
    ended.said_one_line("error: out/a.exr: ", &["it is in ", "-rescued-", "wrote s.json"]);
    let names = sandbox.names();
    let refuge = names.iter().find(|name| name.starts_with("tmp/a-rescued-")).expect("a rescued image");
    assert_eq!(sandbox.image(refuge).pixels.len(), 16 * 12);
    assert!(sandbox.json("s.json").is_object());
}

/// A checkpoint that nobody can go on from is not told as one.
#[test]
fn what_could_be_written_nowhere_is_not_said_to_be_there() {
    let sandbox = Sandbox::new();
    fs::create_dir(sandbox.path("out")).unwrap();
    let mut command = sandbox.command(LONG.iter().chain(&["-o", "out/a.exr"]));
    let running = Running::start(command.env("TMPDIR", sandbox.path("none")));
    fs::remove_dir_all(sandbox.path("out")).unwrap();
    running.send(Signal::INT);
    let ended = running.end();
    assert_eq!(ended.code, Some(1));
    ended.said_one_line("error: out/a.exr: ", &[]);
    assert!(!ended.stderr.contains("it is in") && !ended.stderr.contains("sppm resume"), "{ended:?}");
    assert_eq!(sandbox.names(), [""; 0]);
}
