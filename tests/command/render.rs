//! The command `render` with valid input.

use crate::sandbox::{Sandbox, TINY};
use files::image_file::{self, Encoding, Tone};
use scene::settings::BYTES_PER_PIXEL;
use scene::{Engine, Settings};
use std::fs;

#[test]
fn the_image_is_named_after_the_scene() {
    let sandbox = Sandbox::new();
    let ended = sandbox.render(&["cornell"]);
    ended.said_one_line("wrote cornell.png: 2 iterations in ", &[" s"]);
    assert_eq!(sandbox.names(), ["cornell.png"]);
}

#[test]
fn every_size_renders() {
    let sandbox = Sandbox::new();
    for (width, height) in [(48, 27), (36, 30), (1, 1), (7, 3), (1, 1000)] {
        let size = [width.to_string(), height.to_string()];
        let args =
            ["render", "cornell", "--quality=paper", "-o", "a.exr", "--iterations", "1", "--photons", "300"];
        let ended = sandbox.run(args.into_iter().chain(["--width", &size[0], "--height", &size[1]]));
        assert_eq!(ended.code, Some(0), "{ended:?}");
        let film = sandbox.image("a.exr");
        assert_eq!((film.width, film.height), (width, height));
        assert!(film.pixels.iter().all(|p| p.is_finite() && p.min_element() >= 0.0));
    }
}

#[test]
fn every_scene_renders_to_something() {
    let sandbox = Sandbox::new();
    for builtin in files::builtin::SCENES {
        sandbox.render(&[builtin.name, "-o", "a.exr"]);
        let film = sandbox.image("a.exr");
        assert!(film.pixels.iter().any(|p| p.max_element() > 0.0), "{} is black", builtin.name);
    }
}

#[test]
fn same_seed_same_bytes_whatever_the_threads() {
    let sandbox = Sandbox::new();
    for engine in ["--engine=fast", "--engine=reference", "--method=path", "--engine=path"] {
        let render = |out, threads, seed| {
            sandbox.render(&["cornell", engine, "-o", out, "--threads", threads, "--seed", seed]);
            sandbox.bytes(out)
        };
        let first = render("a.exr", "1", "7");
        assert_eq!(first, render("b.exr", "3", "7"), "{engine}");
        assert_ne!(first, render("c.exr", "1", "8"), "{engine}");
    }
}

#[test]
fn fast_is_the_default_and_equals_the_reference_on_all_lanes() {
    let sandbox = Sandbox::new();
    let render = |args: &[&str]| {
        sandbox.render(&[&["cornell", "-o", "a.exr", "--stats", "s.json"], args].concat());
        let stats = sandbox.json("s.json");
        // Compare pixels rather than bytes, because the file's metadata names the engine.
        (sandbox.image("a.exr"), stats["engine"].clone(), stats["lanes"].clone())
    };
    let (expected, engine, lanes) = render(&["--engine", "reference"]);
    assert_eq!((&engine, &lanes), (&"reference".into(), &serde_json::Value::Null));
    let (default, engine, best) = render(&[]);
    assert!(default == expected && engine == "fast");
    let (auto, _, lanes) = render(&["--lanes", "auto"]);
    assert!(auto == expected && lanes == best);
    for kind in fast::LaneKind::ALL.into_iter().filter(|kind| kind.is_available()) {
        let name = format!("{kind:?}").to_lowercase();
        let (image, _, lanes) = render(&["--engine", "fast", "--lanes", &name]);
        assert!(image == expected && lanes == name, "{name}");
    }
}

#[test]
fn the_path_tracers_are_equal_on_all_lanes_and_keep_their_old_name() {
    let sandbox = Sandbox::new();
    let render = |args: &[&str]| {
        sandbox.render(&[&["cornell", "-o", "a.exr", "--stats", "s.json"], args].concat());
        let stats = sandbox.json("s.json");
        let info = sandbox.run(["info", "a.exr"]).stdout;
        assert_eq!(stats["method"], "path");
        let engine = stats["engine"].as_str().unwrap();
        assert!(
            info.contains("method     path\n") && info.contains(&format!("engine     {engine}")),
            "{info}"
        );
        (sandbox.image("a.exr"), engine.to_owned(), sandbox.bytes("a.exr"))
    };
    let (expected, engine, _) = render(&["--method", "path", "--engine", "reference"]);
    assert_eq!(engine, "reference");
    let (image, engine, bytes) = render(&["--method", "path"]);
    assert!(image == expected && engine == "fast");
    let (_, _, old) = render(&["--engine", "path"]);
    assert!(old == bytes, "the old name makes another file");
    for kind in fast::LaneKind::ALL.into_iter().filter(|kind| kind.is_available()) {
        let lanes = format!("{kind:?}").to_lowercase();
        let (image, _, _) = render(&["--method", "path", "--lanes", &lanes]);
        assert!(image == expected, "{lanes}");
    }
}

