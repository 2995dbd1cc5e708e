//! Files that cannot be written: detected before the render where possible; otherwise no work is lost.

use crate::sandbox::{Ended, Sandbox, TINY};
use std::fs::{self, OpenOptions};
use std::io;
use std::process::{Command, Stdio};

/// Runs `sppm` with a file size limit of `bytes` bytes, to simulate a full disk or a quota.
fn run_limited(sandbox: &Sandbox, bytes: u64, args: &[&str]) -> Ended {
    let script = format!("ulimit -f {}; exec \"$@\"", bytes.div_ceil(512));
    let mut shell = Command::new("sh");
    shell.args(["-c", &script, "sh", env!("CARGO_BIN_EXE_sppm")]).args(args);
    ended(shell.current_dir(sandbox.path("")))
}

fn ended(command: &mut Command) -> Ended {
    let output = command.stdin(Stdio::null()).output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    Ended { code: output.status.code(), stdout: text(output.stdout), stderr: text(output.stderr) }
}

#[test]
fn too_little_disk_space_is_reported_before_the_render() {
    let sandbox = Sandbox::new();
    let endless = "--iterations=100000000";
    let args = ["render", "cornell", "--quality=paper", "-o", "a.exr", endless];
    run_limited(&sandbox, 1 << 20, &args).refused(&["--output: a.exr: there is no room for its 2.2 MiB"]);
    let args = ["render", "cornell", "--quality=paper", "--checkpoint=a.sppm", endless];
    run_limited(&sandbox, 1 << 20, &args).refused(&["--checkpoint: a.sppm: there is no room for its "]);
    assert_eq!(sandbox.names(), [""; 0]);
}

/// There is room for the image but not for the checkpoint. The render continues and writes the image, and says once what
/// fails again and again.
#[test]
fn a_checkpoint_that_cannot_be_written_does_not_stop_a_render() {
    let sandbox = Sandbox::new();
    let args = [
        "render",
        "cornell",
        "--quality=paper",
        "--width=64",
        "--height=64",
        "--photons=100",
        "--iterations=30",
        "--every=1",
    ];
    let ended = run_limited(&sandbox, 64 << 10, &args);
    assert_eq!(ended.code, Some(0), "{ended:?}");
    let lines: Vec<&str> = ended.stderr.lines().collect();
    assert_eq!(lines.len(), 2, "{ended:?}");
    assert!(lines[0].starts_with("warning: cornell.png.sppm: cannot be written: "), "{ended:?}");
    assert!(
        lines[0].ends_with("rendering goes on") && lines[1].starts_with("wrote cornell.png: "),
        "{ended:?}"
    );
    assert_eq!(sandbox.names(), ["cornell.png"]);
    sandbox.image("cornell.png");
}

/// Sizes of less than a mebibyte are told as what they are.
#[test]
fn a_small_image_needs_room_too() {
    let sandbox = Sandbox::new();
    let args = ["render", "cornell", "--quality=paper", "-o", "a.pfm", "--width=16", "--height=12"];
    run_limited(&sandbox, 1024, &args).refused(&["--output: a.pfm: there is no room for its 2.2 KiB: "]);
    let args = ["render", "cornell", "--quality=paper", "-o", "a.png", "--width=16", "--height=12"];
    run_limited(&sandbox, 512, &args).refused(&["--output: a.png: there is no room for its 576 bytes: "]);
    // Each file by itself.
    let args = [&args[..], &["--radius-image", "r.pfm"]].concat();
    let words = ["--radius-image: r.pfm: there is no room for its 2.2 KiB: "];
    run_limited(&sandbox, 1024, &args).refused(&words);
    assert_eq!(sandbox.names(), [""; 0]);
}

/// Images as well as checkpoints.
#[test]
fn what_is_merged_needs_room() {
    let sandbox = Sandbox::new();
    let size = ["--width=64", "--height=48", "--photons=100", "--iterations=1"];
    let part =
        ["render", "cornell", "--quality=paper", "--radius-schedule=global", "--part=1/1", "-o=a.sppm"];
    assert_eq!(sandbox.run(part.iter().chain(&size)).code, Some(0));
    for name in ["b.sppm", "b.pfm"] {
        let ended = run_limited(&sandbox, 16 << 10, &["merge", "a.sppm", "-o", name]);
        ended.refused(&[&format!("--output: {name}: there is no room for its ")]);
    }
    assert_eq!(sandbox.names(), ["a.sppm"]);
}

/// Snapshots fail one after the other, each under another name and all for the same reason.
#[test]
fn snapshots_that_cannot_be_written_are_told_once() {
    let sandbox = Sandbox::new();
    for n in [2, 4, 8, 16] {
        fs::create_dir(sandbox.path(&format!("a-{n:04}.png"))).unwrap();
    }
    let args = [
        "render",
        "cornell",
        "--quality=paper",
        "-o",
        "a.png",
        "--snapshots",
        "--width=16",
        "--height=12",
        "--photons=100",
    ];
    let ended = sandbox.run(args.iter().chain(&["--iterations=20"]));
    assert_eq!(ended.code, Some(0), "{ended:?}");
    let lines: Vec<&str> = ended.stderr.lines().collect();
    assert_eq!(lines.len(), 2, "{ended:?}");
    assert!(lines[0].starts_with("warning: a-0002.png: is a folder"), "{ended:?}");
    sandbox.image("a-0001.png");
}

