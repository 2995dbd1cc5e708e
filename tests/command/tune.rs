//! The command `tune`, and profiles. Here a shell script replaces the optimiser; `tuner/tests` uses the real one.

use crate::sandbox::{Ended, Sandbox, TINY};
use serde_json::{Value, json};
use std::fs;
use std::os::unix::fs::PermissionsExt;

/// Options with which the search space has the dimensions that [`stub`] expects.
const SMALL: [&str; 8] =
    ["--lanes", "emulated", "--threads", "1", "--evaluations", "3", "--python", "./optimiser"];

/// Writes a script to replace Python. It proposes three points, runs `on_ask` at each request for one, and ranks the
/// last one best.
fn stub(sandbox: &Sandbox, on_ask: &str) {
    stub_that(sandbox, "", on_ask);
}

/// The same, which also runs `on_line` at each line that it gets after the first, `$setup`.
fn stub_that(sandbox: &Sandbox, on_line: &str, on_ask: &str) {
    let script = format!(
        r#"#!/bin/sh
read setup
echo '{{"optimiser": "stub 1.0"}}'
asked=0
while read line; do
    {on_line}
    case $line in
    *ask*)
        asked=$((asked + 1))
        {on_ask}
        case $asked in
        1) echo '{{"point": [5.0, 8.0, 0, 2.0, 19, 8, 8, "in_turn"]}}' ;;
        2) echo '{{"point": [2.75, 1.0, -3, 0.5, 15, 6, 6, "tree"]}}' ;;
        *) echo '{{"point": [7.333333, 9.0, 2, 8.0, 21, 7, 8, "clusters"]}}' ;;
        esac ;;
    *tell*) echo '{{"told": 1}}' ;;
    *)
        order=
        while [ $asked -gt 0 ]; do
            asked=$((asked - 1))
            order="$order$asked, "
        done
        echo '{{"order": ['"${{order%, }}"'], "noise": 0.01, "length_scales": {{"cell_size": 0.5}}}}' ;;
    esac
done
"#
    );
    sandbox.write("optimiser", &script);
    fs::set_permissions(sandbox.path("optimiser"), fs::Permissions::from_mode(0o755)).unwrap();
}

fn tune(sandbox: &Sandbox, args: &[&str]) -> Ended {
    sandbox.run(["tune", "cornell", "--final-pairs", "6"].iter().chain(&SMALL).chain(args).chain(&TINY))
}

#[test]
fn a_search_leaves_a_profile_that_renders_load() {
    let sandbox = Sandbox::new();
    stub(&sandbox, "");
    let ended = tune(&sandbox, &["--csv", "tried.csv", "--plot", "search.svg"]);
    assert_eq!((ended.code, &ended.stderr[..]), (Some(0), ""), "{ended:?}");
    let words = [
        "cornell, 1 thread: 3 points tried, each in 3 pairs",
        "noise 1.0 %",
        "of the defaults' time",
        "6 pairs",
    ];
    for word in words.into_iter().chain(["wrote cornell.profile.toml"]) {
        assert!(ended.stdout.contains(word), "no {word:?} in {ended:?}");
    }
    assert_eq!(sandbox.names(), ["cornell.profile.toml", "optimiser", "search.svg", "tried.csv"]);

    let profile: toml::Table =
        String::from_utf8(sandbox.bytes("cornell.profile.toml")).unwrap().parse().unwrap();
    let text = String::from_utf8(sandbox.bytes("cornell.profile.toml")).unwrap();
    let head = "# Free parameters of the fast engine for cornell, by `sppm tune`. The image does not depend on them.\n\
                # sppm render SCENE --profile cornell.profile.toml\n\n[parameters]\n";
    assert!(text.starts_with(head), "{text}");
    let (tuned, search) = (&profile["tuned"], &profile["search"]);
    assert_eq!(
        [&tuned["threads"], &search["seed"], &search["pairs"]].map(toml::Value::as_integer),
        [1, 1, 3].map(Some)
    );
    assert_eq!(tuned["scene"].as_str(), Some("cornell"));
    // The settings that were timed, not those of the scene.
    let settings =
        ["width", "height", "photons_per_iteration", "iterations"].map(|name| tuned[name].as_integer());
    assert_eq!(settings, [16, 12, 500, 2].map(Some));
    assert_eq!(tuned["is_confirmed"].as_bool(), Some(true));
    assert_eq!(tuned["best_pairs"].as_integer(), Some(6));
    assert_eq!(search["optimiser"].as_str(), Some("stub 1.0"));
    assert_eq!(search["ratios"].as_array().map(Vec::len), Some(3));
    // Depending on the measured times, the profile holds either the best point or the defaults.
    let cell_size = profile["parameters"]["cell_size"].as_float().unwrap();
    assert_eq!(tuned["is_gain"].as_bool(), Some(cell_size != 5.0), "{profile}");

    let tried = String::from_utf8(sandbox.bytes("tried.csv")).unwrap();
    let lines: Vec<&str> = tried.lines().collect();
    assert_eq!(lines.len(), 1 + 3 + 1, "{tried}");
    assert!(lines[0].starts_with("evaluation,ratio,least,most,pairs,lanes,cell_size,neighbours_at_first"));
    assert!(lines[2].ends_with(",3,emulated,2.75,1,0.125,0.5,32768,64,64,1024,1024,3,3"), "{tried}");
    assert!(lines[3].ends_with(",3,emulated,7.33,9,4,8,2097152,128,256,1024,1024,3,1024"), "{tried}");
    let svg = String::from_utf8(sandbox.bytes("search.svg")).unwrap();
    assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"));
    // Every point and one in the legend, and the best.
    assert_eq!([3, 5].map(|size| svg.matches(&format!(" r=\"{size}\"")).count()), [3 + 1, 1], "{svg}");
    for words in [
        "cornell: time over the defaults",
        "\na point\n",
        "\nthe least so far\n",
        "\nthe best, 95 % interval\n",
    ] {
        assert!(svg.contains(words), "no {words:?} in {svg}");
    }

    for args in [&["-o", "usual.pfm"][..], &["-o", "tuned.pfm", "--profile", "cornell.profile.toml"]] {
        sandbox.render(&[&["cornell"], args].concat());
    }
    assert_eq!(sandbox.bytes("usual.pfm"), sandbox.bytes("tuned.pfm"));
}

