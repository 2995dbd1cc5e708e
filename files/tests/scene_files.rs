//! Valid scene files in every TOML spelling, and randomly mutated files.

use files::builtin::{self, SCENES};
use files::scene_file;
use proptest::prelude::*;
use scene::still::Role;
use scene::{Automatic, Camera, Material, Quality, Rgb, Scene, Settings, Sphere, Vec3};

/// A small scene in plain TOML; the tests below write it in other ways.
const PLAIN: &str = r#"name = "Plain"

[camera]
eye = [0, 0, 10]
target = [0, 0, 0]
vertical_fov_degrees = 40

[settings]
seed = 18446744073709551615

[materials.white]
type = "diffuse"
albedo = [0.5, 0.5, 0.5]

[[sphere]]
center = [0, 3, 0]
radius = 1
material = "white"
emission = [1, 2, 3]
"#;

fn plain() -> Scene {
    Scene {
        name: "Plain".into(),
        camera: Camera {
            eye: Vec3::new(0.0, 0.0, 10.0),
            direction: Vec3::new(0.0, 0.0, -10.0),
            up: Vec3::Y,
            vertical_fov_degrees: 40.0,
            aperture_radius: 0.0,
            focus_distance: 10.0,
            shutter: [0.0, 0.0],
        },
        materials: vec![Material::Diffuse { albedo: Rgb::splat(0.5) }],
        spheres: vec![Sphere {
            center: Vec3::new(0.0, 3.0, 0.0),
            velocity: Vec3::ZERO,
            radius: 1.0,
            material: 0,
            emission: Rgb::new(1.0, 2.0, 3.0),
        }]
        .into(),
        background: Rgb::ZERO,
        transparent_background: false,
        imports: Vec::new(),
        settings: Settings { seed: u64::MAX, ..Settings::default() },
    }
}

fn parse(text: &str) -> Scene {
    scene_file::parse("dir/Plain.toml", text).unwrap_or_else(|e| panic!("{e} in\n{text}"))
}

#[test]
fn every_spelling_gives_the_same_scene() {
    let inline = r#"
        sphere = [{ center = [0.0, +3.0, -0.0], radius = 1e0, emission = [0x1, 0b10, 3], material.type = "diffuse",
                    material.albedo = [0.5, 5e-1, 0.5] }]
        camera = { eye = [0, 0, 1_0], target = [0, 0, 0], vertical_fov_degrees = 40.0 }
        settings = { seed = 0xffff_ffff_ffff_ffff, width = 512 }"#;
    let dotted = r#"
        "name" = 'Plain'
        camera.eye = [0, 0, 10]
        camera.target = [0, 0, 0]
        camera.up = [0, 1, 0]
        camera."vertical_fov_degrees" = 40
        camera.shutter = [0, 0]
        settings.seed = 18446744073709551615
        materials.white.type = "diffuse"
        materials.white.albedo = [0.5, 0.5, 0.5,]
        [[sphere]]
        center = [
            0, # a comment in between
            3,
            0,
        ]
        radius = 1
        material = "white"
        emission = [1, 2, 3]"#;
    let sub_table = PLAIN.replace("material = \"white\"\n", "")
        + "[sphere.material]\ntype = \"diffuse\"\nalbedo = [0.5, 0.5, 0.5]\n";
    let sub_table =
        sub_table.replace("[materials.white]\ntype = \"diffuse\"\nalbedo = [0.5, 0.5, 0.5]\n", "");
    let (crlf, bom) = (PLAIN.replace('\n', "\r\n"), format!("\u{feff}{PLAIN}"));
    for text in [PLAIN, inline, dotted, &sub_table, &crlf, &bom, PLAIN.trim_end()] {
        assert_eq!(parse(text), plain(), "for\n{text}");
    }
}

