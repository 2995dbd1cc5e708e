//! Settings that are chosen from the scene.

use crate::sandbox::Sandbox;

const SMALL: [&str; 3] = ["--width=48", "--height=36", "--threads=2"];

/// The options that were told to have been chosen.
fn told(stderr: &str) -> Vec<String> {
    let (_, options) = stderr.split_once("chosen for quality ").unwrap();
    let (_, options) = options.lines().next().unwrap().split_once(": ").unwrap();
    options.split(' ').map(Into::into).collect()
}

#[test]
fn a_built_in_scene_gets_a_picture_that_looks_finished() {
    let sandbox = Sandbox::new();
    let ended = sandbox.run(["render", "cornell", "-o", "a.exr"].iter().chain(&SMALL));
    assert_eq!(ended.code, Some(0), "{ended:?}");
    assert!(ended.stderr.starts_with("chosen for quality good: --method sppm -n "), "{ended:?}");
    assert!(!ended.stderr.contains("noisy"), "{ended:?}");
    // What was told gives the same pixels and chooses nothing, and so does the image itself.
    let options = told(&ended.stderr);
    let again = sandbox
        .run(["render", "cornell", "-o", "b.exr"].into_iter().chain(SMALL).map(String::from).chain(options));
    assert!(again.code == Some(0) && !again.stderr.contains("chosen"), "{again:?}");
    let like = sandbox.run(["render", "--like", "a.exr", "-o", "c.exr"]);
    assert!(like.code == Some(0) && !like.stderr.contains("chosen"), "{like:?}");
    for other in ["b.exr", "c.exr"] {
        assert!(sandbox.bytes("a.exr") == sandbox.bytes(other), "{other}");
    }
}

/// The options of all settings that are chosen, as they are told.
const ALL: [&str; 8] = [
    "--method",
    "-n",
    "--photons",
    "--radius",
    "--radius-pilots",
    "--radius-clearance",
    "--depth",
    "--glint-samples",
];
/// Of these, what paths have.
const OF_PATHS: [&str; 3] = ["--method", "-n", "--depth"];
/// The first radius, and what is chosen with it.
const RADII: [&str; 4] = ["--radius", "--radius-pilots", "--radius-clearance", "--glint-samples"];

#[test]
fn what_is_given_is_not_chosen() {
    let sandbox = Sandbox::new();
    let of = |options: &[&str]| {
        let ended = sandbox.run(["render", "cornell", "-o", "a.pfm"].iter().chain(&SMALL).chain(options));
        assert_eq!(ended.code, Some(0), "{ended:?}");
        ended.stderr
    };
    let names = |stderr: &str| -> Vec<String> { told(stderr).into_iter().step_by(2).collect() };
    assert_eq!(names(&of(&["--quality=draft"])), ALL);
    assert_eq!(
        names(&of(&["--quality=draft", "--photons=500"])),
        ["-n", "--radius", "--radius-pilots", "--radius-clearance", "--depth", "--glint-samples"]
    );
    assert_eq!(names(&of(&["-n=2", "--depth=5"])), [&ALL[..1], &ALL[2..6], &ALL[7..]].concat());
    let paper = ["--quality=paper", "-n=1"];
    assert!(!of(&paper).contains("chosen"));
    assert_eq!(names(&of(&["--quality=paper", "-n=1", "--radius=auto"])), RADII);
    // A goal ends the render, so its iterations are without end.
    assert_eq!(names(&of(&["--time=100ms"])), [&ALL[..1], &ALL[2..]].concat());
    assert_eq!(names(&of(&["--quality=draft", "--method=sppm"])), ALL[1..]);
    assert_eq!(names(&of(&["--quality=draft", "--engine=path"])), OF_PATHS[1..]);
    // Images of photons need some.
    assert_eq!(names(&of(&["--quality=draft", "--count-image=n.pfm"])), ALL[1..]);
    // Whoever gives the radius gets that one everywhere, unless pilots or clearance are asked for.
    for option in &RADII[1..] {
        let given = ["-n=2", "--depth=5", "--photons=500", "--radius=3", &format!("{option}=auto")];
        assert_eq!(names(&of(&given)), [*option]);
    }
    assert!(!of(&["-n=2", "--depth=5", "--photons=500", "--radius=3"]).contains("chosen"));
    // The paper's settings are those of section 4.
    of(&["--quality=paper", "--stats=s.json", "-n=1"]);
    let settings = &sandbox.json("s.json")["settings"];
    assert_eq!(
        (&settings["photons_per_iteration"], &settings["max_depth"], &settings["initial_radius"]),
        (&200_000.into(), &5.into(), &2.0.into())
    );
}

