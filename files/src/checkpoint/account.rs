//! What a checkpoint says of its render.

use scene::{Film, Iterations, Stats, Sums};
use serde::{Deserialize, Serialize};

/// The format version that is written. Version 1, in which the scene is all text, and version 2, which has no sums that can
/// be merged, can be read too.
pub const FORMAT: u32 = 3;

/// The progress of a render: section `RNDR`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Account {
    /// Version of the program that wrote it.
    pub version: String,
    /// Version of the light transport that made the sums, [`scene::TRANSPORT`]. Files from before it was noted are of
    /// version 1, or of an unreleased program that cannot be told from it.
    #[serde(default = "first")]
    pub transport: u32,
    /// Digest of the scene, by [`crate::scene_file::digest`].
    pub scene: String,
    /// The kind of sums.
    pub sums: Sums,
    /// Completed iterations in the sums.
    pub iterations: u32,
    /// Which they are, unless they are the first ones.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub which: Option<Iterations>,
    /// Counted work and times so far.
    pub stats: Stats,
}

impl Account {
    /// The iterations in the sums.
    pub fn done(&self) -> Iterations {
        self.which.clone().unwrap_or_else(|| (0..self.iterations).into())
    }
}

/// See [`Account::transport`].
fn first() -> u32 {
    1
}

/// The image of an earlier iteration, kept to estimate the error: section `PAST`.
#[derive(Clone, Debug, PartialEq)]
pub struct Past {
    /// Iterations in the image.
    pub iterations: u32,
    /// The image.
    pub film: Film,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn iterations_are_the_first_unless_it_is_said_which() {
        let account = Account {
            version: "1".into(),
            transport: 3,
            scene: "a".into(),
            sums: Sums::Exact,
            iterations: 4,
            which: None,
            stats: Stats::default(),
        };
        assert_eq!(account.done(), (0..4).into());
        let part = Account { which: Some((7..11).into()), ..account.clone() };
        assert_eq!(part.done(), (7..11).into());
        // Files from before the version was noted.
        let text = serde_json::to_string(&account).unwrap().replace(r#""transport":3,"#, "");
        assert_eq!(serde_json::from_str::<Account>(&text).unwrap(), Account { transport: 1, ..account });
    }
}