#[test]
fn a_lens_focuses_on_its_target_unless_told_otherwise() {
    // A pinhole that is stated is none, even where nothing tells the distance of focus.
    let aside = PLAIN.replace("target = [0, 0, 0]", "direction = [0, 0, -1]");
    let stated = aside.replace("[settings]", "aperture_radius = 0\n[settings]");
    assert_eq!(parse(&stated).camera, parse(&aside).camera);
    let lens = PLAIN.replace("[settings]", "aperture_radius = 0.5\n[settings]");
    assert_eq!(parse(&lens).camera.focus_distance, 10.0);
    let told = lens.replace("aperture_radius", "focus_distance = 7\naperture_radius");
    assert_eq!(parse(&told).camera.focus_distance, 7.0);
}

/// In what identifies a scene, the sign of a zero would count; a number may also be too small for any other.
#[test]
fn no_zero_has_a_sign() {
    let signed = parse(&PLAIN.replace("center = [0, 3, 0]", "center = [-0.0, 3, -1e-60]"));
    assert_eq!(scene_file::digest(&signed), scene_file::digest(&plain()));
}

/// So there may be a picture of nothing but the sky.
#[test]
fn a_background_alone_is_a_scene() {
    let (head, _) = PLAIN.split_once("[materials.white]").unwrap();
    let scene = parse(&format!("background = [1, 2, 3]\n{head}"));
    assert_eq!((scene.spheres.len(), scene.background), (1, Rgb::new(1.0, 2.0, 3.0)));
}

#[test]
fn names_may_be_in_any_script() {
    let text = PLAIN.replace("Plain", "Ka\u{308}se \u{1f9c0}").replace("white", "\"\u{767d}\"");
    let text = text.replace("\"\"\u{767d}\"\"", "\"\u{767d}\"");
    assert_eq!(parse(&text).name, "Ka\u{308}se \u{1f9c0}");
}

/// A stage is of the usual size where a file does not say another, for each side by itself.
#[test]
fn a_stage_is_fitted_to_the_size_of_its_image() {
    let read = |settings: &str| {
        let text = format!(
            "[stage]\n[settings]\n{settings}\n[[sphere]]\ncenter = [0, 0, 0]\nradius = 1\n\
            material = {{ type = \"diffuse\", albedo = [1, 1, 1] }}\n"
        );
        scene_file::parse_with_automatic("stage.toml", &text).unwrap()
    };
    let stage = |settings: &str| read(settings).0;
    let usual = figure::stage::Stage::default().size;
    for (settings, size) in [
        ("", usual),
        ("width = 90", [90, usual[1]]),
        ("height = 9000", [usual[0], 9000]),
        ("width = 90\nheight = 900", [90, 900]),
    ] {
        let scene = stage(settings);
        assert_eq!([scene.settings.width, scene.settings.height], size, "{settings}");
        // All else is as on any stage, but for the radius, which suits the pixels.
        let ([width, height], Settings { initial_radius, .. }) = (size, scene.settings);
        let expected = Settings { width, height, initial_radius, ..stage("").settings };
        assert_eq!(scene.settings, expected, "{settings}");
        assert_eq!(read(settings).1, Automatic::default(), "{settings}: nothing is chosen");
        // The narrower the image, the farther the camera.
        let far = scene.camera.eye.length();
        let narrow = size[0] < size[1];
        assert_eq!(far > 1.5 * stage("").camera.eye.length(), narrow, "{settings}: {far}");
    }
    // A quality is a request to choose, as in every scene; what is stated beside it is not chosen.
    let chosen = read("quality = \"draft\"\nmax_depth = 7").1;
    assert_eq!(chosen, Automatic { max_depth: false, ..Automatic::all(Quality::Draft) });
}

