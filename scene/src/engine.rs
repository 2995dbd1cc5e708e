//! The trait of all engines (iterate, develop, report statistics) and its data types.

use crate::color::Rgb;
use crate::film::{Film, Plane, Tile, tile_of};
use crate::radius_schedule::RadiusSchedule;
use crate::settings::Settings;
use crate::stop::Stop;
use serde::{Deserialize, Serialize};

/// A render in progress. Its state after n iterations depends on scene, settings and seed alone.
///
/// An engine implements iterations and the values of a pixel; images are derived from these.
pub trait Engine {
    /// The settings of the render, and how far it has come.
    fn progress(&self) -> &Progress;

    /// Runs one whole iteration of all passes (for the path tracer: one sample per pixel), or abandons it soon after
    /// `stop` is requested. Returns true if the iteration was completed. An abandoned iteration changes nothing.
    ///
    /// An engine that cannot abandon an iteration runs it and returns true. On the meter of `stop` it shows how much of the
    /// iteration is done, if it can.
    #[must_use]
    fn iterate_unless(&mut self, stop: &Stop) -> bool;

    /// The current values of the pixel in column `x` and row `y`; black before the first iteration.
    ///
    /// # Panics
    /// If there is no such pixel.
    fn probe(&self, x: u32, y: u32) -> Probe;

    /// The radiance of the pixel in column `x` of row `y`, as [`Engine::probe`] has it.
    fn radiance(&self, x: u32, y: u32) -> Rgb {
        self.probe(x, y).radiance
    }

    /// The radiance of some pixels, by column and row.
    fn radiance_of_each(&self, places: &[(u32, u32)]) -> Vec<Rgb> {
        places.iter().map(|(x, y)| self.radiance(*x, *y)).collect()
    }

    /// The radiance of the tile whose upper left pixel is in column `left` of row `top`.
    ///
    /// # Panics
    /// If not all of it is in the image.
    fn radiance_of_tile(&self, left: u32, top: u32) -> Tile<Rgb> {
        tile_of(left, top, |x, y| self.radiance(x, y))
    }

    /// The settings of the render.
    fn settings(&self) -> &Settings {
        &self.progress().settings
    }

    /// Iterations run so far.
    fn iterations(&self) -> u32 {
        self.progress().iterations
    }

    /// Seconds per pass and counted work so far.
    fn stats(&self) -> &Stats {
        &self.progress().stats
    }

    /// Whether the engine traces photons, and so has direct light, radii and counts per pixel.
    fn has_photons(&self) -> bool {
        true
    }

    /// Runs one whole iteration.
    fn iterate(&mut self) {
        let is_whole = self.iterate_unless(&Stop::new());
        debug_assert!(is_whole, "nobody asked to stop");
    }

    /// The current image; black before the first iteration.
    fn develop(&self) -> Film {
        let Settings { width, height, .. } = *self.settings();
        Film::from_fn(width, height, |x, y| self.radiance(x, y))
    }

    /// The direct light, including that of visible lamps, summed over all iterations: radiance times iterations. `None`
    /// where it is not kept apart: without photons, and with global radii.
    fn direct(&self) -> Option<Film> {
        let Settings { width, height, radius_schedule, .. } = *self.settings();
        let is_kept = self.has_photons() && radius_schedule == RadiusSchedule::PerPixel;
        is_kept.then(|| Film::from_fn(width, height, |x, y| self.probe(x, y).direct))
    }

    /// The search radius of every pixel, in scene units; `None` for engines without photons.
    fn radius(&self) -> Option<Plane> {
        let Settings { width, height, .. } = *self.settings();
        self.has_photons().then(|| Plane::from_fn(width, height, |x, y| self.probe(x, y).radius))
    }

    /// `N` of every pixel: the photons counted so far, weighted by alpha where radii are the pixel's own; `None` for engines
    /// without photons.
    fn count(&self) -> Option<Plane> {
        let Settings { width, height, .. } = *self.settings();
        self.has_photons().then(|| Plane::from_fn(width, height, |x, y| self.probe(x, y).count))
    }
}

