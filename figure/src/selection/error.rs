//! Faults in selections.

/// A fault in the text of a selection. Displays as `column 14: ...`.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("column {column}: {problem}")]
pub struct SelectionError {
    /// Where it is, in characters from 1.
    pub column: usize,
    /// What is wrong, and what would be right.
    pub problem: String,
}

impl SelectionError {
    /// The fault at byte `at` of `text`.
    pub(super) fn new(text: &str, at: usize, problem: impl Into<String>) -> Self {
        let before = text.get(..at).unwrap_or(text);
        Self { column: before.chars().count() + 1, problem: problem.into() }
    }
}
