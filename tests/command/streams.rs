//! Scenes from standard input, and images on standard output.

use crate::running::{LONG, Running};
use crate::sandbox::{Ended, Sandbox, TINY};
use rustix::process::Signal;
use std::fs::{self, File};
use std::io;
use std::process::{Output, Stdio};

/// Runs a render with the options of [`TINY`] and returns its raw output.
fn render(sandbox: &Sandbox, args: &[&str]) -> Output {
    sandbox.command(["render", "--quality=paper"].iter().chain(args).chain(&TINY)).output().unwrap()
}

/// Runs `args` with the file `input` as standard input.
fn run_on(sandbox: &Sandbox, input: &str, args: &[&str]) -> Ended {
    let output = sandbox.command(args).stdin(File::open(sandbox.path(input)).unwrap()).output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    Ended { code: output.status.code(), stdout: text(output.stdout), stderr: text(output.stderr) }
}

#[test]
fn standard_output_gets_the_bytes_of_the_file() {
    let sandbox = Sandbox::new();
    for (name, stream) in [("a.png", "-"), ("a.png", "png:-"), ("a.exr", "exr:-"), ("a.pfm", "pfm:-")] {
        sandbox.render(&["cornell", "-o", name]);
        let names = sandbox.names();
        let output = render(&sandbox, &["cornell", "-o", stream]);
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(0), "{said}");
        assert!(said.starts_with("wrote standard output: 2 iterations in "), "{said}");
        assert!(output.stdout == sandbox.bytes(name), "{stream} is not {name}");
        assert_eq!(sandbox.names(), names);
    }
    let bright = render(&sandbox, &["cornell", "-o", "-", "--exposure", "2"]).stdout;
    sandbox.render(&["cornell", "-o", "a.png", "--exposure", "2"]);
    assert!(bright == sandbox.bytes("a.png"));
}

/// The address of the page then is a message like others.
#[test]
fn an_image_on_standard_output_is_alone_there_beside_a_page() {
    let sandbox = Sandbox::new();
    sandbox.render(&["cornell", "-o", "a.png"]);
    let output = render(&sandbox, &["cornell", "-o", "-", "--view", "--no-open"]);
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert!(said.starts_with("the page is at http://127.0.0.1:"), "{said}");
    assert!(output.stdout == sandbox.bytes("a.png"), "{said}");
}

#[test]
fn what_standard_output_cannot_take_is_refused() {
    let sandbox = Sandbox::new();
    let cases: &[(&[&str], &[&str])] = &[
        (&["-o", "foo:-"], &["--output", ".foo", ".png"]),
        (&["-o", "exr:-", "--tone", "aces"], &["--tone: standard output holds linear radiance"]),
        (&["-o", ":-"], &["--output: standard output: has no extension"]),
        (&["-o", "gif:-"], &["--output: standard output: has the extension .gif; it must be .png"]),
        (&["-o", "exr:-", "--exposure", "1"], &["--exposure", "only .png"]),
        (&["-o", "-", "--snapshots"], &["--snapshots", "name a file"]),
        (&["-o", "-", "--progress", "json"], &["--progress json", "standard output"]),
        (&["--stats", "-"], &["--stats: standard output takes the image alone"]),
        (&["--radius-image", "exr:-"], &["--radius-image: standard output takes the image alone"]),
        (&["--count-image", "-"], &["--count-image: standard output takes the image alone"]),
    ];
    for (args, words) in cases {
        sandbox.run(["render", "cornell", "--quality=paper"].iter().chain(*args).chain(&TINY)).refused(words);
        assert_eq!(sandbox.names(), [""; 0], "{args:?}");
    }
}

#[test]
fn a_closed_pipe_is_not_a_failure() {
    let sandbox = Sandbox::new();
    let (reader, writer) = io::pipe().unwrap();
    drop(reader);
    let args = ["render", "cornell", "--quality=paper", "-o", "-"];
    let status = sandbox.command(args.iter().chain(&TINY)).stdout(writer).status().unwrap();
    assert_eq!(status.code(), Some(0));
    for args in [&["--help"][..], &["--version"], &["scenes"], &["render", "--help"]] {
        let (reader, writer) = io::pipe().unwrap();
        drop(reader);
        let ended = sandbox.command(args).stdout(writer).output().unwrap();
        assert_eq!((ended.status.code(), ended.stderr), (Some(0), vec![]), "{args:?}");
    }
}

/// On standard output too, where its format has them.
#[test]
fn a_repeated_render_keeps_exposure_and_tone() {
    let sandbox = Sandbox::new();
    sandbox.render(&["cornell", "-o", "a.png", "--exposure", "1", "--tone", "clamp"]);
    let again = |output: &str| {
        let ended = sandbox.command(["render", "--like", "a.png", "-o", output]).output().unwrap();
        assert_eq!(ended.status.code(), Some(0));
        ended.stdout
    };
    assert!(again("-") == sandbox.bytes("a.png"));
    again("b.pfm");
    assert!(again("pfm:-") == sandbox.bytes("b.pfm"));
}

