//! The command `export`.

use crate::sandbox::{Ended, Sandbox};
use files::builtin::{self, SCENES};
use files::lock::Lock;
use roxmltree::{Document, Node};
use scene::Vec3;

/// Standard output of an export that succeeds.
fn export(sandbox: &Sandbox, args: &[&str]) -> String {
    let Ended { code, stdout, stderr } = sandbox.run(["export"].iter().chain(args));
    assert_eq!(code, Some(0), "{args:?}: {stderr}");
    stdout
}

/// The child of a node whose attribute `name` has the given value.
fn child<'a>(node: Node<'a, 'a>, name: &str) -> Option<Node<'a, 'a>> {
    node.children().find(|c| c.attribute("name") == Some(name))
}

fn number(node: Node, attribute: &str) -> f32 {
    node.attribute(attribute).unwrap().parse().unwrap()
}

fn triple(node: Node, name: &str) -> [f32; 3] {
    let text = child(node, name).unwrap().attribute("value").unwrap();
    let values: Vec<f32> = text.split(", ").map(|v| v.parse().unwrap()).collect();
    values.try_into().unwrap()
}

#[test]
fn every_number_of_built_in_scenes_is_exported_to_mitsuba() {
    let sandbox = Sandbox::new();
    for builtin in SCENES {
        let scene = builtin.scene();
        let time = scene.camera.shutter[0];
        let text = export(&sandbox, &[builtin.name, "--format", "mitsuba", "--time", &time.to_string()]);
        let document = Document::parse(&text).unwrap();
        let root = document.root_element();
        let shapes: Vec<Node> = root.children().filter(|n| n.has_tag_name("shape")).collect();
        assert_eq!(shapes.len(), scene.spheres.len(), "{}", builtin.name);
        let moved = text.split("moved by ").nth(1).expect("rooms of this size stand near the origin");
        let shift: f32 = moved.split(' ').next().unwrap().parse().unwrap();
        for (shape, sphere) in shapes.iter().zip(&scene.spheres) {
            let center = child(*shape, "center").unwrap();
            let [x, y, z] = ["x", "y", "z"].map(|axis| number(center, axis));
            let expected = sphere.at(time).center + Vec3::new(0.0, 0.0, shift);
            assert_eq!([x, y, z], expected.to_array(), "{}", builtin.name);
            assert_eq!(number(child(*shape, "radius").unwrap(), "value"), sphere.radius);
            let around = sphere.center.distance(scene.camera.eye) < sphere.radius;
            assert_eq!(child(*shape, "flip_normals").is_some(), around, "{}", builtin.name);
            let emitter = shape.children().find(|n| n.has_tag_name("emitter"));
            assert_eq!(emitter.is_some(), sphere.is_emitter());
            if let Some(emitter) = emitter {
                assert_eq!(triple(emitter, "radiance"), sphere.emission.to_array());
            }
            let material = shape.children().find(|n| n.has_tag_name("ref")).unwrap().attribute("id").unwrap();
            let bsdf = root.children().find(|n| n.attribute("id") == Some(material)).unwrap();
            let albedo = scene.materials[sphere.material as usize].albedo().to_array();
            let names: &[&str] = match bsdf.attribute("type").unwrap() {
                "diffuse" => &["reflectance"],
                "conductor" => &["specular_reflectance"],
                "dielectric" => &["specular_reflectance", "specular_transmittance"],
                other => panic!("{other}"),
            };
            for name in names {
                assert_eq!(triple(bsdf, name), albedo, "{}", builtin.name);
            }
        }
        let sensor = root.children().find(|n| n.has_tag_name("sensor")).unwrap();
        assert_eq!(number(child(sensor, "fov").unwrap(), "value"), scene.camera.vertical_fov_degrees);
        let is_lens = scene.camera.aperture_radius > 0.0;
        assert_eq!(sensor.attribute("type"), Some(if is_lens { "thinlens" } else { "perspective" }));
        let film = sensor.children().find(|n| n.has_tag_name("film")).unwrap();
        assert_eq!(number(child(film, "width").unwrap(), "value"), 512.0);
    }
}

