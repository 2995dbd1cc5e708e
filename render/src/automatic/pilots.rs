//! The pilots of a render: their size, their settings, and how they are run.

use super::pilot::{Pilot, run, run_paths};
use crate::names::MethodName;
use fast::LaneKind;
use scene::{FirstRadii, RadiusSchedule, Scene, Settings, Stop, first_radii};

/// Photons of the pilot per pixel of it, and the least; and how many times as many the second pilot has.
pub(super) const PILOT_PHOTONS: (f64, u32, u32) = (0.5, 4096, 4);

/// Pixels of a pilot by which settings are chosen, at most. They tell means over the image, of which so many tell enough.
const PIXELS: u64 = 128 * 96;

/// The settings of the pilots by which settings are chosen for a render with `settings`.
pub(super) fn pilot_settings(settings: &Settings) -> Settings {
    let (width, height) = settings.size_within(PIXELS);
    with_photons(Settings { width, height, ..first_radii::pilot_settings(settings) })
}

/// The settings of larger pilots, of as many pixels as those have by which radii are chosen.
pub(super) fn large_pilot_settings(settings: &Settings) -> Settings {
    with_photons(first_radii::pilot_settings(settings))
}

fn with_photons(pilot: Settings) -> Settings {
    let (per_pixel, least, _) = PILOT_PHOTONS;
    let photons = (per_pixel * pilot.pixels() as f64) as u32;
    Settings { iterations: 1, photons_per_iteration: photons.max(least), ..pilot }
}

/// Pilots of a scene.
pub(super) struct Pilots<'a> {
    /// The method of those that trace photons.
    pub(super) method: MethodName,
    lanes: LaneKind,
    pub(super) scene: &'a Scene,
    stop: &'a Stop,
    pub(super) settings: Settings,
}

impl<'a> Pilots<'a> {
    /// Pilots of a render of `scene` with `settings`.
    pub(super) fn new(scene: &'a Scene, settings: &Settings, lanes: LaneKind, stop: &'a Stop) -> Self {
        Self { method: MethodName::Sppm, lanes, scene, stop, settings: pilot_settings(settings) }
    }

    /// Larger pilots of a render of `scene` with `settings`.
    pub(super) fn large(scene: &'a Scene, settings: &Settings, lanes: LaneKind, stop: &'a Stop) -> Self {
        Self { settings: large_pilot_settings(settings), ..Self::new(scene, settings, lanes, stop) }
    }

    /// The same by another method that traces photons.
    pub(super) fn by(&self, method: MethodName) -> Self {
        Self { method, ..*self }
    }

    /// So many pilots, which differ in their seeds, with changed settings; `None` if stopped.
    pub(super) fn run(&self, seeds: u64, change: impl FnOnce(&mut Settings)) -> Option<Pilot> {
        let mut settings = self.settings;
        change(&mut settings);
        run((self.method, self.lanes), self.scene, &settings, seeds, None, self.stop)
    }

    /// So many pilots by path tracing, of so many paths in each pixel.
    pub(super) fn run_paths(&self, seeds: u64, paths: u32, max_depth: u32) -> Option<Pilot> {
        let settings = Settings { iterations: paths, max_depth, ..self.settings };
        run_paths(self.lanes, self.scene, &settings, seeds, self.stop)
    }

