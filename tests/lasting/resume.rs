//! The command `resume`, and `render` if it finds a checkpoint of the same render.

use crate::sandbox::{Ended, Sandbox, TINY};
use std::fs;

/// A render of 4 iterations in `a.exr` with its checkpoint `a.sppm`, and the same render with 9 iterations in
/// `whole.exr`.
fn kept() -> Sandbox {
    let sandbox = Sandbox::new();
    render(&sandbox, &["-o", "whole.exr", "--no-checkpoint", "--iterations=9"]);
    render(&sandbox, &["-o", "a.exr", "--checkpoint=a.sppm", "--every=1", "--iterations=4"]);
    assert_eq!(sandbox.names(), ["a.exr", "a.sppm", "a.sppm.1", "whole.exr"]);
    sandbox
}

/// Renders with the options of [`TINY`] except for the iterations.
fn render(sandbox: &Sandbox, args: &[&str]) -> Ended {
    let tiny = TINY.iter().filter(|option| !["--iterations", "2"].contains(option));
    let ended = sandbox.run(["render", "cornell", "--quality=paper"].iter().chain(args).chain(tiny));
    assert_eq!(ended.code, Some(0), "{ended:?}");
    ended
}

fn resume(sandbox: &Sandbox, args: &[&str]) -> Ended {
    let ended = sandbox.run(["resume", "a.sppm"].iter().chain(args));
    assert_eq!(ended.code, Some(0), "{ended:?}");
    ended
}

#[test]
fn iterations_are_added_to_a_finished_render() {
    for way in
        [["--engine=fast", "--threads=3"], ["--engine=reference", "--threads=1"], ["--lanes=emulated", "-q"]]
    {
        let sandbox = kept();
        resume(&sandbox, &[&["--iterations=7"], &way[..]].concat());
        resume(&sandbox, &["--iterations=9"]);
        assert_eq!(sandbox.image("a.exr"), sandbox.image("whole.exr"), "{way:?}");
        assert_eq!(sandbox.names(), ["a.exr", "a.sppm", "a.sppm.1", "whole.exr"]);
    }
}

#[test]
fn paths_are_resumed_by_either_engine() {
    let engines = ["--engine=fast", "--engine=reference"];
    for (first, then) in [(0, 1), (1, 0)].map(|(first, then)| (engines[first], engines[then])) {
        let sandbox = Sandbox::new();
        render(&sandbox, &["-o", "whole.pfm", "--method=path", "--iterations=5"]);
        let begun = ["-o", "a.pfm", "--checkpoint=a.sppm", "--method=path", "--iterations=3"];
        render(&sandbox, &[&begun[..], &[first]].concat());
        resume(&sandbox, &["--iterations=4", then]);
        // By the engine that rendered last.
        resume(&sandbox, &["--iterations=5"]);
        assert_eq!(sandbox.image("a.pfm"), sandbox.image("whole.pfm"), "{first}, then {then}");
    }
}

#[test]
fn a_resumed_file_is_the_uninterrupted_file() {
    let sandbox = kept();
    let ended = resume(&sandbox, &["--iterations=9"]);
    assert!(ended.stderr.contains("going on from a.sppm after 4 of 9 iterations"), "{ended:?}");
    assert!(sandbox.bytes("a.exr") == sandbox.bytes("whole.exr"));
}

/// Counted work is of all sessions.
#[test]
fn the_statistics_of_a_resumed_render_are_those_of_an_uninterrupted_one() {
    let sandbox = kept();
    resume(&sandbox, &["--iterations=9", "--stats=resumed.json", "--threads=3"]);
    render(&sandbox, &["-o", "b.exr", "--iterations=9", "--stats=whole.json"]);
    let [resumed, whole] = ["resumed.json", "whole.json"].map(|name| sandbox.json(name));
    assert_eq!((&resumed["resumed_after"], &whole["resumed_after"]), (&4.into(), &0.into()));
    // The threads are those that are asked for now.
    assert_eq!(resumed["threads"], 3);
    for key in ["iterations", "settings", "photons", "camera_segments", "visible_points", "shadow_rays"] {
        assert!(!whole[key].is_null(), "no {key}: {whole}");
        assert_eq!(resumed[key], whole[key], "{key}");
    }
    for key in ["photon_segments", "deposits", "contributions", "lanes"] {
        assert_eq!(resumed[key], whole[key], "{key}");
    }
}