#[test]
fn every_number_of_built_in_scenes_is_exported_to_pbrt() {
    let sandbox = Sandbox::new();
    for builtin in SCENES {
        let scene = builtin.scene();
        let time = scene.camera.shutter[1];
        let text = export(&sandbox, &[builtin.name, "--format", "pbrt", "--time", &time.to_string()]);
        let all = |word: &str| {
            let rest =
                |line: &str| Some(line.trim().strip_prefix(word)?.trim_matches(['[', ']', ' ']).to_owned());
            text.lines().filter_map(rest).collect::<Vec<_>>()
        };
        let numbers = |v: &[f32]| v.iter().map(ToString::to_string).collect::<Vec<_>>().join(" ");
        let (centers, radii) = (all("Translate "), all("Shape \"sphere\" \"float radius\""));
        assert_eq!(
            (centers.len(), radii.len()),
            (scene.spheres.len(), scene.spheres.len()),
            "{}",
            builtin.name
        );
        for ((center, radius), sphere) in centers.iter().zip(&radii).zip(&scene.spheres) {
            assert_eq!(*center, numbers(&sphere.at(time).center.to_array()));
            assert_eq!(*radius, sphere.radius.to_string());
        }
        let lit: Vec<_> = scene
            .spheres
            .iter()
            .filter(|s| s.is_emitter())
            .map(|s| numbers(&s.emission.to_array()))
            .collect();
        assert_eq!(all("AreaLightSource \"diffuse\" \"rgb L\""), lit, "{}", builtin.name);
        let around = |s: &&scene::Sphere| s.center.distance(scene.camera.eye) < s.radius;
        assert_eq!(all("ReverseOrientation").len(), scene.spheres.iter().filter(around).count());
        let open = |line: &&str| line.contains("AttributeBegin");
        assert_eq!(text.lines().filter(open).count(), text.matches("AttributeEnd").count());
    }
}

