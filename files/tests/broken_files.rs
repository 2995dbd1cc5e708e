//! Broken scene files: each must give a one-line error with the position of the fault and how to fix it.

#[path = "../../tests/shared/cases.rs"]
mod cases;

use cases::tell;
use files::scene_file;

/// A valid scene, which the tests break.
const BASE: &str = r#"name = "test"
background = [0, 0, 0]
[camera]
eye = [0, 0, 10]
target = [0, 0, 0]
vertical_fov_degrees = 40
[settings]
width = 64
[materials.white]
type = "diffuse"
albedo = [0.5, 0.5, 0.5]
[[sphere]]
name = "lamp"
center = [0, 3, 0]
radius = 1
material = "white"
emission = [1, 1, 1]
[[sphere]]
center = [0, 0, 0]
radius = 1
material = { type = "dielectric", albedo = [1, 1, 1], ior = 1.5 }
"#;

/// Edits of [`BASE`], each of which replaces the first occurrence of a text, and the expected error.
type Case<'a> = (&'a [(&'a str, &'a str)], &'a str);

fn check(cases: &[Case<'_>]) {
    for (edits, expected) in cases {
        expect(&edit(edits), expected);
    }
    tell("broken_files", cases.len(), "broken scene files");
}

fn edit(edits: &[(&str, &str)]) -> String {
    edits.iter().fold(BASE.to_string(), |text, (old, new)| {
        assert!(text.contains(old), "nothing to edit: {old}");
        text.replacen(old, new, 1)
    })
}

fn expect(text: &str, expected: &str) {
    let error = scene_file::parse("dir/broken.toml", text).expect_err(text);
    assert_eq!(error.to_string(), format!("dir/broken.toml:{expected}"), "for\n{text}");
}

#[test]
fn the_base_is_valid() {
    assert_eq!(scene_file::parse("base.toml", BASE).unwrap().spheres.len(), 2);
}

#[test]
fn what_is_at_a_bound_is_within_it() {
    let settings = [
        "width = 1048576\nheight = 256",
        "iterations = 1073741824",
        "photons_per_iteration = 268435456",
        "max_depth = 4096",
        "initial_radius = 1e-15",
        "initial_radius = 1e15",
        "radius_pilots = 4096",
        "radius_clearance = 0.001",
        "radius_clearance = 1000",
        "light_samples = 16",
        "glint_samples = 64",
        "seed = 0",
    ];
    let ball = "center = [0, 0, 0]\nradius = 1";
    let others = [
        ("ior = 1.5", "ior = 1"),
        ("ior = 1.5", "ior = 100"),
        ("emission = [1, 1, 1]", "emission = [1e15, 0, 0]"),
        (ball, "center = [1e15, 0, -1e15]\nradius = 1"),
        (ball, "center = [0, 0, 0]\nradius = 1e-15"),
        (ball, "center = [0, 0, 0]\nradius = 1e15"),
        // An instant on purpose.
        ("target = [0, 0, 0]", "target = [0, 0, 0]\nshutter = [0.5, 0.5]"),
    ];
    for (old, new) in settings.map(|new| ("width = 64", new)).into_iter().chain(others) {
        if let Err(error) = scene_file::parse("bound.toml", &edit(&[(old, new)])) {
            panic!("{new}: {error}");
        }
    }
    // What moves may be shown at that instant.
    let frozen = [
        ("target = [0, 0, 0]", "target = [0, 0, 0]\nshutter = [0.5, 0.5]"),
        ("emission = [1, 1, 1]", "emission = [1, 1, 1]\nvelocity = [1, 0, 0]"),
    ];
    assert!(scene_file::parse("frozen.toml", &edit(&frozen)).is_ok());
}

#[test]
fn invalid_toml() {
    check(SYNTAX);
}

const SYNTAX: &[Case<'static>] = &[
    (&[("eye = [0, 0, 10]", "eye = [0, 0, 10")], "5:1: an array must go on with a comma or end with ] here"),
    (&[("name = \"test\"", "name = \"test")], "1:13: a string must end with \" on the line it begins on"),
    (
        &[("name = \"test\"", "name = test")],
        "1:8: \"test\" is no value; write a number as 1.5, a string as \"...\", an array as [1, 2, 3]",
    ),
    (&[("[camera]", "[camera")], "3:8: this is not TOML: unclosed table; expected `]`"),
    (&[("width = 64", "width =")], "8:8: a value is missing here"),
    (&[("width = 64", "width 64")], "8:7: this is not TOML: key with no value; expected `=`"),
    (&[("width = 64", "width = 064")], "8:9: this is not TOML: unexpected leading zero"),
    (
        &[("width = 64", "width = 64 65")],
        "8:9: \"64 65\" is no value; write a number as 1.5, a string as \"...\", an array as [1, 2, 3]",
    ),
    (
        &[("width = 64", "= 64")],
        "8:1: this is not TOML: unquoted keys cannot be empty; expected letters, numbers, `-`, `_`",
    ),
    (
        &[("name = \"test\"", "name = \"te\\qst\"")],
        "1:12: this is not TOML: missing escaped value; expected `b`, `e`, `f`, `n`, `r`, `\\`, `\"`, `x`, `u`, `U`",
    ),
    (
        &[("radius = 1\nmaterial = \"white\"", "radius = 1\nradius = 2\nmaterial = \"white\"")],
        "16:1: key \"radius\" is given twice; keep one",
    ),
    (&[("[settings]", "[camera]")], "7:2: key \"camera\" is given twice; keep one"),
    (&[("[settings]", "[[camera]]")], "7:3: key \"camera\" is given twice; keep one"),
    (
        &[(
            "[[sphere]]\nname",
            "[materials.white]\ntype = \"specular\"\nalbedo = [1, 1, 1]\n[[sphere]]\nname",
        )],
        "12:12: key \"white\" is given twice; keep one",
    ),
    (&[("[[sphere]]\ncenter", "[sphere]\ncenter")], "18:2: head every sphere with [[sphere]]"),
    (&[("[camera]", "sphere = 1\nsphere = 2\n[camera]")], "4:1: head every sphere with [[sphere]]"),
    (&[("ior = 1.5 }", "ior = 1.5")], "21:64: this is not TOML: unclosed inline table; expected `}`"),
    (&[("ior = 1.5", "ior = 1.5, ior = 2")], "21:66: key \"ior\" is given twice; keep one"),
    (
        &[("eye = [0, 0, 10]", "eye = [0 0 10]")],
        "4:8: \"0 0 10\" is no value; write a number as 1.5, a string as \"...\", an array as [1, 2, 3]",
    ),
    (
        &[("name = \"test\"", "name = \"te\u{1}st\"")],
        "1:11: this is not TOML: invalid basic string; expected non-double-quote visible characters, `\\`",
    ),
    (
        &[("name = \"test\"", "näme = \"test\"")],
        "1:2: this is not TOML: invalid unquoted key; expected letters, numbers, `-`, `_`",
    ),
];

#[test]
fn unknown_and_missing_keys() {
    check(KEYS);
}

const KEYS: &[Case<'static>] = &[
    (
        &[("name = \"test\"", "caption = \"test\"")],
        "1:1: unknown key \"caption\" in the scene; the keys are name, background, transparent_background, camera, stage, settings, materials, sphere, particles",
    ),
    (
        &[("background", "backgruond")],
        "2:1: unknown key \"backgruond\" in the scene (did you mean \"background\"?); the keys are name, background, transparent_background, camera, stage, settings, materials, sphere, particles",
    ),
    (
        &[("[[sphere]]\ncenter", "[[spheres]]\ncenter")],
        "18:3: unknown key \"spheres\" in the scene (did you mean \"sphere\"?); the keys are name, background, transparent_background, camera, stage, settings, materials, sphere, particles",
    ),
    (
        &[("[materials.white]", "[material.white]")],
        "9:2: unknown key \"material\" in the scene (did you mean \"materials\"?); the keys are name, background, transparent_background, camera, stage, settings, materials, sphere, particles",
    ),
    (
        &[("vertical_fov_degrees = 40", "fov = 40")],
        "6:1: unknown key \"fov\" in [camera]; the keys are eye, target, direction, up, vertical_fov_degrees, aperture_radius, focus_distance, shutter",
    ),
    (
        &[("width = 64", "Width = 64")],
        "8:1: unknown key \"Width\" in [settings] (did you mean \"width\"?); the keys are width, height, iterations, photons_per_iteration, max_depth, initial_radius, seed, filter, radius_schedule, radius_pilots, radius_clearance, light_samples, glint_samples, quality",
    ),
    (
        &[("width = 64", "radius_clearance = -1")],
        "8:20: radius_clearance -1 of [settings] must be 0, or from 0.001 to 1000",
    ),
    (
        &[("width = 64", "radius_clearance = 1001")],
        "8:20: radius_clearance 1001 of [settings] must be 0, or from 0.001 to 1000",
    ),
    (
        &[("width = 64", "radius_clearance = 1\nradius_schedule = \"global\"")],
        "8:20: radius_clearance is 1, but with radius_schedule global all pixels have the same radius; it must be 0, or radius_schedule per-pixel",
    ),
    (
        &[("width = 64", "glint_samples = 0")],
        "8:17: glint_samples 0 of [settings] must be a whole number from 1 to 64",
    ),
    (
        &[("width = 64", "glint_samples = 65")],
        "8:17: glint_samples 65 of [settings] must be a whole number from 1 to 64",
    ),
    (
        &[("width = 64", "spp = 64")],
        "8:1: unknown key \"spp\" in [settings]; the keys are width, height, iterations, photons_per_iteration, max_depth, initial_radius, seed, filter, radius_schedule, radius_pilots, radius_clearance, light_samples, glint_samples, quality",
    ),
    // The nearest of several that are near, and the first in the file.
    (
        &[("width = 64", "radius_pilot = 1")],
        "8:1: unknown key \"radius_pilot\" in [settings] (did you mean \"radius_pilots\"?); the keys are width, height, iterations, photons_per_iteration, max_depth, initial_radius, seed, filter, radius_schedule, radius_pilots, radius_clearance, light_samples, glint_samples, quality",
    ),
    (
        &[("width = 64", "zzz = 1\nalpha = 2")],
        "8:1: unknown key \"zzz\" in [settings]; the keys are width, height, iterations, photons_per_iteration, max_depth, initial_radius, seed, filter, radius_schedule, radius_pilots, radius_clearance, light_samples, glint_samples, quality",
    ),
    (
        &[("type = \"diffuse\"\n", "type = \"diffuse\"\ncolour = 1\n")],
        "11:1: unknown key \"colour\" in material \"white\"; the keys are type, albedo, ior",
    ),
    (
        &[("center = [0, 0, 0]\nradius = 1", "center = [0, 0, 0]\nradius = 1\nradios = 2")],
        "21:1: unknown key \"radios\" in sphere 2 (did you mean \"radius\"?); the keys are name, center, radius, material, emission, velocity",
    ),
    (
        &[("center = [0, 0, 0]\nradius = 1", "center = [0, 0, 0]\nradius = 1\nalbedo = [1, 1, 1]")],
        "21:1: unknown key \"albedo\" in sphere 2; the keys are name, center, radius, material, emission, velocity",
    ),
    (
        &[("center = [0, 0, 0]\nradius = 1", "center = [0, 0, 0]\nradius = 1\n\"\\u0007ä\" = 2")],
        "21:1: unknown key \"\\u{7}ä\" in sphere 2; the keys are name, center, radius, material, emission, velocity",
    ),
    (
        &[("ior = 1.5", "ior = 1.5, rough = 1")],
        "21:66: unknown key \"rough\" in the material of sphere 2; the keys are type, albedo, ior",
    ),
    (
        &[("vertical_fov_degrees = 40", "")],
        "3:1: [camera] has no vertical_fov_degrees; add vertical_fov_degrees = 30, say",
    ),
    (
        &[("target = [0, 0, 0]\n", "")],
        "3:1: [camera] has no target; add target = [x, y, z], or direction = [x, y, z]",
    ),
    (&[("eye = [0, 0, 10]\n", "")], "3:1: [camera] has no eye; add eye = [x, y, z]"),
    (
        &[("type = \"diffuse\"\n", "")],
        "9:1: material \"white\" has no type; add type = \"diffuse\", \"specular\" or \"dielectric\"",
    ),
    (
        &[("albedo = [0.5, 0.5, 0.5]\n", "")],
        "9:1: material \"white\" has no albedo; add albedo = [red, green, blue]",
    ),
    (&[(", ior = 1.5", "")], "21:12: the material of sphere 2 has no ior; add ior = 1.5, say"),
    (&[("center = [0, 3, 0]\n", "")], "12:1: sphere \"lamp\" has no center; add center = [x, y, z]"),
    (&[("radius = 1\n", "")], "12:1: sphere \"lamp\" has no radius; add radius = 1, say"),
    (&[("material = \"white\"\n", "")], "12:1: sphere \"lamp\" has no material; add material = \"NAME\""),
];

#[test]
fn wrong_types_and_lengths() {
    check(TYPES);
}

const TYPES: &[Case<'static>] = &[
    (&[("name = \"test\"", "name = 7")], "1:8: name of the scene must be a string, not a number"),
    (
        &[("name = \"test\"", "name = \"a\\nb\"")],
        "1:8: name \"a\\nb\" of the scene has a control character or line break; a name is one line of text",
    ),
    (
        &[("name = \"lamp\"", "name = \"a\\nb\"")],
        "13:8: name \"a\\nb\" of sphere \"a\\nb\" has a control character or line break; a name is one line of text",
    ),
    (
        &[("background = [0, 0, 0]", "background = 0")],
        "2:14: background of the scene must be 3 numbers, [red, green, blue], not a number",
    ),
    (
        &[("background = [0, 0, 0]", "background = [0, 0]")],
        "2:14: background of the scene has 2 elements; it must have 3, [red, green, blue]",
    ),
    (
        &[("eye = [0, 0, 10]", "eye = [0, 0, \"10\"]")],
        "4:14: each in eye of [camera] must be a number, not a string",
    ),
    (
        &[("eye = [0, 0, 10]", "eye = [0, 0, 10, 0]")],
        "4:7: eye of [camera] has 4 elements; it must have 3, [x, y, z]",
    ),
    (
        &[("eye = [0, 0, 10]", "eye = \"origin\"")],
        "4:7: eye of [camera] must be 3 numbers, [x, y, z], not a string",
    ),
    (
        &[("eye = [0, 0, 10]", "eye = {x = 0, y = 0, z = 10}")],
        "4:7: eye of [camera] must be 3 numbers, [x, y, z], not a table",
    ),
    (
        &[("vertical_fov_degrees = 40", "vertical_fov_degrees = true")],
        "6:24: vertical_fov_degrees of [camera] must be a number, not true or false",
    ),
    (
        &[("vertical_fov_degrees = 40", "vertical_fov_degrees = 1979-05-27")],
        "6:24: vertical_fov_degrees of [camera] must be a number, not a date or time",
    ),
    (
        &[("[[sphere]]\ncenter", "[[sphere]]\nname = [1]\ncenter")],
        "19:8: name of sphere 2 must be a string, not an array",
    ),
    (
        &[("width = 64", "width = 64.5")],
        "8:9: width 64.5 of [settings] must be a whole number from 1 to 1048576",
    ),
    (&[("width = 64", "width = \"64\"")], "8:9: width of [settings] must be a whole number, not a string"),
    (
        &[("width = 64", "width = 64\ninitial_radius = \"2\"")],
        "9:18: initial_radius of [settings] must be a number, not a string",
    ),
    (
        &[("material = \"white\"", "material = 3")],
        "16:12: material of sphere \"lamp\" must be a name or a table, for example { type = \"diffuse\", albedo = [0.5, 0.5, 0.5] }, not a number",
    ),
    (
        &[("material = \"white\"", "material = [\"white\"]")],
        "16:12: material of sphere \"lamp\" must be a name or a table, for example { type = \"diffuse\", albedo = [0.5, 0.5, 0.5] }, not an array",
    ),
    (
        &[("type = \"diffuse\"\n", "type = 1\n")],
        "10:8: type of material \"white\" must be a string, not a number",
    ),
    (
        &[("emission = [1, 1, 1]", "emission = 1")],
        "17:12: emission of sphere \"lamp\" must be 3 numbers, [red, green, blue], not a number",
    ),
    (
        &[("[settings]\nwidth = 64\n[materials.white]\n", "[materials]\n")],
        "9:10: material \"albedo\" must be a table, for example { type = \"diffuse\", albedo = [0.5, 0.5, 0.5] }, not an array",
    ),
];

#[test]
fn numbers_out_of_range() {
    check(NUMBERS);
}

const NUMBERS: &[Case<'static>] = &[
    (
        &[("radius = 1\n", "radius = 0\n")],
        "15:10: radius 0 of sphere \"lamp\" must be above 0 (from 1e-15 to 1e15)",
    ),
    (
        &[("radius = 1\n", "radius = -3\n")],
        "15:10: radius -3 of sphere \"lamp\" must be above 0 (from 1e-15 to 1e15)",
    ),
    (
        &[("radius = 1\n", "radius = nan\n")],
        "15:10: radius nan of sphere \"lamp\" must be above 0 (from 1e-15 to 1e15)",
    ),
    (
        &[("radius = 1\n", "radius = inf\n")],
        "15:10: radius inf of sphere \"lamp\" must be above 0 (from 1e-15 to 1e15)",
    ),
    (
        &[("radius = 1\n", "radius = 1e999\n")],
        "15:10: radius 1e999 of sphere \"lamp\" must be above 0 (from 1e-15 to 1e15)",
    ),
    (
        &[("radius = 1\n", "radius = 1e20\n")],
        "15:10: radius 1e20 of sphere \"lamp\" must be above 0 (from 1e-15 to 1e15)",
    ),
    (
        &[("radius = 1\n", "radius = 1e-50\n")],
        "15:10: radius 1e-50 of sphere \"lamp\" must be above 0 (from 1e-15 to 1e15)",
    ),
    (
        &[(
            "radius = 1\n",
            "radius = 9999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999\n",
        )],
        "15:10: radius 9999999999999999999999999999999999999999... of sphere \"lamp\" must be above 0 (from 1e-15 to 1e15)",
    ),
    (
        &[("radius = 1\n", "radius = 0xffffffffffffffffffff\n")],
        "15:10: radius 0xffffffffffffffffffff of sphere \"lamp\" must be above 0 (from 1e-15 to 1e15)",
    ),
    (
        &[("center = [0, 3, 0]", "center = [0, -inf, 0]")],
        "14:14: center -inf of sphere \"lamp\" must be a finite number from -1e15 to 1e15",
    ),
    (
        &[("center = [0, 3, 0]", "center = [2e15, 3, 0]")],
        "14:11: center 2e15 of sphere \"lamp\" must be a finite number from -1e15 to 1e15",
    ),
    (
        &[("center = [0, 3, 0]", "center = [0, 3, +nan]")],
        "14:17: center +nan of sphere \"lamp\" must be a finite number from -1e15 to 1e15",
    ),
    (&[("[0.5, 0.5, 0.5]", "[0.5, 1.5, 0.5]")], "11:16: albedo 1.5 of material \"white\" is outside [0, 1]"),
    (
        &[("[0.5, 0.5, 0.5]", "[0.5, 0.5, -0.1]")],
        "11:21: albedo -0.1 of material \"white\" is outside [0, 1]",
    ),
    (&[("[0.5, 0.5, 0.5]", "[nan, 0.5, 0.5]")], "11:11: albedo nan of material \"white\" is outside [0, 1]"),
    (
        &[("albedo = [1, 1, 1]", "albedo = [1, 2, 1]")],
        "21:48: albedo 2 of the material of sphere 2 is outside [0, 1]",
    ),
    (
        &[("material = \"white\"", "material = { type = \"diffuse\", albedo = [2, 0, 0] }")],
        "16:42: albedo 2 of the material of sphere \"lamp\" is outside [0, 1]",
    ),
    (
        &[("emission = [1, 1, 1]", "emission = [1, -1, 1]")],
        "17:16: emission -1 of sphere \"lamp\" is outside [0, 1e15]",
    ),
    (
        &[("emission = [1, 1, 1]", "emission = [1, 1, inf]")],
        "17:19: emission inf of sphere \"lamp\" is outside [0, 1e15]",
    ),
    (
        &[("background = [0, 0, 0]", "background = [0, 0, -1]")],
        "2:21: background -1 of the scene is outside [0, 1e15]",
    ),
    (
        &[("ior = 1.5", "ior = 0.9")],
        "21:61: ior 0.9 of the material of sphere 2 must be a number from 1 to 100; glass has 1.5",
    ),
    (
        &[("ior = 1.5", "ior = nan")],
        "21:61: ior nan of the material of sphere 2 must be a number from 1 to 100; glass has 1.5",
    ),
    (
        &[("type = \"diffuse\"\n", "type = \"diffuse\"\nior = 1.5\n")],
        "11:7: ior 1.5 of material \"white\" has no meaning for type \"diffuse\", only for \"dielectric\"",
    ),
    (
        &[("type = \"diffuse\"", "type = \"difuse\"")],
        "10:8: type \"difuse\" of material \"white\" is unknown (did you mean \"diffuse\"?); the types are diffuse, specular, dielectric",
    ),
    (
        &[("type = \"diffuse\"", "type = \"plastic\"")],
        "10:8: type \"plastic\" of material \"white\" is unknown; the types are diffuse, specular, dielectric",
    ),
    (&[("width = 64", "width = 0")], "8:9: width 0 of [settings] must be a whole number from 1 to 1048576"),
    (&[("width = 64", "width = -1")], "8:9: width -1 of [settings] must be a whole number from 1 to 1048576"),
    (
        &[("width = 64", "width = 1000000000000")],
        "8:9: width 1000000000000 of [settings] must be a whole number from 1 to 1048576",
    ),
    (
        &[("width = 64", "width = 1000000\nheight = 1000000")],
        "8:9: width 1000000 x height 1000000 is 1000000000000 pixels and would need 238418.6 GiB; at most 268435456 pixels are rendered",
    ),
    (
        &[("width = 64", "photons_per_iteration = 1099511627776")],
        "8:25: photons_per_iteration 1099511627776 of [settings] must be a whole number from 1 to 268435456",
    ),
    (
        &[("width = 64", "photons_per_iteration = 200000000\nmax_depth = 4096")],
        "8:25: photons_per_iteration 200000000 x max_depth 4096 must stay below 2147483648 photon segments; ask for more iterations instead",
    ),
    (
        &[("width = 64", "initial_radius = 0")],
        "8:18: initial_radius 0 of [settings] must be above 0 (from 1e-15 to 1e15)",
    ),
    (
        &[("width = 64", "seed = -1")],
        "8:8: seed -1 of [settings] must be a whole number from 0 to 18446744073709551615",
    ),
    (
        &[("width = 64", "seed = 18446744073709551616")],
        "8:8: seed 18446744073709551616 of [settings] must be a whole number from 0 to 18446744073709551615",
    ),
    (
        &[("width = 64", "max_depth = 0")],
        "8:13: max_depth 0 of [settings] must be a whole number from 1 to 4096",
    ),
    (
        &[("width = 64", "iterations = 0")],
        "8:14: iterations 0 of [settings] must be a whole number from 1 to 1073741824",
    ),
    (
        &[("width = 64", "light_samples = 0")],
        "8:17: light_samples 0 of [settings] must be a whole number from 1 to 16",
    ),
    (
        &[("width = 64", "light_samples = 17")],
        "8:17: light_samples 17 of [settings] must be a whole number from 1 to 16",
    ),
    (
        &[("width = 64", "radius_pilots = 4097")],
        "8:17: radius_pilots 4097 of [settings] must be a whole number from 0 to 4096",
    ),
    (
        &[("width = 64", "height = 600000\n\nwidth = 600000")],
        "10:9: width 600000 x height 600000 is 360000000000 pixels and would need 85830.7 GiB; at most 268435456 pixels are rendered",
    ),
    (
        &[("target = [0, 0, 0]", "target = [0, 0, 10]")],
        "5:10: target of [camera] is where eye is; it must be elsewhere",
    ),
    (&[("target", "direction")], "5:13: direction of [camera] is zero; it must point somewhere"),
    (
        &[("target = [0, 0, 0]", "target = [0, 0, 0]\ndirection = [0, 0, -1]")],
        "6:13: [camera] has both target and direction; it must have one of them",
    ),
    (
        &[("target = [0, 0, 0]", "direction = [0, 0, -1]\ntarget = [0, 0, 0]")],
        "6:10: [camera] has both target and direction; it must have one of them",
    ),
    (
        &[("target = [0, 0, 0]", "target = [0, 9, 10]")],
        "5:10: up (by default [0, 1, 0]) of [camera] is parallel to the viewing direction; take another, say [0, 0, 1]",
    ),
    (
        &[("target = [0, 0, 0]", "target = [0, 0, 0]\nup = [0, 0, 2]")],
        "6:6: up of [camera] is parallel to the viewing direction; take another, say [0, 0, 1]",
    ),
    (
        &[("target = [0, 0, 0]", "target = [0, 0, 0]\nup = [0, 0, 0]")],
        "6:6: up of [camera] is zero; it must point somewhere",
    ),
    (
        &[("vertical_fov_degrees = 40", "vertical_fov_degrees = 0")],
        "6:24: vertical_fov_degrees 0 of [camera] is outside (0, 180)",
    ),
    (
        &[("vertical_fov_degrees = 40", "vertical_fov_degrees = 180")],
        "6:24: vertical_fov_degrees 180 of [camera] is outside (0, 180)",
    ),
    (
        &[("vertical_fov_degrees = 40", "vertical_fov_degrees = -30")],
        "6:24: vertical_fov_degrees -30 of [camera] is outside (0, 180)",
    ),
    (
        &[("vertical_fov_degrees = 40", "vertical_fov_degrees = 40\naperture_radius = -1")],
        "7:19: aperture_radius -1 of [camera] must be a finite number, at least 0; 0 is a pinhole",
    ),
    (
        &[("vertical_fov_degrees = 40", "vertical_fov_degrees = 40\nfocus_distance = 0")],
        "7:18: focus_distance 0 of [camera] must be a finite number above 0, the distance from the eye",
    ),
    (
        &[("target = [0, 0, 0]", "direction = [0, 0, -1]\naperture_radius = 1")],
        "6:19: [camera] has an aperture_radius but no focus_distance; add focus_distance = 100, say, or a target",
    ),
    (
        &[("vertical_fov_degrees = 40", "vertical_fov_degrees = 40\nshutter = [1, 0]")],
        "7:15: shutter 0 of [camera] closes before the shutter opens at 1",
    ),
    (
        &[("vertical_fov_degrees = 40", "vertical_fov_degrees = 40\nshutter = 1")],
        "7:11: shutter of [camera] must be 2 numbers, [open, close], not a number",
    ),
    (
        &[("vertical_fov_degrees = 40", "vertical_fov_degrees = 40\nshutter = [0, nan]")],
        "7:15: shutter nan of [camera] must be a finite number from -1e15 to 1e15",
    ),
    (
        &[("vertical_fov_degrees = 40", "vertical_fov_degrees = 40\nshutter = [nan, 1]")],
        "7:12: shutter nan of [camera] must be a finite number from -1e15 to 1e15",
    ),
];

#[test]
fn faults_of_the_whole_scene() {
    check(WHOLE);
}

/// Puts a material in the place of a question mark.
const GREY: (&str, &str) = ("= ?", "= { type = \"diffuse\", albedo = [0, 0, 0] }");

const WHOLE: &[Case<'static>] = &[
    (
        &[("material = \"white\"", "material = \"whit\"")],
        "16:12: unknown material \"whit\" of sphere \"lamp\" (did you mean \"white\"?); there is \"white\"",
    ),
    // The most similar of all, though only the first eight are listed.
    (
        &[
            (
                "[materials.white]",
                "[materials]\nm1 = ?\nm2 = ?\nm3 = ?\nm4 = ?\nm5 = ?\nm6 = ?\nm7 = ?\nm8 = ?\n[materials.white]",
            ),
            GREY,
            GREY,
            GREY,
            GREY,
            GREY,
            GREY,
            GREY,
            GREY,
            ("material = \"white\"", "material = \"whit\""),
        ],
        "25:12: unknown material \"whit\" of sphere \"lamp\" (did you mean \"white\"?); there is \"m1\", \"m2\", \"m3\", \"m4\", \"m5\", \"m6\", \"m7\", \"m8\", ...",
    ),
    (
        &[
            (
                "[materials.white]",
                "[materials]\nm1 = ?\nm2 = ?\nm3 = ?\nm4 = ?\nm5 = ?\nm6 = ?\nm7 = ?\n[materials.white]",
            ),
            GREY,
            GREY,
            GREY,
            GREY,
            GREY,
            GREY,
            GREY,
            ("material = \"white\"", "material = \"gold\""),
        ],
        "24:12: unknown material \"gold\" of sphere \"lamp\"; there is \"m1\", \"m2\", \"m3\", \"m4\", \"m5\", \"m6\", \"m7\", \"white\"",
    ),
    (
        &[("[materials.white]\ntype = \"diffuse\"\nalbedo = [0.5, 0.5, 0.5]\n", "")],
        "13:12: unknown material \"white\" of sphere \"lamp\"; write [materials.NAME] and use that name, or write the material here, for example { type = \"diffuse\", albedo = [0.5, 0.5, 0.5] }",
    ),
    (
        &[("material = \"white\"", "material = \"gold\"")],
        "16:12: unknown material \"gold\" of sphere \"lamp\"; there is \"white\"",
    ),
    (
        &[("material = \"white\"", "material = \"diffuse\"")],
        "16:12: unknown material \"diffuse\" of sphere \"lamp\"; a type alone is none, write { type = \"diffuse\", albedo = [...] }",
    ),
    (
        &[("emission = [1, 1, 1]", "")],
        "2:14: there is no light; give a sphere an emission = [r, g, b], or the scene a background",
    ),
    (
        &[("emission = [1, 1, 1]\n", ""), ("background = [0, 0, 0]\n", "")],
        "11:1: there is no light; give a sphere an emission = [r, g, b], or the scene a background",
    ),
    (
        &[("emission = [1, 1, 1]", "emission = [0, 0, 0]")],
        "2:14: there is no light; give a sphere an emission = [r, g, b], or the scene a background",
    ),
    (
        &[("emission = [1, 1, 1]", "emission = [1, 1, 1]\nvelocity = [1, 0, 0]")],
        "18:12: sphere \"lamp\" moves, but [camera] has no shutter; add shutter = [0, 1] there",
    ),
    (
        &[
            ("emission = [1, 1, 1]", "emission = [1e15, 0, 0]"),
            ("radius = 1\nmaterial = \"white\"", "radius = 1e12\nmaterial = \"white\""),
            ("center = [0, 3, 0]", "center = [0, 3e12, 0]"),
        ],
        "17:12: the power of all lights, the sum of 4 (pi radius)^2 emission, is beyond the range of a 32-bit float; take another unit for emission or for length",
    ),
    (
        &[
            ("vertical_fov_degrees = 40", "vertical_fov_degrees = 40\nshutter = [0, 1]"),
            ("emission = [1, 1, 1]", "emission = [1, 1, 1]\nvelocity = [6e14, 0, 0]"),
            ("shutter = [0, 1]", "shutter = [0, 2]"),
            ("center = [0, 3, 0]", "center = [1, 3, 0]"),
        ],
        "19:12: velocity of sphere \"lamp\" takes it beyond 1e15 while the shutter is open",
    ),
    (
        &[
            ("center = [0, 0, 0]\nradius = 1", "center = [0, 0, 11]\nradius = 1"),
            ("{ type = \"dielectric\", albedo = [1, 1, 1], ior = 1.5 }", "\"white\""),
        ],
        "4:7: eye of [camera] lies on the surface of sphere 2 (line 18); it must lie clearly inside or outside of an opaque sphere",
    ),
    (
        &[
            ("vertical_fov_degrees = 40", "vertical_fov_degrees = 40\naperture_radius = 2.5"),
            ("center = [0, 3, 0]", "center = [0, 3, 10]"),
        ],
        "7:19: the lens, 2.5 around eye, cuts through sphere \"lamp\" (line 13); it must lie clearly inside or outside of an opaque sphere",
    ),
    (
        &[
            ("vertical_fov_degrees = 40", "vertical_fov_degrees = 40\nshutter = [0, 1]"),
            ("center = [0, 0, 0]\nradius = 1", "center = [5, 0, 10]\nradius = 1\nvelocity = [-10, 0, 0]"),
            ("{ type = \"dielectric\", albedo = [1, 1, 1], ior = 1.5 }", "\"white\""),
        ],
        "22:12: sphere 2 (line 19) passes over the eye while the shutter is open; keep it clear of the eye",
    ),
    (
        &[
            ("center = [0, 0, 0]\nradius = 1", "center = [0, 3, 0]\nradius = 2"),
            ("{ type = \"dielectric\", albedo = [1, 1, 1], ior = 1.5 }", "\"white\""),
        ],
        "17:12: no light reaches the eye: sphere 2 (line 18) encloses sphere \"lamp\"; put a light into the space that the eye is in",
    ),
    (
        &[
            ("vertical_fov_degrees = 40", "vertical_fov_degrees = 40\nshutter = [0, 1]"),
            ("emission = [1, 1, 1]", "emission = [1, 1, 1]\nvelocity = [0, -3, 0]"),
            ("center = [0, 0, 0]\nradius = 1", "center = [0, 0, 0]\nradius = 2"),
            ("{ type = \"dielectric\", albedo = [1, 1, 1], ior = 1.5 }", "\"white\""),
        ],
        "18:12: no light reaches the eye: sphere 2 (line 20) encloses sphere \"lamp\"; put a light into the space that the eye is in",
    ),
    (
        &[(
            "[[sphere]]\nname = \"lamp\"",
            "[[sphere]]\ncenter = [0, 3, 0]\nradius = 1\nmaterial = \"white\"\n\
              [[sphere]]\nname = \"lamp\"",
        )],
        "21:12: no light reaches the eye: sphere 1 (line 12) is opaque and lies exactly where sphere \"lamp\" does; remove one",
    ),
    (
        &[
            ("emission = [1, 1, 1]", ""),
            ("center = [0, 0, 0]\nradius = 1", "center = [0, 0, 0]\nradius = 50"),
            ("background = [0, 0, 0]", "background = [1, 1, 1]"),
            ("{ type = \"dielectric\", albedo = [1, 1, 1], ior = 1.5 }", "\"white\""),
        ],
        "2:14: no light reaches the eye: sphere 2 (line 18) encloses the eye and no light; put a light into the space that the eye is in",
    ),
    (
        &[("[[sphere]]\ncenter", "[[sphere]]\nname = \"äöὠ0\"\nvelocity = [0, 0, \"fast\"]\ncenter")],
        "20:19: each in velocity of sphere \"äöὠ0\" must be a number, not a string",
    ),
    (
        &[("width = 64", "filter = \"gauss\"")],
        "8:10: filter \"gauss\" of [settings] is unknown (did you mean \"gaussian\"?); the filters are box, gaussian, mitchell",
    ),
    (
        &[("width = 64", "radius_schedule = \"globe\"")],
        "8:19: radius_schedule \"globe\" of [settings] is unknown (did you mean \"global\"?); the schedules are per-pixel, global",
    ),
    (
        &[("material = \"white\"", "material = \"\\u001b[31mred\\n\"")],
        "16:12: unknown material \"\\u{1b}[31mred\\n\" of sphere \"lamp\"; there is \"white\"",
    ),
];

#[test]
fn files_that_are_far_from_a_scene() {
    for (text, expected) in [
        ("", "1:1: there is no scene here; it takes a [camera], a [[sphere]] and a light"),
        ("# nothing", "1:1: there is no scene here; it takes a [camera], a [[sphere]] and a light"),
        ("\u{feff}", "1:1: there is no scene here; it takes a [camera], a [[sphere]] and a light"),
        (
            "sphere = []\n[camera]\neye=[0,0,1]\ntarget=[0,0,0]\nvertical_fov_degrees=9\n",
            "1:10: sphere is empty; head every sphere with [[sphere]]",
        ),
        (
            "[camera]\neye=[0,0,1]\ntarget=[0,0,0]\nvertical_fov_degrees=9\n",
            "1:1: the scene has no sphere; add [[sphere]] with center, radius and material",
        ),
        (
            "sphere = 3\n[camera]\neye=[0,0,1]\ntarget=[0,0,0]\nvertical_fov_degrees=9\n",
            "1:10: sphere must be an array of tables, not a number; head every sphere with [[sphere]]",
        ),
        (
            "sphere = [3]\n[camera]\neye=[0,0,1]\ntarget=[0,0,0]\nvertical_fov_degrees=9\n",
            "1:11: sphere 1 must be a table, [[sphere]], not a number",
        ),
        ("camera = 3", "1:10: camera must be a table, [camera], not a number"),
        ("name = \"x\"", "1:1: the scene has no camera; add [camera]"),
        ("\u{feff}camera = 3", "1:10: camera must be a table, [camera], not a number"),
        ("\r\n\r\n# ä\r\ncamera = \"ä\"\r\n", "4:10: camera must be a table, [camera], not a string"),
        ("\u{0}", "1:2: this is not TOML: key with no value; expected `=`"),
        ("PNG\u{1a}\u{0} ", "1:7: this is not TOML: key with no value; expected `=`"),
        (
            "name = \"a\"\rcamera = 1",
            "1:12: this is not TOML: carriage return must be followed by newline; expected newline",
        ),
        ("camera = []", "1:10: camera must be a table, [camera], not an array"),
        (
            "[camera]\neye=[0,0,1]\ntarget=[0,0,0]\nvertical_fov_degrees=9\n[sphere]\nradius=1",
            "5:1: sphere must be an array of tables, not one table; head every sphere with [[sphere]]",
        ),
        (
            "settings = 1\n[camera]\neye=[0,0,1]\ntarget=[0,0,0]\nvertical_fov_degrees=9\n",
            "1:12: settings must be a table, [settings], not a number",
        ),
        (
            "materials = 1\n[camera]\neye=[0,0,1]\ntarget=[0,0,0]\nvertical_fov_degrees=9\n",
            "1:13: materials must be a table for each material, [materials.NAME], not a number",
        ),
        (
            "materials.white = \"diffuse\"\n[camera]\neye=[0,0,1]\ntarget=[0,0,0]\nvertical_fov_degrees=9\n",
            "1:19: material \"white\" must be a table, for example { type = \"diffuse\", albedo = [0.5, 0.5, 0.5] }, not a string",
        ),
        ("{\"name\": \"Cornell Box\"}", "1:1: this is not TOML: invalid key-value pair; expected key"),
        (
            "[camera]\neye=[0,0,1]\ntarget=[0,0,0]\nvertical_fov_degrees=9\n[[sphere]]\ncenter=[0,0,0]\nradius=0.5\nmaterial={type=\"specular\", albedo=[1,1,1]}\n",
            "5:1: there is no light; give a sphere an emission = [r, g, b], or the scene a background",
        ),
    ] {
        expect(text, expected);
    }
}

/// The head is read as one text, but its tables may stand between and behind the spheres.
#[test]
fn tables_behind_the_spheres_have_their_places() {
    let settings = "[settings]\nwidth = 64\n";
    let camera = &BASE[BASE.find("[camera]").unwrap()..BASE.find(settings).unwrap()];
    let behind = |table: &str, new: &str| edit(&[(table, "")]) + new;
    for (text, expected) in [
        (
            behind(settings, "[settings]\nwidth = 0\n"),
            "21:9: width 0 of [settings] must be a whole number from 1 to 1048576",
        ),
        (behind("", "[settings]\n"), "22:2: key \"settings\" is given twice; keep one"),
        (
            behind(camera, &camera.replace("eye = [0, 0, 10]", "eye = [0.6, 3.8, 0]")),
            "19:7: eye of [camera] lies on the surface of sphere \"lamp\" (line 8); it must lie clearly inside or \
             outside of an opaque sphere",
        ),
        (
            behind("", "[materials]\nred = 3\n"),
            "23:7: material \"red\" must be a table, for example { type = \"diffuse\", albedo = [0.5, 0.5, 0.5] }, \
             not a number",
        ),
        // It is none of a sphere's own any more.
        (
            behind("", "[materials.red]\ntype = \"diffuse\"\nalbedo = [1, 0, 0]\n[sphere.material]\n"),
            "25:2: head every sphere with [[sphere]]",
        ),
    ] {
        expect(&text, expected);
    }
}

/// Those of an array as well.
#[test]
fn spheres_are_told_by_their_number_and_place() {
    let ball = "material = { type = \"diffuse\", albedo = [1, 1, 1] }";
    let array = format!(
        "sphere = [{{ center = [0, 3, 0], radius = 1, {ball}, emission = [1, 1, 1] }},\n\
         {{ velocity = [1, 0, 0], center = [0, 0, 0], radius = 1, {ball} }}]\n\
         [camera]\neye = [0, 0, 10]\ntarget = [0, 0, 0]\nvertical_fov_degrees = 40\n"
    );
    expect(&array, "2:14: sphere 2 moves, but [camera] has no shutter; add shutter = [0, 1] there");
    expect(&edit(&[("name = \"test\"", "sphere = []")]), "1:1: head every sphere with [[sphere]]");
}

/// Each by the headers that it needs.
#[test]
fn tables_of_particles_are_told_at_their_places() {
    let file = "[[particles]]\nfile = \"none.xyz\"\n";
    let end = "column 4: this ends where a column, a number or a text is needed";
    for (tail, expected) in [
        (
            "[particles]\nfile = \"none.xyz\"\n".to_owned(),
            "22:1: \"particles\" must be an array of tables; head each with [[particles]]".to_owned(),
        ),
        (
            "[[particles]]\n".into(),
            "22:1: [[particles]] has no file; add file = \"water.pdb\", say".into(),
        ),
        // It is searched where the scene file is.
        (file.to_owned(), "23:8: dir/none.xyz: there is no such file".into()),
        (
            format!("{file}radius = 1\n"),
            "24:1: unknown key \"radius\" in [[particles]]; the keys are file, digest, frame, unit, origin, wrap, cut, \
             bonds, cell, style"
                .into(),
        ),
        (
            format!("{file}frame = -1\n"),
            "24:9: frame of [[particles]]: `-1` must be the number of a frame, from 0, or last".into(),
        ),
        (format!("{file}digest = 3\n"), "24:10: digest of [[particles]] must be a string, not a number".into()),
        (format!("{file}cut = [\"x < 3\", \"y <\"]\n"), format!("24:17: cut of [[particles]]: {end}")),
        (
            format!("{file}[particles.style]\ncolor = \"red\"\n"),
            "24:1: \"style\" must be an array of tables; head each with [[particles.style]]".into(),
        ),
        (
            format!("{file}[[particles.style]]\ncolour = \"red\"\n"),
            "25:1: unknown key \"colour\" in [[particles.style]] (did you mean \"color\"?); the keys are where, radius, \
             scale, color, map, range, material, hide"
                .into(),
        ),
        (
            format!("{file}[[particles.style]]\ncolor = \"red\"\n[[particles.style]]\nwhere = \"z >\"\n"),
            format!("27:9: where of [[particles.style]]: {end}"),
        ),
    ] {
        expect(&format!("{BASE}{tail}"), &expected);
    }
    expect(&format!("particles = [3]\n{BASE}"), "1:14: [[particles]] must be a table, not a number");
}

/// What a stage decides is not said again beside it.
#[test]
fn stages_are_told_at_their_places() {
    let ball =
        "[[sphere]]\ncenter = [0, 0, 0]\nradius = 1\nmaterial = { type = \"diffuse\", albedo = [1, 1, 1] }\n";
    let twice =
        |key: &str| format!("a scene with a [stage] has its {key} from that; leave out one of the two");
    for (head, expected) in [
        ("stage = 3", "1:9: stage of the scene must be a table, not a number".to_owned()),
        ("[stage]\nzoom = 0", "2:8: zoom 0 of [stage] is outside [0.1, 1000]".into()),
        (
            "[stage]\nlight = \"dim\"",
            "2:9: light \"dim\" of [stage] is unknown; the lights are studio, overcast, dark".into(),
        ),
        (
            "[stage]\nvieww = 3",
            "2:1: unknown key \"vieww\" in [stage] (did you mean \"view\"?); the keys are view, zoom, light, ground, \
             background"
                .into(),
        ),
        ("[stage]\n[camera]\neye = [0, 0, 9]", format!("2:1: {}", twice("camera"))),
        ("background = [1, 1, 1]\n[stage]", format!("1:14: {}", twice("background"))),
        ("transparent_background = true\n[stage]", format!("1:26: {}", twice("transparent_background"))),
    ] {
        expect(&format!("{head}\n{ball}"), &expected);
    }
}

/// A stage has no shutter: what is said to move would stand still there.
#[test]
fn what_moves_needs_a_camera_of_its_own() {
    let text = "[stage]\n[[sphere]]\ncenter = [0, 0, 0]\nradius = 1\nvelocity = [1, 0, 0]\n\
        material = { type = \"diffuse\", albedo = [1, 1, 1] }\n";
    scene_file::parse("still.toml", &text.replace("velocity = [1, 0, 0]\n", "")).unwrap();
    expect(text, "5:12: sphere 1 moves, but [stage] has no shutter; give the scene a [camera] with one");
}

/// What is parsed at once takes many times the memory of its text, so it counts together.
#[test]
fn tables_other_than_spheres_and_materials_are_short_together() {
    let half = "#".repeat((1 << 21) + 1);
    expect(
        &format!("[camera]\n{half}\n[settings]\n{half}\n"),
        "3:1: this takes more than 4194304 bytes; head every sphere with [[sphere]] and every material with \
         [materials.NAME], and shorten comments",
    );
    // And so does each sphere by itself.
    expect(
        &format!("{BASE}{half}{half}"),
        "18:1: this takes more than 4194304 bytes; head every sphere with [[sphere]] and every material with \
         [materials.NAME], and shorten comments",
    );
}

#[test]
fn long_values_and_deep_nesting_give_short_messages() {
    let (deep, dotted) = (format!("eye = {}", "[".repeat(100_000)), format!("a{} = 1", ".a".repeat(100_000)));
    let nested = "tables or arrays are nested too deeply; a scene needs three levels";
    let digits = format!("radius = {}\n", "9".repeat(100_000));
    let key = format!("{} = 1\nwidth", "x".repeat(100_000));
    check(&[
        (&[("eye = [0, 0, 10]", &deep)], &format!("4:87: {nested}")),
        (&[("name = \"test\"", &dotted)], &format!("1:1: {nested}")),
        (
            &[("radius = 1\n", &digits)],
            &format!(
                "15:10: radius {}... of sphere \"lamp\" must be above 0 (from 1e-15 to 1e15)",
                "9".repeat(40)
            ),
        ),
        (
            &[("width", &key)],
            &format!(
                "8:1: unknown key \"{}...\" in [settings]; the keys are width, height, iterations, \
                 photons_per_iteration, max_depth, initial_radius, seed, filter, radius_schedule, radius_pilots, radius_clearance, light_samples, glint_samples, quality",
                "x".repeat(40)
            ),
        ),
    ]);
    let many = format!("eye = [{}]", "0, ".repeat(100_000));
    check(&[(
        &[("eye = [0, 0, 10]", &many)],
        "4:7: eye of [camera] has 100000 elements; it must have 3, [x, y, z]",
    )]);
}

#[test]
fn files_that_cannot_be_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    std::fs::create_dir(path("folder.toml")).unwrap();
    std::fs::write(path("latin1.toml"), b"# a scene\nname = \"caf\xe9\"\n").unwrap();
    std::fs::File::create(path("large.toml")).unwrap().set_len(scene_file::MAX_BYTES + 1).unwrap();
    for (name, expected) in [
        ("none.toml", ": there is no such file"),
        ("folder.toml", ": this is a directory; a scene is a file"),
        ("latin1.toml", ":2:12: byte 0xe9 is not UTF-8; a scene file is UTF-8 text"),
        ("large.toml", ": is too large; a scene file has at most 4294967296 bytes"),
    ] {
        let error = scene_file::load(&path(name)).unwrap_err().to_string();
        assert_eq!(error, format!("{}{expected}", path(name).display()));
    }
}
