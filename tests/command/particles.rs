//! Files of particles as scenes: the same picture again, whatever the order of the atoms.

use crate::sandbox::{Ended, Sandbox, TINY};
use std::fmt::Write as _;

/// An XYZ file of these atoms, each an element and a position.
fn xyz(atoms: &[(&str, [f64; 3])]) -> String {
    let mut text = format!("{}\na few atoms\n", atoms.len());
    for (element, [x, y, z]) in atoms {
        writeln!(text, "{element} {x} {y} {z}").unwrap();
    }
    text
}

/// Atoms in a row, in quarters of an angstrom, which are exact.
const ATOMS: [(&str, [f64; 3]); 4] =
    [("O", [0.0, 0.0, 0.0]), ("H", [1.0, 0.0, 0.25]), ("C", [2.5, 0.0, 0.0]), ("N", [3.75, 1.25, 0.5])];

fn with_atoms() -> Sandbox {
    let sandbox = Sandbox::new();
    sandbox.write("atoms.xyz", &xyz(&ATOMS));
    sandbox
}

#[test]
fn a_file_is_a_picture_by_one_command() {
    let sandbox = with_atoms();
    sandbox.render(&["atoms.xyz"]);
    let image = sandbox.image("atoms.png");
    // The background is white, and the atoms are not.
    assert_eq!(image.pixels[0], scene::Rgb::ONE);
    assert!(image.pixels.iter().any(|pixel| pixel.max_element() < 0.9));
}

#[test]
fn neither_the_order_of_atoms_nor_their_distance_from_the_origin_matters() {
    let sandbox = with_atoms();
    let mut turned = ATOMS;
    turned.reverse();
    sandbox.write("turned.xyz", &xyz(&turned));
    sandbox.write("far.xyz", &xyz(&ATOMS.map(|(element, p)| (element, p.map(|x| x + 1e6)))));
    for name in ["atoms", "turned", "far"] {
        sandbox.render(&[&format!("{name}.xyz"), "-o", &format!("{name}.pfm"), "--ground"]);
    }
    assert!(sandbox.bytes("atoms.pfm") == sandbox.bytes("turned.pfm"));
    assert!(sandbox.bytes("atoms.pfm") == sandbox.bytes("far.pfm"));
}

#[test]
fn units_of_length_give_the_same_picture() {
    let sandbox = with_atoms();
    let metres: String = xyz(&ATOMS.map(|(element, p)| (element, p.map(|x| x * 1e-10))));
    sandbox.write("metres.xyz", &metres);
    for name in ["atoms", "metres"] {
        sandbox.render(&[&format!("{name}.xyz"), "-o", &format!("{name}.png")]);
    }
    let [near, small] = ["atoms.png", "metres.png"].map(|name| sandbox.image(name));
    // Other roundings, so other noise: the pictures differ as those of two seeds do.
    let apart = near.pixels.iter().zip(&small.pixels).map(|(a, b)| (*a - *b).abs().element_sum());
    let mean = apart.sum::<f32>() / (3 * near.pixels.len()) as f32;
    assert!(mean < 0.1, "{mean}");
}

#[test]
fn a_picture_is_repeated() {
    let sandbox = with_atoms();
    let style =
        ["--style", "element == \"C\": material=mirror", "--cut", "x < 3", "--view", "iso", "--color", "x"];
    sandbox.render(&[&["atoms.xyz", "-o", "one.png"][..], &style].concat());
    let repeat =
        |args: &[&str]| sandbox.run([&["render", "--like", "one.png", "-o", "two.png"][..], args].concat());
    assert_eq!(repeat(&[]).code, Some(0));
    assert!(sandbox.bytes("one.png") == sandbox.bytes("two.png"));
    // The file may be elsewhere, if it is named.
    std::fs::create_dir(sandbox.path("data")).unwrap();
    std::fs::rename(sandbox.path("atoms.xyz"), sandbox.path("data/atoms.xyz")).unwrap();
    repeat(&[]).refused(&["one.png", "atoms.xyz: there is no such file"]);
    assert_eq!(repeat(&["data/atoms.xyz"]).code, Some(0));
    assert!(sandbox.bytes("one.png") == sandbox.bytes("two.png"));
    repeat(&["data/atoms.xyz", "--zoom", "2"]).refused(&["--zoom", "what --like repeats"]);
    sandbox.write("data/atoms.xyz", &xyz(&ATOMS[1..]));
    repeat(&["data/atoms.xyz"]).refused(&["atoms.xyz has changed", "SHA-256"]);
}