    /// So many pilots of so many photons, with these first radii and their limit, each times `scale`.
    pub(super) fn run_with(
        &self,
        seeds: u64,
        photons: u32,
        (radii, limit): (&FirstRadii, &Settings),
        scale: f32,
    ) -> Option<Pilot> {
        // Global radii are the same in all pixels, whatever they begin with; in one iteration nothing else tells them apart.
        let radius_schedule = RadiusSchedule::PerPixel;
        let settings = Settings {
            photons_per_iteration: photons,
            radius_schedule,
            initial_radius: limit.initial_radius * scale,
            radius_clearance: limit.radius_clearance * scale,
            ..self.settings
        };
        run((self.method, self.lanes), self.scene, &settings, seeds, Some(&radii.scaled(scale)), self.stop)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pilot_is_one_iteration_of_few_photons_but_not_too_few() {
        let large = Settings { width: 1024, height: 768, iterations: 9, ..Settings::default() };
        let pilot = pilot_settings(&large);
        assert_eq!((pilot.iterations, pilot.radius_pilots), (1, 0));
        assert_eq!(u64::from(pilot.photons_per_iteration), pilot.pixels() as u64 / 2);
        let small = pilot_settings(&Settings { width: 8, height: 8, ..large });
        assert_eq!((small.iterations, small.photons_per_iteration), (1, 4096));
    }

    /// Whatever schedule the render has: with global radii the first ones would be ignored.
    #[test]
    fn first_radii_are_those_that_are_given() {
        let mut scene = files::builtin::scene("cornell").unwrap();
        (scene.settings.width, scene.settings.height) = (16, 12);
        let (lanes, stop) = (LaneKind::best(), Stop::new());
        let settings = Settings { radius_pilots: 1, ..scene.settings };
        let radii = fast::first_radii(&scene, &settings, lanes, &stop).unwrap();
        let of = |radius_schedule, radii: &FirstRadii, scale| {
            let settings = Settings { radius_schedule, ..scene.settings };
            let pilots = Pilots::new(&scene, &settings, lanes, &stop);
            pilots.run_with(1, 700, (radii, &settings), scale).unwrap().films
        };
        let [own, global] = RadiusSchedule::ALL.map(|schedule| of(schedule, &radii, 1.0));
        assert_eq!(own, global);
        let half = of(RadiusSchedule::PerPixel, &radii.scaled(0.5), 1.0);
        assert!(own != half && half == of(RadiusSchedule::PerPixel, &radii, 0.5));
    }

    /// Half of the radii is half of them everywhere, also where what is near limits them.
    #[test]
    fn what_limits_radii_is_scaled_with_them() {
        let mut scene = files::builtin::scene("cornell").unwrap();
        (scene.settings.width, scene.settings.height) = (16, 12);
        let stop = Stop::new();
        let pilots = Pilots::new(&scene, &scene.settings, LaneKind::best(), &stop);
        let of = |initial_radius, radius_clearance, scale| {
            let settings = Settings { initial_radius, radius_clearance, ..scene.settings };
            let radii = FirstRadii::even(initial_radius);
            pilots.run_with(1, 20_000, (&radii, &settings), scale).unwrap().films
        };
        let half = of(16.0, 1.0, 0.5);
        assert!(half == of(8.0, 0.5, 1.0) && half != of(8.0, 1.0, 1.0));
    }

    #[test]
    fn pilots_are_as_they_are_asked_for() {
        let mut scene = files::builtin::scene("cornell").unwrap();
        (scene.settings.width, scene.settings.height) = (16, 12);
        scene.settings.radius_schedule = RadiusSchedule::Global;
        let stop = Stop::new();
        let pilots = Pilots::new(&scene, &scene.settings, LaneKind::best(), &stop);
        let radii = FirstRadii::even(1.0);
        let pilot = pilots.run_with(3, 700, (&radii, &scene.settings), 1.0).unwrap();
        assert_eq!((pilot.films.len(), pilot.stats.photons), (3, 2100));
        let pilot = pilots.run(2, |settings| settings.photons_per_iteration = 500).unwrap();
        assert_eq!((pilot.films.len(), pilot.stats.photons), (2, 1000));
        assert_ne!(pilot.films[0], pilot.films[1]);
        let pilot = pilots.run_paths(2, 3, 1).unwrap();
        assert_eq!((pilot.films.len(), pilot.stats.photons), (2, 0));
        // Three paths in each pixel, of at least a segment to the first diffuse surface, and of more if they may be longer.
        assert!(pilot.stats.camera_segments >= 2 * 3 * 16 * 12 && pilot.films[0] != pilot.films[1]);
        let longer = pilots.run_paths(2, 3, 8).unwrap().stats.camera_segments;
        assert!(longer > 2 * pilot.stats.camera_segments, "{longer}");
    }
}
