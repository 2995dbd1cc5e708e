//! A case: one render that all rows run.

use scene::{Scene, Settings};

/// One render that all rows run.
#[derive(Clone, Debug)]
pub struct Case {
    /// The scene's name in tables and files.
    pub name: String,
    /// The scene.
    pub scene: Scene,
    /// The settings, for all rows.
    pub settings: Settings,
    /// In a sweep, the value of the varied parameter; else 0.
    pub value: u64,
}
