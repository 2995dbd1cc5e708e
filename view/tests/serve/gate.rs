//! Who gets in.

use crate::client::{Page, ask, get, place, project, studio};
use serde_json::json;
use tungstenite::Message;
use view::{Place, View};

/// The lines of a head that asks for a websocket.
fn upgrade(host: &str) -> Vec<String> {
    [
        &format!("Host: {host}"),
        "Upgrade: websocket",
        "Connection: Upgrade",
        "Sec-WebSocket-Version: 13",
        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==",
    ]
    .map(str::to_owned)
    .to_vec()
}

#[test]
fn foreign_hosts_foreign_pages_and_who_does_not_know_the_token_are_refused() {
    let view = studio();
    let (host, path) = place(&view);
    let port = host.rsplit_once(':').unwrap().1;
    for below in ["", "main.js", "socket", "save/1/image.exr", "other/0"] {
        let path = format!("{path}{below}");
        let status = |path: &str, lines: &[&str]| ask(&view, "GET", path, lines).status;
        let own = format!("Host: {host}");
        assert_eq!(status(&path, &[&format!("Host: evil.example:{port}")]), 403, "{below}");
        assert_eq!(status(&path, &[&own, "Origin: http://evil.example"]), 403, "{below}");
        assert_eq!(status(&path, &[&own, "Origin: null"]), 403, "{below}");
        assert_eq!(status(&format!("/{below}"), &[&own]), 403, "{below}");
        let other = format!("/{}/{below}", "0".repeat(32));
        assert_eq!(status(&other, &[&own]), 403, "{below}");
        assert_ne!(status(&path, &[&own, &format!("Origin: http://{host}")]), 403, "{below}");
        assert_eq!(ask(&view, "POST", &path, &[&own]).status, 405, "{below}");
    }
}

/// Nobody can open the address of all networks, so that of this machine is told, with the port that it got.
#[test]
fn a_view_for_all_networks_tells_where_it_can_be_opened() {
    let all = Place { ip: [0; 4].into(), ..Place::default() };
    let view = View::studio(project(), None, None, &all).unwrap();
    let (host, port) = (place(&view).0, place(&view).0.rsplit_once(':').unwrap().1.to_owned());
    assert_eq!(host, format!("127.0.0.1:{port}"));
    assert_ne!(port, "0");
    assert_eq!(get(&view, "").status, 200);
}

/// Browsers let any page open a websocket.
#[test]
fn websockets_are_for_ones_own_page() {
    let view = studio();
    let (host, path) = place(&view);
    let status = |path: &str, origin: Option<&str>, host: &str| {
        let mut lines = upgrade(host);
        lines.remove(2);
        lines.extend(origin.map(|origin| format!("Origin: {origin}")));
        let lines: Vec<&str> = lines.iter().map(String::as_str).collect();
        ask(&view, "GET", path, &lines).status
    };
    let socket = format!("{path}socket");
    assert_eq!(status(&socket, Some("http://evil.example"), &host), 403);
    assert_eq!(status(&socket, None, "evil.example"), 403);
    assert_eq!(status("/socket", Some(&format!("http://{host}")), &host), 403);
}

#[test]
fn answers_say_that_nothing_foreign_is_loaded_or_let_in() {
    let view = studio();
    for (path, status) in [("", 200), ("main.js", 200), ("nothing", 404), ("save/9/image.exr", 404)] {
        let reply = get(&view, path);
        assert_eq!(reply.status, status, "{path}");
        for line in [
            "content-security-policy: default-src 'none'",
            "x-content-type-options: nosniff",
            "referrer-policy: no-referrer",
            "cache-control: no-store",
        ] {
            assert!(reply.head.contains(line), "{path}: {}", reply.head);
        }
        assert!(!reply.head.contains("access-control"), "{path}: {}", reply.head);
    }
}

/// Whatever the page asks for is there, and with a type that browsers run under `nosniff`.
#[test]
fn all_files_of_the_page_are_served() {
    let view = studio();
    let page = String::from_utf8(get(&view, "").body).unwrap();
    assert!(page.contains("main.js") && page.contains("style.css"));
    let scripts =
        ["main", "camera", "canvas", "gl", "panel", "picture", "socket", "spheres", "tone", "viewer"];
    for name in scripts {
        let reply = get(&view, &format!("{name}.js"));
        assert!(reply.status == 200 && reply.head.contains("content-type: text/javascript"), "{name}");
        let text = String::from_utf8(reply.body).unwrap();
        for line in text.lines().filter(|line| line.starts_with("import ")) {
            let import = line.split('"').nth(1).unwrap().strip_prefix("./").unwrap();
            assert_eq!(get(&view, import).status, 200, "{line}");
        }
    }
    assert!(get(&view, "style.css").head.contains("content-type: text/css"));
    assert!(get(&view, "icon.svg").head.contains("content-type: image/svg+xml"));
}

/// Sixteen times it is told that nothing was understood.
#[test]
fn a_page_that_goes_on_with_nonsense_is_left() {
    let view = studio();
    let mut page = Page::open(&view);
    for nonsense in [r#"{ "type": "nonsense" }"#, "[", "", r#"{ "type": "pick", "id": 1 }"#].repeat(4) {
        assert!(page.try_send(Message::text(nonsense)));
        assert_eq!(page.typed("refused")["problem"], "that request is unknown");
    }
    // What cannot be is no nonsense.
    page.send(&json!({ "type": "sphere", "index": 99, "radius": 1 }));
    assert_eq!(page.typed("refused")["problem"], "there is no sphere 100; there are 9");
    page.send(&json!({ "type": "describe", "id": 1, "index": 6 }));
    assert!(page.is_answered(1));
    page.try_send(Message::binary(vec![0]));
    page.try_send(Message::text(r#"{ "type": "describe", "id": 2, "index": 6 }"#));
    assert!(!page.is_answered(2));
}
