//! A row beside the reference, and where they first differ.

use ladder::{Options, Row};
use scene::{Engine, Film, Plane, Rgb, Scene, Settings, Stats};

/// All that an engine shows: planes, in the order of the passes that make them, and counted work.
pub(crate) struct Shown {
    pub(crate) planes: [(&'static str, Vec<f32>); 4],
    pub(crate) work: [(&'static str, u64); 7],
}

impl Shown {
    pub(crate) fn of(engine: &(impl Engine + ?Sized)) -> Self {
        let film = |film: Film| film.pixels.iter().flat_map(Rgb::to_array).collect();
        let plane = |plane: Option<Plane>| plane.unwrap().values;
        let stats: Stats = *engine.stats();
        Self {
            planes: [
                ("direct", film(engine.direct().unwrap())),
                ("count", plane(engine.count())),
                ("radius", plane(engine.radius())),
                ("image", film(engine.develop())),
            ],
            work: [
                ("camera_segments", stats.camera_segments),
                ("shadow_rays", stats.shadow_rays),
                ("visible_points", stats.visible_points),
                ("photons", stats.photons),
                ("photon_segments", stats.photon_segments),
                ("deposits", stats.deposits),
                ("contributions", stats.contributions),
            ],
        }
    }

    /// The first difference of `actual` in the planes of the given names and in the work, by bits.
    pub(crate) fn difference(&self, actual: &Self, names: &[&str]) -> Option<String> {
        let planes = self.planes.iter().zip(&actual.planes).filter(|((name, _), _)| names.contains(name));
        let in_planes = planes.filter_map(|((name, expected), (_, actual))| {
            assert_eq!(expected.len(), actual.len(), "{name}");
            let pairs = || expected.iter().zip(actual).enumerate();
            let differs = |(_, (e, a)): &(usize, (&f32, &f32))| e.to_bits() != a.to_bits();
            let (index, (e, a)) = pairs().find(differs)?;
            let count = pairs().filter(differs).count();
            let (have, want) = (a.to_bits(), e.to_bits());
            Some(format!(
                "{name}[{index}] is {a:?} ({have:#010x}) instead of {e:?} ({want:#010x}), {count} in all"
            ))
        });
        let work = self.work.iter().zip(&actual.work).filter(|(expected, actual)| expected != actual);
        let in_work = work.map(|((name, e), (_, a))| format!("{name} is {a} instead of {e}"));
        let all: Vec<String> = in_planes.chain(in_work).collect();
        (!all.is_empty()).then(|| all.join("; "))
    }
}

/// All planes.
pub(crate) const ALL: [&str; 4] = ["direct", "count", "radius", "image"];

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
        let expected = Shown::of(&reference);
        for (name, rung) in &mut rungs {
            rung.iterate();
            if let Some(difference) = expected.difference(&Shown::of(&**rung), &ALL) {
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