#[test]
fn an_old_file_is_replaced_and_nothing_else_is_left() {
    let sandbox = Sandbox::new();
    sandbox.write("a.png", "old");
    sandbox.write("s.json", "old");
    sandbox.render(&["cornell", "-o", "a.png", "--stats", "s.json"]);
    assert_eq!(sandbox.image("a.png").pixels.len(), 16 * 12);
    assert!(sandbox.json("s.json").is_object());
    assert_eq!(sandbox.names(), ["a.png", "s.json"]);
}

/// The same radiance by every curve: as by the library, and with the metadata alone in between.
#[test]
fn tone_curves_apply_to_png_and_jpg_alone() {
    let sandbox = Sandbox::new();
    sandbox.render(&["cornell", "-o", "a.pfm"]);
    let radiance = sandbox.image("a.pfm");
    let white = ["--tone=reinhard", "--white=2.5"];
    let cases: [(&[&str], Tone); 6] = [
        (&[], Tone::Agx),
        (&["--tone=agx"], Tone::Agx),
        (&["--tone=aces"], Tone::Aces),
        (&["--tone=clamp"], Tone::Clamp),
        (&["--tone=reinhard"], Tone::Reinhard { white: 4.0 }),
        (&white, Tone::Reinhard { white: 2.5 }),
    ];
    for (options, tone) in cases {
        for name in ["b.png", "b.jpg"] {
            sandbox.render(&[&["cornell", "-o", name, "--seed=1"], options].concat());
            let encoding = Encoding { tone, seed: 1, ..Encoding::default() };
            image_file::write(&sandbox.path(&format!("c-{name}")), &radiance, &encoding).unwrap();
            assert_eq!(sandbox.image(name), sandbox.image(&format!("c-{name}")), "{name} {tone}");
        }
        let info = sandbox.run(["info", "b.png"]).stdout;
        assert!(info.contains(&format!("tone       {tone}\n")), "{info}");
        // Repeated, whatever the usual one.
        assert_eq!(sandbox.run(["render", "--like", "b.png", "-q", "-o", "d.png"]).code, Some(0));
        assert!(sandbox.bytes("b.png") == sandbox.bytes("d.png"), "{tone}");
    }
    // The last one had a white; a linear image has no curve, and another curve no white.
    sandbox.run(["render", "--like", "b.png", "-q", "-o", "e.pfm"]);
    assert!(sandbox.bytes("e.pfm") == sandbox.bytes("a.pfm"));
    sandbox.run(["render", "--like", "b.png", "-q", "-o", "e.png", "--white=4"]);
    sandbox.render(&["cornell", "-o", "f.png", "--tone=reinhard"]);
    assert!(sandbox.bytes("e.png") == sandbox.bytes("f.png"));
    for (options, words) in [
        (
            &["-o", "a.exr", "--tone=agx"][..],
            &["--tone: a.exr holds linear radiance", "only .png and .jpg"][..],
        ),
        (
            &["-o", "a.png", "--white=2"],
            &["--white: only the curve reinhard", "--tone reinhard", "--exposure"],
        ),
        (&["-o", "a.png", "--tone=aces", "--white=2"], &["--white: only the curve reinhard"]),
        (&["-o", "a.png", "--tone=reinhard", "--white=0"], &["--white: \"0\""]),
        (&["-o", "a.png", "--tone=filmic"], &["--tone: \"filmic\"", "clamp, reinhard, aces and agx"]),
    ] {
        sandbox
            .run(["render", "cornell", "--quality=paper"].iter().chain(options).chain(&TINY))
            .refused(words);
    }
}

#[test]
fn dithering_follows_the_seed_alone() {
    let sandbox = Sandbox::new();
    let options: [&[&str]; 4] =
        [&["--threads=1"], &["--threads=3"], &["--engine=reference"], &["--lanes=emulated"]];
    let codes = |options: &[&str]| {
        sandbox.render(&[&["mirror", "-o", "a.png"], options].concat());
        sandbox.image("a.png")
    };
    let first = codes(options[0]);
    assert!(options.iter().all(|options| codes(options) == first));
}

