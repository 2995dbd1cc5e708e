//! Goals, snapshots, memory limits, progress and logs.

use crate::sandbox::Sandbox;
use serde_json::Value;
use std::ops::RangeInclusive;

#[test]
fn time_ends_a_render() {
    let sandbox = Sandbox::new();
    let size = ["--width=16", "--height=12", "--photons=500", "--stats=s.json"];
    let ended = sandbox.run(["render", "cornell", "--quality=paper", "--time=300ms"].iter().chain(&size));
    assert_eq!(ended.code, Some(0));
    ended.said_one_line("wrote cornell.png and s.json: ", &["iterations in ", "; time is up"]);
    let stats = sandbox.json("s.json");
    assert_eq!((&stats["ended_by"], &stats["interrupted"]), (&"time".into(), &false.into()));
    let done = format!("--iterations={}", stats["iterations"]);
    assert_eq!(
        sandbox.run(["render", "cornell", "--quality=paper", "-o", "b.png", &done].iter().chain(&size)).code,
        Some(0)
    );
    assert!(sandbox.bytes("cornell.png") == sandbox.bytes("b.png"), "not the image of {done}");
    // The goal that is reached first counts.
    sandbox.run(["render", "cornell", "--quality=paper", "--time=1h", "--iterations=2"].iter().chain(&size));
    assert_eq!(sandbox.json("s.json")["ended_by"], "iterations");
}

#[test]
fn the_first_iteration_is_always_finished() {
    let sandbox = Sandbox::new();
    let args = ["render", "cornell", "--quality=paper", "--time=1ms", "--stats=s.json", "--photons=100000"];
    assert_eq!(sandbox.run(args).code, Some(0));
    assert!(sandbox.json("s.json")["iterations"].as_u64() >= Some(1));
}

/// The goal ends the render at the first iteration whose estimate reaches it, and the estimate is the error against a
/// converged image.
#[test]
fn an_error_goal_is_reached_when_the_estimate_and_the_truth_say_so() {
    /// Of the error over its estimate. The estimate is a statistic over 768 pixels; it leaves out part of the bias.
    const NEAR: RangeInclusive<f64> = 0.85..=1.2;
    let sandbox = Sandbox::new();
    let size = ["--width=32", "--height=24"];
    let render = [
        "render",
        "cornell",
        "--quality=paper",
        "--photons=2000",
        "--until-error=0.1",
        "-o=a.exr",
        "--progress=json",
    ];
    let ended = sandbox.run(render.iter().chain(&size));
    assert_eq!(ended.code, Some(0), "{ended:?}");
    let estimates: Vec<Option<f64>> = ended
        .stdout
        .lines()
        .map(|line| serde_json::from_str::<Value>(line).unwrap()["estimated_error"].as_f64())
        .collect();
    let (last, before) = estimates.split_last().unwrap();
    assert!(before.iter().all(|estimate| estimate.is_none_or(|error| error > 0.1)), "{before:?}");
    let estimate = last.unwrap();
    assert!(estimate <= 0.1, "{estimate}");

    let truth = [
        "render",
        "cornell",
        "--quality=paper",
        "-o=truth.exr",
        "--iterations=3000",
        "--engine=path",
        "--depth=5",
    ];
    assert_eq!(sandbox.run(truth.iter().chain(&size)).code, Some(0));
    let compared = sandbox.run(["compare", "a.exr", "truth.exr", "--json"]);
    let compared: Value = serde_json::from_str(&compared.stdout).unwrap();
    let error = compared["relative_mse"]["all"].as_f64().unwrap().sqrt();
    assert!(NEAR.contains(&(error / estimate)), "the error is {error}, estimated as {estimate}");
}

#[test]
fn an_error_goal_ends_a_resumed_render_at_the_same_iteration() {
    let sandbox = Sandbox::new();
    let size = ["--width=32", "--height=24", "--photons=2000", "--until-error=0.1"];
    let ended = sandbox
        .run(["render", "cornell", "--quality=paper", "-o", "a.exr", "--stats=s.json"].iter().chain(&size));
    assert_eq!(ended.code, Some(0), "{ended:?}");
    ended.said_one_line("wrote a.exr and s.json: ", &["the estimated error is "]);
    let stats = sandbox.json("s.json");
    let done = stats["iterations"].as_u64().unwrap();
    assert!(stats["estimated_error"].as_f64().unwrap() <= 0.1 && done > 4, "{stats}");

    // One iteration before the end, the estimate needs the earlier image that the checkpoint holds.
    for first in [done / 2, done - 1] {
        let first = format!("--iterations={first}");
        let saved = ["-o", "b.exr", "--checkpoint=b.sppm", "--every=1"];
        let begun =
            sandbox.run(["render", "cornell", "--quality=paper", &first].iter().chain(&saved).chain(&size));
        assert_eq!(begun.code, Some(0), "{begun:?}");
        let ended = sandbox.run(["resume", "b.sppm", "--iterations=100000", "--threads=1"]);
        assert_eq!(ended.code, Some(0), "{ended:?}");
        assert!(sandbox.bytes("a.exr") == sandbox.bytes("b.exr"), "{first}: {ended:?}");
        for left in ["b.exr", "b.sppm", "b.sppm.1"] {
            let _ = std::fs::remove_file(sandbox.path(left));
        }
    }
}

