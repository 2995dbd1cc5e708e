//! Runs rows side by side with the reference and finds their first difference.

use crate::difference::Outcome;
use ladder::{Options, Row};
use scene::{Engine, Scene, Settings};

/// A built-in scene at a small size, but with large radii, so that visible points reach several cells and get many
/// photons.
pub(crate) fn builtin(name: &str) -> (Scene, Settings) {
    let scene = files::builtin::scene(name).unwrap();
    let settings = Settings {
        width: 33,
        height: 21,
        iterations: 2,
        photons_per_iteration: 1500,
        initial_radius: 9.0,
        ..scene.settings
    };
    (scene, settings)
}

/// What rows are compared with: the row of the fast engine with the reference, and the paper's rows, which choose lights
/// by power for direct light too, with a reference that does the same.
pub(crate) struct References<'a> {
    engine: reference::Sppm<'a>,
    by_power: reference::Sppm<'a>,
}

impl<'a> References<'a> {
    pub(crate) fn new(scene: &'a Scene, settings: &Settings) -> Self {
        let new = || reference::Sppm::new(scene, settings);
        Self { engine: new(), by_power: new().lit_by_power() }
    }

    pub(crate) fn iterate(&mut self) {
        self.engine.iterate();
        self.by_power.iterate();
    }

    /// What a row must give.
    pub(crate) fn of(&self, row: &Row) -> Outcome {
        Outcome::of(if row.is_always_exact() { &self.engine } else { &self.by_power })
    }
}

/// Compares the bits of rows with the reference's after each iteration. Returns the number of photon contributions, or
/// describes the first difference.
pub(crate) fn first_difference(
    scene: &Scene,
    settings: &Settings,
    rows: &[&Row],
    options: &Options,
) -> Result<u64, String> {
    let mut references = References::new(scene, settings);
    let mut rungs: Vec<_> = rows.iter().map(|row| (*row, row.start(scene, settings, options))).collect();
    for iteration in 0..settings.iterations {
        references.iterate();
        for (row, rung) in &mut rungs {
            rung.iterate();
            if let Some(difference) = references.of(row).difference(&Outcome::of(&**rung)) {
                return Err(format!(
                    "{}, {settings:?}: row {} differs in iteration {iteration}: {difference}",
                    scene.name, row.name
                ));
            }
        }
    }
    Ok(references.engine.stats().contributions)
}

/// Expects all rows to give the reference's bits, and that some photons contribute.
pub(crate) fn assert_exact(scene: &Scene, settings: &Settings, rows: &[&Row], options: &Options) {
    let contributions =
        first_difference(scene, settings, rows, options).unwrap_or_else(|difference| panic!("{difference}"));
    assert!(
        contributions > 0 || settings.max_depth == 1,
        "{}: no photon counts, so nothing is shown",
        scene.name
    );
}
