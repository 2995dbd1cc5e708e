//! Reports how many cases a test ran, in a line that `scripts/suites` reads and sums up.

use std::io::{Write, stderr};

/// Prints that `cases` cases of `what` passed. Writes directly to standard error, as the test harness captures
/// `eprintln!`.
pub(crate) fn tell(suite: &str, cases: usize, what: &str) {
    let line = format!("{suite}: {cases} {what}\n");
    stderr().write_all(line.as_bytes()).unwrap();
}
