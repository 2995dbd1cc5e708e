//! A row beside the reference, and where they first differ.

use crate::difference::Outcome;
use ladder::{Options, Row};
use scene::{Engine, Scene, Settings};

/// A built-in scene, small, but with wide radii, so that visible points lie in several cells and get many photons.
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

/// The first difference of a row's bits from the reference's, after each iteration; without any, how often photons
/// have counted.
pub(crate) fn first_difference(
    scene: &Scene,
    settings: &Settings,
    rows: &[&Row],
    options: &Options,
) -> Result<u64, String> {
    let mut reference = reference::Sppm::new(scene, settings);
    let mut rungs: Vec<_> = rows.iter().map(|row| (row.name, row.start(scene, settings, options))).collect();
    for iteration in 0..settings.iterations {
        reference.iterate();
        let expected = Outcome::of(&reference);
        for (name, rung) in &mut rungs {
            rung.iterate();
            if let Some(difference) = expected.difference(&Outcome::of(&**rung)) {
                return Err(format!(
                    "{}, {settings:?}: row {name} differs in iteration {iteration}: {difference}",
                    scene.name
                ));
            }
        }
    }
    Ok(reference.stats().contributions)
}

/// Expects of every row of `rows` the reference's bits, and that photons count.
pub(crate) fn assert_exact(scene: &Scene, settings: &Settings, rows: &[&Row], options: &Options) {
    let contributions =
        first_difference(scene, settings, rows, options).unwrap_or_else(|difference| panic!("{difference}"));
    assert!(
        contributions > 0 || settings.max_depth == 1,
        "{}: no photon counts, so nothing is shown",
        scene.name
    );
}
