//! Failures while a command runs give exit code 1 and a one-line message; input files that are not valid give exit code
//! 2.

use crate::sandbox::{Ended, Sandbox, TINY};
use std::fs;

/// Runs a command with its standard output on a full disk.
#[cfg(target_os = "linux")]
fn on_a_full_disk(sandbox: &Sandbox, args: &[&str]) -> Ended {
    let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let output = sandbox.command(args).stdout(full).output().unwrap();
    Ended {
        code: output.status.code(),
        stdout: String::new(),
        stderr: String::from_utf8(output.stderr).unwrap(),
    }
}

#[cfg(target_os = "linux")]
#[test]
fn every_command_that_prints_fails_on_a_full_disk() {
    let sandbox = Sandbox::new();
    sandbox.render(&["cornell", "-o", "a.pfm"]);
    let verify: Vec<&str> = ["verify", "cornell", "--threads", "1"].into_iter().chain(TINY).collect();
    let commands: [&[&str]; 10] = [
        &["--help"],
        &["render", "--help"],
        &["--version"],
        &["scenes"],
        &["scenes", "cornell"],
        &["compare", "a.pfm", "a.pfm"],
        &["compare", "a.pfm", "a.pfm", "--json"],
        &["completions", "bash"],
        &["man"],
        &verify,
    ];
    for args in commands {
        let ended = on_a_full_disk(&sandbox, args);
        assert_eq!(ended.code, Some(1), "{args:?}: {ended:?}");
        ended.said_one_line("error: cannot write to standard output", &["No space left"]);
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_render_completes_even_if_no_message_can_be_written() {
    let sandbox = Sandbox::new();
    let full = || fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let args: Vec<&str> = ["render", "cornell", "--quality=paper", "-v"].into_iter().chain(TINY).collect();
    let status = sandbox.command(args).stdout(full()).stderr(full()).status().unwrap();
    assert_eq!(status.code(), Some(0));
    assert_eq!(sandbox.image("cornell.png").pixels.len(), 16 * 12);
}

#[test]
fn manual_pages_that_cannot_be_written_are_a_failure() {
    let sandbox = Sandbox::new();
    fs::create_dir_all(sandbox.path("man1/sppm.1")).unwrap();
    let ended = sandbox.run(["man", "man1"]);
    assert_eq!(ended.code, Some(1), "{ended:?}");
    ended.said_one_line("error: cannot write the manual pages into man1: ", &[]);
}

/// All are looked at before the first is written.
#[test]
fn no_manual_page_is_written_if_another_cannot_be() {
    let sandbox = Sandbox::new();
    fs::create_dir_all(sandbox.path("man1/sppm-man.1")).unwrap();
    let ended = sandbox.run(["man", "man1"]);
    assert_eq!(ended.code, Some(1), "{ended:?}");
    ended.said_one_line("error: cannot write the manual pages into man1: ", &["sppm-man.1"]);
    assert_eq!(sandbox.names(), ["man1/", "man1/sppm-man.1/"]);
}

/// On a full disk no empty page is left; here, with a limit on the size of files.
#[cfg(unix)]
#[test]
fn manual_pages_appear_whole_or_not_at_all() {
    let sandbox = Sandbox::new();
    fs::create_dir(sandbox.path("man1")).unwrap();
    let mut shell = std::process::Command::new("sh");
    shell.args(["-c", "ulimit -f 1; exec \"$@\"", "sh", env!("CARGO_BIN_EXE_sppm"), "man", "man1"]);
    let output = shell.current_dir(sandbox.path("")).output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.starts_with("error: cannot write the manual pages into man1: man1/sppm.1: "), "{said}");
    assert_eq!(sandbox.names(), ["man1/"]);
}

#[test]
fn images_out_of_bounds_are_a_failure_that_names_each_bound() {
    let sandbox = Sandbox::new();
    for (seed, name) in [("1", "a.exr"), ("2", "b.exr")] {
        sandbox.render(&["cornell", "--seed", seed, "-o", name]);
    }
    let ended = sandbox.run(["compare", "a.exr", "b.exr", "--max-abs", "0", "--min-ssim", "1"]);
    assert_eq!(ended.code, Some(1), "{ended:?}");
    assert!(ended.stderr.contains("--max-abs 0; ") && ended.stderr.contains("--min-ssim 1"), "{ended:?}");
    assert_eq!(ended.stderr.lines().count(), 1, "{ended:?}");
}

#[test]
fn scene_files_that_are_not_text() {
    let sandbox = Sandbox::new();
    fs::create_dir(sandbox.path("folder.toml")).unwrap();
    fs::write(sandbox.path("latin.toml"), b"name = \"caf\xe9\"\n").unwrap();
    fs::write(sandbox.path("image.toml"), b"\x89PNG\r\n\x1a\n").unwrap();
    for (name, words) in [
        ("folder.toml", &["directory"][..]),
        ("latin.toml", &["latin.toml:1:12", "0xe9", "UTF-8"]),
        ("image.toml", &["image.toml:1:1", "UTF-8"]),
    ] {
        for command in ["render", "verify"] {
            sandbox.run([command, name]).refused(&[&[name], words].concat());
        }
    }
}

#[test]
fn images_that_are_broken() {
    let sandbox = Sandbox::new();
    for name in ["a.png", "a.exr", "a.pfm"] {
        sandbox.render(&["cornell", "-o", name]);
        let whole = sandbox.bytes(name);
        for (bytes, what) in
            [(&whole[..whole.len() / 2], "half"), (&whole[..0], "empty"), (&[7; 999], "noise")]
        {
            let broken = name.replace('a', what);
            fs::write(sandbox.path(&broken), bytes).unwrap();
            sandbox.run(["compare", name, &broken]).refused(&[&format!("{broken}: ")]);
            sandbox.run(["compare", &broken, name]).refused(&[&format!("{broken}: ")]);
        }
    }
}

#[test]
fn a_rejected_render_does_not_change_old_files() {
    let sandbox = Sandbox::new();
    sandbox.write("a.png", "old");
    sandbox
        .run(["render", "cornell", "--quality=paper", "-o", "a.png", "--width", "0"])
        .refused(&["--width"]);
    sandbox.run(["render", "missing.toml", "-o", "a.png"]).refused(&["missing.toml"]);
    assert_eq!(sandbox.bytes("a.png"), b"old");
    assert_eq!(sandbox.names(), ["a.png"]);
}