#[test]
fn sizes_samples_and_files_are_as_asked() {
    let sandbox = Sandbox::new();
    let args = ["cornell", "--format=mitsuba", "--width=40", "--height=30", "--samples=7"];
    let text = export(&sandbox, &args);
    for part in
        [r#"name="width" value="40""#, r#"name="height" value="30""#, r#"name="sample_count" value="7""#]
    {
        assert!(text.contains(part), "no {part} in {text}");
    }
    assert_eq!(export(&sandbox, &[&args[..], &["-o", "box.xml"]].concat()), "");
    assert_eq!(String::from_utf8(sandbox.bytes("box.xml")).unwrap(), text);
    assert_eq!(export(&sandbox, &[&args[..], &["-o", "-"]].concat()), text);
    assert_eq!(sandbox.names(), ["box.xml"]);
}

/// The camera of particles is fitted to the image that is asked for, as where a file states its size.
#[test]
fn particles_are_fitted_to_the_size_that_is_asked_for() {
    let sandbox = Sandbox::new();
    sandbox.write("atoms.xyz", "3\n\nO 0 0 0\nH 0.96 0 0\nH -0.24 0.93 0\n");
    let stage = "[stage]\nview = \"front\"\n[[particles]]\nfile = \"atoms.xyz\"\n";
    sandbox.write("atoms.toml", &format!("{stage}[settings]\nwidth = 20\nheight = 60\n"));
    let particles = |size: &[&str]| {
        export(&sandbox, &[&["atoms.xyz", "--view=front", "--format=mitsuba"], size].concat())
    };
    let narrow = particles(&["--width=20", "--height=60"]);
    assert_eq!(narrow, export(&sandbox, &["atoms.toml", "--format=mitsuba"]));
    let camera = |text: &str| text.lines().find(|line| line.contains("<lookat")).unwrap().to_owned();
    assert_ne!(camera(&narrow), camera(&particles(&[])));
}

#[test]
fn a_portrait_keeps_its_vertical_angle_in_pbrt() {
    let text = export(&Sandbox::new(), &["cornell", "--format=pbrt", "--width=30", "--height=60"]);
    let angle =
        text.split("\"float fov\" [ ").nth(1).unwrap().split(' ').next().unwrap().parse::<f64>().unwrap();
    let expected = 2.0 * (15_f64.to_radians().tan() / 2.0).atan().to_degrees();
    approx::assert_relative_eq!(angle, expected, max_relative = 1e-6);
}

#[test]
fn the_name_of_a_scene_cannot_break_out_of_its_comment() {
    let sandbox = Sandbox::new();
    let text = builtin::find("cornell").unwrap().text;
    sandbox.write("odd.toml", &text.replace("\"Cornell Box\"", r#""a --> <b/> & ---- c""#));
    let xml = export(&sandbox, &["odd.toml", "--format", "mitsuba"]);
    assert!(Document::parse(&xml).unwrap().descendants().all(|n| !n.has_tag_name("b")));
}

#[test]
fn differences_of_pbrt_are_reported() {
    let ended = Sandbox::new().run(["export", "cornell", "--format", "pbrt"]);
    assert_eq!(ended.code, Some(0));
    for word in ["note: ", "mirrors", "tint"] {
        assert!(ended.stderr.contains(word), "{}", ended.stderr);
    }
    assert_eq!(ended.stderr.lines().count(), 1, "{}", ended.stderr);
    assert!(ended.stdout.lines().any(|line| line.starts_with("# ") && line.contains("tint")));
    assert_eq!(Sandbox::new().run(["export", "cornell", "--format", "mitsuba"]).stderr, "");
}

const GLOWING_GLASS: &str = "
camera = { eye = [0, 0, 10], direction = [0, 0, -1], vertical_fov_degrees = 40 }
[[sphere]]
center = [0, 0, 0]
radius = 2
emission = [1, 1, 1]
material = { type = \"dielectric\", albedo = [1, 1, 1], ior = 1.5 }
";

#[test]
fn scenes_that_cannot_be_exported_are_rejected() {
    let sandbox = Sandbox::new();
    sandbox.write("glow.toml", GLOWING_GLASS);
    let before = sandbox.contents();
    let cases: [(&[&str], &[&str]); 10] = [
        (&["glow.toml", "--format", "mitsuba", "-o", "g.xml"], &["sphere 1", "glows", "pbrt"]),
        (&["motion", "--format", "mitsuba"], &["Motion", "--time", "from 0 to 1"]),
        (&["motion", "--format", "pbrt", "-o", "m.pbrt"], &["--time"]),
        (&["motion", "--format", "pbrt", "--time", "1.5"], &["--time: 1.5", "open, 0 to 1"]),
        (&["cornell"], &["--format is missing"]),
        (&["cornell", "--format", "luxrender"], &["--format", "\"luxrender\"", "mitsuba and pbrt"]),
        (&["cornell", "--format", "pbrt", "-o", "no/c.pbrt"], &["--output: no/c.pbrt", "does not exist"]),
        (&["glow.toml", "--format", "pbrt", "-o", "glow.toml"], &["--output", "also the scene"]),
        (&["cornell", "--format", "pbrt", "--samples", "0"], &["--samples: \"0\""]),
        (&["cornell", "--format", "pbrt", "--width", "1000000", "--height", "1000000"], &["--width", "GiB"]),
    ];
    for (args, words) in cases {
        sandbox.run(["export"].iter().chain(args)).refused(words);
        assert!(sandbox.contents() == before, "{args:?} changed the folder: {:?}", sandbox.names());
    }
    let pbrt = export(&sandbox, &["glow.toml", "--format", "pbrt"]);
    assert!(pbrt.contains("\"bool twosided\" [ true ]"), "{pbrt}");
}

/// Nothing moves while the shutter is open for no time.
#[test]
fn an_instant_is_asked_for_only_where_there_are_several() {
    let sandbox = Sandbox::new();
    let scene = builtin::scene("motion").unwrap();
    let text = |shutter| {
        let camera = scene::Camera { shutter, ..scene.camera };
        files::scene_file::to_text(&scene::Scene { camera, ..scene.clone() }, &scene.settings)
    };
    sandbox.write("open.toml", &text([0.25, 0.5]));
    sandbox.write("still.toml", &text([0.25, 0.25]));
    sandbox.run(["export", "open.toml", "--format", "pbrt"]).refused(&["--time", "from 0.25 to 0.5"]);
    let at = export(&sandbox, &["open.toml", "--format", "pbrt", "--time", "0.25"]);
    let still = export(&sandbox, &["still.toml", "--format", "pbrt"]);
    let shapes = |text: &str| {
        text.lines().filter(|line| line.contains("Translate")).map(String::from).collect::<Vec<_>>()
    };
    assert_eq!(shapes(&at), shapes(&still));
    assert!(!shapes(&at).is_empty());
}

#[test]
fn a_file_that_something_else_writes_is_left_alone() {
    let sandbox = Sandbox::new();
    let path = sandbox.path("a.xml");
    let lock = Lock::take(&path).unwrap();
    let export = || sandbox.run(["export", "cornell", "--format", "mitsuba", "-o", "a.xml"]);
    let Ended { code, stderr, .. } = export();
    assert_eq!(code, Some(2), "{stderr}");
    assert!(stderr.contains("--output: a.xml") && !path.exists(), "{stderr}");
    drop(lock);
    assert_eq!(export().code, Some(0));
    assert!(path.exists());
}