#[test]
fn a_checkpoint_names_the_file_instead_of_its_particles() {
    let sandbox = Sandbox::new();
    let mut atoms = Vec::new();
    for i in 0..4096 {
        atoms.push(("Ar", [i % 16, i / 16 % 16, i / 256].map(|i| f64::from(i) * 4.0)));
    }
    sandbox.write("argon.xyz", &xyz(&atoms));
    sandbox.render(&["argon.xyz", "-o", "argon.exr", "--checkpoint", "c.sppm"]);
    let bytes = sandbox.bytes("c.sppm").len();
    // 192 pixels with 8 words each, and texts; the atoms would take 20 bytes each.
    assert!(bytes < 16_000, "{bytes}");
    let resume = || sandbox.run(["resume", "c.sppm", "-n", "4", "-o", "resumed.pfm"]);
    assert_eq!(resume().code, Some(0));
    let whole = ["render", "argon.xyz", "-o", "whole.pfm", "-n", "4", "--quality", "paper"];
    let ended = sandbox.run(whole.iter().chain(&["--width", "16", "--height", "12", "--photons", "500"]));
    assert_eq!(ended.code, Some(0), "{ended:?}");
    assert!(sandbox.bytes("resumed.pfm") == sandbox.bytes("whole.pfm"));
    sandbox.write("argon.xyz", &xyz(&atoms[1..]));
    resume().refused(&["c.sppm", "argon.xyz has changed"]);
}

#[test]
fn scene_files_name_particles() {
    let sandbox = with_atoms();
    sandbox.render(&[
        "atoms.xyz",
        "-o",
        "one.exr",
        "--style",
        "element == 'O': color=red",
        "--background",
        "grey",
    ]);
    let printed = sandbox.run(["info", "one.exr", "--scene"]);
    assert_eq!(printed.code, Some(0));
    assert!(printed.stdout.contains("[[particles]]\nfile = \"atoms.xyz\"\n"), "{}", printed.stdout);
    sandbox.write("scene.toml", &printed.stdout);
    let ended = sandbox.run(["render", "scene.toml", "-o", "two.exr", "--method", "path"]);
    assert_eq!(ended.code, Some(0), "{ended:?}");
    assert!(sandbox.bytes("one.exr") == sandbox.bytes("two.exr"));
    // Numbers and texts, one selection or several; a room of its own spheres around.
    let text = "[camera]\neye = [1, 0, 40]\ntarget = [1, 0, 0]\nvertical_fov_degrees = 20\n\
        [[sphere]]\ncenter = [0, 30, 0]\nradius = 3\nemission = [9, 9, 9]\nmaterial = { type = \"diffuse\", albedo = [0, 0, 0] }\n\
        [[particles]]\nfile = \"atoms.xyz\"\nframe = 0\ncut = \"x < 3\"\norigin = [1.5, 0, 0]\nstyle = [{ radius = 0.5, color = \"z\" }]\n";
    sandbox.write("room.toml", text);
    sandbox.render(&["room.toml"]);
    for (old, new, words) in [
        ("frame = 0", "frame = 7", &["room.toml:11:8", "atoms.xyz", "frame 7"][..]),
        ("frame = 0", "frames = 0", &["room.toml:12:1", "unknown key \"frames\" in [[particles]]"]),
        ("x < 3", "x < ", &["room.toml:13:7", "cut of [[particles]]: column 5"]),
        ("x < 3", "q < 3", &["room.toml:13:7", "cut: column 1: there is no column `q`"]),
        ("\"z\"", "\"charge\"", &["room.toml:15:34", "color: there is no column `charge`"]),
        ("radius = 0.5", "radius = []", &["room.toml:15:21", "must be a text, a number, true or false"]),
        ("frame = 0", "digest = \"00\"", &["room.toml:12:10", "atoms.xyz has changed"]),
        ("[1.5, 0, 0]", "[1.5, 0]", &["room.toml:14:10", "must be three finite numbers"]),
        ("[1.5, 0, 0]", "[1.5, 0, inf]", &["room.toml:14:19", "must be three finite numbers"]),
        ("atoms.xyz", "other.xyz", &["room.toml:11:8", "other.xyz: there is no such file"]),
    ] {
        sandbox.write("room.toml", &text.replace(old, new));
        sandbox.run(["render", "room.toml"]).refused(words);
    }
}

