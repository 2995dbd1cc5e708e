//! The live view as a command: what it prints, refuses and leaves behind. Its server has tests of its own, in `view/tests`.

use crate::info::write_layers;
use crate::sandbox::{Ended, Sandbox};
use files::image_file::{self, Encoding};
use rustix::process::{Pid, Signal, kill_process};
use scene::Film;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::process::{Child, ChildStdout, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};
use tungstenite::{Message, WebSocket};

/// What takes longer is taken to be lost.
const PATIENCE: Duration = Duration::from_mins(1);
const QUICK: [&str; 8] = ["--width", "16", "--height", "12", "--photons", "1000", "--threads=1", "--no-open"];

/// A view that runs.
struct Viewing {
    child: Child,
    stdout: BufReader<ChildStdout>,
    /// The host and port of its page, and the path.
    page: (String, String),
}

impl Viewing {
    /// Starts `command`, and returns once it has printed the page's address.
    fn start(command: &mut Command) -> Self {
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let mut stdout = BufReader::new(child.stdout.take().unwrap());
        let mut line = String::new();
        stdout.read_line(&mut line).unwrap();
        let rest = line.trim_end().strip_prefix("http://").unwrap_or_else(|| panic!("no address: {line:?}"));
        let (host, path) = rest.split_once('/').unwrap();
        let page = (host.into(), format!("/{path}"));
        Self { child, stdout, page }
    }

    /// What the page says.
    fn get(&self) -> String {
        let (host, path) = &self.page;
        let mut stream = TcpStream::connect(host).unwrap();
        write!(stream, "GET {path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n").unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        answer
    }

    /// The socket of an open page.
    fn socket(&self) -> WebSocket<TcpStream> {
        let (host, path) = &self.page;
        let stream = TcpStream::connect(host).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        tungstenite::client(format!("ws://{host}{path}socket"), stream).unwrap().0
    }

