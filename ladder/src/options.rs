//! How rows are run: the same for all rows that are compared.

use crate::index::Tuning;
use serde::Serialize;

/// Where random numbers come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Random {
    /// The row's own generator, as in the paper.
    Paper,
    /// The keyed streams of the reference: the same paths in every row.
    Keyed,
}

/// How flux is summed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Sums {
    /// In floats, as in the paper; what comes of it depends on the order.
    Float,
    /// In integers, as in the reference.
    Integer,
}

/// How a row is to be run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Where random numbers come from.
    pub random: Random,
    /// How flux is summed.
    pub sums: Sums,
    /// Count operations and bytes, which takes some ten times as long and gives the same image.
    pub counts_operations: bool,
    /// Free parameters of the index.
    pub tuning: Tuning,
}

impl Options {
    /// As in the paper.
    pub const fn paper() -> Self {
        let tuning = Tuning::PAPER;
        Self { random: Random::Paper, sums: Sums::Float, counts_operations: false, tuning }
    }

    /// As in the reference: every row gives its bits.
    pub const fn exact() -> Self {
        Self { random: Random::Keyed, sums: Sums::Integer, ..Self::paper() }
    }
}