/// Whichever of them it is: a render reads them all.
#[test]
fn no_output_replaces_a_file_of_particles() {
    let sandbox = with_atoms();
    sandbox.write("points.csv", "x,y,z,radius\n4,0,0,1\n");
    sandbox.write(
        "both.toml",
        "[camera]\neye = [1, 0, 40]\nvertical_fov_degrees = 20\ndirection = [0, 0, -1]\n\
         [[sphere]]\ncenter = [0, 30, 0]\nradius = 3\nemission = [9, 9, 9]\nmaterial = { type = \"diffuse\", albedo = [0, 0, 0] }\n\
         [[particles]]\nfile = \"atoms.xyz\"\n[[particles]]\nfile = \"points.csv\"\n",
    );
    for file in ["atoms.xyz", "points.csv"] {
        let before = sandbox.bytes(file);
        let ended = sandbox.run(["render", "both.toml", "--stats", file].iter().chain(&TINY));
        ended.refused(&["--stats", file, "is also the scene"]);
        assert!(sandbox.bytes(file) == before, "{file}");
    }
    sandbox.render(&["both.toml", "--stats", "stats.json"]);
}

/// What `[stage]` says is what the options say, and it is repeated like everything else of a scene.
#[test]
fn scene_files_have_stages() {
    let sandbox = with_atoms();
    let stage = "[stage]\nview = \"front\"\nzoom = 0.8\nlight = \"studio\"\nground = true\nbackground = \"grey\"\n\
        [[particles]]\nfile = \"atoms.xyz\"\n";
    sandbox.write("atoms.toml", stage);
    let options = ["--view", "front", "--zoom", "0.8", "--ground", "--background", "grey"];
    let exposed = ["--tone", "clamp"];
    sandbox.render(&[&["atoms.xyz", "-o", "options.png"][..], &options, &exposed].concat());
    sandbox.render(&["atoms.toml", "-o", "file.png"]);
    assert!(sandbox.bytes("options.png") == sandbox.bytes("file.png"));
    // The camera is fitted to the image that is asked for, or else to that of the file.
    sandbox.write("wide.toml", &format!("{stage}[settings]\nwidth = 32\nheight = 12\niterations = 2\n"));
    let sized = |file: &str, size: &[&str]| {
        let ended = sandbox.run(["render", file, "-o", "sized.pfm", "-n", "2"].iter().chain(size));
        assert_eq!(ended.code, Some(0), "{ended:?}");
        sandbox.bytes("sized.pfm")
    };
    assert!(sized("wide.toml", &[]) == sized("atoms.toml", &["--width", "32", "--height", "12"]));
    assert!(
        sized("wide.toml", &["--width", "16"]) == sized("atoms.toml", &["--width", "16", "--height", "12"])
    );
    // What was recorded says the same without the stage.
    let repeated = sandbox.run(["render", "--like", "file.png", "-o", "again.png"]);
    assert_eq!(repeated.code, Some(0), "{repeated:?}");
    assert!(sandbox.bytes("file.png") == sandbox.bytes("again.png"));
    sandbox.render(&["atoms.toml", "-o", "one.png", "--checkpoint", "c.sppm"]);
    let resumed = sandbox.run(["resume", "c.sppm", "-n", "4", "-o", "four.png"]);
    assert_eq!(resumed.code, Some(0), "{resumed:?}");
    let four = [
        "render",
        "atoms.toml",
        "--quality=paper",
        "-o",
        "whole.png",
        "-n",
        "4",
        "--width",
        "16",
        "--height",
        "12",
    ];
    assert_eq!(sandbox.run(four.iter().chain(&["--photons", "500"])).code, Some(0));
    assert!(sandbox.bytes("four.png") == sandbox.bytes("whole.png"));
}

