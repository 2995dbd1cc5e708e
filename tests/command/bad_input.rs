//! Invalid input: exit code 2, a one-line message that says what is wrong and how to fix it, and no file written.

use crate::cases::tell;
use crate::sandbox::Sandbox;
use std::fs;

/// A folder with files and folders that an option may name by mistake.
fn prepared() -> Sandbox {
    let sandbox = Sandbox::new();
    fs::create_dir(sandbox.path("folder.png")).unwrap();
    sandbox.write("broken.toml", "name = \"broken\"\nspheres = 3 4\n");
    sandbox.write("empty.toml", "");
    sandbox.write("note.txt", "no image");
    sandbox.write("note.png", "no image either");
    sandbox.write("mine.toml", files::builtin::find("cornell").unwrap().text);
    sandbox
}

/// Expects each command line to be rejected with a message that contains the given words, without changes to the
/// folder.
fn all_refused(cases: &[(&[&str], &[&str])]) {
    refuse(cases);
    tell("command", cases.len(), "refused command lines");
}

fn refuse(cases: &[(&[&str], &[&str])]) {
    let sandbox = prepared();
    let before = sandbox.contents();
    for (args, words) in cases {
        sandbox.run(*args).refused(words);
        assert!(sandbox.contents() == before, "{args:?} changed the folder: {:?}", sandbox.names());
    }
}

#[test]
fn commands() {
    all_refused(&[
        (&[], &["command is missing", "--help"]),
        (&["rendr", "cornell"], &["no command \"rendr\"", "did you mean render"]),
        (&["frobnicate"], &["no command \"frobnicate\"", "sppm --help"]),
        (&[""], &["no command \"\""]),
        (&["-x"], &["no option -x"]),
        (&["--versoin"], &["no option --versoin", "--version"]),
        (&["render"], &["<SCENE> is missing", "sppm render --help"]),
        (&["verify"], &["<SCENE> is missing", "sppm verify --help"]),
        (&["render", "cornell", "mirror"], &["\"mirror\"", "too many"]),
        (&["render", "cornell", "-"], &["\"-\"", "too many"]),
    ]);
}

#[test]
fn scene_names() {
    all_refused(&[
        (&["render", "cornel"], &["no scene \"cornel\"", "did you mean cornell?", "surgery", ".toml"]),
        (&["render", "Mirror"], &["no scene \"Mirror\"", "did you mean mirror?"]),
        (&["render", "zzzzzzzz"], &["no scene \"zzzzzzzz\"; a scene is one of cornell, large"]),
        (&["render", ""], &["no scene \"\""]),
        (&["render", "two\nlines"], &["no scene \"two\\nlines\""]),
        (&["render", "note.txt"], &["no scene \"note.txt\"", ".toml"]),
        (&["render", "missing.toml"], &["missing.toml: "]),
        (&["render", "broken.toml"], &["broken.toml:2:"]),
        (&["render", "empty.toml"], &["empty.toml"]),
        (&["verify", "cornel"], &["did you mean cornell?"]),
        (&["scenes", "cornel"], &["did you mean cornell?"]),
        (&["scenes", "mine.toml"], &["no scene \"mine.toml\""]),
        (&["scenes", "cornell", "mirror"], &["\"mirror\"", "too many"]),
    ]);
}

#[test]
fn whole_numbers() {
    let whole = |option: &str| format!("{option}: ");
    for (option, most) in [
        ("--width", "1048576"),
        ("--height", "1048576"),
        ("--iterations", "1073741824"),
        ("--photons", "268435456"),
        ("--depth", "4096"),
        ("--threads", "1024"),
    ] {
        let range = format!("is not a whole number from 1 to {most}");
        for value in
            ["0", "-1", "1e6", "2.5", "abc", "", " 7", "NaN", "inf", "0x10", "99999999999", "1099511627776"]
        {
            let quoted = format!("{value:?}");
            refuse(&[(&["render", "cornell", option, value], &[&whole(option), &quoted, &range])]);
        }
    }
    tell("command", 72, "refused whole numbers");
}