/// Whoever states one of four numbers has the paper's others; what else is stated leaves the rest to be chosen.
#[test]
fn one_of_four_numbers_leaves_nothing_to_be_chosen() {
    let read = |settings: &str| {
        let text = PLAIN.replace("seed = 18446744073709551615", settings);
        let (scene, automatic) = scene_file::parse_with_automatic("open.toml", &text).unwrap();
        (scene.settings, automatic)
    };
    let (usual, all) = (Settings::default(), Automatic::all(Quality::default()));
    let numbers = [
        ("iterations", Settings { iterations: 3, ..usual }),
        ("photons_per_iteration", Settings { photons_per_iteration: 3, ..usual }),
        ("max_depth", Settings { max_depth: 3, ..usual }),
        ("initial_radius", Settings { initial_radius: 3.0, ..usual }),
    ];
    for (key, stated) in numbers {
        assert_eq!(read(&format!("{key} = 3")), (stated, Automatic::default()));
        assert_eq!(read(&format!("{key} = \"auto\"")), (usual, all));
    }
    for (settings, stated, automatic) in [
        ("width = 9\nheight = 8", Settings { width: 9, height: 8, ..usual }, all),
        ("light_samples = 2", Settings { light_samples: 2, ..usual }, all),
        (
            "radius_pilots = 2",
            Settings { radius_pilots: 2, ..usual },
            Automatic { method: false, radius_pilots: false, ..all },
        ),
        (
            "radius_clearance = 0.5",
            Settings { radius_clearance: 0.5, ..usual },
            Automatic { method: false, radius_clearance: false, ..all },
        ),
        (
            "glint_samples = 4",
            Settings { glint_samples: 4, ..usual },
            Automatic { glint_samples: false, ..all },
        ),
    ] {
        assert_eq!(read(settings), (stated, automatic), "{settings}");
    }
}

#[test]
fn a_moving_sphere_may_pass_beside_the_lens_but_not_over_it() {
    let moving = |velocity: &str| {
        let text = PLAIN.replace("[settings]", "shutter = [0, 1]\n[settings]");
        let text = text.replace("emission", &format!("velocity = {velocity}\nemission"));
        scene_file::parse("moving.toml", &text)
    };
    assert!(moving("[0, 0, 20]").is_ok());
    assert!(moving("[0, -6, 20]").is_err());
    assert!(moving("[0, -3, 10]").is_err());
}

#[test]
fn a_background_becomes_a_sky_around_everything() {
    let open = PLAIN.replace("name", "background = [0.1, 0.2, 0.3]\nname");
    let ground = "[[sphere]]\ncenter = [0, -10002, 0]\nradius = 10000\nmaterial = \"white\"\n";
    let far = "[[sphere]]\ncenter = [900, 0, 0]\nvelocity = [0, 500, 0]\nradius = 3\nmaterial = \"white\"\n";
    let shutter = open.replace("[settings]", "shutter = [-1, 1]\n[settings]");
    for text in [
        open.clone(),
        format!("{open}{ground}"),
        format!("{shutter}{ground}{far}"),
        format!("{shutter}{far}"),
    ] {
        let scene = parse(&text);
        let (sky, others) = scene.spheres.split_last().unwrap();
        assert_eq!(sky.emission, scene.background);
        assert_eq!(scene.materials[sky.material as usize], Material::Diffuse { albedo: Rgb::ZERO });
        let mut needed = 0.0_f32;
        for s in others.iter().flat_map(|s| scene.camera.shutter.map(|time| s.at(time))) {
            needed = needed.max(s.center.distance(sky.center) + s.radius);
        }
        assert!(scene.camera.eye.distance(sky.center) < sky.radius);
        assert!(needed < sky.radius && sky.radius < 1.02 * needed.max(10.0), "{needed} {}", sky.radius);
        let still = scene.at(scene.camera.shutter[0]);
        assert!(matches!(still.roles.iter().next_back(), Some(Role::Enclosure(_))));
        let light = still.lights.entries.last().unwrap();
        assert!(light.inside && light.blockers.is_empty());
        assert_eq!(light.sphere as usize, others.len());
    }
}