/// Own spheres and several files share a stage, and an origin.
#[test]
fn a_stage_is_set_around_everything() {
    let sandbox = with_atoms();
    let far = ATOMS.map(|(element, p)| (element, p.map(|x| x + 1e6)));
    sandbox.write("near.xyz", &xyz(&ATOMS[..2]));
    sandbox.write("far.xyz", &xyz(&far[..2]));
    sandbox.write("rest.xyz", &xyz(&far[2..]));
    let text = "[stage]\nview = \"front\"\n[[sphere]]\ncenter = [0, 0, 9]\nradius = 1\n\
        material = { type = \"specular\", albedo = [1, 1, 1] }\n";
    let file = |name: &str| format!("[[particles]]\nfile = \"{name}.xyz\"\n");
    sandbox.write("two.toml", &format!("{text}{}{}", file("far"), file("rest")));
    sandbox.render(&["two.toml"]);
    let printed = sandbox.run(["info", "two.png", "--scene"]);
    // Both origins are the centre of the first file, in double precision.
    assert_eq!(
        printed.stdout.matches("origin = [1000000.5, 1000000.0, 1000000.125]").count(),
        2,
        "{printed:?}"
    );
    sandbox.write("printed.toml", &printed.stdout);
    sandbox.render(&["printed.toml", "-o", "again.png", "--tone", "clamp"]);
    assert!(sandbox.bytes("two.png") == sandbox.bytes("again.png"));
    for (old, new, words) in [
        (
            "\"front\"",
            "\"side\"",
            &["two.toml:2:8", "view \"side\" of [stage] is unknown", "front, back"][..],
        ),
        ("view", "vieww", &["two.toml:2:1", "unknown key \"vieww\" in [stage]"]),
        ("[stage]", "background = [1, 1, 1]\n[stage]", &["two.toml:1:14", "leave out one of the two"]),
        ("\"front\"", "\"front\"\nzoom = 0", &["two.toml:3:8", "zoom 0 of [stage] is outside"]),
        ("\"front\"", "\"front\"\nground = 1", &["two.toml:3:10", "must be true or false"]),
        ("\"front\"", "\"bottom\"\nground = true", &["[stage]: the view bottom is from below the ground"]),
        ("\"front\"", "\"front\"\nbackground = \"mauve\"", &["background of [stage]: `mauve` must be"]),
    ] {
        sandbox.write("two.toml", &format!("{text}{}", file("near")).replace(old, new));
        sandbox.run(["render", "two.toml"]).refused(words);
    }
    sandbox.write("empty.toml", "particles = []\n[stage]\n");
    sandbox.run(["render", "empty.toml"]).refused(&["empty.toml:2:1", "there is nothing on the [stage]"]);
}

/// The bytes of a pixel of a PNG are not looked at here: see `tests/render/alpha.rs`.
#[test]
fn a_transparent_background_is_recorded() {
    let sandbox = with_atoms();
    sandbox.render(&["atoms.xyz", "--background", "transparent", "-o", "one.png"]);
    // Bit depth 8, colour type 6: RGB with alpha.
    assert_eq!(sandbox.bytes("one.png")[24..26], [8, 6]);
    let printed = sandbox.run(["info", "one.png", "--scene"]).stdout;
    assert!(printed.contains("\ntransparent_background = true\n"), "{printed}");
    let repeated = sandbox.run(["render", "--like", "one.png", "-o", "two.png"]);
    assert_eq!(repeated.code, Some(0), "{repeated:?}");
    assert!(sandbox.bytes("one.png") == sandbox.bytes("two.png"));
    sandbox
        .write("atoms.toml", "[stage]\nbackground = \"transparent\"\n[[particles]]\nfile = \"atoms.xyz\"\n");
    sandbox.render(&["atoms.toml", "-o", "three.png"]);
    assert!(sandbox.bytes("one.png") == sandbox.bytes("three.png"));
    sandbox
        .run(["render", "atoms.toml", "-o", "four.jpg"])
        .refused(&["--output: four.jpg", "JPEG files have no alpha"]);
}

