//! Messages as JSON, and what a render says of its noise.

use crate::sandbox::{Ended, Sandbox, TINY};
use serde_json::Value;

/// The lines of JSON on standard error.
fn lines(ended: &Ended) -> Vec<Value> {
    let parse = |line| serde_json::from_str(line).unwrap_or_else(|error| panic!("{error}: {ended:?}"));
    ended.stderr.lines().map(parse).collect()
}

#[test]
fn every_error_is_json_where_that_is_asked_for() {
    let sandbox = Sandbox::new();
    let cases: &[(&[&str], &str)] = &[
        (
            &["render", "cornell", "--quality=paper", "--width", "0", "--log-format", "json"],
            "--width: \"0\" is not",
        ),
        (&["render", "--log-format=json", "cornell", "--widht", "3"], "there is no option --widht"),
        (&["render", "--log-format", "json"], "<SCENE> is missing"),
        (&["resume", "--log-format=json"], "<FILE> is missing"),
        (&["render", "cornel", "--log-format", "json"], "there is no scene \"cornel\""),
        (
            &["render", "a.xyz", "--frame", "2..2", "--log-format", "json"],
            "--frame: `2..2` is not a range of frames",
        ),
        (
            &["render", "cornell", "--quality=paper", "-o", "no/a.png", "--log-format", "json"],
            "--output: no/a.png",
        ),
        (&["resume", "no.sppm", "--log-format", "json"], "no.sppm: there is no such file"),
        (&["merge", "no.sppm", "--missing", "--log-format", "json"], "no.sppm: there is no such file"),
    ];
    for (args, words) in cases {
        let ended = sandbox.run(*args);
        assert_eq!(ended.code, Some(2), "{ended:?}");
        let [line] = &lines(&ended)[..] else { panic!("{ended:?}") };
        assert_eq!((&line["level"], &line["exit_code"]), (&"ERROR".into(), &2.into()), "{line}");
        assert!(line["message"].as_str().unwrap().starts_with(words), "{line}");
    }
    // The farm's words are handed on, and what is missing for that is told by the command itself.
    let mut farm = sandbox.command(["farm", "cornell", "--log-format", "json"]);
    let farm = farm.env("SPPM_PYTHON", "no-such-python").output().unwrap();
    let told: Value = serde_json::from_slice(&farm.stderr).unwrap();
    assert_eq!(told["exit_code"], 2, "{told}");
    // For people, the label stays.
    sandbox
        .run(["render", "cornell", "--quality=paper", "--width", "0", "--log-format", "text"])
        .refused(&["--width: \"0\" is not"]);
}

/// Notes, faults of single frames and the address of a page among them.
#[test]
fn every_line_beside_the_output_is_json_where_that_is_asked_for() {
    let sandbox = Sandbox::new();
    let frame = |second: &str| format!("2\n\nO 0 0 0\nC {second} 0 0\n");
    sandbox.write("run.xyz", &(frame("2") + &frame("north")));
    let told = |args: &[&str]| {
        let ended = sandbox.run(["render"].iter().chain(args).chain(&["--log-format=json"]).chain(&TINY));
        let lines = lines(&ended);
        let line =
            |line: &Value| [&line["level"], &line["message"]].map(|text| text.as_str().unwrap().to_owned());
        lines.iter().map(line).collect::<Vec<_>>()
    };
    let has = |told: &[[String; 2]], level: &str, words: &str| {
        assert!(
            told.iter().any(|[at, text]| at == level && text.starts_with(words)),
            "no {words:?} in {told:?}"
        );
    };
    let frames = told(&["run.xyz", "--frame", "0..2", "--bonds", "file"]);
    has(&frames, "INFO", "note: frame 0: there are no bonds to draw");
    has(&frames, "ERROR", "frame 1: run.xyz:8");
    has(&told(&["run.xyz", "--bonds", "file"]), "INFO", "note: run.xyz: there are no bonds to draw");
    let viewed = told(&["cornell", "--view", "--no-open", "-o", "a.exr", "--progress=json", "-q"]);
    has(&viewed, "WARN", "the page is at http://127.0.0.1:");
}