#[test]
fn a_closed_room_keeps_its_sky_out() {
    let text = builtin::find("cornell")
        .unwrap()
        .text
        .replace("name = \"Cornell", "background = [1, 1, 1]\nname = \"C");
    let scene = parse(&text);
    assert_eq!(scene.spheres.len(), 10);
    assert_eq!(scene.at(0.0).lights.entries.len(), 2);
}

#[test]
fn the_papers_scenes_keep_their_numbers() {
    let spheres = |name| builtin::scene(name).unwrap().spheres.len();
    assert_eq!(["cornell", "large", "mirror", "random", "surgery"].map(spheres), [9, 9, 11, 178, 71]);
    for name in ["cornell", "large", "mirror", "random", "surgery"] {
        let camera = builtin::scene(name).unwrap().camera;
        assert_eq!(camera.eye, Vec3::new(50.0, 52.0, 295.6));
        assert_eq!(camera.direction, Vec3::new(0.0, -0.042_612, -1.0));
        assert_eq!((camera.up, camera.vertical_fov_degrees), (Vec3::Y, 30.0));
    }
    let glass = |tint| Material::Dielectric { albedo: Rgb::splat(tint), ior: 1.5 };
    check("cornell", 0, [10001.0, 40.8, 81.6], 1e4, Material::Diffuse { albedo: Rgb::new(0.75, 0.25, 0.25) });
    check("cornell", 6, [73.0, 16.5, 78.0], 16.5, glass(0.999));
    check("large", 3, [50.0, 1e4, 81.6], 1e4, Material::Diffuse { albedo: Rgb::new(0.212, 0.157, 0.127) });
    check("large", 8, [87.0, 22.0, 24.0], 22.0, Material::Specular { albedo: Rgb::splat(0.4176) });
    check("mirror", 2, [50.0, 40.8, 1e4], 1e4, Material::Specular { albedo: Rgb::splat(0.75) });
    check("mirror", 10, [72.5, 12.5, 82.0], 12.5, glass(0.9216));
    check("random", 86, [58.0, 9.0, 54.0], 9.0, Material::Specular { albedo: Rgb::splat(0.9216) });
    check(
        "random",
        173,
        [-9880.0, 40.8, 81.6],
        1e4,
        Material::Diffuse { albedo: Rgb::new(0.25, 0.25, 0.75) },
    );
    check("surgery", 62, [110.0, 80.0, 90.0], 5.0, Material::Diffuse { albedo: Rgb::ZERO });
    check("surgery", 66, [50.0, 1e4, 81.6], 1e4, Material::Specular { albedo: Rgb::splat(0.5) });
    let emission = |name, i: usize| builtin::scene(name).unwrap().spheres[i].emission;
    assert_eq!(emission("cornell", 7), Rgb::new(20.0, 10.0, 10.0));
    assert_eq!(emission("large", 5), Rgb::new(45.0, 25.0, 25.0));
    assert_eq!(emission("surgery", 0), Rgb::new(4.5, 4.5, 6.5));
}

fn check(name: &str, i: usize, center: [f32; 3], radius: f32, material: Material) {
    let scene = builtin::scene(name).unwrap();
    let s = scene.spheres[i];
    assert_eq!((s.center, s.radius), (center.into(), radius), "sphere {i} of {name}");
    assert_eq!(scene.materials[s.material as usize], material, "sphere {i} of {name}");
}

#[test]
fn every_built_in_scene_is_valid() {
    for builtin in SCENES {
        let scene = scene_file::parse(builtin.name, builtin.text).unwrap();
        assert_eq!(builtin::scene(builtin.name), Some(scene.clone()));
        assert!(!scene.name.is_empty() && !builtin.about.contains('\n'));
    }
    assert!(builtin::scene("focus").unwrap().camera.aperture_radius > 0.0);
    let motion = builtin::scene("motion").unwrap();
    assert!(motion.spheres.iter().filter(|s| s.velocity != Vec3::ZERO).count() >= 3);
    assert_eq!(builtin::find("Cornell"), None);
}

