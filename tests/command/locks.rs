//! Two renders never work towards the same file: the second is refused at once, and changes nothing.

use crate::running::{LONG, Running};
use crate::sandbox::{Sandbox, TINY};
use rustix::process::Signal;
use std::fs;
use std::os::unix::fs::symlink;

/// Starts an endless render with `args`.
fn begin(sandbox: &Sandbox, args: &[&str]) -> Running {
    Running::start(&mut sandbox.command(LONG.iter().chain(args)))
}

/// Expects each of `commands`, with the options of a tiny render, to be refused because `file` is in use by `running`.
fn all_refused(sandbox: &Sandbox, running: &Running, file: &str, commands: &[&[&str]]) {
    let before = sandbox.contents();
    let process = format!("{file}: is in use by another render, process {};", running.id());
    for args in commands {
        sandbox
            .run(["render", "--quality=paper"].iter().chain(*args).chain(&TINY))
            .refused(&[&process, "wait for it"]);
        assert!(sandbox.contents() == before, "{args:?} changed the folder: {:?}", sandbox.names());
    }
}

#[test]
fn of_two_renders_to_one_image_the_second_is_refused_whatever_its_options() {
    let sandbox = Sandbox::new();
    sandbox.write("same.pfm", "old");
    fs::create_dir(sandbox.path("folder")).unwrap();
    symlink("same.pfm", sandbox.path("link.pfm")).unwrap();
    symlink("../same.pfm", sandbox.path("folder/far.pfm")).unwrap();
    let running = begin(&sandbox, &["-o", "same.pfm"]);
    let far = sandbox.path("folder/../same.pfm");
    all_refused(
        &sandbox,
        &running,
        "same.pfm",
        &[
            &["cornell", "-o", "same.pfm"],
            &["cornell", "-o", "same.pfm", "--seed", "2", "--no-checkpoint"],
            &["mirror", "-o", "./same.pfm", "--checkpoint", "other.sppm"],
            &["cornell", "-o", far.to_str().unwrap(), "--engine", "path"],
            &["cornell", "-o", "other.pfm", "--radius-image", "same.pfm"],
        ],
    );
    all_refused(&sandbox, &running, "link.pfm", &[&["cornell", "-o", "link.pfm"]]);
    all_refused(&sandbox, &running, "folder/far.pfm", &[&["cornell", "-o", "folder/far.pfm"]]);
    running.send(Signal::TERM);
    assert_eq!(running.end().code, Some(143));
    assert_eq!(sandbox.image("same.pfm").pixels.len(), 16 * 12);
}

#[test]
fn every_file_of_a_render_is_locked() {
    let sandbox = Sandbox::new();
    let files = ["--radius-image", "r.exr", "--count-image", "c.exr", "--stats", "s.json"];
    // The path tracer of `LONG` has no radii.
    let engine = ["--engine=fast", "--width=16", "--height=12", "--photons=500", "-n", "100000000", "-v"];
    let args = ["render", "cornell", "--quality=paper", "-o", "a.png"].into_iter().chain(files).chain(engine);
    let running = Running::start_saying(&mut sandbox.command(args), "engine fast");
    for (file, option) in [("r.exr", "--radius-image"), ("c.exr", "--count-image"), ("s.json", "--stats")] {
        all_refused(&sandbox, &running, file, &[&["cornell", "-o", "b.png", option, file]]);
    }
    all_refused(&sandbox, &running, "a.png.sppm", &[&["mirror", "-o", "b.png", "--checkpoint=a.png.sppm"]]);
    // Other files are free.
    sandbox.render(&["cornell", "-o", "b.png", "--stats", "t.json"]);
    running.send(Signal::TERM);
    assert_eq!(running.end().code, Some(143));
}

/// The names of snapshots are made from that of the image, and may be another render's image.
#[test]
fn snapshots_are_locked_before_they_are_written() {
    let sandbox = Sandbox::new();
    let running = begin(&sandbox, &["-o", "a.png", "--snapshots"]);
    // Written already, and not before days have passed.
    let process = format!("process {};", running.id());
    for file in ["a-0001.png", "a-67108864.png"] {
        let ended = sandbox.run(["render", "cornell", "--quality=paper", "-o", file].iter().chain(&TINY));
        ended.refused(&[&format!("{file}: is in use by another render"), &process]);
    }
    sandbox.render(&["cornell", "-o", "a-0003.png"]);
    running.send(Signal::TERM);
    assert_eq!(running.end().code, Some(143));

    let running = begin(&sandbox, &["-o", "b-0002.pfm"]);
    all_refused(&sandbox, &running, "b-0002.pfm", &[&["cornell", "-o", "b.pfm", "--snapshots"]]);
    running.send(Signal::TERM);
    assert_eq!(running.end().code, Some(143));
}

#[test]
fn a_snapshot_is_no_other_file_of_its_render() {
    let sandbox = Sandbox::new();
    let render = |options: &[&str]| {
        let args = ["render", "cornell", "--quality=paper", "-o", "a.pfm", "--snapshots"].iter().chain(&TINY);
        sandbox.run(args.chain(options))
    };
    let problem = "--snapshots: a-0002.pfm is also --radius-image; name another file";
    render(&["--radius-image=a-0002.pfm"]).refused(&[problem]);
    render(&["--checkpoint=a-0001.pfm"]).refused(&["--snapshots: a-0001.pfm is also --checkpoint"]);
    assert_eq!(sandbox.names(), [""; 0]);
    assert_eq!(render(&["--radius-image=a-0004.pfm"]).code, Some(0));
}

