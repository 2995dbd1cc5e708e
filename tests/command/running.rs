//! A render that runs until it is interrupted.

use crate::sandbox::Ended;
use rustix::process::{Pid, Signal, kill_process};
use std::io::{BufRead, BufReader, Read};
use std::process::{Child, ChildStderr, Command, Stdio};
use std::thread::sleep;
use std::time::Duration;

/// A render with short iterations that would run for hours.
pub(crate) const LONG: [&str; 13] = [
    "render",
    "cornell",
    "--engine",
    "path",
    "--width",
    "16",
    "--height",
    "12",
    "--iterations",
    "100000000",
    "-v",
    "--threads=1",
    "--quality=paper",
];

/// A running render.
pub(crate) struct Running {
    child: Child,
    stderr: BufReader<ChildStderr>,
}

impl Running {
    /// Starts `command`, one of [`LONG`], and returns once it renders.
    pub(crate) fn start(command: &mut Command) -> Self {
        Self::start_saying(command, "method path")
    }

    /// Starts `command`, whose first line contains `words`, and returns once it renders.
    pub(crate) fn start_saying(command: &mut Command, words: &str) -> Self {
        Self::start_writing(command, Stdio::null(), words)
    }

    /// [`Self::start_saying`] with its standard output going to `out`.
    pub(crate) fn start_writing(command: &mut Command, out: Stdio, words: &str) -> Self {
        let mut child = command.stdout(out).stderr(Stdio::piped()).spawn().unwrap();
        let stderr = BufReader::new(child.stderr.take().unwrap());
        let mut running = Self { child, stderr };
        // With -v, the first line is printed just before the first iteration.
        let mut introduction = String::new();
        running.stderr.read_line(&mut introduction).unwrap();
        assert!(introduction.contains(words), "{introduction}");
        sleep(Duration::from_millis(300));
        running
    }

    pub(crate) fn send(&self, signal: Signal) {
        kill_process(Pid::from_child(&self.child), signal).unwrap();
    }

    /// The id of the process.
    pub(crate) fn id(&self) -> u32 {
        self.child.id()
    }

    /// The exit code of one that ends at once, and does not wait for anything.
    pub(crate) fn end_at_once(mut self) -> Option<i32> {
        // Far more than it takes, on any machine.
        for _ in 0..6000 {
            if let Some(status) = self.child.try_wait().unwrap() {
                return status.code();
            }
            sleep(Duration::from_millis(5));
        }
        panic!("it does not end");
    }

    /// Waits for the end.
    pub(crate) fn end(mut self) -> Ended {
        let mut stderr = String::new();
        self.stderr.read_to_string(&mut stderr).unwrap();
        // Leave out the times per pass, which -v prints.
        let lines: Vec<&str> =
            stderr.split_inclusive('\n').filter(|l| !l.starts_with("camera pass")).collect();
        let stderr = lines.concat();
        Ended { code: self.child.wait().unwrap().code(), stdout: String::new(), stderr }
    }
}

/// A test that fails leaves no endless render behind.
impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.child.kill(); // fails if it has ended
        let _ = self.child.wait();
    }
}
