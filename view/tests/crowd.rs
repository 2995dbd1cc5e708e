//! Many clients, slow clients, and clients that send nonsense. A program of its own, as it measures its memory.

#[path = "common/mod.rs"]
mod client;

use client::{Header, Page, ask_for_socket, studio};
use proptest::strategy::{Strategy, ValueTree};
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use serde_json::json;
use std::io::Read;
use std::thread;
use std::time::Duration;
use tungstenite::Message;
use view::View;

/// Clients, beside the odd ones.
const CLIENTS: usize = 100;
/// Messages of a client that sends nonsense, over all its connections.
const NONSENSE: usize = 100_000;
/// Memory of a client: mostly buffers of 128 KiB each, at the test's end of the connection.
const PER_CLIENT: u64 = 512 << 10;
/// Nonsense may take this much more: some connections at a time, and what the allocator keeps.
const ROOM: u64 = 16 << 20;

/// Memory of this process, in bytes.
fn memory() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find(|line| line.starts_with("VmRSS")).unwrap();
    line.split_whitespace().nth(1).unwrap().parse::<u64>().unwrap() << 10
}

/// Messages that are wrong in many ways.
fn nonsense() -> impl Strategy<Value = Message> {
    use proptest::prelude::*;
    let number =
        prop_oneof![Just("1e999".to_owned()), Just("-1".into()), any::<f64>().prop_map(|v| v.to_string())];
    let nearly = number.prop_map(|n| {
        format!(r#"{{"type":"camera","id":1,"camera":{{"eye":[{n},0,0],"direction":[0,0,{n}],"up":[0,1,0],"vertical_fov_degrees":{n},"aperture_radius":0,"focus_distance":1}}}}"#)
    });
    prop_oneof![
        ".{0,200}".prop_map(Message::text),
        nearly.prop_map(Message::text),
        any::<[u8; 32]>().prop_map(|bytes| Message::binary(bytes.to_vec())),
        Just(Message::text(r#"{"type":"pick","id":4294967295,"x":null,"y":1e39}"#)),
        Just(Message::text(r#"{"type":"layer","layer":4294967295}"#)),
        Just(Message::text("[".repeat(10_000))),
    ]
}

/// Sends nonsense, on a new connection whenever the server hangs up.
fn flood(view: &View) {
    let mut runner =
        TestRunner::new_with_rng(Config::default(), TestRng::from_seed(RngAlgorithm::ChaCha, &[7; 32]));
    let strategy = nonsense();
    let some: Vec<Message> = (0..500).map(|_| strategy.new_tree(&mut runner).unwrap().current()).collect();
    let (mut sent, mut page) = (0, None);
    while sent < NONSENSE {
        let now = page.get_or_insert_with(|| Page::open(view));
        // Messages that the system takes and the server never reads count: they were sent.
        let is_there = (0..1000).all(|i| now.try_send(some[(sent + i) % some.len()].clone()));
        sent += 1000;
        if !is_there {
            page = None;
        }
    }
}

#[test]
fn a_crowd_a_slow_client_and_a_mad_one_cost_little_and_slow_nobody() {
    let view = studio();
    let mut page = Page::open(&view);
    page.picture(Header::is_whole);
    let empty = memory();
    let mut crowd: Vec<Page> = (0..CLIENTS).map(|_| Page::open(&view)).collect();
    let mut slow = Page::open(&view);
    for one in &mut crowd {
        one.picture(Header::is_whole);
    }
    let before = memory();
    assert!(
        before - empty < CLIENTS as u64 * PER_CLIENT,
        "{CLIENTS} clients take {} MiB",
        (before - empty) >> 20
    );
    slow.stream().set_nodelay(true).unwrap();
    thread::scope(|scope| {
        let mad = scope.spawn(|| flood(&view));
        let mut last = page.picture(Header::is_whole);
        while !mad.is_finished() {
            // A byte now and then.
            let _ = slow.stream().read(&mut [0]);
            last = page.picture(|picture| picture.number > last.number);
            thread::sleep(Duration::from_millis(20));
        }
    });
    for one in &mut crowd {
        one.picture(Header::is_whole);
    }
    let grown = memory().saturating_sub(before);
    assert!(grown < ROOM, "memory grew by {} MiB", grown >> 20);
    page.send(&json!({ "type": "pick", "id": 3, "x": 0.68, "y": 0.75 }));
    assert_eq!(page.typed("picked")["sphere"], 6);
}

#[test]
fn too_many_pages_are_turned_away_and_let_in_when_others_leave() {
    let view = studio();
    let open = || ask_for_socket(&view);
    let pages: Vec<Page> = (0..128).map(|_| Page::open(&view)).collect();
    assert_eq!(open(), 503);
    drop(pages);
    let is_let_in = (0..100).any(|_| {
        thread::sleep(Duration::from_millis(50));
        open() == 101
    });
    assert!(is_let_in);
}
