//! Finds how much of the background the camera sees in each pixel, for images with alpha.
//!
//! A pixel is the mean of samples, each of which is a camera path with a weight. Let `s` be the mean of the weights and
//! tints of the paths that reach the background before any surface but glass. A background of radiance `b` adds `b s` to
//! the pixel, and nothing else of the pixel depends on what is seen there. So the pixel without the background is
//! `c = radiance - b s`, and over another background `b'` it would be `c + b' s`. Alpha is a single number: `1 - s`,
//! averaged over the channels.
//!
//! `s` is the image of [`Scene::background_alone`]. Rendered by the same method with the same seed and iterations it
//! has the same camera paths, so it holds exactly the samples of the image itself, along every edge.

use crate::choice::{EngineChoice, Started};
use fast::Parts;
use rayon::prelude::*;
use scene::{Film, Iterations, Rgb, Rgba, Scene, Settings};

/// Light that is a smaller share of the background's in a pixel counts as none, and so does a smaller alpha. The sums of both
/// renders are rounded, to 2^-24 of each at every addition, and so are the factors by which glass scales radiance.
const ROUNDING: f32 = 1e-5;

/// A second render, which follows that of the image.
pub(crate) struct Backdrop<'a> {
    background: Rgb,
    /// `None` where no camera path can reach the background.
    engine: Option<Started<'a>>,
    done: Iterations,
}

/// The scene that is rendered in addition, if the background of `scene` is transparent.
pub(crate) fn scene_behind(scene: &Scene) -> Option<Scene> {
    let behind = || Scene { settings: settings_behind(&scene.settings), ..scene.background_alone() };
    scene.transparent_background.then(behind)
}

/// The settings with which it is rendered. Photons change nothing in it.
pub(crate) fn settings_behind(settings: &Settings) -> Settings {
    Settings { photons_per_iteration: 1, radius_pilots: 0, radius_clearance: 0.0, ..*settings }
}

impl<'a> Backdrop<'a> {
    /// For the image of a scene with this `background`, rendered by `choice`; `behind` is its [`scene_behind`].
    pub(crate) fn new(behind: &'a Scene, background: Rgb, choice: EngineChoice) -> Self {
        let is_seen = behind.check_light().is_ok();
        let engine = is_seen.then(|| choice.start(behind, 1, Parts::default(), None));
        Self { background, engine, done: Iterations::default() }
    }

    /// Renders the iterations of the image that it has not yet.
    pub(crate) fn catch_up(&mut self, done: &Iterations) {
        let Some(engine) = self.engine.as_mut().map(Started::engine) else { return };
        for iteration in done.without(&self.done).ranges().flatten() {
            if iteration != engine.progress().next {
                engine.skip_to(iteration);
            }
            engine.iterate();
        }
        self.done.clone_from(done);
    }

    /// The pixel without the background, if its radiance is `radiance`.
    pub(crate) fn pixel(&self, radiance: Rgb, x: u32, y: u32) -> Rgba {
        let share = self.engine.as_ref().map_or(Rgb::ZERO, |engine| engine.get().probe(x, y).radiance);
        without(self.background * share, radiance, share)
    }

    /// All pixels without the background, in the order of those of the image, which is `film`.
    pub(crate) fn pixels(&self, film: &Film) -> Vec<Rgba> {
        let place = |i: usize| (i as u32 % film.width, i as u32 / film.width);
        let pixel = |(i, radiance): (usize, &Rgb)| {
            let (x, y) = place(i);
            self.pixel(*radiance, x, y)
        };
        film.pixels.par_iter().enumerate().map(pixel).collect()
    }
}

/// A pixel of this `radiance` without the light `seen` of the background, which takes a `share` of each channel.
fn without(seen: Rgb, radiance: Rgb, share: Rgb) -> Rgba {
    let rest = radiance - seen;
    let color = Rgb::select(rest.abs().cmple(ROUNDING * seen), Rgb::ZERO, rest);
    let alpha = 1.0 - (share.x + share.y + share.z) / 3.0;
    Rgba { color, alpha: if alpha.abs() < ROUNDING { 0.0 } else { alpha } }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pixel_over_its_own_background_is_as_it_was() {
        let background = Rgb::new(0.5, 1.0, 2.0);
        let (radiance, share) = (Rgb::new(0.7, 0.8, 0.9), Rgb::splat(0.25));
        let Rgba { color, alpha } = without(background * share, radiance, share);
        assert_eq!(alpha, 0.75);
        let over = color + background * (1.0 - alpha);
        assert!((over - radiance).abs().max_element() <= f32::EPSILON, "{over}");
    }

    /// A thousandth of rounding is none, a thousandth of the background is some.
    #[test]
    fn what_rounding_leaves_is_no_light() {
        let share = Rgb::ONE;
        let clear = without(share, Rgb::splat(1.0 - 1e-6), share);
        assert_eq!(clear, Rgba { color: Rgb::ZERO, alpha: 0.0 });
        assert!(without(share, Rgb::splat(1.001), share).color.min_element() > 0.0);
        // Nothing is behind it: every light counts.
        let dim = Rgb::splat(1e-9);
        assert_eq!(without(Rgb::ZERO, dim, Rgb::ZERO), Rgba { color: dim, alpha: 1.0 });
    }

    /// Glass that lets only red through covers two thirds, and adds no light of its own.
    #[test]
    fn alpha_is_the_mean_of_the_channels() {
        let red = without(Rgb::X, Rgb::X, Rgb::X);
        assert!((red.alpha - 2.0 / 3.0).abs() <= f32::EPSILON && red.color == Rgb::ZERO, "{red:?}");
    }

    /// The same camera paths, and photons that change nothing.
    #[test]
    fn what_is_behind_is_seen_by_the_same_paths() {
        let settings =
            Settings { photons_per_iteration: 500, radius_pilots: 3, seed: 9, ..Settings::default() };
        assert_eq!(
            settings_behind(&settings),
            Settings { photons_per_iteration: 1, radius_pilots: 0, ..settings }
        );
        let mut scene = files::builtin::scene("cornell").unwrap();
        assert!(scene_behind(&scene).is_none());
        (scene.transparent_background, scene.settings) = (true, settings);
        assert_eq!(scene_behind(&scene).unwrap().settings, settings_behind(&settings));
    }

    /// The image is opaque where nothing of the background is seen.
    #[test]
    fn without_a_background_in_sight_all_is_opaque() {
        let mut scene = files::builtin::scene("cornell").unwrap();
        (scene.settings.width, scene.settings.height) = (3, 2);
        scene.transparent_background = true;
        let behind = scene_behind(&scene).unwrap();
        let mut backdrop = Backdrop::new(&behind, scene.background, EngineChoice::default());
        backdrop.catch_up(&(0..2).into());
        let film = Film::from_fn(3, 2, |x, y| Rgb::splat((10 * y + x) as f32));
        let pixels: Vec<Rgba> = film.pixels.iter().map(|color| Rgba { color: *color, alpha: 1.0 }).collect();
        assert_eq!(backdrop.pixels(&film), pixels);
        assert_eq!(backdrop.pixel(film.pixels[5], 2, 1), pixels[5]);
    }
}
