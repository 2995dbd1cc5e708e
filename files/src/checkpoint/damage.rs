//! The ways in which a checkpoint can be unusable.

use super::account::FORMAT;
use crate::atomic_file::reason;
use scene::TRANSPORT;
use std::io;
use thiserror::Error;

/// Why a render cannot be resumed from a file. Displays as one line that continues the file's name.
#[derive(Debug, Error)]
pub enum Damage {
    /// It does not begin with the checkpoint magic number.
    #[error("is no checkpoint of sppm")]
    NoCheckpoint,
    /// It is shorter than its header says.
    #[error("is cut short: it has {has} of its {length} bytes")]
    Truncated {
        /// Its actual length in bytes.
        has: u64,
        /// The length in its header.
        length: u64,
    },
    /// It is longer than its header says.
    #[error("has {has} bytes where its own count is {length}; something was appended to it")]
    Appended {
        /// Its actual length in bytes.
        has: u64,
        /// The length in its header.
        length: u64,
    },
    /// A checksum does not match.
    #[error("is damaged: the checksum of {section} does not match")]
    Flipped {
        /// The section with that checksum.
        section: &'static str,
    },
    /// Its format version is not supported.
    #[error("has format {found}; this version of sppm reads formats up to {FORMAT}")]
    Version {
        /// The version in its header.
        found: u32,
    },
    /// Its sums are of another version of the light transport.
    #[error(
        "was begun by version {found} of the light transport (sppm {program}), and this program computes version \
         {TRANSPORT}, another image; go on with the program that began it, or render anew under another name"
    )]
    Transport {
        /// The version that made the sums.
        found: u32,
        /// The version of the program that wrote the file.
        program: String,
    },
    /// Its sums and its scene come from different renders.
    #[error("has the sums of another scene: they belong to {theirs}, and its scene is {ours}")]
    OtherScene {
        /// The scene digest recorded with the sums.
        theirs: String,
        /// The digest of the scene in the file.
        ours: String,
    },
    /// Its checksums match, but the content is not valid.
    #[error("is wrong: {section} {problem}")]
    Invalid {
        /// The section with the invalid content.
        section: &'static str,
        /// What is invalid; continues the section's name.
        problem: String,
    },
    /// It is not there, or no regular file.
    #[error("{0}")]
    Unopened(String),
    /// Reading it failed.
    #[error("cannot be read: {}", reason(.0))]
    Io(#[from] io::Error),
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of two numbers the file's own is told first, and of versions the file's before the program's.
    #[test]
    fn messages_tell_each_number_in_its_place() {
        let told = |damage: Damage| damage.to_string();
        assert_eq!(told(Damage::Truncated { has: 3, length: 9 }), "is cut short: it has 3 of its 9 bytes");
        assert_eq!(
            told(Damage::Appended { has: 9, length: 3 }),
            "has 9 bytes where its own count is 3; something was appended to it"
        );
        assert_eq!(
            told(Damage::Version { found: 99 }),
            format!("has format 99; this version of sppm reads formats up to {FORMAT}")
        );
        let line = told(Damage::Transport { found: 2, program: "0.2.0".into() });
        let words = format!(
            "version 2 of the light transport (sppm 0.2.0), and this program computes version {TRANSPORT},"
        );
        assert!(line.contains(&words), "{line}");
        assert_eq!(told(Damage::Unopened("is a pipe".into())), "is a pipe");
        let read = told(Damage::Io(io::Error::from_raw_os_error(5)));
        assert!(read.starts_with("cannot be read: ") && !read.contains("os error"), "{read}");
    }
}
