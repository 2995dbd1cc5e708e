//! Names of files: long ones, links, pipes and devices.

use crate::running::{LONG, Running};
use crate::sandbox::{Ended, Sandbox, TINY};
use rustix::fs::{CWD, FileType, Mode, mknodat};
use rustix::process::Signal;
use std::fs;
use std::io::Read;
use std::os::unix::fs::symlink;
use std::process::Stdio;
use std::thread::sleep;
use std::time::{Duration, Instant};

/// What takes longer waits for a pipe.
const PATIENCE: Duration = Duration::from_secs(30);

/// Runs the command, and kills it if it does not end.
fn run_in_time(sandbox: &Sandbox, args: &[&str]) -> Ended {
    let mut command = sandbox.command(args);
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let began = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if began.elapsed() > PATIENCE {
            child.kill().unwrap();
            panic!("{args:?} does not end");
        }
        sleep(Duration::from_millis(5));
    }
    let (mut stdout, mut stderr) = (String::new(), String::new());
    child.stdout.take().unwrap().read_to_string(&mut stdout).unwrap();
    child.stderr.take().unwrap().read_to_string(&mut stderr).unwrap();
    Ended { code: child.wait().unwrap().code(), stdout, stderr }
}

fn pipe(sandbox: &Sandbox, name: &str) {
    mknodat(CWD, sandbox.path(name), FileType::Fifo, Mode::RUSR | Mode::WUSR, 0).unwrap();
}

#[test]
fn names_of_up_to_255_bytes_are_fine() {
    for length in [240, 250, 251, 255] {
        let sandbox = Sandbox::new();
        let name = "n".repeat(length - 4) + ".pfm";
        sandbox.render(&["cornell", "-o", &name, "--every", "1", "--snapshots"]);
        let names = sandbox.names();
        assert!(names.contains(&name) && names.len() == 3, "{names:?}");
        sandbox.render(&[
            "cornell",
            "-o",
            &name,
            "--checkpoint",
            &("c".repeat(length - 5) + ".sppm"),
            "--every",
            "1",
        ]);
        let names = sandbox.names();
        assert_eq!(names.len(), 5, "{names:?}");
    }
    let sandbox = Sandbox::new();
    let name = "n".repeat(252) + ".pfm";
    sandbox
        .run(["render", "cornell", "--quality=paper", "-o", &name].iter().chain(&TINY))
        .refused(&["--output: nnn", "too long"]);
}

/// The name that stands for a long one is always the same, so that the render is found again.
#[test]
fn a_render_with_a_long_name_goes_on_from_its_checkpoint() {
    let sandbox = Sandbox::new();
    let name = "n".repeat(251) + ".pfm";
    let mut command = sandbox.command(LONG.iter().chain(&["-o", &name, "--every", "1"]));
    let running = Running::start(&mut command);
    running.send(Signal::TERM);
    let ended = running.end();
    assert_eq!(ended.code, Some(143), "{ended:?}");
    let checkpoint = sandbox.names().into_iter().find(|name| name.contains(".sppm")).unwrap();
    let done = sandbox.run(["info", &checkpoint, "--json"]).stdout;
    let done: serde_json::Value = serde_json::from_str(&done).unwrap();
    let more = (done["iterations"].as_u64().unwrap() + 1).to_string();
    let args = [
        "render",
        "cornell",
        "--quality=paper",
        "--engine=path",
        "--width=16",
        "--height=12",
        "-n",
        &more,
        "-o",
        &name,
    ];
    let ended = sandbox.run(args);
    assert!(ended.stderr.starts_with("going on from nnn"), "{ended:?}");
    assert_eq!(sandbox.names(), [name]);
}

#[test]
fn links_are_followed_even_to_files_that_are_not_there_yet() {
    let sandbox = Sandbox::new();
    fs::create_dir(sandbox.path("there")).unwrap();
    symlink("there/new.pfm", sandbox.path("early.pfm")).unwrap();
    symlink("early.pfm", sandbox.path("far.pfm")).unwrap();
    symlink("missing/new.pfm", sandbox.path("nowhere.pfm")).unwrap();
    symlink("circle.pfm", sandbox.path("circle.pfm")).unwrap();
    sandbox.render(&["cornell", "-o", "far.pfm"]);
    for link in ["early.pfm", "far.pfm"] {
        assert!(sandbox.path(link).is_symlink());
    }
    assert!(!sandbox.path("there/new.pfm").is_symlink());
    assert_eq!(sandbox.image("there/new.pfm").pixels.len(), 16 * 12);
    let render =
        |output| sandbox.run(["render", "cornell", "--quality=paper", "-o", output].iter().chain(&TINY));
    render("nowhere.pfm").refused(&["--output: nowhere.pfm: the folder missing does not exist"]);
    render("circle.pfm").refused(&["--output: circle.pfm", "links lead in a circle"]);
    let both = ["render", "cornell", "--quality=paper", "-o", "early.pfm", "--radius-image", "far.pfm"];
    sandbox.run(both.iter().chain(&TINY)).refused(&["--radius-image: far.pfm is also --output"]);
}

