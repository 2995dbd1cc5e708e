//! Parts of a render, and the command `merge`: whoever renders what, and in whatever grouping and order parts are added, the
//! image is that of the whole render.

use crate::cases::tell;
use crate::sandbox::{Ended, Sandbox};
use std::fs;

/// Options of the render.
const GLOBAL: [&str; 12] = [
    "--quality",
    "paper",
    "--width",
    "16",
    "--height",
    "12",
    "--iterations",
    "12",
    "--photons",
    "500",
    "--radius-schedule",
    "global",
];

fn run(sandbox: &Sandbox, args: &[&str]) -> Ended {
    let ended = sandbox.run(args);
    assert_eq!(ended.code, Some(0), "{args:?}: {ended:?}");
    ended
}

fn render(sandbox: &Sandbox, args: &[&str]) -> Ended {
    run(sandbox, &[&["render", "cornell"], &GLOBAL[..], args].concat())
}

/// The iterations from `range` in the file `name`.
fn part(sandbox: &Sandbox, range: &str, name: &str, more: &[&str]) {
    render(sandbox, &[&["--range", range, "-o", name], more].concat());
}

/// A sandbox with the whole image, `whole.exr`, and four parts of three iterations, each by another engine.
fn parted() -> Sandbox {
    let sandbox = Sandbox::new();
    render(&sandbox, &["-o", "whole.exr"]);
    let ways = [&["--engine=reference"][..], &["--lanes=emulated"], &["--threads=1"], &["--threads=3"]];
    for (k, way) in ways.iter().enumerate() {
        let (part, name) = (format!("{}/4", k + 1), format!("{}.sppm", k + 1));
        render(&sandbox, &[&["--part", &part, "-o", &name], *way].concat());
    }
    assert_eq!(sandbox.names(), ["1.sppm", "2.sppm", "3.sppm", "4.sppm", "whole.exr"]);
    sandbox
}

#[test]
fn parts_are_the_whole_in_any_grouping_order_and_repetition() {
    let sandbox = parted();
    let mut state = 11_u32;
    let mut random = |below: usize| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 16) as usize % below
    };
    let rounds = 12;
    for round in 0..rounds {
        // Merges some of the files, until those that are left are one.
        let mut files: Vec<String> = (1..=4).map(|k| format!("{k}.sppm")).collect();
        while files.len() > 1 {
            let mut some: Vec<String> =
                (0..2 + random(files.len() - 1)).map(|_| files.swap_remove(random(files.len()))).collect();
            some.push(some[random(some.len())].clone());
            let out = format!("{round}-{}.sppm", files.len());
            let names: Vec<&str> = some.iter().map(String::as_str).collect();
            run(&sandbox, &[&["merge", "-q"], &names[..], &["-o", &out]].concat());
            files.push(out);
        }
        run(&sandbox, &["merge", &files[0], "-o", "merged.exr"]);
        assert_eq!(sandbox.image("merged.exr"), sandbox.image("whole.exr"), "round {round}");
    }
    tell("lasting", rounds, "random ways to merge four parts give the whole image");
}

#[test]
fn a_merge_counts_what_it_has_once_and_says_so() {
    let sandbox = parted();
    let ended = run(&sandbox, &["merge", "4.sppm", "2.sppm", "1.sppm", "3.sppm", "2.sppm", "-o", "a.exr"]);
    assert!(ended.stderr.contains("2.sppm: its iterations are in other parts too"), "{ended:?}");
    assert!(ended.stderr.contains("wrote a.exr: 12 of 12 iterations"), "{ended:?}");
    assert_eq!(sandbox.image("a.exr"), sandbox.image("whole.exr"));
    // One that overlaps two, and one that has another as its part.
    part(&sandbox, "2..7", "over.sppm", &[]);
    part(&sandbox, "0..6", "half.sppm", &[]);
    let all = ["merge", "over.sppm", "half.sppm", "1.sppm", "2.sppm", "3.sppm", "4.sppm"];
    let ended = run(&sandbox, &[&all[..], &["-o", "b.exr"]].concat());
    assert_eq!(sandbox.image("b.exr"), sandbox.image("whole.exr"), "{ended:?}");
    // A part is not the output, needed or not.
    let half = sandbox.bytes("half.sppm");
    for out in ["half.sppm", "1.sppm", "4.sppm"] {
        let ended = sandbox.run([&all[..], &["-o", out]].concat());
        assert_eq!(ended.code, Some(2), "{ended:?}");
        assert!(ended.stderr.contains(&format!("--output: {out} is also one of the parts")), "{ended:?}");
    }
    assert_eq!(sandbox.bytes("half.sppm"), half);
    let ended = sandbox.run(["merge", "over.sppm", "1.sppm", "4.sppm", "-o", "c.sppm"]);
    ended.refused(&["over.sppm (2..7)", "1.sppm (0..3)", "both hold the iterations 2..3"]);
}