/// It gets all words, the command's output and its exit code are its own.
#[cfg(unix)]
#[test]
fn the_farm_is_run_by_the_python_that_is_named() {
    use std::os::unix::fs::PermissionsExt as _;
    let sandbox = Sandbox::new();
    // Python has what the farm needs if the program after -c, which asks for it, ends well.
    let python = |probe: u8| {
        sandbox
            .write("python", &format!("#!/bin/sh\n[ \"$1\" = -c ] && exit {probe}\necho \"$@\"\nexit 7\n"));
        let path = sandbox.path("python");
        std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).unwrap();
        let mut farm = sandbox.command(["farm", "cornell", "--parts", "9"]);
        let output = farm.env("SPPM_PYTHON", path).output().unwrap();
        let text = |bytes| String::from_utf8(bytes).unwrap();
        (output.status.code(), text(output.stdout), text(output.stderr))
    };
    assert_eq!(python(0), (Some(7), "-m sppm.farm cornell --parts 9\n".into(), String::new()));
    let (code, printed, said) = python(1);
    assert_eq!((code, printed.as_str()), (Some(2), ""));
    assert!(said.contains("python lacks the package sppm or Dask"), "{said}");
}

#[cfg(unix)]
#[test]
fn an_interruption_is_json_too() {
    use crate::running::{LONG, Running};
    let sandbox = Sandbox::new();
    let running = Running::start(&mut sandbox.command(LONG.iter().chain(&["--log-format=json"])));
    running.send(rustix::process::Signal::TERM);
    let ended = running.end();
    let last = lines(&ended).pop().unwrap();
    assert_eq!((&last["exit_code"], &last["signal"]), (&143.into(), &"SIGTERM".into()), "{last}");
    assert!(last["message"].as_str().unwrap().starts_with("wrote cornell.png after "), "{last}");
}

#[test]
fn a_noisy_image_is_told_with_what_to_do() {
    let sandbox = Sandbox::new();
    let size = ["--width=64", "--height=48", "--photons=2000"];
    let ended = sandbox.run(["render", "cornell", "--quality=paper", "-n=4"].iter().chain(&size));
    ended.said_one_line(
        "wrote cornell.png: 4 iterations in ",
        &["; it is noisy, with an error of about 0.", "`--time "],
    );
    let (_, rest) = ended.stderr.split_once("`--time ").unwrap();
    let (time, _) = rest.split_once('`').unwrap();
    assert!(time.ends_with(['s', 'm', 'h']), "{ended:?}");
    // Sky is not noisy, and an error that was asked for is enough.
    sandbox.write("sky.toml", SKY);
    let smooth = sandbox.run(["render", "sky.toml", "--quality=paper", "-n=4"].iter().chain(&size));
    assert!(smooth.code == Some(0) && !smooth.stderr.contains("noisy"), "{smooth:?}");
    let asked =
        sandbox.run(["render", "cornell", "--quality=paper", "--until-error=0.5"].iter().chain(&size));
    assert!(asked.code == Some(0) && !asked.stderr.contains("noisy"), "{asked:?}");
    // One iteration cannot be compared with another.
    let one = sandbox.render(&["cornell", "-o", "one.png", "--quiet"]);
    assert_eq!(one.stderr, "");
    let args = ["render", "cornell", "--quality=paper", "-n=1"].iter().chain(&TINY[..4]);
    let first = sandbox.run(args);
    first.said_one_line("wrote cornell.png: 1 iteration in ", &["one sample in each pixel", "`-n 16`"]);
    assert!(!first.stderr.contains("noisy"), "{first:?}");
}

/// They are those of the iterations that were made, which may be fewer than were asked for.
#[test]
fn instants_that_are_seen_apart_are_those_that_were_rendered() {
    let args = ["render", "motion", "--quality=paper", "-n=100000", "--photons=500", "--until-error=0.9"];
    let ended = Sandbox::new().run(args.iter().chain(&["--width=256", "--height=192"]));
    ended.said_one_line("wrote motion.png: 2 iterations in ", &["moving spheres show at 2 instants", "`-n "]);
}