/// The space with the defaults to start from, and each point with the logarithm of its ratio.
#[test]
fn the_optimiser_learns_what_is_searched_and_what_was_measured() {
    let sandbox = Sandbox::new();
    stub_that(&sandbox, "echo \"$line\" >> lines", "echo \"$setup\" > setup");
    let ended = tune(&sandbox, &["--search-seed", "7", "--csv", "tried.csv"]);
    assert_eq!((ended.code, &ended.stderr[..]), (Some(0), ""), "{ended:?}");
    let setup = sandbox.json("setup");
    assert_eq!((&setup["seed"], &setup["initial"]), (&json!(7), &json!(2)), "{setup}");
    assert_eq!(setup["start"], json!([5.0, 8.0, 0, 2.0, 19, 8, 8, "in_turn"]));
    let dimensions = setup["dimensions"].as_array().unwrap();
    assert_eq!(dimensions[0], json!({ "name": "cell_size", "kind": "real", "least": 2.0, "most": 12.0 }));
    assert_eq!(dimensions[4], json!({ "name": "occupancy_bits", "kind": "whole", "least": 15, "most": 21 }));
    let choices = ["in_turn", "clusters", "tree"];
    assert_eq!(dimensions[7..], [json!({ "name": "search", "kind": "choice", "choices": choices })]);
    let text = |name| String::from_utf8(sandbox.bytes(name)).unwrap();
    let (lines, tried) = (text("lines"), text("tried.csv"));
    let lines: Vec<Value> = lines.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let told: Vec<&Value> = lines.iter().filter(|line| !line["tell"].is_null()).collect();
    assert_eq!((lines.len(), told.len()), (3 + 3 + 1, 3), "{lines:?}");
    assert_eq!(told[0]["tell"], setup["start"]);
    assert_eq!(told[1]["tell"], json!([2.75, 1.0, -3, 0.5, 15, 6, 6, "tree"]));
    for (told, line) in told.into_iter().zip(tried.lines().skip(1)) {
        let ratio: f64 = line.split(',').nth(1).unwrap().parse().unwrap();
        assert!((told["value"].as_f64().unwrap() - ratio.ln()).abs() < 1e-3, "{told} and {line}");
    }
}

/// The point that is being tried then is the last one, and the best is measured anew all the same.
#[test]
fn a_search_ends_when_its_time_is_up() {
    let sandbox = Sandbox::new();
    stub(&sandbox, "sleep 0.3");
    let ended = tune(&sandbox, &["--time", "100ms"]);
    assert_eq!((ended.code, &ended.stderr[..]), (Some(0), ""), "{ended:?}");
    for words in ["1 point tried", "6 pairs"] {
        assert!(ended.stdout.contains(words), "no {words:?} in {ended:?}");
    }
}