#[test]
fn the_documented_example_is_valid() {
    let readme = include_str!("../scenes/README.md");
    let example = readme.split("```toml\n").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
    let scene = parse(example);
    assert_eq!(scene.camera.focus_distance, 200.0);
    assert_eq!(scene.settings, Settings::default());
    assert_eq!(scene.spheres.len(), 2, "the lamp and the sky");
}

#[test]
fn the_scene_in_the_readme_is_valid() {
    let readme = include_str!("../../README.md");
    let example = readme.split("```toml\n").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
    let scene = parse(example);
    assert_eq!(scene.name, "A glass ball");
    assert_eq!(scene.spheres.len(), 4);
}

#[test]
fn a_file_loads_as_its_text_parses() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plain.toml");
    let nameless = PLAIN.replace("name = \"Plain\"", "");
    std::fs::write(&path, nameless).unwrap();
    assert_eq!(scene_file::load(&path).unwrap(), Scene { name: "plain".into(), ..plain() });
}

/// The texts to be mutated.
fn texts() -> Vec<&'static str> {
    let small = SCENES.iter().filter(|b| b.name != "random").map(|b| b.text);
    small.chain([PLAIN]).collect()
}

/// What a mutation inserts: bytes that have a meaning in TOML or in numbers.
const PIECES: [&[u8]; 26] = [
    b"",
    b"\0",
    b"\n",
    b"\r",
    b"\t",
    b"\"",
    b"'",
    b"[",
    b"]",
    b"{",
    b"}",
    b"=",
    b".",
    b",",
    b"#",
    b"-",
    b"e99",
    b"9999",
    b"nan",
    b"inf",
    b"0",
    b"\xff",
    b"\xe2\x80\xa8",
    b"\xef\xbb\xbf",
    b"[[sphere]]\n",
    b"\"\"\"",
];

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// A mutated file gives either a scene that can be set up for rendering or a one-line error.
    #[test]
    fn a_mutated_file_gives_a_scene_or_an_error(
        text in prop::sample::select(texts()),
        edits in prop::collection::vec((any::<prop::sample::Index>(), 0..4_usize, prop::sample::select(&PIECES[..])), 1..6),
        end in prop::option::weighted(0.2, any::<prop::sample::Index>()),
    ) {
        let mut bytes = text.as_bytes().to_vec();
        for (at, delete, insert) in edits {
            let at = at.index(bytes.len() + 1);
            let end = bytes.len().min(at + delete);
            bytes.splice(at..end, insert.iter().copied());
        }
        if let Some(end) = end {
            bytes.truncate(end.index(bytes.len() + 1));
        }
        let text = String::from_utf8_lossy(&bytes);
        match scene_file::parse("mutated.toml", &text) {
            Ok(scene) => {
                prop_assert!(scene.settings.validate().is_ok());
                prop_assert!(!scene.at(scene.camera.shutter[0]).lights.entries.is_empty());
            }
            Err(error) => {
                let line = error.to_string();
                let position = error.position().unwrap();
                let column = position.column - 1;
                prop_assert!(line.starts_with("mutated.toml:"), "{}", line);
                prop_assert!(!line.chars().any(char::is_control), "{:?}", line);
                prop_assert!(line.len() < 400, "{}", line);
                let in_file = text.split('\n').nth(position.line - 1).is_some_and(|l| column <= l.chars().count());
                prop_assert!(in_file, "{}", line);
            }
        }
    }
}