#[test]
fn the_same_render_resumes_automatically() {
    let sandbox = kept();
    let ended = render(&sandbox, &["-o", "b.exr", "--checkpoint=a.sppm", "--iterations=9"]);
    assert!(ended.stderr.starts_with("going on from a.sppm after 4 of 9 iterations\n"), "{ended:?}");
    assert!(sandbox.bytes("b.exr") == sandbox.bytes("whole.exr"));
}

#[test]
fn checkpoint_and_image_can_be_moved() {
    let sandbox = kept();
    fs::create_dir(sandbox.path("moved")).unwrap();
    fs::rename(sandbox.path("a.sppm"), sandbox.path("moved/b.sppm")).unwrap();
    let ended = sandbox.run(["resume", "moved/b.sppm"]);
    assert_eq!(ended.code, Some(0), "{ended:?}");
    assert!(sandbox.bytes("moved/a.exr") == sandbox.bytes("a.exr"));
    let ended = sandbox.run(["resume", "moved/b.sppm", "-o", "c.pfm", "--iterations=9"]);
    assert_eq!(ended.code, Some(0), "{ended:?}");
    assert_eq!(sandbox.image("c.pfm"), sandbox.image("whole.exr"));
    assert_eq!(
        sandbox.names(),
        [
            "a.exr",
            "a.sppm.1",
            "c.pfm",
            "moved/",
            "moved/a.exr",
            "moved/b.sppm",
            "moved/b.sppm.1",
            "whole.exr"
        ]
    );
}

#[test]
fn other_renders_are_not_overwritten() {
    let sandbox = kept();
    let before = sandbox.contents();
    let tiny = ["--width=16", "--height=12", "--photons=500"];
    let cases: &[(&[&str], &[&str])] = &[
        (
            &["render", "mirror", "--quality=paper", "--checkpoint=a.sppm"],
            &["holds 4 iterations of another scene, Cornell Box", "sppm resume"],
        ),
        (&["render", "cornell", "--quality=paper", "--checkpoint=a.sppm", "--seed=2"], &["other settings"]),
        (
            &["render", "cornell", "--quality=paper", "--checkpoint=a.sppm", "--engine=path"],
            &["photon mapping"],
        ),
        (
            &["render", "cornell", "--quality=paper", "--checkpoint=a.sppm", "--iterations=3"],
            &["more than 3"],
        ),
        (
            &["render", "cornell", "--quality=paper", "--checkpoint=whole.exr"],
            &["whole.exr: is no checkpoint of sppm"],
        ),
        (
            &["render", "cornell", "--quality=paper", "-o", "a.png", "--checkpoint=a.png"],
            &["--checkpoint", "also --output"],
        ),
        (
            &["render", "cornell", "--quality=paper", "--checkpoint=missing/a.sppm"],
            &["--checkpoint", "does not exist"],
        ),
        (
            &["render", "cornell", "--quality=paper", "--checkpoint=a.sppm", "--no-checkpoint"],
            &["--no-checkpoint"],
        ),
    ];
    for (args, words) in cases {
        sandbox.run(args.iter().chain(&tiny)).refused(words);
        assert!(sandbox.contents() == before, "{args:?} changed the folder: {:?}", sandbox.names());
    }
    let cases: &[(&[&str], &[&str])] = &[
        (&["resume"], &["<FILE> is missing"]),
        (&["resume", "missing.sppm"], &["missing.sppm", "no such file"]),
        (&["resume", "whole.exr"], &["whole.exr: is no checkpoint"]),
        (&["resume", "a.sppm", "--iterations=3"], &["--iterations 3", "holds 4 already"]),
        (&["resume", "a.sppm", "--engine=path"], &["--engine path", "photon mapping", "fast and reference"]),
        (
            &["resume", "a.sppm", "--method=path"],
            &["--method path", "photon mapping", "goes on by sppm alone"],
        ),
        (&["resume", "a.sppm", "-o", "a.sppm"], &["--output", "also the checkpoint"]),
        (&["resume", "a.sppm", "--stats", "a.sppm"], &["--stats", "also the checkpoint"]),
        (&["resume", "a.sppm", "--time=0s"], &["--time", "10m"]),
        (&["resume", "a.sppm", "--every=0"], &["--every", "iterations"]),
    ];
    for (args, words) in cases {
        sandbox.run(*args).refused(words);
        assert!(sandbox.contents() == before, "{args:?} changed the folder: {:?}", sandbox.names());
    }
}