#[test]
fn pipes_and_devices_are_refused_at_once() {
    let sandbox = Sandbox::new();
    sandbox.render(&["cornell", "-o", "a.png", "--checkpoint=a.sppm"]);
    for name in ["p.toml", "p.npy", "p.png", "p.exr", "p.sppm", "p"] {
        pipe(&sandbox, name);
    }
    symlink("p.png", sandbox.path("link.png")).unwrap();
    symlink("/dev/null", sandbox.path("null.toml")).unwrap();
    let cases: &[(&[&str], &[&str])] = &[
        (&["render", "p.toml"], &["p.toml: this is a pipe or a device; a scene is a file"]),
        (&["render", "null.toml"], &["null.toml: this is a pipe or a device"]),
        (&["verify", "p.toml"], &["p.toml: this is a pipe"]),
        (&["export", "p.toml", "--format=pbrt"], &["p.toml: this is a pipe"]),
        (&["trace", "p.toml", "--rays=p.npy", "--hits=h.npy"], &["p.toml: this is a pipe"]),
        (&["trace", "cornell", "--rays=p.npy", "--hits=h.npy"], &["--rays: p.npy: this is a pipe"]),
        (&["trace", "cornell", "--rays=p.npy", "--hits=p.npy"], &["--hits: p.npy"]),
        (&["info", "p.png"], &["p.png: this is a pipe or a device; name a file"]),
        (&["info", "/dev/null"], &["/dev/null: this is a pipe or a device"]),
        (&["info", "p.sppm"], &["p.sppm: this is a pipe or a device; name a checkpoint"]),
        (&["resume", "p.sppm"], &["p.sppm: this is a pipe or a device; name a checkpoint"]),
        (&["resume", "p"], &["p: this is a pipe or a device; name a checkpoint"]),
        (&["merge", "p", "-o", "a.sppm"], &["p: this is a pipe or a device; name a part"]),
        (&["merge", "none", "--missing"], &["none: there is no such file"]),
        (&["render", "--like", "p.exr"], &["p.exr: this is a pipe or a device"]),
        (&["render", "cornell", "--quality=paper", "--profile", "p"], &["--profile: p: this is a pipe"]),
        (&["compare", "p.png", "a.png"], &["p.png: this is a pipe or a device; name an image file"]),
        (&["compare", "a.png", "p"], &["p: this is a pipe or a device; name an image file"]),
        (
            &["render", "cornell", "--quality=paper", "-o", "p.png"],
            &["--output: p.png: is a device or a pipe"],
        ),
        (
            &["render", "cornell", "--quality=paper", "-o", "link.png"],
            &["--output: link.png: is a device or a pipe"],
        ),
        (&["render", "cornell", "--quality=paper", "--stats", "p"], &["--stats: p: is a device or a pipe"]),
        (
            &["render", "cornell", "--quality=paper", "--checkpoint", "p.sppm"],
            &["--checkpoint: p.sppm: is a device or a pipe"],
        ),
        (
            &["render", "cornell", "--quality=paper", "-o", "p/a.png"],
            &["--output: p/a.png: p is not a folder"],
        ),
    ];
    for (args, words) in cases {
        run_in_time(&sandbox, args).refused(words);
    }
}

/// `/dev/stdout` is a link to whatever standard output is.
#[cfg(target_os = "linux")]
#[test]
fn a_link_to_a_pipe_is_told_as_a_pipe() {
    let sandbox = Sandbox::new();
    symlink("/dev/stdout", sandbox.path("out.png")).unwrap();
    let ended = run_in_time(&sandbox, &["render", "cornell", "--quality=paper", "-o", "out.png"]);
    ended.refused(&["--output: out.png: is a device or a pipe"]);
}

#[test]
fn what_a_file_contains_decides_whatever_its_name() {
    let sandbox = Sandbox::new();
    sandbox.render(&["cornell", "-o", "a.png", "--checkpoint=a.sppm"]);
    for (from, name, kind) in [("a.png", "image.sppm", "image"), ("a.sppm", "checkpoint.png", "checkpoint")] {
        fs::copy(sandbox.path(from), sandbox.path(name)).unwrap();
        let info = sandbox.run(["info", name]);
        let words = [format!("file       {kind}\n"), "scene      Cornell Box\n".into()];
        assert!(words.iter().all(|words| info.stdout.contains(words)), "{info:?}");
        let like = sandbox.run(["render", "-q", "--like", name, "-o", "b.png"]);
        assert_eq!(like.code, Some(0), "{like:?}");
    }
}

#[test]
fn a_file_that_is_missing_is_told_as_such_whatever_its_name() {
    let sandbox = Sandbox::new();
    sandbox.render(&["cornell", "-o", "a.png"]);
    fs::create_dir(sandbox.path("folder")).unwrap();
    for name in ["nofile", "no.png", "no.sppm", "no.txt", "folder/nofile"] {
        sandbox.run(["info", name]).refused(&[&format!("error: {name}: there is no such file")]);
        sandbox.run(["render", "--like", name]).refused(&[&format!("{name}: there is no such file")]);
        sandbox.run(["resume", name]).refused(&[&format!("{name}: there is no such file")]);
        sandbox.run(["compare", "a.png", name]).refused(&[&format!("{name}: there is no such file")]);
        sandbox.run(["compare", name, "a.png"]).refused(&[&format!("{name}: there is no such file")]);
        let rays = ["trace", "cornell", "--hits=h.npy", "--rays", name];
        sandbox.run(rays).refused(&[&format!("--rays: {name}: there is no such file")]);
    }
    sandbox.run(["info", "folder"]).refused(&["folder: this is a directory; name a file"]);
    sandbox.run(["compare", "a.png", "folder"]).refused(&["folder: this is a directory; name an image file"]);
    sandbox.run(["render", "no.toml"]).refused(&["no.toml: there is no such file"]);
    sandbox
        .run(["render", "cornell", "--quality=paper", "--profile", "no"])
        .refused(&["--profile: no: there is no such file"]);
}