/// Notes have the place of the lamp, and the line of what hides it.
#[test]
fn lamps_that_light_nothing_are_told_with_their_place() {
    let notes = |more: &str| {
        let text = format!("{PLAIN}{more}");
        let input = (text.as_bytes(), text.len() as u64);
        scene_file::load_from("dir/noted.toml", input, [None; 2], u64::MAX).unwrap().notes
    };
    let core = "\n[[sphere]]\nname = \"core\"\ncenter = [5, 0, 0]\nradius = 1\nmaterial = \"white\"\nemission = [9, 9, 9]\n";
    let shell = "\n[[sphere]]\ncenter = [5, 0, 0]\nradius = 2\nmaterial = \"white\"\n";
    assert!(notes("").is_empty() && notes(core).is_empty());
    assert_eq!(
        notes(&format!("{core}{shell}")),
        [
            "dir/noted.toml:26:12: sphere \"core\" lights nothing: sphere 3 (line 28) is opaque and encloses it"
        ]
    );
}

/// A stage shows its balls from a corner of their cell if one of the files of particles has a cell, wherever it stands.
#[test]
fn one_file_with_a_cell_shows_the_stage_from_a_corner() {
    let folder = tempfile::tempdir().unwrap();
    let atoms = "C 1 2 3\nC 7 3 4\nC 2 8 3.5\n";
    for (name, comment) in [("open", ""), ("cell", "Lattice=\"20 0 0 0 20 0 0 0 20\"")] {
        std::fs::write(folder.path().join(format!("{name}.xyz")), format!("3\n{comment}\n{atoms}")).unwrap();
    }
    let direction = |names: &[&str]| {
        let particles = |name: &&str| format!("[[particles]]\nfile = \"{name}.xyz\"\n");
        let path = folder.path().join("scene.toml");
        std::fs::write(&path, format!("[stage]\n{}", names.iter().map(particles).collect::<String>()))
            .unwrap();
        scene_file::load(&path).unwrap().camera.direction
    };
    let [corner, axis] = [["cell"], ["open"]].map(|names| direction(&names));
    assert_ne!(corner, axis);
    assert_eq!([["cell", "open"], ["open", "cell"]].map(|names| direction(&names)), [corner; 2]);
    assert_eq!(direction(&["open", "open"]), axis);
}

/// So that its scene file, of which images hold a copy, can be read again.
#[test]
fn a_name_from_a_file_is_one_line_of_text() {
    let nameless = PLAIN.replace("name = \"Plain\"", "");
    let scene = scene_file::parse("dir/a\u{7}b.c.toml", &nameless).unwrap();
    assert_eq!(scene.name, "a\\u{7}b.c");
    assert_eq!(parse(&scene_file::to_text(&scene, &scene.settings)), scene);
}

/// Of a file that is too long by itself nothing is read; what is read takes more than its text.
#[test]
fn what_takes_more_memory_than_is_allowed_is_not_read() {
    const MEBIBYTE: u64 = 1 << 20;
    let read = |text: &str, length: u64, most: u64| {
        let loaded = scene_file::load_from("large.toml", (text.as_bytes(), length), [None; 2], most);
        loaded.map(|loaded| loaded.bytes).map_err(|error| error.to_string())
    };
    let told = |bytes: &str| {
        Err(format!("large.toml: takes up to {bytes} MiB to read, more than the limit of 1.0 MiB"))
    };
    assert_eq!(read("", 3 * MEBIBYTE, MEBIBYTE), told("3.0"));
    let comment = "#".repeat(1 << 16);
    assert_eq!(read(&format!("{comment}\n{PLAIN}"), 0, MEBIBYTE), told("3.1"));
    // To the byte.
    let bytes = read(PLAIN, 0, u64::MAX).unwrap();
    assert_eq!(read(PLAIN, 0, bytes), Ok(bytes));
    assert!(read(PLAIN, 0, bytes - 1).unwrap_err().starts_with("large.toml: takes up to "));
}

