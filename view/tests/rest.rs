//! A view that nobody looks at. A program of its own, as it measures its processor time.

#[path = "common/mod.rs"]
mod client;

use client::{Page, studio};
use std::thread::sleep;
use std::time::Duration;

/// Processor time of this process, in ticks of the system.
fn ticks() -> u64 {
    let status = std::fs::read_to_string("/proc/self/stat").unwrap();
    let rest = status.rsplit_once(')').unwrap().1;
    rest.split(' ').skip(12).take(2).map(|field| field.parse::<u64>().unwrap()).sum()
}

#[test]
fn the_processor_rests_within_a_second_of_the_last_page() {
    let view = studio();
    let mut page = Page::open(&view);
    page.picture(|picture| picture.is_whole() && picture.iterations > 2);
    drop(page);
    sleep(Duration::from_secs(1));
    let before = ticks();
    sleep(Duration::from_secs(2));
    let taken = ticks() - before;
    // A tick is 10 ms; what is left are the looks of waiting threads. One thread that worked would take 200.
    assert!(taken <= 10, "{taken} ticks in 2 s");
    // Somebody comes back: it goes on.
    let mut page = Page::open(&view);
    let first = page.picture(|_| true);
    page.picture(|picture| picture.iterations > first.iterations);
}
