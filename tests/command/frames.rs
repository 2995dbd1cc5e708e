//! Ranges of the frames of a trajectory: an image of each, with one camera.

use crate::running::Running;
use crate::sandbox::{Sandbox, TINY};
use rustix::process::Signal;
use std::fmt::Write as _;
use std::thread::sleep;
use std::time::Duration;

/// Frames in which two atoms move apart.
fn trajectory(frames: usize) -> String {
    let mut text = String::new();
    for frame in 0..frames {
        writeln!(text, "2\nframe {frame}\nO 0 0 0\nC {} 0 0.5", 2.0 + 0.25 * frame as f64).unwrap();
    }
    text
}

fn with_trajectory(frames: usize) -> Sandbox {
    let sandbox = Sandbox::new();
    sandbox.write("run.xyz", &trajectory(frames));
    sandbox
}

#[test]
fn each_frame_is_as_by_itself_with_the_camera_of_the_first() {
    let sandbox = with_trajectory(4);
    sandbox.render(&["run.xyz", "--frame", "1..", "-o", "f{frame}.png", "--stats", "s.json"]);
    assert_eq!(
        sandbox.names(),
        ["f0001.png", "f0002.png", "f0003.png", "run.xyz", "s-0001.json", "s-0002.json", "s-0003.json"]
    );
    for frame in ["1", "2", "3"] {
        sandbox.render(&["run.xyz", "--frame", frame, "--camera-frame", "1", "-o", "alone.png"]);
        assert!(sandbox.bytes("alone.png") == sandbox.bytes(&format!("f000{frame}.png")), "{frame}");
    }
    sandbox.render(&["run.xyz", "--frame", "3", "-o", "own.png"]);
    assert!(sandbox.bytes("own.png") != sandbox.bytes("f0003.png"));
    sandbox.render(&["run.xyz", "--frame", "1..4:2", "--camera-frame", "each"]);
    assert!(sandbox.bytes("own.png") == sandbox.bytes("run-0003.png"));
    assert!(!sandbox.names().contains(&"run-0002.png".into()));
    // Each says what made it.
    let again = sandbox.run(["render", "--like", "f0003.png", "-o", "again.png"]);
    assert_eq!(again.code, Some(0), "{again:?}");
    assert!(sandbox.bytes("again.png") == sandbox.bytes("f0003.png"));
}

/// The third frame is damaged, so frames cannot be counted; those before it are found all the same.
#[test]
fn a_frame_that_fails_does_not_lose_the_others() {
    let sandbox = Sandbox::new();
    sandbox.write("run.xyz", &trajectory(4).replace("C 2.5 0", "C north 0"));
    let render = |range: &str| {
        sandbox.run(["render", "run.xyz", "--quality=paper", "--frame", range].iter().chain(&TINY))
    };
    let ended = render("1..4");
    assert_eq!(ended.code, Some(1), "{ended:?}");
    assert!(ended.stderr.contains("error: frame 2: run.xyz:12"), "{ended:?}");
    assert!(
        ended.stderr.contains("error: of 3 frames these failed: 2; the others are rendered"),
        "{ended:?}"
    );
    assert_eq!(sandbox.names(), ["run-0001.png", "run-0003.png", "run.xyz"]);
    // A style need not suit all frames.
    sandbox.write("run.xyz", &trajectory(3));
    let cut =
        ["render", "run.xyz", "--quality=paper", "--frame", "..", "--cut", "x > 2.3", "--camera-frame", "2"];
    let ended = sandbox.run(cut.iter().chain(&TINY));
    assert_eq!(ended.code, Some(1), "{ended:?}");
    assert!(ended.stderr.contains("of 3 frames these failed: 0 and 1;"), "{ended:?}");
}

/// Of none it is said that it is rendered.
#[test]
fn all_frames_may_fail() {
    let sandbox = with_trajectory(2);
    let cut = ["--frame", "..", "--camera-frame", "each", "--cut", "x > 9"];
    let ended = sandbox.run(["render", "run.xyz", "--quality=paper"].iter().chain(&cut).chain(&TINY));
    assert_eq!(ended.code, Some(1), "{ended:?}");
    assert!(ended.stderr.ends_with("\nerror: of 2 frames these failed: 0 and 1\n"), "{ended:?}");
    assert_eq!(sandbox.names(), ["run.xyz"]);
}