#[test]
fn a_profile_changes_no_bit() {
    let sandbox = Sandbox::new();
    let odd_text = "[parameters]\ncell_size = 3.6\nbuckets_per_photon = 4\noccupancy_cell_size = 7\noccupancy_bits = 32768\n\
               pixels_per_batch = 64\nphotons_per_batch = 128\npixels_per_job = 256\nphotons_per_job = 512\n\
               most_balls_in_turn = 0\nmost_balls_in_clusters = 0\nlanes = \"emulated\"\n";
    sandbox.write("odd.toml", odd_text);
    for scene in ["cornell", "random"] {
        sandbox.render(&[scene, "-o", "usual.pfm", "--stats", "usual.json"]);
        sandbox.render(&[scene, "-o", "odd.pfm", "--stats", "odd.json", "--profile", "odd.toml"]);
        assert_eq!(sandbox.bytes("usual.pfm"), sandbox.bytes("odd.pfm"));
        // The profile did take effect.
        let (usual, odd) = (sandbox.json("usual.json"), sandbox.json("odd.json"));
        assert_eq!(odd["lanes"], "emulated");
        assert_ne!(usual["candidates"], odd["candidates"]);
        assert_eq!(usual["contributions"], odd["contributions"]);
        // What the command line says goes before the profile.
        sandbox.write("auto.toml", &odd_text.replace("emulated", "auto"));
        let both = ["--profile", "auto.toml", "--lanes", "emulated", "--stats", "both.json"];
        sandbox.render(&[&[scene, "-o", "odd.pfm"], &both[..]].concat());
        let both = sandbox.json("both.json");
        assert_eq!((&both["lanes"], &both["candidates"]), (&odd["lanes"], &odd["candidates"]));
        let ended = sandbox.run(["verify", scene, "--profile", "odd.toml"].iter().chain(&TINY));
        assert!(ended.code == Some(0) && ended.stdout.contains("identical"), "{ended:?}");
    }
    sandbox.render(&["cornell", "-o", "a.pfm", "--checkpoint", "a.sppm"]);
    let ended = sandbox.run(["resume", "a.sppm", "--iterations", "3", "--profile", "odd.toml"]);
    assert_eq!(ended.code, Some(0), "{ended:?}");
    let three = ["--width", "16", "--height", "12", "--photons", "500", "-n", "3"];
    let ended = sandbox.run(["render", "cornell", "--quality=paper", "-o", "b.pfm"].iter().chain(&three));
    assert_eq!(ended.code, Some(0), "{ended:?}");
    assert_eq!(sandbox.bytes("a.pfm"), sandbox.bytes("b.pfm"));
    sandbox.render(&["cornell", "-o", "c.pfm", "--checkpoint", "c.sppm"]);
    let over = sandbox.run(["resume", "c.sppm", "--iterations=3", "--profile=odd.toml", "--stats=odd.toml"]);
    over.refused(&["--stats: odd.toml is also --profile"]);
}

#[test]
fn wrong_profiles_are_refused() {
    let sandbox = Sandbox::new();
    sandbox.write("far.toml", "# mine\n[parameters]\ncell_size = 50\n");
    sandbox.write("other.toml", "[parameters]\nlanes = \"emulated\"\n");
    let cases: [(&[&str], &[&str]); 5] = [
        (&["--profile", "far.toml"], &["--profile: far.toml:3:13: cell_size 50", "from 2 to 12"]),
        (&["--profile", "none.toml"], &["--profile: none.toml: there is no such file"]),
        (&["--profile", "."], &["--profile: .: this is a directory; a profile is a file"]),
        (
            &["--profile", "other.toml", "--engine", "reference"],
            &["--engine reference has no free parameters"],
        ),
        (
            &["--profile", "other.toml", "-o", "other.toml.png", "--stats", "other.toml"],
            &["--stats", "is also --profile"],
        ),
    ];
    for (args, words) in cases {
        sandbox.run(["render", "cornell", "--quality=paper"].iter().chain(args).chain(&TINY)).refused(words);
    }
    sandbox.run(["verify", "cornell", "--profile", "far.toml"]).refused(&["far.toml:3:13"]);
    assert_eq!(sandbox.names(), ["far.toml", "other.toml"]);
}