#[test]
fn snapshots_are_images_of_their_iterations() {
    let sandbox = Sandbox::new();
    sandbox.render(&["cornell", "-o", "a.png", "--snapshots"]);
    assert_eq!(sandbox.names(), ["a-0001.png", "a-0002.png", "a.png"]);
    assert!(sandbox.bytes("a-0002.png") == sandbox.bytes("a.png"));
    let args = [
        "render",
        "cornell",
        "--quality=paper",
        "-o",
        "b.png",
        "--snapshots",
        "--width=8",
        "--height=8",
        "--photons=10",
    ];
    assert_eq!(sandbox.run(args.iter().chain(&["--iterations=5"])).code, Some(0));
    let names = sandbox.names();
    let of_b: Vec<_> = names.iter().filter(|name| name.starts_with('b')).collect();
    assert_eq!(of_b, ["b-0001.png", "b-0002.png", "b-0004.png", "b.png"]);
}

#[test]
fn a_memory_limit_is_kept_or_rejected() {
    let sandbox = Sandbox::new();
    let large = ["render", "cornell", "--quality=paper", "--width=8000", "--height=8000"];
    sandbox.run(large.iter().chain(&["--memory-limit=100M"])).refused(&[
        "--memory-limit",
        "needs up to",
        "100.0 MiB",
    ]);
    sandbox.run(large.iter().chain(&["--memory-limit=lots"])).refused(&["--memory-limit", "500M or 4G"]);
    sandbox.render(&["cornell", "--memory-limit=200M", "--stats=s.json"]);
    let stats = sandbox.json("s.json");
    assert!(stats["bytes_at_most"].as_u64() <= Some(200 << 20));
}

/// The bound that is computed before the start holds for all engines.
#[cfg(target_os = "linux")]
#[test]
fn memory_stays_within_the_bound() {
    let all = [["sppm", "fast"], ["sppm", "reference"], ["path", "fast"], ["path", "reference"]];
    for [method, engine] in all {
        for size in [
            ["--width=300", "--height=200", "--photons=1000"],
            ["--width=64", "--height=64", "--photons=150000"],
        ] {
            let sandbox = Sandbox::new();
            let files =
                ["render", "cornell", "--quality=paper", "-o", "a.exr", "--iterations=3", "--stats=s.json"];
            let args = [&files[..], &["--method", method, "--engine", engine]].concat();
            assert_eq!(sandbox.run(args.iter().chain(&size)).code, Some(0));
            let stats = sandbox.json("s.json");
            let (told, held) =
                (stats["bytes_at_most"].as_u64().unwrap(), stats["peak_bytes"].as_u64().unwrap());
            assert!(held <= told, "{method} {engine} {size:?}: held {held} bytes, told {told}");
        }
    }
}

/// What is told and what is held at most, for a render of cornell.
#[cfg(target_os = "linux")]
fn told_and_held(args: &[&str]) -> [f64; 2] {
    let sandbox = Sandbox::new();
    let files = ["render", "cornell", "--quality=paper", "-o", "a.pfm", "--stats=s.json", "--iterations=2"];
    let ended = sandbox.run(files.iter().chain(args));
    assert_eq!(ended.code, Some(0), "{args:?}: {}", ended.stderr);
    let stats = sandbox.json("s.json");
    ["bytes_at_most", "peak_bytes"].map(|key| stats[key].as_f64().unwrap())
}

/// Each term of the bound by itself: what more threads, pixels or photons are told to take is what they take, or more, but
/// not several times as much. So no term is forgotten or hidden by another that is too large.
#[cfg(target_os = "linux")]
#[test]
fn memory_grows_by_what_is_told() {
    /// What the allocator and the system add or save from run to run, far less than each step.
    const NOISE: f64 = 3e6;
    /// Deposits are bounded as if every photon were deposited at every bounce; threads have room that they may not need.
    const MOST: f64 = 6.0;
    let few = ["--width=128", "--height=128", "--photons=20000", "--threads=1"];
    let many_photons = ["--width=128", "--height=128", "--photons=400000", "--threads=1"];
    for engine in ["fast", "reference"] {
        let told_and_held = |args: &[&str; 4]| told_and_held(&[&args[..], &["--engine", engine]].concat());
        let steps: [(&str, [&str; 4], [&str; 4]); 3] = [
            ("pixels", few, ["--width=700", "--height=700", "--photons=20000", "--threads=1"]),
            ("photons", few, many_photons),
            // So many photons that all threads take part: what a thread does not write takes no memory.
            ("threads", many_photons, ["--width=128", "--height=128", "--photons=400000", "--threads=16"]),
        ];
        for (what, base, args) in steps {
            let ([told, held], [more_told, more_held]) = (told_and_held(&base), told_and_held(&args));
            let (told, held) = (more_told - told, more_held - held);
            assert!(held < told + NOISE, "{engine}, {what}: {held} more bytes held, {told} told");
            assert!(told < MOST * held.max(0.0) + 2.0 * NOISE, "{engine}, {what}: {told} told, {held} held");
        }
    }
}

