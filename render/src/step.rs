//! The progress of a render after each iteration.

use scene::{PhotonSums, Resumable, Sums};
use serde::Serialize;

/// The progress of a render after an iteration.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Step {
    /// Iterations done.
    pub iteration: u32,
    /// Iterations requested.
    pub iterations: u32,
    /// Seconds of this iteration.
    pub seconds: f64,
    /// Seconds since the start of this session.
    pub elapsed_seconds: f64,
    /// Photons so far.
    pub photons: u64,
    /// Camera segments so far.
    pub camera_segments: u64,
    /// The mean search radius of all pixels, in scene units; only in photon mapping, and if an observer follows.
    pub mean_radius: Option<f64>,
    /// The last estimate of the relative error, if there is an error goal.
    pub estimated_error: Option<f64>,
    /// Whether a checkpoint was written after this iteration.
    pub saved: bool,
}

impl Step {
    /// The part of the progress that `engine` provides.
    pub fn of(engine: &dyn Resumable) -> Self {
        let mean_radius = match engine.sums() {
            Sums::Photons | Sums::Hybrid => Some(mean_radius(engine)),
            Sums::Exact => Some(engine.probe(0, 0).radius.into()),
            Sums::Paths => None,
        };
        Self { mean_radius, ..Self::brief(engine) }
    }

    /// The same without the mean radius, which takes a pass over all pixels.
    pub(crate) fn brief(engine: &dyn Resumable) -> Self {
        let stats = engine.stats();
        Self {
            iteration: engine.iterations(),
            iterations: engine.settings().iterations,
            photons: stats.photons,
            camera_segments: stats.camera_segments,
            ..Self::default()
        }
    }
}

/// The mean search radius. Computed row by row, to avoid allocating an image after every iteration.
fn mean_radius(engine: &dyn Resumable) -> f64 {
    let settings = engine.settings();
    let words = engine.sums().words();
    let mut row = vec![0; settings.width as usize * words];
    let of_row = |y| {
        engine.save_row(y, &mut row);
        // The last of a pixel's words, whatever else is kept.
        let of_photons = |words: &[u32]| words.last_chunk().map(|words| PhotonSums::from_words(*words));
        let pixels = row.chunks_exact(words).filter_map(of_photons);
        pixels.map(|pixel| f64::from(pixel.radius_squared.sqrt())).sum::<f64>()
    };
    (0..settings.height).map(of_row).sum::<f64>() / settings.pixels() as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use scene::Engine;

    #[test]
    fn only_photon_mapping_has_a_radius() {
        let scene = files::builtin::scene("cornell").unwrap();
        let settings = scene::Settings { width: 3, height: 2, initial_radius: 2.5, ..scene.settings };
        let engine = fast::Sppm::new(&scene, &settings);
        assert_eq!(Step::of(&engine).mean_radius, Some(2.5));
        let global = scene::Settings { radius_schedule: scene::RadiusSchedule::Global, ..settings };
        assert_eq!(Step::of(&fast::Sppm::new(&scene, &global)).mean_radius, Some(2.5));
        assert_eq!(Step::of(&reference::PathTracer::new(&scene, &settings)).mean_radius, None);
        // Paths with photons for caustics have that of the photons.
        let (paths, photons) =
            (reference::PathTracer::new(&scene, &settings), reference::Sppm::new(&scene, &settings));
        assert_eq!(Step::of(&reference::hybrid(paths, photons)).mean_radius, Some(2.5));
    }

    /// Where radii are not the same, and in whichever order the rows are.
    #[test]
    fn the_mean_radius_is_that_of_all_pixels() {
        let scene = files::builtin::scene("cornell").unwrap();
        let settings =
            scene::Settings { width: 24, height: 18, photons_per_iteration: 20_000, ..scene.settings };
        let mut engine = fast::Sppm::new(&scene, &settings);
        engine.iterate();
        let places = (0..18).flat_map(|y| (0..24).map(move |x| (x, y)));
        let radii: Vec<f64> = places.map(|(x, y)| engine.probe(x, y).radius.into()).collect();
        let exact = radii.iter().sum::<f64>() / radii.len() as f64;
        assert!(radii.iter().any(|radius| *radius != radii[0]));
        let step = Step::of(&engine);
        assert!((step.mean_radius.unwrap() / exact - 1.0).abs() < 1e-12, "{step:?}, not {exact}");
        let stats = engine.stats();
        assert_eq!((step.iteration, step.photons, step.camera_segments), (1, 20_000, stats.camera_segments));
        assert_eq!(Step::brief(&engine), Step { mean_radius: None, ..step });
    }
}