#[test]
fn scene_files_may_leave_settings_open() {
    let sandbox = Sandbox::new();
    let scene = "
camera = { eye = [0, 0, 10], target = [0, 0, 0], vertical_fov_degrees = 40 }
background = [1, 1, 1]
[[sphere]]
center = [0, 0, 0]
radius = 2
material = { type = \"diffuse\", albedo = [0.5, 0.5, 0.5] }
";
    let names = |settings: &str| -> Vec<String> {
        sandbox.write("a.toml", &format!("{settings}\n{scene}"));
        let ended = sandbox.run(["render", "a.toml", "-o", "a.pfm"].iter().chain(&SMALL));
        assert_eq!(ended.code, Some(0), "{settings}: {ended:?}");
        if !ended.stderr.contains("chosen") {
            return Vec::new();
        }
        told(&ended.stderr).into_iter().step_by(2).collect()
    };
    // A ball under the sky: by paths.
    assert_eq!(names(""), OF_PATHS);
    assert_eq!(names("settings = { seed = 3 }"), OF_PATHS);
    assert_eq!(names("settings = { quality = \"draft\", max_depth = 4 }"), OF_PATHS[..2]);
    assert_eq!(names("settings = { radius_schedule = \"global\" }"), ALL[1..]);
    // Whoever states one setting keeps what the others have been so far.
    assert_eq!(names("settings = { iterations = 1 }"), [""; 0]);
    assert_eq!(names("settings = { iterations = 1, initial_radius = \"auto\" }"), RADII);
    assert_eq!(names("settings = { iterations = 1, radius_clearance = \"auto\" }"), ALL[5..6]);
    assert_eq!(
        names("settings = { quality = \"draft\", radius_clearance = 0 }"),
        [&ALL[1..5], &ALL[6..]].concat()
    );
    assert_eq!(names("settings = { quality = \"paper\", iterations = 1 }"), [""; 0]);
}

#[test]
fn bad_qualities_are_refused() {
    let sandbox = Sandbox::new();
    sandbox.run(["render", "cornell", "--quality", "best"]).refused(&[
        "--quality",
        "\"best\"",
        "paper, draft, good and final",
    ]);
    sandbox
        .run(["verify", "cornell", "--radius", "auto"])
        .refused(&["--radius auto: only `sppm render` chooses"]);
    sandbox
        .run(["render", "cornell", "--radius", "automatic"])
        .refused(&["--radius: \"automatic\" is not a number"]);
    let camera = "camera = { eye = [0, 0, 10], target = [0, 0, 0], vertical_fov_degrees = 40 }\n";
    sandbox.write("a.toml", &format!("settings = {{ quality = \"god\" }}\n{camera}"));
    sandbox.run(["render", "a.toml"]).refused(&[
        "a.toml:1",
        "quality \"god\"",
        "did you mean \"good\"?",
        "paper, draft, good, final",
    ]);
    sandbox.write("b.toml", &format!("settings = {{ initial_radius = \"big\" }}\n{camera}"));
    sandbox.run(["render", "b.toml"]).refused(&["b.toml:1", "initial_radius"]);
}
