//! How balls are searched, and what a search costs.

use scene::Still;

/// How rays find the balls that they hit. The hits are the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Search {
    /// One by one: for few balls.
    InTurn,
    /// In clusters of sixteen, each with a queue of rays: up to about a thousand balls.
    Clusters,
    /// In a tree of bounding boxes: for many balls.
    Tree,
}

/// Counted work of searches. The image does not depend on it; the time does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Boxes of a tree below its top, or clusters, that rays have entered.
    pub boxes: u64,
    /// Balls that were tested by the exact formula.
    pub balls: u64,
}

/// The number of balls: spheres that rays meet from outside, solid or glass. Grounds, which are few, are none.
pub fn ball_count(still: &Still) -> usize {
    still.roles.iter().filter(|role| !role.is_anchored()).count()
}