/// What the picture of a frame lacks is told with the number of the frame.
#[test]
fn notes_are_of_their_frames() {
    let sandbox = with_trajectory(3);
    let ended = sandbox.render(&["run.xyz", "--frame", "1..", "--bonds", "file"]);
    let notes: Vec<&str> = ended.stderr.lines().filter(|line| line.starts_with("note: ")).collect();
    let expected = [1, 2].map(|frame| format!("note: frame {frame}: there are no bonds to draw"));
    assert_eq!(notes, expected);
}

/// What is wrong with the files of one frame alone, here the checkpoint of another render in its place, is no reason to leave
/// out those after it.
#[test]
fn a_frame_whose_files_are_taken_does_not_lose_the_others() {
    let sandbox = with_trajectory(3);
    sandbox.render(&["cornell", "-o", "other.png", "--checkpoint", "run-0001.png.sppm"]);
    let ended = sandbox.run(["render", "run.xyz", "--quality=paper", "--frame", ".."].iter().chain(&TINY));
    assert_eq!(ended.code, Some(1), "{ended:?}");
    assert!(ended.stderr.contains("of 3 frames these failed: 1; the others are rendered"), "{ended:?}");
    let images = ["run-0000.png", "run-0002.png"];
    assert!(images.iter().all(|image| sandbox.path(image).exists()), "{:?}", sandbox.names());
    assert!(!sandbox.path("run-0001.png").exists());
}

#[test]
fn a_signal_ends_all_frames() {
    let sandbox = with_trajectory(3);
    let args = ["render", "run.xyz", "--frame", "..", "-n", "100000000", "--width", "16", "--height", "12"];
    let mut command = sandbox.command(args.iter().chain(&["--every", "1", "--threads", "1"]));
    let running = Running::start_saying(&mut command, "frame 0, 1 of 3");
    while !sandbox.path("run-0000.png.sppm").exists() {
        sleep(Duration::from_millis(10));
    }
    running.send(Signal::INT);
    let ended = running.end();
    assert_eq!(ended.code, Some(130), "{ended:?}");
    assert!(ended.stderr.contains("interrupted: frame 0: wrote run-0000.png"), "{ended:?}");
    assert!(ended.stderr.contains("`--frame 0..` goes on with it"), "{ended:?}");
    assert!(!sandbox.names().iter().any(|name| name.contains("0001")), "{:?}", sandbox.names());
}

#[test]
fn ranges_that_cannot_be_rendered_are_refused() {
    let sandbox = with_trajectory(3);
    let refused = |args: &[&str], words: &[&str]| sandbox.run(args).refused(words);
    refused(&["render", "run.xyz", "--frame", "2..9"], &["--frame: there is no frame 8; the file has 3"]);
    refused(&["render", "run.xyz", "--frame", "2..2"], &["--frame: `2..2` is not a range of frames"]);
    refused(
        &["render", "run.xyz", "--frame", "..", "-o", "-"],
        &["--output: standard output takes one image"],
    );
    refused(&["render", "run.xyz", "--frame", "..", "--view"], &["--view: the page shows one frame"]);
    refused(
        &["render", "cornell", "--frame", ".."],
        &["--frame: ranges of frames are for files of particles"],
    );
    // What was rendered before is one frame.
    refused(
        &["render", "run.xyz", "--frame", "..", "--like", "a.png"],
        &["--frame: ranges of frames are for files of particles"],
    );
    refused(&["verify", "run.xyz", "--frame", ".."], &["--frame: only `render` takes a range"]);
    refused(&["render", "none.xyz", "--frame", ".."], &["none.xyz: there is no such file"]);
    refused(&["render", "run.xyz", "--frame", "..", "--camera-frame", "9"], &["run.xyz: has no frame 9"]);
    refused(&["render", "run.xyz", "--camera-frame", "x"], &["--camera-frame: `x` must be the number"]);
    // What is wrong with all frames is told once, whichever is the first; nor is a frame announced that is not rendered.
    for frames in ["..", "1.."] {
        let ended = sandbox.run(["render", "run.xyz", "--frame", frames, "-o", "a.gif"]);
        let told = ended.stderr.matches(".gif: has the extension").count();
        assert_eq!((ended.code, told), (Some(2), 1), "{ended:?}");
        assert!(!ended.stderr.contains("frame 0") && !ended.stderr.contains("frame 1"), "{ended:?}");
    }
    assert_eq!(sandbox.names(), ["run.xyz"]);
}