/// What is rendered and how at its beginning, and what it took at its end.
#[test]
fn verbose_renders_tell_what_they_take() {
    let sandbox = Sandbox::new();
    let ended = sandbox.render(&["cornell", "--verbose", "--threads=1", "--engine=reference"]);
    let lines: Vec<&str> = ended.stderr.lines().collect();
    let [first, passes, last] = lines[..] else { panic!("{ended:?}") };
    assert!(first.contains("16 x 12 pixels, 2 iterations, 500 photons each"), "{first}");
    assert!(first.contains("method sppm, engine reference, 1 thread; up to "), "{first}");
    assert!(passes.starts_with("camera pass ") && passes.ends_with(" KiB"), "{passes}");
    let others = ["; ", ", grid ", ", photon pass ", ", consolidation ", ", developing and writing "];
    assert!(others.iter().all(|other| passes.contains(other)), "{passes}");
    assert!(last.starts_with("wrote cornell.png: 2 iterations in "), "{last}");
}

/// Nothing but sky.
const SKY: &str = "
background = [1, 1, 1]
camera = { eye = [0, 0, 10], direction = [0, 0, 1], vertical_fov_degrees = 40 }
[[sphere]]
center = [0, 0, 0]
radius = 2
material = { type = \"diffuse\", albedo = [1, 1, 1] }
";

/// A glass ball on a ground that is much wider than what is seen, under a sky and a lamp.
const PLAIN: &str = "
background = [0.5, 0.6, 0.8]
camera = { eye = [0, 2, 12], target = [0, 1, 0], vertical_fov_degrees = 40 }
[materials.grey]
type = \"diffuse\"
albedo = [0.6, 0.6, 0.6]
[[sphere]]
center = [0, -10000, 0]
radius = 10000
material = \"grey\"
[[sphere]]
center = [0, 1, 0]
radius = 1
material = { type = \"dielectric\", albedo = [1, 1, 1], ior = 1.5 }
[[sphere]]
center = [0, 8, 3]
radius = 0.5
material = \"grey\"
emission = [40, 40, 40]
";

#[test]
fn photons_that_miss_what_is_seen_are_told() {
    let sandbox = Sandbox::new();
    sandbox.write("plain.toml", PLAIN);
    // Photons are aimed, but none lands so near.
    let size = ["--width=64", "--height=48", "--photons=10000", "--radius=1e-7"];
    let few = sandbox.run(["render", "plain.toml", "--quality=paper", "-n=4"].iter().chain(&size));
    assert_eq!(few.code, Some(0), "{few:?}");
    assert!(few.stderr.contains("warning: of 40000 photons none counted at what is seen"), "{few:?}");
    // An error goal is not said to be reached for light that is not there.
    let goal =
        sandbox.run(["render", "plain.toml", "--quality=paper", "--until-error=0.5"].iter().chain(&size));
    assert!(goal.stderr.contains(", of direct light alone"), "{goal:?}");
    let enough = sandbox.run(["render", "cornell", "--quality=paper", "-n=4"].iter().chain(&size[..3]));
    assert!(!enough.stderr.contains("counted"), "{enough:?}");
}

/// Whatever the clock says: an iteration takes no longer than the session until then, all of them together no longer than
/// the whole of it, and its passes no longer than it.
#[test]
fn the_seconds_of_iterations_are_their_own() {
    let sandbox = Sandbox::new();
    let words = ["--progress=json", "--threads=1", "--stats=s.json"];
    let ended = sandbox.run(
        [
            "render",
            "cornell",
            "--quality=paper",
            "--width=64",
            "--height=48",
            "--iterations=8",
            "--photons=9000",
        ]
        .iter()
        .chain(&words),
    );
    let parse = |line| serde_json::from_str::<Value>(line).unwrap();
    let steps: Vec<Value> = ended.stdout.lines().map(parse).collect();
    assert_eq!(steps.len(), 8, "{ended:?}");
    let number = |step: &Value, key: &str| step[key].as_f64().unwrap();
    let (mut sum, mut last) = (0.0, 0.0);
    for step in &steps {
        let (own, elapsed) = (number(step, "seconds"), number(step, "elapsed_seconds"));
        assert!(own > 0.0 && last + own <= elapsed, "{step} after {last}");
        (sum, last) = (sum + own, elapsed);
    }
    let report = sandbox.json("s.json");
    let wall = number(&report, "wall_seconds");
    let passes = ["camera_seconds", "build_grid_seconds", "photon_seconds", "consolidate_seconds"];
    let passes: f64 = passes.iter().map(|key| number(&report, key)).sum();
    assert!(0.0 < passes && passes <= sum && sum <= wall, "{passes}, {sum}, {report}");
}