#[test]
fn options_that_do_not_fit_are_refused() {
    let sandbox = with_atoms();
    let refused = |args: &[&str], words: &[&str]| sandbox.run(["render"].iter().chain(args)).refused(words);
    refused(&["cornell", "--view", "iso"], &["--view", "files of particles", "cornell is none"]);
    refused(&["cornell", "--color", "red"], &["--color", "files of particles"]);
    refused(&["atoms.xyz", "--style", "z > 3: colour=red"], &["--style: colour: there is no `colour`"]);
    refused(
        &["atoms.xyz", "--style", "zz > 3: hide"],
        &["--style: where: column 1: there is no column `zz`"],
    );
    refused(&["atoms.xyz", "--color", "type"], &["--color: there is no column `type`"]);
    refused(&["atoms.xyz", "--ball-radius", "-1"], &["--ball-radius: `-1` must be a number"]);
    refused(&["atoms.xyz", "--cut", "x > 3 and"], &["--cut: column 10: this ends"]);
    refused(
        &["atoms.xyz", "--background", "mauve"],
        &["--background: `mauve` must be transparent, #rrggbb or one of white"],
    );
    refused(&["atoms.xyz", "--view", "bottom", "--ground"], &["the view bottom is from below the ground"]);
    refused(&["atoms.xyz", "--frame", "1"], &["atoms.xyz", "frame 1"]);
    refused(&["atoms.xyz", "--stats", "atoms.xyz"], &["--stats", "atoms.xyz", "the scene"]);
    sandbox.write(
        "room.toml",
        "[camera]\neye = [0, 0, 9]\ntarget = [0, 0, 0]\nvertical_fov_degrees = 40\n\
        [[particles]]\nfile = \"atoms.xyz\"\nstyle = [{ material = \"light\" }]\n",
    );
    refused(&["room.toml", "--stats", "atoms.xyz"], &["--stats", "atoms.xyz", "the scene"]);
    std::fs::remove_file(sandbox.path("room.toml")).unwrap();
    refused(&["none.xyz"], &["none.xyz: there is no such file"]);
    assert_eq!(sandbox.names(), ["atoms.xyz"]);
}

#[test]
fn engines_agree_on_particles_and_other_renderers_get_them() {
    let sandbox = with_atoms();
    let style = ["--material", "glass", "--ball-radius", "0.4", "--ground"];
    let Ended { code, stdout, stderr } =
        sandbox.run(["verify", "atoms.xyz"].iter().chain(&style).chain(&TINY));
    assert_eq!((code, stderr.as_str()), (Some(0), ""));
    assert!(stdout.contains("identical"), "{stdout}");
    let exported = sandbox.run(["export", "atoms.xyz", "--format", "pbrt"]);
    assert_eq!(exported.code, Some(0));
    assert!(exported.stdout.matches("Shape \"sphere\"").count() >= ATOMS.len(), "{}", exported.stdout);
}

#[test]
fn what_the_user_should_know_is_told() {
    let sandbox = with_atoms();
    let ended = sandbox.render(&["atoms.xyz", "--material", "glass"]);
    assert!(ended.stderr.contains("note: atoms.xyz: balls of glass overlap"), "{ended:?}");
    sandbox.write(
        "glass.toml",
        "[stage]\n[[particles]]\nfile = \"atoms.xyz\"\nstyle = [{ material = \"glass\" }]\n",
    );
    let ended = sandbox.render(&["glass.toml"]);
    assert!(ended.stderr.contains("note: glass.toml:3:8: balls of glass overlap"), "{ended:?}");
}
