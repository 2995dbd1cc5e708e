//! The radii with which pixels begin, by pilots: [`scene::first_radii`].

use super::memory::DEPOSITS_OF_PILOTS;
use super::render::{Parts, Sppm};
use crate::hierarchy::Hierarchy;
use crate::parameters::Parameters;
use crate::pixels::{Pixel, slot_of};
use crate::prepared::Prepared;
use lanes::LaneKind;
use scene::still::Carried;
use scene::{Engine, FirstRadii, Progress, Scene, Settings, Stop};
use std::mem::take;

/// The first radii of a render with these settings, if `radius_pilots` is not 0; `None` if stopped.
pub fn first_radii(scene: &Scene, settings: &Settings, lanes: LaneKind, stop: &Stop) -> Option<FirstRadii> {
    first_radii_for((scene, Carried::All), settings, lanes, stop)
}

/// The same where photons carry this light.
pub fn first_radii_for(
    (scene, carried): (&Scene, Carried),
    settings: &Settings,
    lanes: LaneKind,
    stop: &Stop,
) -> Option<FirstRadii> {
    choose((scene, carried), settings, (lanes, &Parameters::default()), &mut None, stop)
}

/// As [`first_radii`]. `hierarchy` is that of the scene, if there is one already, and is left there.
fn choose(
    (scene, carried): (&Scene, Carried),
    settings: &Settings,
    (lanes, parameters): (LaneKind, &Parameters),
    hierarchy: &mut Option<Hierarchy>,
    stop: &Stop,
) -> Option<FirstRadii> {
    let mut parts = Parts::of_hierarchy(hierarchy.take());
    let radii = FirstRadii::choose(settings, stop, |settings, stop| {
        let pilot = Sppm::with_parts(scene, settings, lanes, parameters, take(&mut parts));
        let mut pilot = pilot.deposits_at_once(DEPOSITS_OF_PILOTS).carrying(carried);
        let is_whole = (0..settings.iterations).all(|_| pilot.iterate_unless(stop));
        let film = is_whole.then(|| pilot.develop());
        parts = pilot.into_parts();
        film
    });
    *hierarchy = parts.into_hierarchy();
    radii
}

impl Sppm<'_> {
    /// Undoes [`Self::begin`], so that a first iteration that was abandoned has changed nothing.
    pub(super) fn begin_again(&mut self) {
        let Progress { settings, next, .. } = self.progress;
        if next == 0 && self.first_radii.is_some() {
            self.pixels.fill(Pixel::new(settings.initial_radius));
        }
    }

    /// Before the first iteration, gives each pixel its first radius; false if stopped.
    pub(super) fn begin(&mut self, stop: &Stop) -> bool {
        let Progress { settings, next, .. } = self.progress;
        if next > 0 || (settings.radius_pilots == 0 && self.first_radii.is_none()) {
            return true;
        }
        if self.first_radii.is_none() {
            let mut hierarchy = self.prepared.take().map(|prepared| prepared.tables.hierarchy);
            let (scene, parameters) = (self.scene, &self.parameters);
            let lanes = (self.lanes, parameters);
            self.first_radii = choose((scene, self.carried), &settings, lanes, &mut hierarchy, stop);
            self.prepared = Prepared::only(scene, self.carried, parameters, hierarchy);
        }
        let Some(radii) = &self.first_radii else { return false };
        let size = (settings.width, settings.height);
        for y in 0..settings.height {
            for x in 0..settings.width {
                self.pixels[slot_of(settings.width, x, y)] = Pixel::new(radii.at((x, y), size));
            }
        }
        true
    }
}