#[test]
fn wrong_searches_are_refused() {
    let sandbox = Sandbox::new();
    let cases: [(&[&str], &[&str]); 6] = [
        (&["--evaluations", "1"], &["--evaluations", "from 2 to 10000"]),
        (&["--final-pairs", "5"], &["--final-pairs", "from 6 to 1000"]),
        (&["--plot", "search.png"], &["--plot: search.png must end in .svg"]),
        (&["-o", "missing/a.toml"], &["--output", "missing"]),
        (&["-o", "a.toml", "--csv", "a.toml"], &["--csv", "is also --output"]),
        (&["--width", "0"], &["--width"]),
    ];
    for (args, words) in cases {
        sandbox.run(["tune", "cornell"].iter().chain(args)).refused(words);
    }
    sandbox.run(["tune", "kornell"]).refused(&["did you mean cornell?"]);
    assert_eq!(sandbox.names(), [""; 0]);
}

#[test]
fn a_failing_optimiser_is_reported() {
    let sandbox = Sandbox::new();
    let cases = [
        ("echo nothing of the kind", "did not answer as the optimiser does"),
        ("echo '{\"missing\": \"No module named skopt\"}'", "has no scikit-optimize (No module named skopt)"),
        ("echo '{\"point\": [9]}'", "the optimiser proposed what cannot be: 1 coordinates"),
        ("echo '{\"point\": [90, 8.0, 0, 2.0, 19, 8, 8, \"tree\"]}'", "cannot be: cell_size 90"),
        ("echo it went wrong >&2; exit 1", "the optimiser ended: it went wrong"),
    ];
    for (on_ask, words) in cases {
        stub(&sandbox, on_ask);
        let ended = tune(&sandbox, &[]);
        assert_eq!(ended.code, Some(1), "{ended:?}");
        ended.said_one_line("error: ", &[words]);
    }
    let args = ["tune", "cornell", "--python", "/nowhere/python"];
    let ended = sandbox.run(args);
    assert_eq!(ended.code, Some(1), "{ended:?}");
    ended.said_one_line("error: --python: /nowhere/python: cannot be run", &[]);
    assert_eq!(sandbox.names(), ["optimiser"]);
}

/// Too few, and one that there is not.
#[test]
fn an_order_of_other_points_is_refused() {
    let sandbox = Sandbox::new();
    for order in ["[0, 1]", "[0, 1, 3]"] {
        let answer = format!("{{\"order\": {order}, \"noise\": null, \"length_scales\": {{}}}}");
        stub_that(&sandbox, &format!("case $line in *conclude*) echo '{answer}' ;; esac"), "");
        let ended = tune(&sandbox, &[]);
        assert_eq!(ended.code, Some(1), "{ended:?}");
        let words = "did not answer as the optimiser does: an order of points that were never tried";
        ended.said_one_line("error: --python: ./optimiser: ", &[words]);
    }
    assert_eq!(sandbox.names(), ["optimiser"]);
}

#[test]
fn an_interruption_keeps_the_best_so_far() {
    let sandbox = Sandbox::new();
    stub(&sandbox, "if [ $asked = 3 ]; then kill -INT $PPID; fi");
    let ended = tune(&sandbox, &["--csv", "tried.csv"]);
    assert_eq!(ended.code, Some(130), "{ended:?}");
    assert!(ended.stdout.contains("the best so far takes"), "{ended:?}");
    assert!(ended.stderr.contains("interrupted: cornell.profile.toml holds the best so far"), "{ended:?}");
    let profile: toml::Table =
        String::from_utf8(sandbox.bytes("cornell.profile.toml")).unwrap().parse().unwrap();
    assert_eq!(profile["tuned"]["is_confirmed"].as_bool(), Some(false));
    let ratios =
        profile["search"]["ratios"].as_array().unwrap().iter().map(|ratio| ratio.as_float().unwrap());
    assert_eq!(profile["tuned"]["best_ratio"].as_float(), ratios.min_by(f64::total_cmp));
    // The signal may arrive late during the third point, but not after it.
    let tried = String::from_utf8(sandbox.bytes("tried.csv")).unwrap();
    assert!((3..=4).contains(&tried.lines().count()), "{tried}");
    sandbox.render(&["cornell", "--profile", "cornell.profile.toml"]);
}

#[test]
fn an_interruption_before_anything_was_tried_writes_nothing() {
    let sandbox = Sandbox::new();
    stub(&sandbox, "kill -INT $PPID; sleep 0.2");
    let ended = tune(&sandbox, &[]);
    assert_eq!(ended.code, Some(130), "{ended:?}");
    ended.said_one_line("interrupted: ", &["nothing has been tried"]);
    assert_eq!(sandbox.names(), ["optimiser"]);
}
