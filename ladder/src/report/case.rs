//! One render that every row does.

use scene::{Scene, Settings};

/// One render that every row does.
#[derive(Clone, Debug)]
pub struct Case {
    /// The scene's name in tables and files.
    pub name: String,
    /// The scene.
    pub scene: Scene,
    /// Of all rows.
    pub settings: Settings,
    /// In a sweep, the value of what is varied; else 0.
    pub value: u64,
}
