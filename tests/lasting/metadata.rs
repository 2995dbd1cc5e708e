//! Metadata in images, and renders that are repeated from it.

use crate::sandbox::Sandbox;
use serde_json::Value;

fn info(sandbox: &Sandbox, file: &str) -> Value {
    let ended = sandbox.run(["info", file, "--json"]);
    assert_eq!((ended.code, ended.stderr.as_str()), (Some(0), ""), "{file}");
    serde_json::from_str(&ended.stdout).unwrap()
}

#[test]
fn images_and_checkpoints_contain_metadata() {
    let sandbox = Sandbox::new();
    sandbox.render(&["mirror", "-o", "a.png", "--seed=7", "--exposure=1", "--checkpoint=a.sppm"]);
    sandbox.render(&["mirror", "-o", "a.exr", "--seed=7", "--radius-image=r.exr", "--engine=reference"]);
    let scene = files::builtin::scene("mirror").unwrap();
    for file in ["a.png", "a.exr", "r.exr", "a.sppm"] {
        let info = info(&sandbox, file);
        assert_eq!(info["version"], env!("CARGO_PKG_VERSION"));
        assert_eq!(info["kind"], if file == "a.sppm" { "checkpoint" } else { "image" });
        assert_eq!(
            (&info["scene"], &info["scene_digest"]),
            (&scene.name.clone().into(), &files::scene_file::digest(&scene).into())
        );
        assert_eq!((&info["iterations"], &info["photons"]), (&2.into(), &1000.into()));
        assert_eq!((&info["settings"]["seed"], &info["settings"]["width"]), (&7.into(), &16.into()));
        assert_eq!(info["engine"], if file.ends_with("exr") { "reference" } else { "fast" });
        assert_eq!(info["lanes"].is_null(), file != "a.png");
        assert_eq!(info["exposure"].is_null(), file.ends_with("exr"));
        let text = sandbox.run(["info", file]).stdout;
        for words in ["Mirror Box", "16 x 12 pixels", "500 per iteration", "seed       7"] {
            assert!(text.contains(words), "no {words:?} in {text}");
        }
        sandbox.write("again.toml", &sandbox.run(["info", file, "--scene"]).stdout);
        sandbox.run(["render", "again.toml", "-q", "-o", "again.pfm"]);
        assert_eq!(sandbox.image("again.pfm"), sandbox.image("a.exr"), "{file}");
    }
}

#[test]
fn like_repeats_a_render_bit_for_bit() {
    let sandbox = Sandbox::new();
    sandbox.write("mine.toml", &files::builtin::find("focus").unwrap().text.replace("seed", "# seed"));
    for (scene, file, args) in [
        ("cornell", "a.png", &["--exposure=-1.5", "--seed=9"][..]),
        ("motion", "a.exr", &["--engine=reference"]),
        ("cornell", "b.exr", &["--engine=path", "--depth=3", "--light-samples=3"]),
        ("cornell", "d.exr", &["--method=path", "--engine=reference"]),
        ("mine.toml", "b.png", &["--lanes=emulated", "--radius=3"]),
    ] {
        sandbox.render(&[&[scene, "-o", file], args].concat());
        let again = format!("again-{file}");
        let lanes = if args.contains(&"--lanes=emulated") { "--lanes=emulated" } else { "-v" };
        let ended = sandbox.run(["render", "--like", file, "-o", &again, lanes]);
        assert_eq!(ended.code, Some(0), "{ended:?}");
        assert!(sandbox.bytes(file) == sandbox.bytes(&again), "{file}");
    }
    sandbox.render(&["cornell", "-o", "c.exr", "--checkpoint=c.sppm", "--seed=5"]);
    assert_eq!(sandbox.run(["render", "--like", "c.sppm", "-o", "d.exr"]).code, Some(0));
    assert!(sandbox.bytes("c.exr") == sandbox.bytes("d.exr"));
    // A checkpoint knows how its image shows bright light as well.
    let shown = ["--exposure=1", "--tone=reinhard", "--white=2"];
    sandbox.render(&[&["cornell", "-o", "f.png", "--checkpoint=f.sppm"], &shown[..]].concat());
    assert_eq!(sandbox.run(["render", "--like", "f.sppm", "-o", "g.png"]).code, Some(0));
    assert!(sandbox.bytes("f.png") == sandbox.bytes("g.png"));
    assert_eq!(sandbox.run(["render", "--like", "c.exr", "-o", "e.exr", "--seed=6"]).code, Some(0));
    assert_ne!(sandbox.image("c.exr"), sandbox.image("e.exr"));
}