#[test]
fn exposure_makes_a_png_brighter() {
    let sandbox = Sandbox::new();
    let sum = |name: &str| sandbox.image(name).pixels.iter().map(|p| p.element_sum()).sum::<f32>();
    sandbox.render(&["cornell", "-o", "dark.png", "--exposure", "-3"]);
    sandbox.render(&["cornell", "-o", "plain.png"]);
    sandbox.render(&["cornell", "-o", "zero.png", "--exposure", "0"]);
    assert_eq!(sandbox.bytes("plain.png"), sandbox.bytes("zero.png"));
    assert!(sum("dark.png") < 0.5 * sum("plain.png"));
}

#[test]
fn radius_and_count_images_hold_what_they_say() {
    let sandbox = Sandbox::new();
    let out =
        ["cornell", "-o", "a.exr", "--radius-image", "r.exr", "--count-image", "n.pfm", "--radius", "30"];
    let ended = sandbox.render(&out);
    ended.said_one_line("wrote a.exr, r.exr and n.pfm: ", &[]);
    let (radius, count) = (sandbox.image("r.exr"), sandbox.image("n.pfm"));
    assert!(radius.pixels.iter().all(|p| p.x > 0.0 && p.x <= 30.0));
    assert!(count.pixels.iter().any(|p| p.x > 0.0), "no photon counted");
    for (radius, count) in radius.pixels.iter().zip(&count.pixels) {
        // A radius shrinks only where photons were counted.
        assert!(radius.x == 30.0 || count.x > 0.0);
    }
    // What the reference says of the same render, of which all bits are kept.
    let scene = files::builtin::scene("cornell").unwrap();
    let tiny =
        Settings { width: 16, height: 12, iterations: 2, photons_per_iteration: 500, ..scene.settings };
    let mut engine = reference::Sppm::new(&scene, &Settings { initial_radius: 30.0, ..tiny });
    (0..2).for_each(|_| engine.iterate());
    assert!(radius == engine.radius().unwrap().to_film() && count == engine.count().unwrap().to_film());
    assert!(sandbox.image("a.exr") == engine.develop());
}

#[test]
fn quiet_says_nothing_and_verbose_says_more() {
    let sandbox = Sandbox::new();
    let quiet = sandbox.render(&["cornell", "-q"]);
    assert_eq!((quiet.stdout.as_str(), quiet.stderr.as_str()), ("", ""));
    let verbose = sandbox.render(&["cornell", "-v", "--threads", "2"]);
    assert_eq!(verbose.stdout, "");
    let lines: Vec<&str> = verbose.stderr.lines().collect();
    assert_eq!(lines.len(), 3, "{lines:?}");
    for words in [
        "16 x 12 pixels",
        "2 iterations",
        "500 photons each",
        "method sppm, engine fast on ",
        " lanes, 2 threads",
    ] {
        assert!(lines[0].contains(words), "no {words:?} in {lines:?}");
    }
    assert!(lines[1].contains("photon pass") && lines[1].ends_with(" MiB"), "{lines:?}");
    assert!(lines[2].starts_with("wrote cornell.png"), "{lines:?}");
}

#[test]
fn stats_tell_what_was_asked_for_and_done() {
    let sandbox = Sandbox::new();
    sandbox.render(&[
        "cornell",
        "--stats",
        "s.json",
        "--depth",
        "4",
        "--seed",
        "4294967305",
        "--threads",
        "2",
    ]);
    let stats = sandbox.json("s.json");
    assert_eq!(stats["version"], env!("CARGO_PKG_VERSION"));
    assert_eq!((&stats["engine"], &stats["threads"]), (&"fast".into(), &2.into()));
    assert!(["avx512", "avx2", "emulated"].contains(&stats["lanes"].as_str().unwrap()), "{stats}");
    assert_eq!((&stats["iterations"], &stats["interrupted"]), (&2.into(), &false.into()));
    let settings = &stats["settings"];
    for (key, value) in [
        ("width", 16_i64),
        ("height", 12),
        ("iterations", 2),
        ("photons_per_iteration", 500),
        ("max_depth", 4),
        // Of more than 32 bits.
        ("seed", (1 << 32) + 9),
    ] {
        assert_eq!(settings[key], value, "{key}");
    }
    let own = files::builtin::find("cornell").unwrap().scene().settings;
    assert_eq!(settings["initial_radius"], f64::from(own.initial_radius));

    let count = |key: &str| stats[key].as_u64().unwrap_or_else(|| panic!("{key}: {stats}"));
    assert_eq!(count("photons"), 2 * 500);
    assert!((2 * 16 * 12..=2 * 16 * 12 * 4).contains(&count("camera_segments")));
    assert!(count("visible_points") <= 2 * 16 * 12);
    assert!(count("photon_segments") <= 2 * 500 * 4);
    assert!(count("deposits") <= count("photon_segments"));
    assert!(count("contributions") <= count("candidates"));

    let seconds = |key: &str| stats[key].as_f64().unwrap_or_else(|| panic!("{key}: {stats}"));
    let passes = ["camera", "build_grid", "photon", "consolidate"].map(|p| seconds(&format!("{p}_seconds")));
    assert!(seconds("write_seconds") > 0.0, "{stats}");
    assert!(
        passes.iter().all(|&s| s >= 0.0) && passes.iter().sum::<f64>() <= seconds("wall_seconds"),
        "{stats}"
    );
}