/// Those of the rules of its style too. Written out again, it makes the same spheres.
#[test]
fn each_key_of_a_file_of_particles_counts_and_is_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let frame = |x: f64| {
        format!(
            "3\nLattice=\"8 0 0 0 8 0 0 0 8\" Properties=species:S:1:pos:R:3:q:R:1\n\
             C 1 1 1 0.1\nO {x} 1 1 0.2\nH 9.5 1 1 0.4\n"
        )
    };
    std::fs::write(folder.path().join("a.xyz"), frame(2.25) + &frame(2.0)).unwrap();
    let name = folder.path().join("scene.toml");
    let read = |keys: &str| {
        let text = format!(
            "background = [1, 1, 1]\n[camera]\neye = [0, 0, 90]\ntarget = [0, 0, 0]\nvertical_fov_degrees = 40\n\
             [[particles]]\nfile = \"a.xyz\"\n{keys}\n"
        );
        scene_file::parse(name.to_str().unwrap(), &text).unwrap_or_else(|error| panic!("{keys}: {error}"))
    };
    let shown = |scene: &Scene| (scene.spheres.clone(), scene.materials.clone());
    let by_charge = read("style = [{ color = \"q\" }]");
    let scenes = [
        "frame = 1",
        "unit = \"nanometre\"",
        "origin = [0.5, 0, 0]",
        "wrap = true",
        "cut = \"x < 3\"",
        "bonds = \"distance\"",
        "cell = true",
        "style = [{ radius = 0.5 }]",
        "style = [{ scale = 2 }]",
        "style = [{ color = \"q\", range = \"0..1\" }]",
        "style = [{ color = \"q\", map = \"grey\" }]",
        "style = [{ material = \"mirror\" }]",
        "style = [{ hide = true, where = \"q < 0.3\" }]",
        "style = [{ hide = true, where = \"q < 0.15\" }]",
    ]
    .map(|keys| (keys, read(keys)));
    let before = [("", read("")), ("by charge", by_charge)];
    let all: Vec<_> = before.iter().chain(&scenes).collect();
    for (i, (keys, scene)) in all.iter().enumerate() {
        assert!(all[..i].iter().all(|(_, other)| shown(other) != shown(scene)), "{keys}");
        let text = scene_file::to_text(scene, &scene.settings);
        assert_eq!(scene_file::parse("again.toml", &text).unwrap(), *scene, "{keys}");
    }
    // A number is the same in any notation.
    assert_eq!(read("frame = 0x1").spheres, scenes[0].1.spheres);
    assert_eq!(read("frame = \"last\"").spheres, scenes[0].1.spheres);
}

/// On a stage all files share an origin, which the first of them states or is the centre of; a later one may state its own.
#[test]
fn files_on_a_stage_share_the_origin_of_the_first() {
    let folder = tempfile::tempdir().unwrap();
    for (name, x) in [("a", 0.0), ("b", 4.0)] {
        let atoms = format!("2\n\nC {x} 0 0\nC {} 2 0\n", x + 1.0);
        std::fs::write(folder.path().join(format!("{name}.xyz")), atoms).unwrap();
    }
    // Where the first atom of each file is.
    let places = |origins: [&str; 3]| {
        let table =
            |(name, origin): (&str, &str)| format!("[[particles]]\nfile = \"{name}.xyz\"\n{origin}\n");
        let path = folder.path().join("scene.toml");
        let tables: String = ["a", "b", "b"].into_iter().zip(origins).map(table).collect();
        std::fs::write(&path, format!("[stage]\n{tables}")).unwrap();
        let scene = scene_file::load(&path).unwrap();
        let first = |import: &scene::Import| scene.spheres[import.spheres.start].center.to_array();
        scene.imports.iter().map(first).collect::<Vec<_>>()
    };
    let stated = "origin = [1, 1, 1]";
    assert_eq!(places(["", "", ""]), [[-0.5, -1.0, 0.0], [3.5, -1.0, 0.0], [3.5, -1.0, 0.0]]);
    assert_eq!(places([stated, "", ""]), [[-1.0, -1.0, -1.0], [3.0, -1.0, -1.0], [3.0, -1.0, -1.0]]);
    assert_eq!(places(["", stated, ""]), [[-0.5, -1.0, 0.0], [3.0, -1.0, -1.0], [3.5, -1.0, 0.0]]);
}