#[test]
fn sizes_that_are_too_large_are_rejected_with_their_memory() {
    all_refused(&[
        (&["render", "cornell", "--photons", "1099511627776"], &["--photons", "GiB"]),
        (&["render", "cornell", "--width", "1000000000000"], &["--width", "GiB"]),
        (
            &["render", "cornell", "--width", "1000000", "--height", "1000000"],
            &["--width 1000000", "238418.6 GiB"],
        ),
        (
            &["render", "cornell", "--height", "1000000"],
            &["x --height 1000000 is", "GiB", "at most 268435456 pixels"],
        ),
        (
            &["render", "cornell", "--depth", "4000", "--photons", "200000000"],
            &["--photons 200000000", "4000", "iterations"],
        ),
        (&["verify", "cornell", "--width", "1000000", "--height", "1000000"], &["--width 1000000", "GiB"]),
    ]);
}

#[test]
fn other_numbers() {
    all_refused(&[
        (&["render", "cornell", "--radius", "0"], &["--radius: \"0\" is not a number from 1e-15 to 1e15"]),
        (&["render", "cornell", "--radius", "-2"], &["--radius: \"-2\""]),
        (&["render", "cornell", "--radius", "NaN"], &["--radius: \"NaN\""]),
        (&["render", "cornell", "--radius", "inf"], &["--radius: \"inf\""]),
        (&["render", "cornell", "--radius", "-inf"], &["--radius: \"-inf\""]),
        (&["render", "cornell", "--radius", "1e-40"], &["--radius: \"1e-40\""]),
        (&["render", "cornell", "--radius", "2 cm"], &["--radius: \"2 cm\""]),
        (&["render", "cornell", "--radius="], &["--radius: \"\""]),
        (&["render", "cornell", "--seed", "-1"], &["--seed: \"-1\" is not a whole number from 0 to"]),
        (&["render", "cornell", "--seed", "18446744073709551616"], &["--seed", "18446744073709551615"]),
        (&["render", "cornell", "--exposure", "bright"], &["--exposure: \"bright\"", "-100"]),
        (&["render", "cornell", "--exposure", "inf"], &["--exposure: \"inf\""]),
        (&["verify", "cornell", "--radius", "-2"], &["--radius: \"-2\""]),
    ]);
}

#[test]
fn options() {
    all_refused(&[
        (&["render", "cornell", "--widht", "3"], &["no option --widht", "did you mean --width?"]),
        (&["render", "cornell", "-z"], &["no option -z", "sppm render --help"]),
        (&["render", "cornell", "--width"], &["--width: the value is missing"]),
        (&["render", "cornell", "--width", "3", "--width", "4"], &["--width is given twice"]),
        (&["render", "cornell", "--engine", "gpu"], &["--engine: \"gpu\"", "fast, reference and path"]),
        (&["render", "cornell", "--engine", ""], &["--engine", "fast, reference and path"]),
        (&["render", "cornell", "--lanes", "sse"], &["--lanes: \"sse\"", "auto, avx2, avx512 and emulated"]),
        (&["verify", "cornell", "--lanes", "avx2"], &["no option --lanes"]),
        (&["render", "cornell", "-q", "-v"], &["--quiet", "--verbose", "one of them"]),
        (&["render", "cornell", "--quiet=yes"], &["--quiet"]),
        (&["render", "cornell", "--method", "gpu"], &["--method: \"gpu\"", "sppm, path and hybrid"]),
        (&["verify", "cornell", "--engine", "path"], &["no option --engine"]),
        (&["verify", "cornell", "-o", "a.png"], &["no option -o"]),
        (&["completions", "klingon"], &["\"klingon\"", "bash", "zsh"]),
        (&["completions"], &["<SHELL> is missing"]),
        (&["man", "missing"], &["DIR", "missing", "not a folder"]),
        (&["man", "note.txt"], &["note.txt", "not a folder"]),
        (&["view", "cornell", "--listen", "here"], &["--listen: \"here\" is not the number of an address"]),
        (&["render", "cornell", "--checkpoint", "-"], &["--checkpoint: \"-\" is standard output"]),
    ]);
}

/// Processors that support all lanes cannot test this; for those there is a unit test of the message.
#[test]
fn lanes_that_the_processor_lacks() {
    for kind in fast::LaneKind::ALL.into_iter().filter(|kind| !kind.is_available()) {
        let name = format!("{kind:?}").to_lowercase();
        let option = format!("--lanes {name}");
        all_refused(&[(&["render", "cornell", "--lanes", &name], &[&option, "this processor", "emulated"])]);
    }
}

