//! Signals that interrupt a render.

use crate::sandbox::{Ended, Sandbox, heeding_signals};
use rustix::process::{Pid, Signal, kill_process};
use std::io::{BufRead, BufReader, Read};
use std::process::{Child, ChildStderr, Command, Stdio};

/// A render that would run for hours.
const LONG: [&str; 9] = [
    "render",
    "cornell",
    "--width=16",
    "--height=12",
    "--photons=500",
    "--iterations=100000000",
    "-v",
    "--threads=2",
    "--quality=paper",
];

/// A running render.
struct Running {
    child: Child,
    stderr: BufReader<ChildStderr>,
}

impl Running {
    /// Starts `command` and returns once it has printed a line that contains `words`.
    fn start(command: &mut Command, words: &str) -> Self {
        let mut child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
        let mut stderr = BufReader::new(child.stderr.take().unwrap());
        let mut line = String::new();
        while !line.contains(words) {
            line.clear();
            assert!(stderr.read_line(&mut line).unwrap() > 0, "ended before it said {words:?}");
        }
        Self { child, stderr }
    }

    fn send(&self, signal: Signal) {
        kill_process(Pid::from_child(&self.child), signal).unwrap();
    }

    /// Expects the render to go on for some iterations.
    fn goes_on(&mut self) {
        for _ in 0..20 {
            let mut line = String::new();
            self.stderr.read_line(&mut line).unwrap();
            assert!(line.starts_with("saved after "), "{line}");
        }
    }

    fn end(mut self) -> Ended {
        let mut stderr = String::new();
        self.stderr.read_to_string(&mut stderr).unwrap();
        let last = stderr.lines().last().unwrap_or_default();
        Ended { code: self.child.wait().unwrap().code(), stdout: String::new(), stderr: format!("{last}\n") }
    }
}

/// A test that fails leaves no endless render behind.
impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.child.kill(); // fails if it has ended
        let _ = self.child.wait();
    }
}

#[test]
fn every_signal_leaves_an_image_and_a_checkpoint() {
    for (signal, code) in [(Signal::INT, 130), (Signal::TERM, 143), (Signal::HUP, 129)] {
        let sandbox = Sandbox::new();
        let running = Running::start(&mut sandbox.command(LONG.iter().chain(&["--every=1"])), "saved after ");
        running.send(signal);
        let ended = running.end();
        assert_eq!(ended.code, Some(code), "{ended:?}");
        ended.said_one_line("interrupted: wrote cornell.png after ", &["`sppm resume cornell.png.sppm`"]);
        let info = sandbox.run(["info", "cornell.png", "--json"]);
        let info: serde_json::Value = serde_json::from_str(&info.stdout).unwrap();
        let done = info["iterations"].to_string();
        // What is asked for is told, not what is done.
        let scene_file = sandbox.run(["info", "cornell.png.sppm", "--scene"]).stdout;
        assert!(scene_file.contains("\niterations = 100000000\n"), "{scene_file}");
        let more = format!("--iterations={}", info["iterations"].as_u64().unwrap() + 3);
        assert_eq!(sandbox.run(["resume", "cornell.png.sppm", "-q", &more]).code, Some(0));
        let whole = LONG.map(|option| if option.starts_with("--iterations") { &more } else { option });
        assert_eq!(sandbox.run(whole.iter().chain(&["-o", "whole.png"])).code, Some(0));
        assert!(sandbox.bytes("cornell.png") == sandbox.bytes("whole.png"), "after {done} iterations");
        assert_eq!(sandbox.names(), ["cornell.png", "whole.png"]);
    }
}

/// Of a part, what is left are the iterations of that part.
#[test]
fn an_interrupted_part_counts_its_own_iterations() {
    let sandbox = Sandbox::new();
    let part = ["--radius-schedule=global", "--part=2/4", "--every=1", "-o", "part.sppm"];
    let running = Running::start(&mut sandbox.command(LONG.iter().chain(&part)), "saved after ");
    running.send(Signal::INT);
    let ended = running.end();
    assert_eq!(ended.code, Some(130), "{ended:?}");
    let words = [" of 25000000 iterations in ", "`sppm resume part.sppm` goes on after "];
    ended.said_one_line("interrupted: wrote part.sppm after ", &words);
}

#[test]
fn hangups_are_ignored_under_nohup() {
    let sandbox = Sandbox::new();
    let program = env!("CARGO_BIN_EXE_sppm");
    let script = format!("trap '' HUP; exec {program} {} --every=1", LONG.join(" "));
    let mut command = sandbox.command([""; 0]);
    let mut shell = heeding_signals("sh");
    shell.args(["-c", &script]).current_dir(command.get_current_dir().unwrap()).stdin(Stdio::null());
    std::mem::swap(&mut command, &mut shell);
    let running = Running::start(&mut command, "saved after ");
    running.send(Signal::HUP);
    running.send(Signal::TERM);
    assert_eq!(running.end().code, Some(143));
}

/// A shell without job control starts what is in the background with SIGINT ignored. Ctrl-C, which goes to all, is not
/// for it.
#[test]
fn a_signal_that_is_ignored_at_the_start_stays_ignored() {
    for (name, signal) in [("INT", Signal::INT), ("TERM", Signal::TERM)] {
        let sandbox = Sandbox::new();
        let program = env!("CARGO_BIN_EXE_sppm");
        let script = format!("trap '' {name}; exec {program} {} --every=1", LONG.join(" "));
        let mut shell = heeding_signals("sh");
        shell.args(["-c", &script]).current_dir(sandbox.path("")).stdin(Stdio::null());
        let mut running = Running::start(&mut shell, "saved after ");
        running.send(signal);
        running.goes_on();
        let (other, code) = if signal == Signal::INT { (Signal::TERM, 143) } else { (Signal::INT, 130) };
        running.send(other);
        assert_eq!(running.end().code, Some(code));
    }
}

/// An iteration that would take minutes is abandoned.
#[test]
fn an_interruption_does_not_wait_for_the_iteration() {
    let sandbox = Sandbox::new();
    let args = [
        "render",
        "cornell",
        "--quality=paper",
        "--width=64",
        "--height=48",
        "--photons=200000000",
        "--iterations=9",
        "-v",
    ];
    let running = Running::start(&mut sandbox.command(args), "engine fast");
    running.send(Signal::INT);
    let ended = running.end();
    assert_eq!(ended.code, Some(130));
    ended.said_one_line("interrupted: not one iteration was over, so nothing is written", &[]);
    assert_eq!(sandbox.names(), [""; 0]);
}