#[test]
fn a_scene_too_large_for_the_metadata_must_be_given() {
    let sandbox = Sandbox::new();
    let ball = |x: f32| format!("[[sphere]]\ncenter = [{x:.2}, 0, -50]\nradius = 0.1\nmaterial = \"m\"\n");
    let head = "background = [1, 1, 1]\n[camera]\neye = [0, 0, 0]\ntarget = [0, 0, -1]\nvertical_fov_degrees = 30\n\
        [materials.m]\ntype = \"diffuse\"\nalbedo = [0.5, 0.5, 0.5]\n";
    let text = head.to_owned() + &(0..17_000_u16).map(|i| ball(f32::from(i))).collect::<String>();
    sandbox.write("many.toml", &text);
    sandbox.render(&["many.toml", "-o", "a.exr"]);
    sandbox.run(["render", "--like", "a.exr"]).refused(&["--like: a.exr", "too large", "name the scene"]);
    sandbox
        .run(["render", "cornell", "--quality=paper", "--like", "a.exr", "-o", "b.exr"])
        .refused(&["--like: a.exr", "another"]);
    assert_eq!(sandbox.run(["render", "many.toml", "--like", "a.exr", "-o", "b.exr"]).code, Some(0));
    assert!(sandbox.bytes("a.exr") == sandbox.bytes("b.exr"));
    assert_eq!(sandbox.run(["info", "a.exr", "--scene"]).code, Some(1));
}

/// Of what is as usual, the text says nothing.
#[test]
fn what_is_unusual_is_told() {
    let sandbox = Sandbox::new();
    let rows = |args: &[&str]| {
        sandbox.render(&[&["cornell", "-o", "a.png"], args].concat());
        let text = sandbox.run(["info", "a.png"]).stdout;
        let rows = text.lines().filter_map(|line| line.split_once(' '));
        rows.map(|(name, value)| (name.to_string(), value.trim().to_string())).collect::<Vec<_>>()
    };
    let usual = rows(&[]);
    for (name, options, value) in [
        ("filter", ["--filter", "gaussian"], "gaussian"),
        ("light", ["--light-samples", "3"], "3 samples"),
        ("exposure", ["--exposure", "1.5"], "1.5 stops"),
    ] {
        assert!(usual.iter().all(|(known, _)| known != name), "{usual:?}");
        let told = rows(&options);
        assert!(told.contains(&(name.into(), value.into())), "{told:?}");
        assert_eq!(told.len(), usual.len() + 1, "{told:?}");
    }
}

#[test]
fn files_without_metadata_are_rejected() {
    let sandbox = Sandbox::new();
    sandbox.render(&["cornell", "-o", "a.pfm"]);
    sandbox.render(&["cornell", "-o", "a.png"]);
    files::image_file::write(
        &sandbox.path("b.png"),
        &sandbox.image("a.pfm"),
        &files::image_file::Encoding::default(),
    )
    .unwrap();
    sandbox.write("c.png", "no image");
    for file in ["a.pfm", "b.png", "a.jpg", "a.tif", "a.hdr"] {
        if !sandbox.path(file).exists() {
            sandbox.render(&["cornell", "-o", file]);
        }
        for args in [&["info", file, "--scene"][..], &["render", "--like", file]] {
            sandbox.run(args).refused(&[file, "only .png and .exr images by sppm do"]);
        }
    }
    for file in ["c.png", "missing.png", "missing.sppm", "missing.jpg"] {
        sandbox.run(["info", file]).refused(&[file]);
        sandbox.run(["render", "--like", file]).refused(&[file]);
    }
    sandbox.run(["render", "--like", "a.png", "-o", "a.png"]).refused(&["--output", "also --like"]);
    sandbox.run(["render"]).refused(&["<SCENE> is missing"]);
}

#[test]
fn images_without_metadata_are_described() {
    let sandbox = Sandbox::new();
    for (file, format) in [
        ("a.pfm", "PFM, linear floats"),
        ("a.hdr", "HDR, linear floats"),
        ("a.tif", "TIFF, linear floats"),
        ("a.jpg", "JPEG, 8 bits of sRGB"),
    ] {
        sandbox.render(&["cornell", "-o", file]);
        let ended = sandbox.run(["info", file]);
        assert_eq!(ended.code, Some(0), "{ended:?}");
        for words in [format, " pixels", "only .png and .exr images"] {
            assert!(ended.stdout.contains(words), "no {words:?} in {ended:?}");
        }
        let json = sandbox.run(["info", file, "--json"]);
        let told: Value = serde_json::from_str(&json.stdout).unwrap();
        assert_eq!(told["format"], format.split(',').next().unwrap());
        assert_eq!(told["width"], sandbox.image(file).width);
        // Of one that is cut, it is told that it is.
        let whole = sandbox.bytes(file);
        std::fs::write(sandbox.path("cut"), &whole[..8]).unwrap();
        let cut = sandbox.run(["info", "cut"]);
        cut.refused(&["cut: "]);
        assert!(!cut.stderr.contains("does not say"), "{cut:?}");
    }
}