/// The image is not lost: it is written beside.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_behind_standard_output_is_a_failure_with_an_image() {
    let sandbox = Sandbox::new();
    let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let args = ["render", "cornell", "--quality=paper", "-o", "pfm:-"];
    let output = sandbox.command(args.iter().chain(&TINY)).stdout(full).output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(
        said.starts_with("error: standard output: cannot be written: No space left on device; it is in "),
        "{said}"
    );
    let names = sandbox.names();
    assert!(names.len() == 1 && names[0].starts_with("image-rescued-"), "{names:?}");
    assert_eq!(sandbox.image(&names[0]).pixels.len(), 16 * 12);
}

#[test]
fn an_interrupted_render_goes_to_standard_output_and_is_resumed_to_it() {
    let sandbox = Sandbox::new();
    let out = File::create(sandbox.path("first")).unwrap();
    let mut command = sandbox.command(LONG.iter().chain(&["-o", "pfm:-", "--checkpoint=a.sppm"]));
    let running = Running::start_writing(&mut command, out.into(), "method path");
    running.send(Signal::INT);
    let ended = running.end();
    assert_eq!(ended.code, Some(130), "{ended:?}");
    ended.said_one_line("interrupted: wrote standard output after ", &["`sppm resume a.sppm`"]);
    let done = sandbox.run(["info", "a.sppm", "--json"]).stdout;
    let done: serde_json::Value = serde_json::from_str(&done).unwrap();
    let done = done["iterations"].to_string();
    let again = sandbox.command(["resume", "a.sppm", "-o", "pfm:-", "-n", &done]).output().unwrap();
    assert_eq!(again.status.code(), Some(0), "{again:?}");
    assert!(again.stdout == sandbox.bytes("first"));
    // The checkpoint asks for these iterations now, and the older one for more.
    assert_eq!(sandbox.names(), ["a.sppm", "a.sppm.1", "first"]);
}

#[test]
fn a_scene_is_read_from_standard_input() {
    let sandbox = Sandbox::new();
    sandbox.write("mine.toml", files::builtin::find("cornell").unwrap().text);
    sandbox.render(&["mine.toml", "-o", "file.pfm"]);
    let args: Vec<&str> =
        ["render", "-", "--quality=paper", "-o", "input.pfm"].into_iter().chain(TINY).collect();
    let ended = run_on(&sandbox, "mine.toml", &args);
    assert_eq!(ended.code, Some(0), "{ended:?}");
    assert!(sandbox.bytes("file.pfm") == sandbox.bytes("input.pfm"));
    // Without a name, the image is called after standard input.
    let args: Vec<&str> = ["render", "-"].into_iter().chain(TINY).collect();
    assert_eq!(run_on(&sandbox, "mine.toml", &args).code, Some(0));
    assert_eq!(sandbox.names(), ["file.pfm", "input.pfm", "mine.toml", "stdin.png"]);

    let size = ["--width=16", "--height=12", "--photons=100", "--iterations=1"];
    let verify: Vec<&str> = ["verify", "-"].into_iter().chain(size).collect();
    assert_eq!(run_on(&sandbox, "mine.toml", &verify).code, Some(0));
    let export = run_on(&sandbox, "mine.toml", &["export", "-", "--format=pbrt", "-o", "-"]);
    assert_eq!(export.stdout, sandbox.run(["export", "mine.toml", "--format=pbrt"]).stdout);
}

/// The size of the image, to which a stage is fitted, and the limit of memory.
#[test]
fn what_options_say_holds_while_standard_input_is_read() {
    let sandbox = Sandbox::new();
    let ball = "[[sphere]]\ncenter = [1, 2, 3]\nradius = 1\nmaterial = { type = \"specular\", albedo = [1, 1, 1] }\n";
    sandbox.write("staged.toml", &format!("[stage]\nview = \"front\"\n{ball}"));
    let size = ["--width=9", "--height=24", "--iterations=1"];
    let file = sandbox.run(["render", "staged.toml", "-o", "file.pfm"].iter().chain(&size));
    assert_eq!(file.code, Some(0), "{file:?}");
    let args: Vec<&str> = ["render", "-", "-o", "input.pfm"].into_iter().chain(size).collect();
    assert_eq!(run_on(&sandbox, "staged.toml", &args).code, Some(0));
    assert!(sandbox.bytes("file.pfm") == sandbox.bytes("input.pfm"));
    let limited = run_on(&sandbox, "staged.toml", &["render", "-", "--memory-limit=1K"]);
    limited.refused(&["stdin: takes up to ", " to read, more than the limit of 1.0 KiB"]);
}

#[test]
fn a_broken_scene_on_standard_input_is_told_with_its_place() {
    let sandbox = Sandbox::new();
    sandbox.write("broken", "name = \"broken\"\nspheres = 3 4\n");
    sandbox.write("empty", "");
    fs::write(sandbox.path("latin"), b"name = \"caf\xe9\"\n").unwrap();
    for (input, words) in [("broken", "stdin:2:"), ("empty", "stdin"), ("latin", "stdin:1:12: byte 0xe9")] {
        run_on(&sandbox, input, &["render", "-"]).refused(&[words]);
    }
    assert_eq!(sandbox.names(), ["broken", "empty", "latin"]);
    let closed = sandbox.command(["render", "-"]).stdin(Stdio::null()).output().unwrap();
    assert_eq!(closed.status.code(), Some(2), "{closed:?}");
}
