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
        // Those of its file: the sky that a background becomes is none of them.
        let spheres = builtin.text.lines().filter(|line| *line == "[[sphere]]").count();
        assert!(line.contains(&format!(" {spheres} spheres ")), "{line}");
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

/// A lamp that is pasted twice in a scene with another light: the render succeeds, and is told to miss a light.
#[test]
fn a_lamp_that_lights_nothing_is_told() {
    let sandbox = Sandbox::new();
    let glowing = "[[sphere]]\ncenter = [0, 6, 0]\nradius = 1\nemission = [9, 9, 9]\nmaterial = { type = \"diffuse\", albedo = [0, 0, 0] }\n";
    let scene = |lamps: &str| {
        format!(
            "background = [1, 1, 1]\n[camera]\neye = [0, 0, 9]\ntarget = [0, 0, 0]\nvertical_fov_degrees = 40\n{lamps}"
        )
    };
    sandbox.write("once.toml", &scene(glowing));
    sandbox.write("twice.toml", &scene(&glowing.repeat(2)));
    let once = sandbox.render(&["once.toml"]);
    assert!(!once.stderr.contains("note:"), "{once:?}");
    let told = "note: twice.toml:9:12: sphere 1 lights nothing, as does another lamp: sphere 2 (line 11) is opaque and lies \
                exactly where it does; remove one\n";
    let twice = sandbox.render(&["twice.toml"]);
    assert!(twice.stderr.contains(told), "{twice:?}");
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