/// The settings of a render, and how far it has come.
#[derive(Clone, Copy, Debug)]
pub struct Progress {
    /// The settings of the render.
    pub settings: Settings,
    /// Iterations run so far.
    pub iterations: u32,
    /// The number of the next iteration, from 0; it keys the random numbers. It differs from `iterations` where iterations
    /// are rendered elsewhere ([`crate::Resumable::skip_to`]).
    pub next: u32,
    /// Seconds per pass and counted work so far.
    pub stats: Stats,
}

impl Progress {
    /// That of a render before its first iteration.
    pub fn new(settings: &Settings) -> Self {
        Self { settings: *settings, iterations: 0, next: 0, stats: Stats::default() }
    }

    /// That of a render whose sums hold so many iterations, the first ones.
    pub fn go_on_after(&mut self, iterations: u32, stats: Stats) {
        (self.iterations, self.next, self.stats) = (iterations, iterations, stats);
    }

    /// Counts an iteration that was completed.
    pub fn advance(&mut self) {
        (self.iterations, self.next) = (self.iterations + 1, self.next + 1);
    }
}

/// The current values of a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Probe {
    /// Radiance; black before the first iteration.
    pub radiance: Rgb,
    /// Direct light, including that of visible lamps, summed over all iterations; 0 without photons and with
    /// global radii.
    pub direct: Rgb,
    /// The search radius of the next iteration, in scene units; 0 without photons.
    pub radius: f32,
    /// `N`, the count of photons, weighted where radii are the pixel's own; 0 without photons.
    pub count: f32,
}

/// The passes of an iteration, in order. The last one runs on demand.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Pass {
    /// Traces rays from the eye to visible points, and estimates direct light there.
    Camera,
    /// Builds the spatial index that joins photons with visible points.
    BuildGrid,
    /// Traces photons from the lights and adds them to visible points.
    Photon,
    /// Updates radius, count and flux of every pixel.
    Consolidate,
    /// Computes radiance from the sums.
    Develop,
}

/// Seconds per pass and counted work, summed over all iterations.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stats {
    /// Seconds in the camera pass.
    pub camera_seconds: f64,
    /// Seconds building the spatial index.
    pub build_grid_seconds: f64,
    /// Seconds tracing and depositing photons.
    pub photon_seconds: f64,
    /// Seconds consolidating.
    pub consolidate_seconds: f64,
    /// Ray segments traced from the eye, without shadow rays.
    pub camera_segments: u64,
    /// Shadow rays.
    pub shadow_rays: u64,
    /// Visible points stored.
    pub visible_points: u64,
    /// Photons emitted.
    pub photons: u64,
    /// Ray segments traced from the lights.
    pub photon_segments: u64,
    /// Photons that reached a diffuse surface from bounce 1 on.
    pub deposits: u64,
    /// Pairs of a photon and a visible point whose distance was tested.
    pub candidates: u64,
    /// Pairs that contributed: the photon is within the radius and arrives on the visible side.
    pub contributions: u64,
    /// Bytes that the engine holds: film, visible points, index and photons.
    pub bytes: u64,
}

