//! The command `scenes`.

use crate::sandbox::{Ended, Sandbox};
use files::builtin::SCENES;
use std::io;

#[test]
fn every_scene_is_listed_in_a_line_with_its_spheres() {
    let Ended { code, stdout, stderr } = Sandbox::new().run(["scenes"]);
    assert_eq!((code, stderr.as_str()), (Some(0), ""));
    assert_eq!(stdout.lines().count(), SCENES.len());
    for (line, builtin) in stdout.lines().zip(SCENES) {
        assert!(line.starts_with(builtin.name) && line.ends_with(builtin.about), "{line}");
        assert!(line.contains(&format!(" {} spheres ", builtin.scene().spheres.len())), "{line}");
    }
}

#[test]
fn a_printed_scene_is_a_file_to_start_from() {
    let sandbox = Sandbox::new();
    let printed = sandbox.run(["scenes", "mirror"]);
    assert_eq!((printed.code, printed.stderr.as_str()), (Some(0), ""));
    sandbox.write("mine.toml", &printed.stdout);
    sandbox.render(&["mine.toml"]);
    sandbox.render(&["mirror"]);
    assert_eq!(sandbox.bytes("mine.png"), sandbox.bytes("mirror.png"));
}

#[test]
fn a_closed_pipe_is_not_a_failure() {
    let (reader, writer) = io::pipe().unwrap();
    drop(reader);
    let sandbox = Sandbox::new();
    let output = sandbox.command(["scenes", "random"]).stdout(writer).output().unwrap();
    assert_eq!((output.status.code(), output.stderr.as_slice()), (Some(0), &b""[..]));
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_a_failure() {
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let output = Sandbox::new().command(["scenes"]).stdout(full).output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    Ended { code: output.status.code(), stdout: String::new(), stderr: stderr.clone() }
        .said_one_line("error: cannot write to standard output", &["No space left"]);
    assert_eq!(output.status.code(), Some(1), "{stderr}");
}
