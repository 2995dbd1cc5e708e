//! A client of the server, without a browser.

#![allow(dead_code, reason = "each test program uses a part of it")]

use render::EngineChoice;
use scene::Settings;
use serde_json::Value;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};
use tungstenite::client::IntoClientRequest;
use tungstenite::{Message, WebSocket};
use view::{Place, Project, View};

/// What takes longer is taken to be lost.
const PATIENCE: Duration = Duration::from_mins(1);

/// A small image of the Cornell Box, so that an iteration takes milliseconds.
pub(crate) fn project() -> Project {
    let mut scene = files::builtin::scene("cornell").unwrap();
    scene.settings = Settings { width: 64, height: 48, photons_per_iteration: 2000, ..scene.settings };
    Project {
        scene,
        text: files::builtin::find("cornell").map(|builtin| builtin.text.into()),
        stem: "cornell".into(),
        engine: EngineChoice::default(),
        threads: Some(2),
        memory_limit: None,
        limit: None,
    }
}

pub(crate) fn studio() -> View {
    View::studio(project(), None, None, &Place::default()).unwrap()
}

/// The host and port of the page, and its path.
pub(crate) fn place(view: &View) -> (String, String) {
    let rest = view.address().strip_prefix("http://").unwrap();
    let (host, path) = rest.split_once('/').unwrap();
    (host.into(), format!("/{path}"))
}

/// An answer to a request over HTTP.
pub(crate) struct Reply {
    pub(crate) status: u16,
    pub(crate) head: String,
    pub(crate) body: Vec<u8>,
}

/// Sends a request with these lines in its head, to the server of `view`.
pub(crate) fn ask(view: &View, method: &str, path: &str, lines: &[&str]) -> Reply {
    let mut stream = TcpStream::connect(place(view).0).unwrap();
    let head = format!("{method} {path} HTTP/1.1\r\nConnection: close\r\n{}\r\n\r\n", lines.join("\r\n"));
    stream.write_all(head.as_bytes()).unwrap();
    let mut all = Vec::new();
    stream.read_to_end(&mut all).unwrap();
    let end = all.windows(4).position(|four| four == b"\r\n\r\n").unwrap();
    let head = String::from_utf8(all[..end].to_vec()).unwrap().to_lowercase();
    let status = head.split(' ').nth(1).unwrap().parse().unwrap();
    Reply { status, head, body: all[end + 4..].to_vec() }
}

/// What `path`, below that of the page, leads to.
pub(crate) fn get(view: &View, path: &str) -> Reply {
    let (host, base) = place(view);
    ask(view, "GET", &format!("{base}{path}"), &[&format!("Host: {host}")])
}

/// A page's connection.
pub(crate) struct Page {
    socket: WebSocket<TcpStream>,
    /// Texts that were read while something else was waited for.
    texts: Vec<Value>,
    pictures: Vec<Header>,
    /// Whether it says of each picture at once that it is drawn.
    pub(crate) draws: bool,
}

/// The header of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Header {
    pub(crate) version: u32,
    pub(crate) iterations: u32,
    pub(crate) size: [u32; 2],
    pub(crate) whole: [u32; 2],
    pub(crate) layer: u32,
    pub(crate) number: u32,
}

impl Header {
    fn read(bytes: &[u8]) -> Self {
        let word = |at: usize| u32::from_le_bytes(bytes[4 * at..][..4].try_into().unwrap());
        let header = Self {
            version: word(1),
            iterations: word(2),
            size: [word(3), word(4)],
            whole: [word(5), word(6)],
            layer: word(7),
            number: word(10),
        };
        assert_eq!(bytes.len(), view::HEADER + 4 * (header.size[0] * header.size[1]) as usize);
        header
    }

    pub(crate) fn is_whole(&self) -> bool {
        self.size == self.whole
    }
}

