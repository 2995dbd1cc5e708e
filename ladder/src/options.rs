//! The options for running rows. They are the same for all rows that are compared.

use crate::index::Tuning;
use serde::Serialize;

/// The source of random numbers.
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
    /// In floats, as in the paper; the result depends on the order.
    Float,
    /// In integers, as in the reference.
    Integer,
}

/// The options for running rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// The source of random numbers.
    pub random: Random,
    /// How flux is summed.
    pub sums: Sums,
    /// Whether to count operations and bytes. This takes about ten times as long and gives the same image.
    pub counts_operations: bool,
    /// Free parameters of the index.
    pub tuning: Tuning,
}

impl Options {
    /// The options of the paper.
    pub const fn paper() -> Self {
        let tuning = Tuning::PAPER;
        Self { random: Random::Paper, sums: Sums::Float, counts_operations: false, tuning }
    }

    /// The options with which every row gives the reference's image bit for bit (see the crate).
    pub const fn exact() -> Self {
        Self { random: Random::Keyed, sums: Sums::Integer, ..Self::paper() }
    }
}