#[test]
fn outputs() {
    all_refused(&[
        (&["render", "cornell", "-o", ""], &["--output: the value is missing"]),
        (&["render", "cornell", "-o", "a.gif"], &["--output: a.gif", ".png, .jpg, .exr, .pfm, .hdr or .tif"]),
        (
            &["render", "cornell", "-o", "picture"],
            &["--output: picture", ".png, .jpg, .exr, .pfm, .hdr or .tif"],
        ),
        (&["render", "cornell", "-o", "a.webp"], &["--output: a.webp", "read but not written"]),
        (&["render", "cornell", "-o", "missing/a.png"], &["--output: missing/a.png", "does not exist"]),
        (&["render", "cornell", "-o", "note.txt/a.png"], &["--output: note.txt/a.png", "not a folder"]),
        (&["render", "cornell", "-o", "folder.png"], &["--output: folder.png", "is a folder"]),
        (&["render", "cornell", "-o", "."], &["--output: .: is a folder; name a file in it"]),
        (&["render", "cornell", "--radius-image", "/"], &["--radius-image: /", "names a folder"]),
        (&["render", "cornell", "--stats", "folder.png"], &["--stats: folder.png", "is a folder"]),
        (&["render", "cornell", "--stats", "missing/s.json"], &["--stats: missing/s.json", "does not exist"]),
        (&["render", "cornell", "--radius-image", "r.txt"], &["--radius-image: r.txt", ".exr"]),
        (&["render", "cornell", "--count-image", "missing/c.exr"], &["--count-image: missing/c.exr"]),
        (&["render", "cornell", "--stats", "two\nlines/s.json"], &["--stats", "two\\nlines"]),
    ]);
}

#[test]
fn contradictions() {
    all_refused(&[
        (
            &["render", "cornell", "--engine", "path", "--radius-image", "r.exr"],
            &["--radius-image", "--engine path has no photons"],
        ),
        (
            &["render", "cornell", "--method", "path", "--engine", "reference", "--lanes", "auto"],
            &["--lanes", "--engine reference has no lanes", "only fast"],
        ),
        (
            &["render", "cornell", "--method", "path", "--radius-image", "r.exr"],
            &["--radius-image", "--method path has no photons"],
        ),
        (
            &["render", "cornell", "--method", "sppm", "--engine", "path"],
            &["--engine path means --method path", "--method sppm", "leave out one"],
        ),
        (
            &["render", "cornell", "--engine", "path", "--count-image", "c.exr"],
            &["--count-image", "--engine path has no photons"],
        ),
        (
            &["render", "cornell", "-o", "a.exr", "--radius-image", "./a.exr"],
            &["--radius-image", "./a.exr", "also --output"],
        ),
        (&["render", "cornell", "--count-image", "cornell.png"], &["--count-image", "also --output"]),
        (
            &["render", "cornell", "--stats", "folder.png/../s.json", "--radius-image", "s.json"],
            &["--stats", "also --radius-image"],
        ),
        (&["render", "mine.toml", "--stats", "mine.toml"], &["--stats", "also the scene"]),
        (
            &["render", "cornell", "-o", "a.exr", "--exposure", "1"],
            &["--exposure", "a.exr", "only .png and .jpg"],
        ),
        (
            &["render", "cornell", "-o", "a.hdr", "--exposure", "1"],
            &["--exposure", "a.hdr", "linear radiance"],
        ),
    ]);
}

#[cfg(unix)]
#[test]
fn arguments_that_are_not_unicode() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;

    let sandbox = Sandbox::new();
    let odd = OsStr::from_bytes(b"a\xff");
    let new = OsStr::new;
    sandbox.run([new("render"), odd]).refused(&["no scene"]);
    sandbox.run([odd]).refused(&["a\u{fffd}"]);
    sandbox.run([new("render"), new("cornell"), new("--width"), odd]).refused(&["a\u{fffd}", "UTF-8"]);
    sandbox
        .run([new("render"), new("cornell"), new("-o"), odd])
        .refused(&[".png, .jpg, .exr, .pfm, .hdr or .tif"]);
    assert_eq!(sandbox.names(), [""; 0]);
}
