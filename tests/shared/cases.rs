//! How many cases ran: one line per test, for people and for `scripts/suites`, which adds them up.

use std::io::{Write, stderr};

/// Tells on standard error, past the capture of the test harness, that `cases` of `what` held.
pub(crate) fn tell(suite: &str, cases: usize, what: &str) {
    let line = format!("{suite}: {cases} {what}\n");
    stderr().write_all(line.as_bytes()).unwrap();
}