impl Stats {
    /// Adds the times and counted work of other iterations; of bytes, the most.
    pub fn add(&mut self, other: &Self) {
        let seconds = [
            (&mut self.camera_seconds, other.camera_seconds),
            (&mut self.build_grid_seconds, other.build_grid_seconds),
            (&mut self.photon_seconds, other.photon_seconds),
            (&mut self.consolidate_seconds, other.consolidate_seconds),
        ];
        for (sum, more) in seconds {
            *sum += more;
        }
        let counts = [
            (&mut self.camera_segments, other.camera_segments),
            (&mut self.shadow_rays, other.shadow_rays),
            (&mut self.visible_points, other.visible_points),
            (&mut self.photons, other.photons),
            (&mut self.photon_segments, other.photon_segments),
            (&mut self.deposits, other.deposits),
            (&mut self.candidates, other.candidates),
            (&mut self.contributions, other.contributions),
        ];
        for (sum, more) in counts {
            // Read from files, which may say anything.
            *sum = sum.saturating_add(more);
        }
        self.bytes = self.bytes.max(other.bytes);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An engine whose pixels are known.
    struct Fake {
        progress: Progress,
        has_photons: bool,
    }

    fn fake(radius_schedule: RadiusSchedule, has_photons: bool) -> Fake {
        let settings = Settings { width: 3, height: 2, radius_schedule, ..Settings::default() };
        Fake { progress: Progress::new(&settings), has_photons }
    }

    impl Engine for Fake {
        fn progress(&self) -> &Progress {
            &self.progress
        }

        fn iterate_unless(&mut self, stop: &Stop) -> bool {
            if !stop.is_requested() {
                self.progress.advance();
            }
            !stop.is_requested()
        }

        fn probe(&self, x: u32, y: u32) -> Probe {
            let value = (10 * y + x) as f32;
            let (radiance, direct) = (Rgb::splat(value), Rgb::splat(value + 0.25));
            Probe { radiance, direct, radius: value + 0.5, count: value + 0.75 }
        }

        fn has_photons(&self) -> bool {
            self.has_photons
        }
    }

    #[test]
    fn images_are_of_the_values_of_their_pixels() {
        let mut engine = fake(RadiusSchedule::PerPixel, true);
        let value = |x: u32, y: u32| (10 * y + x) as f32;
        assert_eq!(engine.develop(), Film::from_fn(3, 2, |x, y| Rgb::splat(value(x, y))));
        assert_eq!(engine.direct(), Some(Film::from_fn(3, 2, |x, y| Rgb::splat(value(x, y) + 0.25))));
        assert_eq!(engine.radius(), Some(Plane::from_fn(3, 2, |x, y| value(x, y) + 0.5)));
        assert_eq!(engine.count(), Some(Plane::from_fn(3, 2, |x, y| value(x, y) + 0.75)));
        engine.iterate();
        engine.iterate();
        assert_eq!((engine.iterations(), engine.progress.next, engine.settings().width), (2, 2, 3));
        assert!(fake(RadiusSchedule::Global, true).direct().is_none());
        assert!(fake(RadiusSchedule::Global, true).radius().is_some());
        let path = fake(RadiusSchedule::PerPixel, false);
        assert!(path.direct().is_none() && path.radius().is_none() && path.count().is_none());
    }

    #[test]
    fn a_render_goes_on_from_where_it_was() {
        let mut progress = Progress::new(&Settings::default());
        let stats = Stats { photons: 5, ..Stats::default() };
        progress.go_on_after(7, stats);
        assert_eq!((progress.iterations, progress.next, progress.stats), (7, 7, stats));
        progress.next = 20;
        progress.advance();
        assert_eq!((progress.iterations, progress.next), (8, 21));
    }

    /// Each field by itself: times and counts are added, of bytes the most counts.
    #[test]
    fn statistics_are_added_up() {
        let numbered = |from: u64, bytes| {
            let seconds = |k: u64| (from + k) as f64;
            Stats {
                camera_seconds: seconds(0),
                build_grid_seconds: seconds(1),
                photon_seconds: seconds(2),
                consolidate_seconds: seconds(3),
                camera_segments: from + 4,
                shadow_rays: from + 5,
                visible_points: from + 6,
                photons: from + 7,
                photon_segments: from + 8,
                deposits: from + 9,
                candidates: from + 10,
                contributions: from + 11,
                bytes,
            }
        };
        let mut sum = numbered(100, 5);
        sum.add(&numbered(0, 9));
        let twice = numbered(100, 9);
        assert_eq!(sum.camera_seconds, 100.0);
        assert_eq!(
            (sum.build_grid_seconds, sum.photon_seconds, sum.consolidate_seconds),
            (102.0, 104.0, 106.0)
        );
        assert_eq!(
            [sum.camera_segments, sum.shadow_rays, sum.visible_points, sum.photons],
            [108, 110, 112, 114]
        );
        assert_eq!(
            [sum.photon_segments, sum.deposits, sum.candidates, sum.contributions],
            [116, 118, 120, 122]
        );
        assert_eq!(sum.bytes, twice.bytes);
        sum.add(&Stats { photons: u64::MAX, bytes: 3, ..Stats::default() });
        assert_eq!((sum.photons, sum.bytes), (u64::MAX, 9));
    }
}