#[test]
fn a_checkpoint_is_not_resumed_while_it_is_rendered() {
    let sandbox = Sandbox::new();
    let running = begin(&sandbox, &["--checkpoint=a.sppm", "--every=1"]);
    while !sandbox.path("a.sppm").exists() {
        std::thread::yield_now();
    }
    let process = format!("process {};", running.id());
    sandbox.run(["resume", "a.sppm", "-o", "b.png"]).refused(&["a.sppm: is in use", &process]);
    running.send(Signal::KILL);
    running.end();
}

/// A killed render leaves its lock files behind, which lock nothing.
#[test]
fn a_killed_render_does_not_block_the_next() {
    let sandbox = Sandbox::new();
    let running = begin(&sandbox, &["-o", "a.png"]);
    running.send(Signal::KILL);
    assert_eq!(running.end().code, None);
    assert!(sandbox.names().contains(&".sppm-a.png.lock".into()), "{:?}", sandbox.names());
    sandbox.render(&["cornell", "-o", "a.png"]);
    assert_eq!(sandbox.names(), ["a.png"]);
}

/// An image is replaced as a whole, so its other hard links keep the old content, and are free.
#[test]
fn hard_links_are_different_files() {
    let sandbox = Sandbox::new();
    sandbox.write("a.png", "old");
    for name in ["b.png", "c.png"] {
        fs::hard_link(sandbox.path("a.png"), sandbox.path(name)).unwrap();
    }
    let running = begin(&sandbox, &["-o", "a.png"]);
    sandbox.render(&["cornell", "-o", "b.png"]);
    running.send(Signal::TERM);
    assert_eq!(running.end().code, Some(143));
    assert_eq!(sandbox.image("a.png").pixels.len(), sandbox.image("b.png").pixels.len());
    assert_eq!(sandbox.bytes("c.png"), b"old");
    assert_eq!(sandbox.names(), ["a.png", "a.png.sppm", "b.png", "c.png"]);
}

#[test]
fn many_renders_at_once_leave_one_image_and_one_winner() {
    let sandbox = Sandbox::new();
    let size = ["--width=64", "--height=48", "--photons=20000", "--iterations=400", "--no-checkpoint"];
    let seeds: Vec<String> = (1..=6).map(|seed| format!("--seed={seed}")).collect();
    let start = |seed: &String| {
        let args =
            ["render", "cornell", "--quality=paper", "-o", "a.pfm", "-q", seed].into_iter().chain(size);
        sandbox.command(args).stderr(std::process::Stdio::piped()).spawn().unwrap()
    };
    let all: Vec<_> = seeds.iter().map(start).collect();
    let outputs: Vec<_> = all.into_iter().map(|child| child.wait_with_output().unwrap()).collect();
    let winners: Vec<_> = (0..6).filter(|&i| outputs[i].status.success()).collect();
    assert_eq!(winners.len(), 1, "{outputs:?}");
    for output in outputs.iter().filter(|output| !output.status.success()) {
        assert_eq!(output.status.code(), Some(2), "{output:?}");
    }
    let again = ["render", "cornell", "--quality=paper", "-o", "b.pfm", "-q", &seeds[winners[0]]]
        .into_iter()
        .chain(size);
    assert_eq!(sandbox.run(again).code, Some(0));
    assert!(sandbox.bytes("a.pfm") == sandbox.bytes("b.pfm"), "not the winner's image");
}

#[test]
fn a_folder_that_cannot_be_written_is_told_as_such() {
    use std::os::unix::fs::PermissionsExt;
    let sandbox = Sandbox::new();
    let folder = sandbox.path("locked");
    fs::create_dir(&folder).unwrap();
    fs::set_permissions(&folder, fs::Permissions::from_mode(0o555)).unwrap();
    // The superuser may write all the same.
    if fs::write(folder.join("x"), "").is_ok() {
        return;
    }
    let args = ["render", "cornell", "--quality=paper", "-o", "locked/a.png"];
    sandbox.run(args).refused(&["--output: locked/a.png: no file can be made in the folder"]);
}

#[test]
fn a_lock_that_cannot_be_made_is_told_as_such() {
    let sandbox = Sandbox::new();
    fs::create_dir(sandbox.path(".sppm-a.png.lock")).unwrap();
    let ended = sandbox.run(["render", "cornell", "--quality=paper", "-o", "a.png"].iter().chain(&TINY));
    ended.refused(&["--output: a.png: cannot be locked: "]);
}

/// A checkpoint that is damaged stays as it is until the render is accepted and has something to save.
#[test]
fn a_refused_render_leaves_both_generations_as_they_are() {
    let sandbox = Sandbox::new();
    sandbox.render(&["cornell", "-o", "a.exr", "--checkpoint=a.sppm", "--every=1"]);
    sandbox.write("a.sppm", "damaged");
    let before = sandbox.contents();
    for args in [
        &["resume", "a.sppm", "--memory-limit=1M"][..],
        &["resume", "a.sppm", "-o", "missing/a.exr"],
        &["resume", "a.sppm", "--iterations=100000000", "--memory-limit=1M"],
    ] {
        assert_eq!(sandbox.run(args).code, Some(2), "{args:?}");
        assert!(sandbox.contents() == before, "{args:?}");
    }
}