#[test]
fn memory_per_pixel_is_as_stated() {
    let sandbox = Sandbox::new();
    let size = ["--width", "400", "--height", "400", "--iterations", "1", "--photons", "100"];
    assert_eq!(
        sandbox.run(["render", "cornell", "--quality=paper", "--stats", "s.json"].iter().chain(&size)).code,
        Some(0)
    );
    let bytes = sandbox.json("s.json")["bytes"].as_u64().unwrap();
    assert!((1..=400 * 400 * BYTES_PER_PIXEL).contains(&bytes), "{} bytes per pixel", bytes / (400 * 400));
}

#[test]
fn a_scene_in_another_folder_is_rendered_here() {
    let sandbox = Sandbox::new();
    fs::create_dir(sandbox.path("scenes")).unwrap();
    sandbox.write("scenes/box.toml", files::builtin::find("cornell").unwrap().text);
    sandbox.render(&["scenes/box.toml"]);
    assert_eq!(sandbox.names(), ["box.png", "scenes/", "scenes/box.toml"]);
}

/// It names the image, as without, and is not written over.
#[test]
fn a_scene_beside_a_repeated_image_is_an_input() {
    let sandbox = Sandbox::new();
    sandbox.write("mine.toml", files::builtin::find("cornell").unwrap().text);
    sandbox.render(&["mine.toml", "-o", "a.png"]);
    let again = ["render", "mine.toml", "--like", "a.png"];
    sandbox.run(again.iter().chain(&["--stats", "mine.toml"])).refused(&["--stats", "also the scene"]);
    sandbox.run(again.iter().chain(&["--stats", "a.png"])).refused(&["--stats", "also --like"]);
    let ended = sandbox.run(again);
    assert_eq!(ended.code, Some(0), "{ended:?}");
    assert_eq!(sandbox.names(), ["a.png", "mine.png", "mine.toml"]);
    assert!(sandbox.bytes("a.png") == sandbox.bytes("mine.png"));
}

#[cfg(unix)]
#[test]
fn links_to_the_same_file_are_detected() {
    let sandbox = Sandbox::new();
    sandbox.write("a.exr", "old");
    std::os::unix::fs::symlink("a.exr", sandbox.path("b.exr")).unwrap();
    let args = ["render", "cornell", "--quality=paper", "-o", "a.exr", "--radius-image", "b.exr"];
    sandbox.run(args.iter().chain(&TINY)).refused(&["--radius-image", "also --output"]);
    assert_eq!(sandbox.bytes("a.exr"), b"old");
}

/// They change the image of both methods, are told, and have bounds.
#[test]
fn light_samples_are_taken() {
    let sandbox = Sandbox::new();
    for method in ["--method=sppm", "--method=path"] {
        sandbox.render(&["random", method, "-o", "one.exr"]);
        sandbox.render(&["random", method, "-o", "three.exr", "--light-samples=3"]);
        assert!(sandbox.image("one.exr") != sandbox.image("three.exr"), "{method}");
        let [one, three] = ["one.exr", "three.exr"].map(|file| sandbox.run(["info", file]).stdout);
        assert!(!one.contains("samples") && three.contains("light      3 samples"), "{one}{three}");
    }
    for given in ["0", "17", "many"] {
        let ended = sandbox.run(["render", "random", "--light-samples", given, "-o", "x.pfm"]);
        ended.refused(&["--light-samples", given, "from 1 to 16"]);
    }
}
