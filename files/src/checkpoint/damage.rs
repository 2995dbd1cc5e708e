//! What can be wrong with a checkpoint.

use super::FORMAT;
use crate::atomic_file::reason;
use std::io;
use thiserror::Error;

/// Why a file cannot be gone on from. Displays as what is to be read after its name, on one line.
#[derive(Debug, Error)]
pub enum Damage {
    /// It begins like no checkpoint.
    #[error("is no checkpoint of sppm")]
    NoCheckpoint,
    /// It ends too early.
    #[error("is cut short: it has {has} of its {length} bytes")]
    Truncated {
        /// Bytes there are.
        has: u64,
        /// Bytes that there were, by its header.
        length: u64,
    },
    /// It ends too late.
    #[error("has {has} bytes where its own count is {length}; something was appended to it")]
    Appended {
        /// Bytes there are.
        has: u64,
        /// Bytes that there were, by its header.
        length: u64,
    },
    /// Some bits are not what was written.
    #[error("is damaged: the checksum of {section} does not match")]
    Flipped {
        /// Where they are.
        section: &'static str,
    },
    /// It is of another format.
    #[error("has format {found}; this version of sppm reads format {FORMAT}")]
    Version {
        /// Which.
        found: u32,
    },
    /// It was put together from two.
    #[error("has the sums of another scene: they belong to {theirs}, and its scene is {ours}")]
    OtherScene {
        /// The digest that the sums belong to.
        theirs: String,
        /// The digest of the scene in the file.
        ours: String,
    },
    /// Its checksums match, but nothing of the kind is ever written.
    #[error("is wrong: {section} {problem}")]
    Invalid {
        /// Where.
        section: &'static str,
        /// What, to be read after the section.
        problem: String,
    },
    /// It cannot be read.
    #[error("cannot be read: {}", reason(.0))]
    Io(#[from] io::Error),
}
