//! Errors in scene files, displayed as one line with the position of the fault.

use std::fmt::Write;
use thiserror::Error;

/// An error in a scene file or another TOML file of ours. Displays as one line,
/// `path:line:column: what is wrong and how to fix it`.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{}{}: {message}", escape(.name), place(*.position))]
pub struct FileError {
    name: String,
    position: Option<Position>,
    message: String,
}

/// A position in a text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Position {
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
}

impl FileError {
    /// The path of the file as the caller gave it.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Where the fault is; `None` if the file could not be read at all.
    pub fn position(&self) -> Option<Position> {
        self.position
    }

    /// What is wrong and how to fix it.
    pub fn message(&self) -> &str {
        &self.message
    }

    /// An error for a file that could not be read.
    pub(super) fn unread(name: &str, message: &str) -> Self {
        Self { name: name.into(), position: None, message: escape(message) }
    }

    /// An error for a fault in the text of a file.
    pub(super) fn in_text(name: &str, text: &str, fault: &Fault) -> Self {
        let position = Some(Position::of(text, fault.at));
        Self { name: name.into(), position, message: escape(&fault.message) }
    }
}

impl Position {
    /// The position of byte `at` of `text`. A byte order mark does not count as a column.
    pub(super) fn of(text: &str, at: usize) -> Self {
        let before = &text[..text.floor_char_boundary(at)];
        let (line, start) = match before.rfind('\n') {
            Some(newline) => (1 + before.bytes().filter(|&b| b == b'\n').count(), newline + 1),
            None => {
                (1, if text.starts_with('\u{feff}') { '\u{feff}'.len_utf8().min(before.len()) } else { 0 })
            }
        };
        Self { line, column: 1 + before[start..].chars().count() }
    }
}

/// A fault at a byte offset of the text, before it becomes a [`FileError`].
#[derive(Debug)]
pub struct Fault {
    pub(super) at: usize,
    pub(super) message: String,
}

impl Fault {
    pub(super) fn new(at: usize, message: impl Into<String>) -> Self {
        Self { at, message: message.into() }
    }
}

/// `text` in double quotes, shortened, and escaped so that it stays on one line.
pub(super) fn quote(text: &str) -> String {
    format!("\"{}\"", short(text).escape_debug())
}

/// `text`, cut after 40 characters, so that a long value does not make a long message.
pub(super) fn short(text: &str) -> String {
    match text.char_indices().nth(40) {
        Some((cut, _)) => format!("{}...", &text[..cut]),
        None => text.into(),
    }
}

/// The candidate most similar to `word` as " (did you mean ...?)", or nothing if none is similar enough.
pub(super) fn suggestion<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> String {
    /// Least Jaro similarity of a suggestion; clap uses the same for its options.
    const NEAR: f64 = 0.7;
    let word = short(word);
    let near = candidates.into_iter().map(|c| (strsim::jaro(&word, &short(c)), c)).filter(|(s, _)| *s > NEAR);
    match near.max_by(|a, b| a.0.total_cmp(&b.0)) {
        Some((_, best)) => format!(" (did you mean {}?)", quote(best)),
        None => String::new(),
    }
}

fn place(position: Option<Position>) -> String {
    position.map_or_else(String::new, |p| format!(":{}:{}", p.line, p.column))
}

/// `text` with control characters and line separators escaped.
pub(super) fn escape(text: &str) -> String {
    let mut line = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            c if c.is_control() || matches!(c, '\u{2028}' | '\u{2029}') => {
                let _ = write!(line, "{}", c.escape_debug()); // writing to a String cannot fail
            }
            c => line.push(c),
        }
    }
    line
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_count_characters() {
        let position = |at| {
            let p = Position::of("\u{feff}ab\r\n\u{e4}\u{1f600}x\n", at);
            (p.line, p.column)
        };
        assert_eq!(position(0), (1, 1));
        assert_eq!(position(3), (1, 1));
        assert_eq!(position(4), (1, 2));
        assert_eq!(position(7), (2, 1));
        assert_eq!(position(13), (2, 3));
        assert_eq!(position(15), (3, 1));
        assert_eq!(position(99), (3, 1));
    }

    #[test]
    fn a_line_is_made_of_what_can_be_asked_for() {
        let error = FileError::in_text("a.toml", "one\ntwo", &Fault::new(5, "is wrong".to_owned()));
        assert_eq!((error.name(), error.message()), ("a.toml", "is wrong"));
        assert_eq!(error.position(), Some(Position { line: 2, column: 2 }));
        assert_eq!(error.to_string(), "a.toml:2:2: is wrong");
    }

    #[test]
    fn a_path_or_message_with_line_breaks_stays_on_one_line() {
        let error = FileError::unread("a\nb.toml", "no\r\u{2028}such\u{1b}[31m file");
        assert_eq!(error.to_string(), "a\\nb.toml: no\\r\\u{2028}such\\u{1b}[31m file");
    }
}
