//! Kills random renders at random moments, even during writes, and resumes them. Each must end with the same image as
//! an undisturbed render, and no file may ever be incomplete.

use crate::cases::tell;
use crate::sandbox::Sandbox;
use fast::LaneKind;
use files::builtin::SCENES;
use files::checkpoint::Store;
use files::image_file;
use rustix::process::{Pid, Signal, kill_process};
use scene::rng::{Family, Stream, StreamKey};
use std::process::Stdio;
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Least number of renders. `SPPM_KILLS` asks for more renders, until there are that many kills.
const RENDERS: u32 = 8;
/// Least number of kills of all renders together.
const KILLS: u32 = 3;
/// After this many kills, a render is no longer disturbed.
const MOST_KILLS: u32 = 12;

/// A random element of `all`.
fn choose<T: Copy>(numbers: &mut Stream, all: &[T]) -> T {
    all[numbers.next_u32() as usize % all.len()]
}

/// A random number from `low` up to, but not including, `high`.
fn between(numbers: &mut Stream, low: u32, high: u32) -> u32 {
    low + numbers.next_u32() % (high - low)
}

/// Random options for engine, lanes and threads, on which the image does not depend.
fn way(numbers: &mut Stream, is_path: bool) -> Vec<String> {
    let threads = format!("--threads={}", between(numbers, 1, 4));
    let method = if is_path { "--method=path" } else { "--method=sppm" };
    let lanes: Vec<_> = LaneKind::ALL.into_iter().filter(|kind| kind.is_available()).collect();
    if between(numbers, 0, 4) == 0 {
        vec![threads, method.into(), "--engine=reference".into()]
    } else {
        let lanes = format!("{:?}", choose(numbers, &lanes)).to_lowercase();
        vec![threads, method.into(), "--engine=fast".into(), format!("--lanes={lanes}")]
    }
}

/// A random render, and how often it was killed.
struct Trial {
    sandbox: Sandbox,
    numbers: Stream,
    render: Vec<String>,
    is_path: bool,
    patience: Duration,
    kills: u32,
}

impl Trial {
    fn new(number: u32) -> Self {
        let mut numbers = StreamKey::new(6, Family::Path, 0).stream(number);
        let scene = choose(&mut numbers, SCENES).name;
        let is_path = between(&mut numbers, 0, 5) == 0;
        let mut render: Vec<String> =
            ["render", scene, "--quality=paper", "--snapshots"].map(Into::into).to_vec();
        for (option, low, high) in [
            ("--width", 1, 60),
            ("--height", 1, 40),
            ("--iterations", 2, 40),
            ("--photons", 1, 4000),
            ("--seed", 0, u32::MAX),
        ] {
            render.push(format!("{option}={}", between(&mut numbers, low, high)));
        }
        Self { sandbox: Sandbox::new(), numbers, render, is_path, patience: Duration::ZERO, kills: 0 }
    }

    /// The image of the undisturbed render.
    fn undisturbed(&mut self) -> scene::Film {
        let way = way(&mut self.numbers, self.is_path);
        let alone = ["-o", "whole.exr", "--no-checkpoint"].map(String::from);
        let began = Instant::now();
        let ended =
            self.sandbox.run(self.render.iter().filter(|o| *o != "--snapshots").chain(&way).chain(&alone));
        assert_eq!(ended.code, Some(0), "{ended:?}");
        self.patience = began.elapsed();
        self.sandbox.image("whole.exr")
    }

    /// Starts or resumes the render and kills it at a random moment; returns true if it completed before that.
    fn disturb(&mut self) -> bool {
        let is_begun = Store::new(self.sandbox.path("a.sppm")).exists();
        let mut command: Vec<String> = if is_begun && between(&mut self.numbers, 0, 3) > 0 {
            vec!["resume".into(), "a.sppm".into()]
        } else {
            let saved = ["-o", "a.exr", "--checkpoint", "a.sppm", "--every=1"];
            self.render.iter().cloned().chain(saved.map(Into::into)).collect()
        };
        command.extend(way(&mut self.numbers, self.is_path));
        let mut child = self.sandbox.command(&command).stderr(Stdio::piped()).spawn().unwrap();
        if self.kills < MOST_KILLS {
            let share = f64::from(self.numbers.next_u32()) / f64::from(u32::MAX);
            // Longer than the undisturbed render, as writing a checkpoint after every iteration takes time.
            sleep(self.patience.mul_f64(1.5 * share));
            let signal = choose(
                &mut self.numbers,
                &[Signal::TERM, Signal::INT, Signal::KILL, Signal::KILL, Signal::HUP],
            );
            if child.try_wait().unwrap().is_none() {
                let _ = kill_process(Pid::from_child(&child), signal);
                if between(&mut self.numbers, 0, 4) == 0 {
                    let _ = kill_process(Pid::from_child(&child), signal);
                }
            }
        }
        let output = child.wait_with_output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        let is_over = output.status.code() == Some(0);
        let is_killed = matches!(output.status.code(), None | Some(129 | 130 | 143));
        assert!(is_over || is_killed, "{command:?} ended with {}: {said}", output.status);
        assert!(!said.contains("panicked"), "{command:?}: {said}");
        self.kills += u32::from(is_killed);
        is_over
    }

    /// Expects every file to be complete.
    fn check_files(&self) {
        for name in self.sandbox.names() {
            let path = self.sandbox.path(&name);
            match name.as_str() {
                "a.sppm" | "a.sppm.1" => {
                    let loaded = Store::new(&path).load().unwrap_or_else(|torn| panic!("{torn}"));
                    assert!(loaded.unwrap().fallback.is_none(), "{name} is torn");
                }
                // A lock, or a temporary file that was complete but not yet renamed to its target.
                name if name.starts_with(".sppm-") => {}
                _ => {
                    image_file::read(&path).unwrap_or_else(|torn| panic!("{torn}"));
                }
            }
        }
    }
}

#[test]
fn killed_renders_resume_to_the_same_image() {
    let asked =
        std::env::var("SPPM_KILLS").ok().map(|kills| kills.parse::<u32>().expect("a number of kills"));
    let (mut kills, mut renders) = (0, 0);
    while renders < RENDERS || asked.is_some_and(|asked| kills < asked) {
        let mut trial = Trial::new(renders);
        let expected = trial.undisturbed();
        loop {
            let is_over = trial.disturb();
            trial.check_files();
            if is_over {
                break;
            }
        }
        assert_eq!(trial.sandbox.image("a.exr"), expected, "{:?} after {} kills", trial.render, trial.kills);
        (kills, renders) = (kills + trial.kills, renders + 1);
    }
    assert!(kills >= KILLS, "hardly a render was killed: {kills}");
    tell(
        "lasting",
        kills as usize,
        &format!("kills of {renders} renders: every image identical, no file torn"),
    );
}
