//! Eight words that lie together in memory.

use bytemuck::{Pod, Zeroable};

/// Eight words: a row of a table, or a record. Lanes fetch rows by aligned loads and a transpose (on the machines at hand
/// four times faster than eight gathers).
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C, align(32))]
pub struct Row(pub [f32; 8]);