/// Renders out/a.exr, and removes its folder with all files as soon as `checkpoint` exists. The render takes long
/// enough that this happens before its end.
fn render_while_the_folder_goes(sandbox: &Sandbox, checkpoint: &str) -> Ended {
    fs::create_dir(sandbox.path("tmp")).unwrap();
    let script = "mkdir out; \"$@\" & pid=$!; while [ ! -e $0 ]; do sleep 0.01; done
        until rm -rf out; do :; done; wait $pid";
    let option = format!("--checkpoint={checkpoint}");
    let args =
        ["render", "cornell", "--quality=paper", "-o", "out/a.exr", &option, "--every=1", "--stats=s.json"];
    let size = ["--width=32", "--height=32", "--photons=100", "--iterations=300"];
    let mut shell = Command::new("sh");
    shell.args(["-c", script, checkpoint, env!("CARGO_BIN_EXE_sppm")]).args(args).args(size);
    let ended = ended(shell.current_dir(sandbox.path("")).env("TMPDIR", sandbox.path("tmp")));
    assert_eq!(ended.code, Some(1), "{ended:?}");
    ended
}

/// Resumes from `checkpoint`, which has all iterations, and expects the image that was rescued.
fn expect_all_iterations(sandbox: &Sandbox, checkpoint: &str) {
    let again = sandbox.run(["resume", checkpoint, "-o", "c.exr", "-q", "--stats=again.json"]);
    assert_eq!(again.code, Some(0), "{again:?}");
    assert_eq!(sandbox.json("again.json")["resumed_after"], 300);
    let rescued = sandbox.names().into_iter().find(|name| name.starts_with("tmp/a-rescued-")).unwrap();
    assert_eq!(sandbox.image("c.exr"), sandbox.image(&rescued));
}

/// The image is rescued to another folder, and the checkpoint is written.
#[test]
fn a_render_whose_image_cannot_be_written_is_not_lost() {
    let sandbox = Sandbox::new();
    let ended = render_while_the_folder_goes(&sandbox, "safe.sppm");
    let last = ended.stderr.lines().last().unwrap();
    for words in ["error: out/a.exr: ", "tmp/a-rescued-", "`sppm resume safe.sppm`", "wrote s.json"] {
        assert!(last.contains(words), "no {words:?} in {last}");
    }
    expect_all_iterations(&sandbox, "safe.sppm");
}

/// Image and checkpoint are both rescued to another folder.
#[test]
fn a_render_whose_checkpoint_cannot_be_written_either_is_not_lost() {
    let sandbox = Sandbox::new();
    let ended = render_while_the_folder_goes(&sandbox, "out/gone.sppm");
    let last = ended.stderr.lines().last().unwrap();
    for words in ["error: out/a.exr: ", "tmp/a-rescued-", "tmp/gone-rescued-", "after 300 iterations"] {
        assert!(last.contains(words), "no {words:?} in {last}");
    }
    let saved = sandbox.names().into_iter().find(|name| name.starts_with("tmp/gone-rescued-")).unwrap();
    expect_all_iterations(&sandbox, &saved);
}

#[test]
fn a_closed_pipe_for_progress_is_not_a_failure() {
    let sandbox = Sandbox::new();
    let (reader, writer) = io::pipe().unwrap();
    drop(reader);
    let args = ["render", "cornell", "--quality=paper", "--progress=json"];
    let output = sandbox.command(args.iter().chain(&TINY)).stdout(writer).output().unwrap();
    assert_eq!(output.status.code(), Some(0));
    sandbox.image("cornell.png");
}

#[cfg(target_os = "linux")]
#[test]
fn progress_onto_a_full_disk_is_a_failure_with_an_image() {
    let sandbox = Sandbox::new();
    let full = OpenOptions::new().write(true).open("/dev/full").unwrap();
    let args = ["render", "cornell", "--quality=paper", "--progress=json", "-q"];
    let output = sandbox.command(args.iter().chain(&TINY)).stdout(full).output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{stderr}");
    assert!(stderr.starts_with("error: cannot write to standard output: No space left"), "{stderr}");
    sandbox.image("cornell.png");
}

#[cfg(target_os = "linux")]
#[test]
fn messages_onto_a_full_disk_do_not_stop_a_render() {
    let sandbox = Sandbox::new();
    let full = OpenOptions::new().write(true).open("/dev/full").unwrap();
    let output = sandbox
        .command(["render", "cornell", "--quality=paper", "-v"].iter().chain(&TINY))
        .stderr(full)
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(0));
    sandbox.image("cornell.png");
}

/// The checkpoint may be on another file system than the image, as each temporary file is created in its own folder.
#[cfg(target_os = "linux")]
#[test]
fn a_checkpoint_on_another_file_system() {
    let elsewhere = tempfile::TempDir::new_in("/dev/shm").unwrap();
    let path = elsewhere.path().join("a.sppm");
    let checkpoint = format!("--checkpoint={}", path.display());
    let sandbox = Sandbox::new();
    sandbox.render(&["cornell", "-o", "a.exr", &checkpoint, "--every=1"]);
    assert_eq!(sandbox.names(), ["a.exr"]);
    let ended = sandbox.run(["resume".as_ref(), path.as_os_str(), "--iterations=4".as_ref()]);
    assert_eq!(ended.code, Some(0), "{ended:?}");
}
