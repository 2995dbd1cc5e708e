//! Chooses the method: photon mapping, or path tracing, with photons for caustics where there may be some.
//!
//! In closed rooms, which are lit by light that has come a long way, photons do better; in the open, where most light comes
//! straight from lamps and sky, paths do. Pilots by both methods tell their noise and work, and the render is by the one that
//! has less noise after the work that the quality allows. What that is worth: docs/quality.md.

use super::account::{Account, camera_work, photon_work};
use super::goal::Goal;
use super::pilot::SEEDS;
use super::pilots::{PILOT_PHOTONS, Pilots};
use crate::names::MethodName;
use scene::settings::{MAX_DEPOSITS, MAX_PHOTONS};
use scene::{Automatic, Scene, Settings};

/// The numbers of rays through a pixel that sees a lamp, or a mirror or glass, from which one is chosen, each with a share: the most
/// whose work is not more than this share of what an iteration takes without them. Up to 8 rays gain what they cost in most scenes;
/// more of them gain little, and are sent where they hardly cost. See docs/quality.md.
pub(super) const GLINT_SAMPLES: [(u32, f64); 5] = [(32, 0.25), (16, 0.25), (8, 1.25), (4, 1.25), (2, 1.25)];
/// The rays of the pilot that counts their work.
const GLINTS_OF_PILOT: u32 = 8;
/// Paths in each pixel of the pilot by path tracing. With fewer, light that few paths find is missed in most pixels.
pub(super) const PATHS: u32 = 4;

/// Paths are taken if their noise, as [`Account::least_noise`] has it, is below this share of that of photons: half of it by each of
/// three terms. Pilots with few photons guide them badly, so they tell more noise of them than the render will have; and of
/// sparks, which paths have more of, they tell nothing. See docs/quality.md.
pub(super) const LEAST_ADVANTAGE: f64 = 0.125;

/// A method, and what its pilots tell.
pub(super) struct Plan {
    pub(super) method: MethodName,
    /// The rays by which lamps are seen.
    glint_samples: u32,
    /// Noise and work, if anything depends on them.
    account: Option<Account>,
}

/// The plan by the method that is chosen for a render with `settings`, or by `method`; `None` if stopped.
pub(super) fn plan(
    pilots: &Pilots<'_>,
    settings: &Settings,
    (automatic, method): (Automatic, MethodName),
    goal: &Goal,
) -> Option<Plan> {
    let scene = pilots.scene;
    if !automatic.method {
        return Plan::new(&pilots.by(method), settings, automatic);
    }
    let other = if shows_lamps_again(scene) { MethodName::Hybrid } else { MethodName::Path };
    let photons = Plan::new(pilots, settings, automatic)?;
    let paths = Plan::new(&pilots.by(other), settings, automatic)?;
    let [of_photons, of_paths] = [&photons, &paths].map(|plan| plan.least_noise(settings, goal));
    Some(if of_paths < LEAST_ADVANTAGE * of_photons { paths } else { photons })
}

/// True if lamps may be seen in mirrors or glass, which also make caustics of their light.
pub(super) fn shows_lamps_again(scene: &Scene) -> bool {
    let is_smooth = |material: u32| !scene.materials[material as usize].is_diffuse();
    scene.spheres.iter().any(|sphere| is_smooth(sphere.material)) && scene.at(0.0).has_lamps()
}

/// The most photons of an iteration of paths that have at most `max_depth` segments.
pub(super) fn most_photons(max_depth: u32) -> u32 {
    ((MAX_DEPOSITS - 1) / u64::from(max_depth)).min(MAX_PHOTONS.into()) as u32
}

impl Plan {
    /// By the method of the pilots, whose settings are those of a render with `settings`.
    pub(super) fn new(pilots: &Pilots<'_>, settings: &Settings, automatic: Automatic) -> Option<Self> {
        let method = pilots.method;
        let glint_samples = if !automatic.glint_samples || !method.has_photons() {
            settings.glint_samples
        } else if shows_lamps_again(pilots.scene) {
            pilots.glint_samples(settings.max_depth)?
        } else {
            1
        };
        let is_needed = automatic.photons_per_iteration || automatic.iterations;
        let settings = Settings { glint_samples, ..*settings };
        let account = if is_needed { Some(pilots.account(&settings)?) } else { None };
        Some(Self { method, glint_samples, account })
    }

    /// The noise after the work that the quality allows, with the best number of photons.
    pub(super) fn least_noise(&self, settings: &Settings, goal: &Goal) -> f64 {
        let account = self.account.as_ref();
        account.map_or(f64::INFINITY, |account| account.least_noise(self.most_photons(settings), goal.work))
    }

    fn most_photons(&self, settings: &Settings) -> u32 {
        if self.method.has_photons() { most_photons(settings.max_depth) } else { 1 }
    }

    /// Gives `settings` what is automatic.
    pub(super) fn apply(&self, settings: &mut Settings, automatic: Automatic, goal: &Goal) {
        settings.glint_samples = self.glint_samples;
        let Some(account) = &self.account else { return };
        if automatic.photons_per_iteration && self.method.has_photons() {
            settings.photons_per_iteration = account.photons(self.most_photons(settings), goal.work);
        }
        if automatic.iterations {
            settings.iterations = account.iterations(settings.photons_per_iteration, goal.noise, goal.work);
        }
    }
}

impl Pilots<'_> {
    /// The rays through a pixel that sees a lamp, or a mirror or glass, in paths of so many segments.
    fn glint_samples(&self, max_depth: u32) -> Option<u32> {
        let of = |glint_samples| {
            self.run(1, |pilot| (pilot.max_depth, pilot.glint_samples) = (max_depth, glint_samples))
        };
        let (one, several) = (of(1)?.stats, of(GLINTS_OF_PILOT)?.stats);
        let each = (camera_work(&several) - camera_work(&one)) / f64::from(GLINTS_OF_PILOT);
        let rest = camera_work(&one) + photon_work(&one, 1.0);
        let is_cheap = |&&(samples, share): &&(u32, f64)| f64::from(samples) * each <= share * rest;
        Some(GLINT_SAMPLES.iter().find(is_cheap).map_or(1, |(samples, _)| *samples))
    }

    /// Noise and work of a render with the depth of `settings` and as many rays to lamps, by the radius of the pilots.
    fn account(&self, settings: &Settings) -> Option<Account> {
        let side = self.block(settings);
        let scale = settings.pixels() as f64 / self.settings.pixels() as f64;
        let account = if self.method.has_photons() {
            let few = self.settings.photons_per_iteration;
            let many = few * PILOT_PHOTONS.2;
            let of = |photons| {
                self.run(SEEDS, |pilot| {
                    pilot.photons_per_iteration = photons;
                    (pilot.max_depth, pilot.glint_samples) = (settings.max_depth, settings.glint_samples);
                })
            };
            let (first, second) = (of(few)?, of(many)?);
            Account::new([few, many], [first.variance(side), second.variance(side)], &second.stats, scale)
        } else {
            let pilot = self.run_paths(SEEDS, PATHS, settings.max_depth)?;
            Account::of_paths(PATHS, pilot.variance(side), &pilot.stats, scale)
        };
        Some(account.of(settings.pixels(), self.scene.spheres.len()))
    }
}