#[test]
fn what_is_missing_is_named_with_commands_that_render_it() {
    let sandbox = parted();
    let ended = sandbox.run(["merge", "3.sppm", "1.sppm", "--missing"]);
    assert_eq!(ended.code, Some(1), "{ended:?}");
    assert!(ended.stderr.contains("3..6, 9..12 are missing"), "{ended:?}");
    // So it ends with what there is in a file, too: a script must not take that for all.
    let written = sandbox.run(["merge", "3.sppm", "1.sppm", "--missing", "-o", "some.exr"]);
    assert_eq!((written.code, &written.stdout), (Some(1), &ended.stdout), "{written:?}");
    let commands: Vec<&str> = ended.stdout.lines().collect();
    assert_eq!(commands.len(), 2, "{ended:?}");
    for command in commands {
        let words: Vec<&str> = command.split(' ').skip(1).collect();
        run(&sandbox, &words);
    }
    let files = ["3.sppm", "missing-9-12.sppm", "1.sppm", "missing-3-6.sppm"];
    let ended = run(&sandbox, &[&["merge"], &files[..], &["--missing", "-o", "a.exr"]].concat());
    assert_eq!(ended.stdout, "");
    assert_eq!(sandbox.image("a.exr"), sandbox.image("whole.exr"));
}

#[test]
fn a_merged_file_is_described_and_resumed() {
    let sandbox = parted();
    let ended = run(&sandbox, &["merge", "3.sppm", "1.sppm", "-o", "a.sppm"]);
    assert!(ended.stderr.contains("the iterations 3..6, 9..12 are missing"), "{ended:?}");
    let ended = run(&sandbox, &["info", "a.sppm"]);
    assert!(ended.stdout.contains("6 of 12: 0..3, 6..9") && ended.stdout.contains("global"), "{ended:?}");
    let ended = run(&sandbox, &["info", "3.sppm"]);
    assert!(ended.stdout.contains("iterations 6..9"), "{ended:?}");
    for engine in ["--engine=fast", "--engine=reference"] {
        fs::copy(sandbox.path("a.sppm"), sandbox.path("b.sppm")).unwrap();
        run(&sandbox, &["resume", "b.sppm", "-o", "a.exr", engine]);
        assert_eq!(sandbox.image("a.exr"), sandbox.image("whole.exr"), "{engine}");
        // It was asked for by its name, and is not removed as a checkpoint beside an image is.
        assert!(run(&sandbox, &["info", "b.sppm"]).stdout.contains("\niterations 12\n"));
    }
    // What is done goes up to the last iteration that it holds, however many are missing before.
    fs::copy(sandbox.path("a.sppm"), sandbox.path("b.sppm")).unwrap();
    sandbox
        .run(["resume", "b.sppm", "--iterations=7", "-o", "x.exr"])
        .refused(&["--iterations 7", "holds 9 already"]);
    let mut seven = GLOBAL;
    assert_eq!(seven[6], "--iterations");
    seven[7] = "7";
    sandbox
        .run([&["render", "cornell"], &seven[..], &["--checkpoint=b.sppm", "-o", "x.exr"]].concat())
        .refused(&["b.sppm", "more than 7"]);
    assert_eq!(sandbox.bytes("a.sppm"), sandbox.bytes("b.sppm"));
    // An image of some iterations says so, and is not repeated as if it were of the first.
    run(&sandbox, &["merge", "3.sppm", "1.sppm", "-o", "some.exr"]);
    assert!(run(&sandbox, &["info", "some.exr"]).stdout.contains("6: 0..3, 6..9"));
    sandbox.run(["render", "--like", "some.exr", "-o", "x.exr"]).refused(&["some.exr", "0..3, 6..9"]);
}

/// Rendered again, a part goes on from its file; and resumed, it stays that part.
#[test]
fn parts_go_on_where_they_were() {
    let sandbox = parted();
    part(&sandbox, "4..9", "a.sppm", &[]);
    let ended = render(&sandbox, &["--range=4..9", "-o", "a.sppm"]);
    assert!(ended.stderr.contains("going on from a.sppm after 5 of 5"), "{ended:?}");
    run(&sandbox, &["resume", "a.sppm", "-o", "part.exr"]);
    assert!(run(&sandbox, &["info", "a.sppm"]).stdout.contains("5 of 12: 4..9"));
    let ended =
        sandbox.run([&["render", "cornell"], &GLOBAL[..], &["--range=4..8", "-o", "a.sppm"]].concat());
    ended.refused(&["a.sppm", "4..9, another part"]);
}