/// The bound covers reading the scene, whatever its spheres are, and what is read within a limit stays within it.
#[cfg(target_os = "linux")]
#[test]
fn memory_of_many_spheres_stays_within_the_bound() {
    const COUNT: usize = 100_000;
    /// Times what is held. Of lamps, what is found out while they are read is told again with what an engine keeps of them.
    const MOST_TOLD: f64 = 1.8;
    let head = "background = [1, 1, 1]\n[camera]\neye = [0, 0, 9]\ntarget = [0, 0, 0]\nshutter = [0, 1]\n\
        vertical_fov_degrees = 40\n[materials.a]\ntype = \"diffuse\"\nalbedo = [0.5, 0.5, 0.5]\n";
    for rest in [
        "material = \"a\"\n",
        "material = { type = \"dielectric\", albedo = [0.1, 0.2, 0.3], ior = 1.5 }\n",
        "material = \"a\"\nvelocity = [0, 0.1, 0]\n",
        "material = \"a\"\nemission = [1, 2, 3]\n",
    ] {
        let sandbox = Sandbox::new();
        let sphere = |i: usize| {
            let (x, y) = (i % 317, i / 317);
            format!("[[sphere]]\ncenter = [{x}.125, {y}.25, -10.5]\nradius = 0.25\n{rest}")
        };
        let text: String = std::iter::once(head.into()).chain((0..COUNT).map(sphere)).collect();
        std::fs::write(sandbox.path("many.toml"), &text).unwrap();
        // Of the render alone: choosing settings takes memory of its own, which the bound covers too. By one thread: others would
        // have no photons, and take no room for deposits.
        let own = ["--quality=paper", "-n=1", "--photons=10", "--width=8", "--height=8", "--threads=1"];
        let args: Vec<&str> = ["render", "many.toml", "-o=a.pfm"].into_iter().chain(own).collect();
        let chosen =
            sandbox.run(["render", "many.toml", "-o=b.pfm", "-n=1", "--photons=10", "--stats=c.json"]);
        assert_eq!(chosen.code, Some(0), "{chosen:?}");
        let stats = sandbox.json("c.json");
        let (told, held) = (stats["bytes_at_most"].as_u64().unwrap(), stats["peak_bytes"].as_u64().unwrap());
        assert!(held <= told, "{rest}: held {held} bytes with settings chosen, told {told}");
        assert_eq!(sandbox.run(args.iter().chain(&["--stats=s.json"])).code, Some(0));
        let stats = sandbox.json("s.json");
        let (told, held) = (stats["bytes_at_most"].as_u64().unwrap(), stats["peak_bytes"].as_u64().unwrap());
        assert!(held <= told, "{rest}: held {held} bytes, told {told}");
        assert!(told as f64 <= MOST_TOLD * held as f64, "{rest}: held {held} bytes, told {told}");
        // 200 bytes a sphere beyond the text to read it, and about as much again to render it.
        let most = 32 * (1 << 20) + text.len() + 400 * COUNT;
        assert!(held <= most as u64, "{rest}: held {held} bytes");
        let limited = sandbox.run(args.iter().chain(&["--memory-limit=10M"]));
        limited.refused(&["many.toml", "to read, more than the limit of 10.0 MiB"]);
    }
}

#[test]
fn progress_is_a_line_per_iteration() {
    let sandbox = Sandbox::new();
    let ended = sandbox.render(&["cornell", "--progress=json", "--checkpoint=a.sppm", "--every=1"]);
    let lines: Vec<Value> = ended.stdout.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(lines.len(), 2);
    for (i, line) in (1..).zip(&lines) {
        assert_eq!((&line["iteration"], &line["iterations"]), (&i.into(), &2.into()));
        assert_eq!((&line["photons"], &line["saved"]), (&(500 * i).into(), &(i == 1).into()));
        assert!(line["seconds"].as_f64() > Some(0.0) && line["mean_radius"].as_f64() > Some(0.0), "{line}");
    }
}

#[test]
fn a_log_is_json_to_its_last_line() {
    let sandbox = Sandbox::new();
    let ended = sandbox.render(&["cornell", "--log-format=json", "-v"]);
    let lines: Vec<Value> = ended.stderr.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(lines.len(), 3);
    for line in &lines {
        assert!(
            line["timestamp"].is_string() && line["level"].is_string() && line["message"].is_string(),
            "{line}"
        );
    }
    assert_eq!(lines[2]["iterations"], 2);
    let ended =
        sandbox.run(["render", "cornell", "--quality=paper", "-o", "missing/a.png", "--log-format=json"]);
    assert_eq!(ended.code, Some(2));
    let line: Value = serde_json::from_str(&ended.stderr).unwrap();
    assert_eq!((&line["level"], &line["exit_code"]), (&"ERROR".into(), &2.into()));
    assert!(line["message"].as_str().unwrap().contains("missing/a.png"));
}