impl Page {
    pub(crate) fn open(view: &View) -> Self {
        let (host, path) = place(view);
        let stream = TcpStream::connect(&host).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        let request = format!("ws://{host}{path}socket").into_client_request().unwrap();
        let (socket, _) = tungstenite::client(request, stream).unwrap();
        Self { socket, texts: Vec::new(), pictures: Vec::new(), draws: true }
    }

    pub(crate) fn send(&mut self, request: &Value) {
        self.socket.send(Message::text(request.to_string())).unwrap();
    }

    /// Sends any message; false if the server has hung up.
    pub(crate) fn try_send(&mut self, message: Message) -> bool {
        self.socket.send(message).is_ok()
    }

    pub(crate) fn stream(&mut self) -> &mut TcpStream {
        self.socket.get_mut()
    }

    /// Reads a message, and answers a picture as a page does when it has drawn it; `None` if the server has hung up.
    fn read(&mut self) -> Option<()> {
        match self.socket.read().ok()? {
            Message::Text(text) => self.texts.push(serde_json::from_str(text.as_str()).unwrap()),
            Message::Binary(bytes) => {
                self.pictures.push(Header::read(&bytes));
                if self.draws && !self.try_send(Message::text(r#"{ "type": "ack" }"#)) {
                    return None;
                }
            }
            Message::Close(_) => return None,
            _ => {}
        }
        Some(())
    }

    /// The next text that `is_meant`.
    pub(crate) fn text(&mut self, is_meant: impl Fn(&Value) -> bool) -> Value {
        let until = Instant::now() + PATIENCE;
        loop {
            if let Some(at) = self.texts.iter().position(&is_meant) {
                return self.texts.remove(at);
            }
            assert!(Instant::now() < until, "it does not come; there is {:?}", self.texts.last());
            self.read().expect("the server is there");
        }
    }

    /// Whether an answer to the request `id` comes, before the server hangs up.
    pub(crate) fn is_answered(&mut self, id: u32) -> bool {
        while self.texts.iter().all(|text| text["id"] != id) {
            if self.read().is_none() {
                return false;
            }
        }
        true
    }

    /// The next text of this type.
    pub(crate) fn typed(&mut self, kind: &str) -> Value {
        self.text(|text| text["type"] == kind)
    }

    /// The next picture that `is_meant`; those before it are checked for their order, and left out.
    pub(crate) fn picture(&mut self, mut is_meant: impl FnMut(&Header) -> bool) -> Header {
        let until = Instant::now() + PATIENCE;
        loop {
            while !self.pictures.is_empty() {
                let picture = self.pictures.remove(0);
                if is_meant(&picture) {
                    return picture;
                }
            }
            assert!(Instant::now() < until, "no such picture comes");
            self.read().expect("the server is there");
        }
    }

    /// Keeps the image, and returns the start of the paths of its files, and its iterations.
    pub(crate) fn keep(&mut self) -> (String, u64) {
        self.send(&serde_json::json!({ "type": "keep", "id": 77 }));
        let kept = self.text(|text| text["id"] == 77);
        assert_eq!(kept["type"], "kept", "{kept}");
        (format!("save/{}/", kept["number"]), kept["iterations"].as_u64().unwrap())
    }

    /// The camera, after the server has told of it.
    pub(crate) fn camera(&mut self) -> Value {
        self.typed("setup")["camera"].clone()
    }
}

/// The status of the answer to a page's request for a websocket.
pub(crate) fn ask_for_socket(view: &View) -> u16 {
    let (host, path) = place(view);
    let stream = TcpStream::connect(&host).unwrap();
    let request = format!("ws://{host}{path}socket").into_client_request().unwrap();
    match tungstenite::client(request, stream) {
        Ok((_, response)) => response.status().as_u16(),
        Err(tungstenite::HandshakeError::Failure(tungstenite::Error::Http(response))) => {
            response.status().as_u16()
        }
        Err(error) => panic!("{error}"),
    }
}