    /// Waits for a picture in full size, which there is once an iteration is over.
    fn wait_for_picture(&self) {
        let mut page = self.socket();
        loop {
            if let Message::Binary(picture) = page.read().expect("a picture comes") {
                // After three words: the size that is sent, and that of the whole image.
                if picture[12..20] == picture[20..28] {
                    return;
                }
                page.send(Message::text(r#"{ "type": "ack" }"#)).unwrap();
            }
        }
    }

    /// Ends it by Ctrl-C.
    fn end(mut self) -> Ended {
        kill_process(Pid::from_child(&self.child), Signal::INT).unwrap();
        let (mut stdout, mut stderr) = (String::new(), String::new());
        self.stdout.read_to_string(&mut stdout).unwrap();
        self.child.stderr.take().unwrap().read_to_string(&mut stderr).unwrap();
        Ended { code: self.child.wait().unwrap().code(), stdout, stderr }
    }
}

/// A test that fails leaves no view behind.
impl Drop for Viewing {
    fn drop(&mut self) {
        let _ = self.child.kill(); // fails if it has ended
        let _ = self.child.wait();
    }
}

#[test]
fn ctrl_c_ends_the_view_and_writes_what_it_has() {
    let sandbox = Sandbox::new();
    let out = ["-o", "a.exr"];
    let viewing = Viewing::start(&mut sandbox.command(["view", "cornell"].iter().chain(&QUICK).chain(&out)));
    assert!(viewing.get().starts_with("HTTP/1.1 200"));
    viewing.wait_for_picture();
    let ended = viewing.end();
    assert_eq!(ended.code, Some(130), "{ended:?}");
    // In a slow second it may be one.
    ended.said_one_line("interrupted: wrote a.exr after ", &[" iteration"]);
    assert_eq!(sandbox.names(), ["a.exr"]);
    // It is the image of a render of as many iterations.
    let done = ended.stderr.split(' ').nth(4).unwrap().to_owned();
    // A view has the same first radius for all pixels.
    let same = ["--radius-pilots", "0", "--radius-clearance", "0"];
    let again = [&["-n", &done, "-o", "b.exr", "--quiet"], &same[..]].concat();
    let ended = sandbox.run(["render", "cornell"].iter().chain(&QUICK[..7]).chain(&again));
    assert_eq!(ended.code, Some(0), "{ended:?}");
    assert_eq!(sandbox.image("a.exr"), sandbox.image("b.exr"));
    // No curve is noted that only images of codes have.
    let about = |name| sandbox.run(["info", name]).stdout;
    assert!(!about("b.exr").contains("tone"), "{}", about("b.exr"));
    assert!(!about("a.exr").contains("tone"), "{}", about("a.exr"));
}

#[test]
fn without_an_output_nothing_is_written() {
    let sandbox = Sandbox::new();
    let viewing = Viewing::start(&mut sandbox.command(["view", "cornell"].iter().chain(&QUICK)));
    let ended = viewing.end();
    assert_eq!(ended.code, Some(130));
    assert_eq!(ended.stdout, "");
    assert_eq!(sandbox.names(), [""; 0]);
}

/// It was enough for the scene as it was opened.
#[test]
fn the_memory_limit_holds_for_what_the_page_asks_for() {
    let sandbox = Sandbox::new();
    let limited = ["--memory-limit", "100MB"];
    let mut command = sandbox.command(["view", "cornell"].iter().chain(&QUICK).chain(&limited));
    let viewing = Viewing::start(&mut command);
    let mut page = viewing.socket();
    page.send(Message::text(r#"{ "type": "settings", "width": 2400, "height": 1800 }"#)).unwrap();
    let problem = loop {
        match page.read().expect("the problem is told") {
            Message::Text(text) if text.contains(r#""type":"problem""#) => break text,
            Message::Binary(_) => page.send(Message::text(r#"{ "type": "ack" }"#)).unwrap(),
            _ => {}
        }
    };
    assert!(problem.contains("more than 100.0 MiB"), "{problem}");
}

#[test]
fn images_are_shown_and_compared() {
    let sandbox = Sandbox::new();
    assert_eq!(sandbox.render(&["cornell", "-o", "a.exr"]).code, Some(0));
    for args in [vec!["view", "a.exr", "--no-open"], vec!["compare", "a.exr", "a.exr", "--view", "--no-open"]]
    {
        let viewing = Viewing::start(&mut sandbox.command(&args));
        assert!(viewing.get().starts_with("HTTP/1.1 200"));
        let ended = viewing.end();
        assert_eq!((ended.code, &ended.stdout[..]), (Some(130), ""), "{args:?}");
        // What was measured is told beside the address.
        assert_eq!(ended.stderr.contains("RMSE"), args[0] == "compare", "{ended:?}");
    }
}

/// The page and the viewer change nothing in the image.
#[test]
fn a_watched_render_gives_the_same_image() {
    let sandbox = Sandbox::new();
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let place = listener.local_addr().unwrap().to_string();
    let viewer = thread::spawn(move || {
        let mut bytes = Vec::new();
        listener.accept().unwrap().0.read_to_end(&mut bytes).unwrap();
        bytes
    });
    let watched = sandbox.render(&["cornell", "-o", "a.exr", "--view", "--no-open", "--display", &place]);
    assert_eq!(watched.code, Some(0), "{watched:?}");
    assert!(watched.stdout.starts_with("http://127.0.0.1:"), "{watched:?}");
    assert_eq!(sandbox.render(&["cornell", "-o", "b.exr"]).code, Some(0));
    assert_eq!(sandbox.bytes("a.exr"), sandbox.bytes("b.exr"));
    let bytes = viewer.join().unwrap();
    // A packet that creates an image, and then its pixels.
    assert_eq!((bytes[4], &bytes[6..13]), (4, &b"Cornell"[..]));
    assert!(bytes.len() > 16 * 12 * 3 * 4);
}

/// It shows what there is so far, not the end alone.
#[test]
fn a_page_follows_a_render_on_its_way() {
    let sandbox = Sandbox::new();
    let endless = ["render", "cornell", "--quality=paper", "-n", "100000000", "--no-checkpoint", "--view"];
    let viewing = Viewing::start(&mut sandbox.command(endless.iter().chain(&QUICK)));
    viewing.wait_for_picture();
    let ended = viewing.end();
    assert_eq!(ended.code, Some(130), "{ended:?}");
    ended.said_one_line("interrupted: wrote cornell.png after ", &[" of 100000000 iterations in "]);
}

/// A viewer that is not there is told, and keeps nobody waiting.
#[test]
fn a_resumed_render_is_watched_too() {
    let sandbox = Sandbox::new();
    sandbox.render(&["cornell", "-o", "a.exr", "--checkpoint", "a.sppm"]);
    let nobody = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().to_string();
    let ended = sandbox.run(["resume", "a.sppm", "-n", "3", "--view", "--no-open", "--display", &nobody]);
    assert_eq!(ended.code, Some(0), "{ended:?}");
    assert!(ended.stdout.starts_with("http://127.0.0.1:") && ended.stdout.lines().count() == 1, "{ended:?}");
    let told = format!("--display: no viewer is reached at {nobody} ");
    assert!(ended.stderr.lines().any(|line| line.starts_with(&told)), "{ended:?}");
}

/// Who reads standard output gets what was asked for, and nothing else; the page's address goes beside it.
#[test]
fn the_address_is_told_where_nobody_reads() {
    let sandbox = Sandbox::new();
    let read = |args: &[&str]| {
        let words = ["render", "cornell", "-n", "2", "--view"];
        let output = sandbox.command(words.iter().chain(&QUICK).chain(args)).output().unwrap();
        let told = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success() && told.contains("http://127.0.0.1:"), "{told}");
        output.stdout
    };
    let lines = String::from_utf8(read(&["-o", "a.exr", "--progress", "json"])).unwrap();
    assert_eq!(lines.lines().count(), 2, "{lines}");
    for line in lines.lines() {
        serde_json::from_str::<Value>(line).unwrap_or_else(|error| panic!("{line}: {error}"));
    }
    assert!(read(&["-o", "-"]).starts_with(b"\x89PNG"));
}

/// Particles on a stage are rendered by paths, in a view as without.
#[test]
fn particles_are_viewed_by_the_method_that_renders_them() {
    let sandbox = Sandbox::new();
    sandbox.write("atoms.xyz", "2\n\nC 0 0 0\nO 0 0 1.2\n");
    let size = ["--width", "16", "--height", "12", "--threads=1", "--no-open", "-o", "a.exr"];
    let viewing = Viewing::start(&mut sandbox.command(["view", "atoms.xyz"].iter().chain(&size)));
    viewing.wait_for_picture();
    let ended = viewing.end();
    assert_eq!(ended.code, Some(130), "{ended:?}");
    let rendered =
        ["render", "atoms.xyz", "-n", "1", "-o", "b.exr", "--quiet", "--width", "16", "--height", "12"];
    assert_eq!(sandbox.run(rendered).code, Some(0));
    let method = |name| {
        let about = sandbox.run(["info", name]).stdout;
        about.lines().find(|line| line.contains("method")).unwrap_or_else(|| panic!("{about}")).to_owned()
    };
    assert_eq!(method("a.exr"), method("b.exr"));
    assert!(method("b.exr").contains("path"), "{}", method("b.exr"));
}

#[test]
fn bad_requests_are_refused_in_one_line() {
    let sandbox = Sandbox::new();
    sandbox.write("no.exr", "no image");
    for (args, words) in [
        (&["view", "cornel"][..], &["did you mean cornell?"][..]),
        (&["view", "missing.exr"], &["missing.exr"]),
        (&["view", "no.exr"], &["no.exr"]),
        (&["view", "cornell", "--reference", "missing.exr"], &["missing.exr"]),
        (&["view", "cornell", "-o", "a.txt"], &["--output", "a.txt"]),
        (&["view", "no.exr", "-o", "a.png"], &["--output"]),
        (&["view", "cornell", "--layer", "x"], &["--layer"]),
        (&["view", "cornell", "--display", "host:x"], &["--display host:x", "localhost:14158"]),
        (&["render", "cornell", "--port", "8000"], &["--port", "--view"]),
        (&["compare", "no.exr", "no.exr", "--no-open"], &["--no-open", "--view"]),
        (&["render", "cornell", "--no-open"], &["--no-open", "--view"]),
        (&["view", "cornell", "--port", "0"], &["--port"]),
        (&["view", "cornell", "--listen", "everywhere"], &["--listen"]),
    ] {
        sandbox.run(args).refused(words);
    }
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = taken.local_addr().unwrap().port().to_string();
    for words in
        [&["view", "cornell"][..], &["render", "cornell", "-o", "a.exr", "--quality=draft", "--view"]]
    {
        let words = [words, &["--no-open", "--port", &port]].concat();
        sandbox.run(words).refused(&["cannot listen at 127.0.0.1:"]);
    }
    assert!(!sandbox.path("a.exr").exists());
    let ended =
        sandbox.command(["view", "cornell", "--no-open"]).env("SPPM_VIEW_TOKEN", "short").output().unwrap();
    assert_eq!(ended.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&ended.stderr).contains("at least 16 letters and digits"));
}

/// What the page is told first of each of these types.
fn told(page: &mut WebSocket<TcpStream>, types: &[&str]) -> BTreeMap<String, Value> {
    let mut found = BTreeMap::new();
    while found.len() < types.len() {
        match page.read().expect("it is told") {
            Message::Text(text) => {
                let message: Value = serde_json::from_str(&text).unwrap();
                let name = message["type"].as_str().unwrap().to_owned();
                if types.contains(&&name[..]) {
                    found.entry(name).or_insert(message);
                }
            }
            Message::Binary(_) => page.send(Message::text(r#"{ "type": "ack" }"#)).unwrap(),
            _ => {}
        }
    }
    found
}

#[test]
fn a_view_begins_with_what_was_asked_for() {
    let sandbox = Sandbox::new();
    image_file::write(&sandbox.path("truth.exr"), &Film::new(16, 12), &Encoding::default()).unwrap();
    let words =
        ["--reference=truth.exr", "-n=3", "--seed=9", "--depth=4", "--method=path", "--engine=reference"];
    let viewing =
        Viewing::start(&mut sandbox.command(["view", "cornell"].iter().chain(&QUICK).chain(&words)));
    let mut page = viewing.socket();
    let told = told(&mut page, &["scene", "setup", "status"]);
    assert_eq!(told["scene"]["others"], json!(["truth.exr"]));
    // It goes on until then, and no further.
    assert_eq!(told["status"]["limit"], 3);
    let setup = &told["setup"];
    assert_eq!([&setup["method"], &setup["engine"]], ["path", "reference"], "{setup}");
    for (name, value) in [
        ("width", json!(16)),
        ("height", json!(12)),
        ("photons_per_iteration", json!(1000)),
        ("max_depth", json!(4)),
        ("seed", json!("9")),
    ] {
        assert_eq!(setup["settings"][name], value, "{name}");
    }
}

/// Makes the radius of a ball 12.5, and waits until that is seen.
fn change(page: &mut WebSocket<TcpStream>) {
    page.send(Message::text(r#"{ "type": "sphere", "index": 6, "radius": 12.5 }"#)).unwrap();
    loop {
        if let Message::Binary(picture) = page.read().expect("a picture comes") {
            // The second word is the version of what is shown.
            if picture[4..8] == 2_u32.to_le_bytes() && picture[12..20] == picture[20..28] {
                return;
            }
            page.send(Message::text(r#"{ "type": "ack" }"#)).unwrap();
        }
    }
}

/// With its comments, and beside the image.
#[test]
fn a_scene_that_was_changed_and_not_saved_is_written_when_the_view_ends() {
    let sandbox = Sandbox::new();
    let text = files::builtin::find("cornell").unwrap().text;
    sandbox.write("mine.toml", text);
    let out = ["-o", "a.exr"];
    let viewing =
        Viewing::start(&mut sandbox.command(["view", "mine.toml"].iter().chain(&QUICK).chain(&out)));
    let mut page = viewing.socket();
    // It has no end of its own, however many iterations the scene file asks for.
    assert_eq!(told(&mut page, &["status"])["status"]["limit"], Value::Null);
    change(&mut page);
    let ended = viewing.end();
    assert_eq!(ended.code, Some(130), "{ended:?}");
    ended.said_one_line("interrupted: wrote a.exr after ", &["; the changed scene is in a-edited.toml\n"]);
    assert_eq!(sandbox.names(), ["a-edited.toml", "a.exr", "mine.toml"]);
    let changed = String::from_utf8(sandbox.bytes("a-edited.toml")).unwrap();
    assert_eq!(changed.lines().next(), text.lines().next());
    assert!(changed.contains("12.5") && !text.contains("12.5"), "{changed}");
}

#[test]
fn a_changed_scene_is_not_lost_with_its_image() {
    let sandbox = Sandbox::new();
    let out = ["-o", "a.exr"];
    let viewing = Viewing::start(&mut sandbox.command(["view", "cornell"].iter().chain(&QUICK).chain(&out)));
    let mut page = viewing.socket();
    change(&mut page);
    std::fs::create_dir(sandbox.path("a.exr")).unwrap();
    let ended = viewing.end();
    assert_eq!(ended.code, Some(1), "{ended:?}");
    ended.said_one_line("error: a.exr", &["; the changed scene is in a-edited.toml\n"]);
    assert!(String::from_utf8(sandbox.bytes("a-edited.toml")).unwrap().contains("12.5"));
}

/// Of each image the layer that was compared, or the image as a whole where it has no layers.
#[test]
fn the_page_shows_the_layers_that_were_asked_for() {
    let sandbox = Sandbox::new();
    write_layers(&sandbox.path("a.exr"), &["diffuse", "glossy"]);
    write_layers(&sandbox.path("b.exr"), &["glossy", "rough"]);
    image_file::write(&sandbox.path("plain.exr"), &Film::new(2, 1), &Encoding::default()).unwrap();
    let cases: [(&[&str], &str, [&str; 2]); 3] = [
        (&["compare", "a.exr", "b.exr", "--view", "--difference=d.png"], "glossy", ["a.exr", "b.exr"]),
        (
            &["compare", "plain.exr", "b.exr", "--view", "--difference=d.png", "--max-abs=0.25"],
            "image",
            ["plain.exr", "b.exr"],
        ),
        (&["view", "a.exr", "--reference=plain.exr"], "glossy", ["a.exr", "plain.exr"]),
    ];
    for (words, layer, [name, other]) in cases {
        let ask = ["--layer", "glossy", "--no-open"];
        let viewing = Viewing::start(&mut sandbox.command(words.iter().chain(&ask)));
        let told = told(&mut viewing.socket(), &["scene"]);
        let shown =
            json!({ "type": "scene", "mode": "files", "name": name, "layers": [layer], "others": [other] });
        assert_eq!(told["scene"], shown, "{words:?}");
        let ended = viewing.end();
        assert_eq!(ended.code, Some(130));
        // Bounds are told of, though the page decides how the command ends.
        let is_told = ended.stderr.contains("warning: the largest difference is 0.5, above --max-abs 0.25\n");
        assert_eq!(is_told, words.contains(&"--max-abs=0.25"), "{ended:?}");
        // It is written before the page opens.
        assert_eq!(std::fs::remove_file(sandbox.path("d.png")).is_ok(), words[0] == "compare");
    }
}

/// Under the name that it was opened by.
#[test]
fn what_is_looked_at_goes_to_the_viewer_too() {
    let sandbox = Sandbox::new();
    image_file::write(&sandbox.path("a.exr"), &Film::new(2, 1), &Encoding::default()).unwrap();
    for (target, size) in [("a.exr", &[] as &[&str]), ("cornell", &["--width=16", "--height=12"])] {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        listener.set_nonblocking(true).unwrap();
        let place = listener.local_addr().unwrap().to_string();
        let words = ["view", target, "--no-open", "--display", &place];
        let _viewing = Viewing::start(&mut sandbox.command(words.iter().chain(size)));
        let until = Instant::now() + PATIENCE;
        let mut stream = loop {
            match listener.accept() {
                Ok((stream, _)) => break stream,
                Err(error) => assert!(Instant::now() < until, "{target}: {error}"),
            }
            thread::sleep(Duration::from_millis(5));
        };
        stream.set_nonblocking(false).unwrap();
        let mut bytes = [0; 13];
        stream.read_exact(&mut bytes).unwrap();
        // A packet that creates an image of this name.
        assert_eq!(bytes[4], 4, "{bytes:?}");
        assert!(bytes[6..].starts_with(target.as_bytes()), "{bytes:?}");
    }
}

/// Every address that begins with 127 is this machine.
#[cfg(target_os = "linux")]
#[test]
fn every_page_is_served_where_it_is_asked_for() {
    let sandbox = Sandbox::new();
    image_file::write(&sandbox.path("a.exr"), &Film::new(2, 1), &Encoding::default()).unwrap();
    let scene: &[&str] = &["view", "cornell", "--width=16", "--height=12"];
    for words in [scene, &["view", "a.exr"], &["compare", "a.exr", "a.exr", "--view"]] {
        let place = ["--no-open", "--listen", "127.0.0.2"];
        let viewing = Viewing::start(&mut sandbox.command(words.iter().chain(&place)));
        assert!(viewing.page.0.starts_with("127.0.0.2:"), "{words:?}: {}", viewing.page.0);
    }
}