/// The fixture is from before the choice of lamps: its iterations and today's are of two images.
#[test]
fn iterations_of_another_light_transport_are_not_gone_on_from() {
    let sandbox = Sandbox::new();
    let old = concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/checkpoints/version-1.sppm");
    fs::copy(old, sandbox.path("old.sppm")).unwrap();
    let before = sandbox.contents();
    let words =
        ["old.sppm was begun by version 1 of the light transport (sppm 0.1.0)", "go on with the program"];
    sandbox.run(["resume", "old.sppm", "-n", "4"]).refused(&words);
    let again = Sandbox::new();
    fs::copy(old, again.path("old.sppm")).unwrap();
    let like = again.run(["render", "--like", "old.sppm", "-o", "a.pfm"]);
    let transport = scene::TRANSPORT;
    let line = format!(
        "warning: old.sppm was made by version 1 of the light transport, and this program computes version {transport}"
    );
    assert!(like.code == Some(0) && like.stderr.starts_with(&line), "{like:?}");
    sandbox
        .run(["render", "cornell", "--quality=paper", "--checkpoint=old.sppm"].iter().chain(&TINY))
        .refused(&words);
    assert!(sandbox.contents() == before, "{:?}", sandbox.names());
    let info = sandbox.run(["info", "old.sppm"]);
    let line = format!("transport  1; this program computes {transport}");
    assert!(info.code == Some(0) && info.stdout.contains(&line), "{info:?}");
}

#[test]
fn a_checkpoint_is_locked_by_one_render_at_a_time() {
    let sandbox = kept();
    let lock = files::lock::Lock::take(&sandbox.path("a.sppm")).unwrap();
    let process = format!("process {}", std::process::id());
    for args in [
        &["resume", "a.sppm", "-q"][..],
        &["render", "cornell", "--quality=paper", "--checkpoint=a.sppm"][..],
    ] {
        sandbox.run(args).refused(&["a.sppm", "in use by another render", &process]);
    }
    drop(lock);
    resume(&sandbox, &[]);
}

#[test]
fn damage_is_reported_and_the_older_generation_is_resumed() {
    let sandbox = kept();
    let whole = sandbox.bytes("a.sppm");
    let flipped = |at: usize| {
        let mut bytes = whole.clone();
        bytes[at] ^= 1;
        bytes
    };
    for (bytes, says) in [
        (whole[..whole.len() / 2].to_vec(), "cut short"),
        (flipped(10), "the checksum of its header does not match"),
        (flipped(60), "the checksum of its scene does not match"),
        (flipped(whole.len() - 40), "the checksum of its sums does not match"),
        (b"something else".to_vec(), "is no checkpoint of sppm"),
        (Vec::new(), "is no checkpoint of sppm"),
    ] {
        let older = sandbox.bytes("a.sppm.1");
        fs::write(sandbox.path("a.sppm"), &bytes).unwrap();
        for format in [&["--json"][..], &["--scene"], &[]] {
            let ended = sandbox.run([&["info", "a.sppm"], format].concat());
            assert_eq!(ended.code, Some(0), "{ended:?}");
            assert!(
                ended.stderr.starts_with("warning: a.sppm: ") && ended.stderr.contains(says),
                "{ended:?}"
            );
            assert!(ended.stderr.ends_with("; this is the older generation\n"), "{ended:?}");
        }
        let ended = resume(&sandbox, &[]);
        let lines: Vec<&str> = ended.stderr.lines().collect();
        assert!(lines[0].starts_with("warning: a.sppm: ") && lines[0].contains(says), "{ended:?}");
        assert!(lines[1].starts_with("going on from a.sppm.1 after 3 of 4 iterations"), "{ended:?}");

        fs::write(sandbox.path("a.sppm"), &bytes).unwrap();
        fs::remove_file(sandbox.path("a.sppm.1")).unwrap();
        sandbox.run(["resume", "a.sppm"]).refused(&["a.sppm: ", says]);
        assert!(sandbox.bytes("a.sppm") == bytes);
        fs::write(sandbox.path("a.sppm.1"), older).unwrap();
    }
}