#[test]
fn parts_of_other_renders_are_refused_by_name() {
    let sandbox = parted();
    part(&sandbox, "3..6", "seed.sppm", &["--seed=2"]);
    part(&sandbox, "3..6", "radius.sppm", &["--radius=1.5"]);
    part(&sandbox, "3..6", "samples.sppm", &["--light-samples=3"]);
    run(&sandbox, &[&["render", "mirror"], &GLOBAL[..], &["--range=3..6", "-o", "scene.sppm"]].concat());
    let own = ["--checkpoint=own.sppm", "--quality=paper", "-o", "own.exr", "-n", "2"];
    run(&sandbox, &[&["render", "cornell", "--width=16", "--height=12", "--photons=500"], &own[..]].concat());
    let bytes = sandbox.bytes("2.sppm");
    fs::write(sandbox.path("cut.sppm"), &bytes[..bytes.len() - 100]).unwrap();
    let mut flipped = bytes.clone();
    flipped[bytes.len() - 100] ^= 4;
    fs::write(sandbox.path("flipped.sppm"), flipped).unwrap();
    for (name, why) in [
        ("seed.sppm", "other settings than 1.sppm: seed is 2, not 1"),
        ("radius.sppm", "initial_radius is 1.5, not 2"),
        ("samples.sppm", "light_samples is 3, not 1"),
        ("scene.sppm", "another scene than 1.sppm"),
        ("own.sppm", "whose sums cannot be merged"),
        ("cut.sppm", "is cut short"),
        ("flipped.sppm", "the checksum of its sums does not match"),
        ("whole.exr", "is no checkpoint"),
        ("none.sppm", "there is no such file"),
    ] {
        let ended = sandbox.run(["merge", "1.sppm", name, "3.sppm", "-o", "x.sppm"]);
        ended.refused(&[name, why]);
        assert!(!sandbox.path("x.sppm").exists(), "{name}");
    }
}

/// Files of particles are not in them. Those that have moved with the parts are read where these are.
#[test]
fn parts_of_particles_are_merged_where_they_are() {
    let sandbox = Sandbox::new();
    sandbox.write("atoms.xyz", "2\nProperties=species:S:1:pos:R:3\nO 0 0 0\nH 1 1 1\n");
    let size = ["--width=8", "--height=6", "--photons=100", "-n=2", "--quality=paper", "--method=sppm"];
    let render = |args: &[&str]| {
        let schedule = ["--radius-schedule=global"];
        run(&sandbox, &[&["render", "atoms.xyz"], &size[..], &schedule, args].concat());
    };
    render(&["-o", "whole.pfm"]);
    render(&["--part=1/2", "-o", "1.sppm"]);
    render(&["--part=2/2", "-o", "2.sppm"]);
    fs::create_dir(sandbox.path("moved")).unwrap();
    for name in ["atoms.xyz", "1.sppm", "2.sppm"] {
        fs::rename(sandbox.path(name), sandbox.path(&format!("moved/{name}"))).unwrap();
    }
    run(&sandbox, &["merge", "moved/1.sppm", "moved/2.sppm", "-o", "merged.pfm"]);
    assert!(sandbox.bytes("merged.pfm") == sandbox.bytes("whole.pfm"));
}

#[test]
fn parts_that_cannot_be_are_refused() {
    let sandbox = Sandbox::new();
    for (options, why) in [
        (&["--part=1/13"][..], &["--part 1/13 has no iterations", "ask for fewer parts"][..]),
        (&["--range=6..13"], &["--range 6..13", "to before 12"]),
        (&["--part=1/2", "-o", "a.exr"], &["--output", "a.exr", ".sppm"]),
        (&["--part=1/2", "--snapshots"], &["--snapshots", "leave out"]),
        (&["--part=1/2", "--method=path"], &["--part: iterations", "--radius-schedule global"]),
        (&["--range=0..6", "--method=path"], &["--range: iterations", "--radius-schedule global"]),
    ] {
        sandbox.run([&["render", "cornell"], &GLOBAL[..], options].concat()).refused(why);
    }
    let ended = sandbox.run([&["render", "cornell"], &GLOBAL[..10], &["--part=1/2"]].concat());
    ended.refused(&["--part: iterations", "--radius-schedule global"]);
    let endless = ["--radius-schedule=global", "--time=1s", "--part=1/2"];
    sandbox.run(["render", "cornell"].iter().chain(&endless)).refused(&["--part", "state them by -n"]);
    assert_eq!(sandbox.names(), [""; 0]);
}
