//! Stochastic progressive photon mapping (Hachisuka and Jensen 2009): runs the passes of an iteration in order.

use crate::camera_pass::{CameraNumbers, VisiblePoint, camera_ray, trace};
use crate::consolidate::{Gathered, Pixel, estimate};
use crate::glints::GlintRays;
use crate::grid::Grid;
use crate::photon_pass::{Deposit, photon_pass};
use crate::survey::survey_for;
use scene::aim::{Aim, Targets};
use scene::exact::Scale;
use scene::film::FluxUnit;
use scene::filter::Table;
use scene::light_tree::LightTree;
use scene::radius_schedule::{RadiusSchedule, Shrinking};
use scene::still::{Carried, Role};
use scene::{
    Clearance, Engine, ExactSums, FirstRadii, PhotonSums, Probe, Progress, Resumable, Rgb, Rims, Scene,
    Settings, Stats, Still, Stop, Sums,
};
use std::time::Instant;

/// The default cell size of the grid, in units of the largest radius. The image does not depend on it.
const CELL_SIZE: f32 = 2.0;

/// The work of a photon in units of that of a pixel, about; for [`scene::Meter`].
const PHOTON_WORK: u64 = 5;

/// Photons traced between two checks of the stop flag.
const PHOTONS_PER_STOP: u32 = 256;

/// The reference renderer.
pub struct Sppm<'a> {
    scene: &'a Scene,
    progress: Progress,
    /// The table of the pixels' filter; `None` for the box.
    filter: Option<&'static Table>,
    rims: Option<Rims>,
    cell_size: f32,
    /// See [`Sppm::lit_by_power`].
    lit_by_power: bool,
    carried: Carried,
    pixels: Vec<Pixel>,
    /// What pixels have gained, if radii are global.
    global: Option<Global>,
    /// What photons are aimed at, once it is known. It is the same for all iterations, so it need not be saved.
    targets: Option<Targets>,
    /// The radii with which pixels begin, if they are given or known.
    first_radii: Option<FirstRadii>,
}

/// The state of a render with global radii.
struct Global {
    scale: Scale,
    shrinking: Shrinking,
    sums: Vec<ExactSums>,
}

/// The result of the camera pass of one iteration.
#[derive(Default)]
struct Seen {
    /// Direct light of every pixel.
    direct: Vec<Rgb>,
    /// The visible points, in order of their pixels.
    points: Vec<VisiblePoint>,
    /// The pixel of each visible point.
    owners: Vec<usize>,
    /// The squared search radius of each visible point.
    radii_squared: Vec<f32>,
}

impl Seen {
    fn bytes(&self) -> usize {
        size_of_val(&self.direct[..])
            + size_of_val(&self.points[..])
            + size_of_val(&self.owners[..])
            + size_of_val(&self.radii_squared[..])
    }
}

impl<'a> Sppm<'a> {
    /// A render that has not begun.
    pub fn new(scene: &'a Scene, settings: &Settings) -> Self {
        Self::with_cell_size(scene, settings, CELL_SIZE)
    }

    /// The same render with grid cells of `cell_size` times the largest radius, a number above 0.
    pub fn with_cell_size(scene: &'a Scene, settings: &Settings, cell_size: f32) -> Self {
        let pixels = vec![Pixel::new(settings.initial_radius); settings.pixels()];
        let filter = settings.filter.table();
        let global = (settings.radius_schedule == RadiusSchedule::Global).then(|| Global {
            scale: Scale::of(scene),
            shrinking: Shrinking::default(),
            sums: vec![ExactSums::default(); settings.pixels()],
        });
        Self {
            scene,
            progress: Progress::new(settings),
            filter,
            rims: Rims::new(scene, settings),
            cell_size,
            lit_by_power: false,
            carried: Carried::All,
            pixels,
            global,
            targets: None,
            first_radii: None,
        }
    }

    /// The same render with other first radii than those that [`Settings::radius_pilots`] choose. The image changes, but not
    /// what it converges to.
    #[must_use]
    pub fn beginning_with(self, radii: FirstRadii) -> Self {
        Self { first_radii: Some(radii), ..self }
    }

    /// The same render with photons aimed at `targets`; by default they are found by a survey. The image changes, but not
    /// what it converges to.
    #[must_use]
    pub fn aimed_at(self, targets: Targets) -> Self {
        Self { targets: Some(targets), ..self }
    }

    /// What its photons are aimed at; `None` before the first iteration has found that by a survey.
    pub fn targets(&self) -> Option<&Targets> {
        self.targets.as_ref()
    }

    /// The image of caustics alone, and of what they light: of lamps' light whose first surface is a mirror or glass, as
    /// photons bring it to diffuse surfaces. A part of [`scene::Hybrid`].
    #[must_use]
    pub fn of_caustics(self) -> Self {
        Self { carried: Carried::Caustics, ..self }
    }

    /// The same render with direct light from lights chosen by their power alone, and photons that leave all lamps alike, as
    /// in the paper: another estimate of the same image. The rows of the ladder are compared with it.
    #[must_use]
    pub fn lit_by_power(self) -> Self {
        Self { lit_by_power: true, targets: Some(Targets::default()), ..self }
    }

    /// The scene at the instant of this iteration.
    fn still(&self) -> Still<'a> {
        let Progress { settings, next, .. } = &self.progress;
        let mut still = self.scene.at_for(self.scene.camera.shutter_time(settings.seed, *next), self.carried);
        if self.lit_by_power {
            let lights = &mut still.lights;
            let probabilities = lights.entries.iter().map(|light| light.probability);
            lights.tree = LightTree::by_power(probabilities, &lights.cumulative);
        }
        still
    }

    /// One camera path per pixel; `None` if stopped.
    fn camera_pass(&mut self, still: &Still, stop: &Stop) -> Option<Seen> {
        let Progress { settings, next, stats, .. } = &mut self.progress;
        let frame = self.scene.camera.frame(settings.width, settings.height);
        let clearance = Clearance::new(settings);
        let (filter, rims) = (self.filter, self.rims.as_ref());
        let glints = GlintRays { frame: &frame, filter, rims, settings, iteration: *next };
        let mut seen = Seen::default();
        for index in 0..self.pixels.len() {
            if stop.is_requested() {
                return None;
            }
            let (x, y) = (index as u32 % settings.width, index as u32 / settings.width);
            if x == 0 {
                stop.meter().advance(settings.width.into());
            }
            let mut numbers = CameraNumbers::new(settings, *next, x, y).at_rim(glints.is_rim(x, y));
            let ray = camera_ray(&frame, filter, x, y, &numbers);
            let sample = trace(still, ray, settings.max_depth, &mut numbers, stats);
            let lamps = sample.glints.map(|own| glints.mean(still, (x, y), own, &mut stats.camera_segments));
            seen.direct.push(lamps.map_or(sample.direct, |lamps| sample.direct + lamps));
            if let Some(visible) = sample.visible {
                let Pixel { n, mut radius_squared, .. } = self.pixels[index];
                if n == 0.0
                    && let Some(clearance) = &clearance
                {
                    let place = (visible.point, visible.sphere);
                    radius_squared = clearance.limited(&still.spheres, place, radius_squared);
                }
                seen.points.push(visible);
                seen.owners.push(index);
                seen.radii_squared.push(radius_squared);
            }
        }
        Some(seen)
    }

    /// Traces the photons and adds each to the visible points within whose radius it arrives; `None` if stopped.
    fn photon_pass(
        &mut self,
        (still, aim): (&Still, &Aim),
        grid: &Grid,
        seen: &Seen,
        stop: &Stop,
    ) -> Option<Vec<Gathered>> {
        let mut gathered = vec![Gathered::default(); seen.points.len()];
        let all = self.progress.settings.photons_per_iteration;
        for first in (0..all).step_by(PHOTONS_PER_STOP as usize) {
            if stop.is_requested() {
                return None;
            }
            let photons = first..all.min(first.saturating_add(PHOTONS_PER_STOP));
            stop.meter().advance(PHOTON_WORK * photons.len() as u64);
            photon_pass(
                still,
                aim,
                &self.progress.settings,
                self.progress.next,
                photons,
                &mut self.progress.stats,
                |deposit, stats| {
                    for index in grid.candidates(deposit.point) {
                        stats.candidates += 1;
                        if contributes(still, deposit, &seen.points[index], seen.radii_squared[index]) {
                            stats.contributions += 1;
                            let sum = &mut gathered[index];
                            sum.m += 1;
                            for (total, flux) in sum.flux.iter_mut().zip(deposit.flux.values()) {
                                *total += flux;
                            }
                        }
                    }
                },
            );
        }
        Some(gathered)
    }

    /// Undoes [`Self::begin`], so that a first iteration that was abandoned has changed nothing.
    fn begin_again(&mut self) {
        let Progress { settings, next, .. } = self.progress;
        if next == 0 && self.first_radii.is_some() {
            self.pixels.fill(Pixel::new(settings.initial_radius));
        }
    }

    /// Before the first iteration, gives each pixel its first radius; `None` if stopped.
    fn begin(&mut self, stop: &Stop) -> Option<()> {
        let Progress { settings, next, .. } = self.progress;
        if next > 0 || (settings.radius_pilots == 0 && self.first_radii.is_none()) {
            return Some(());
        }
        if self.first_radii.is_none() {
            self.first_radii = Some(first_radii(self.scene, &settings, self.carried, stop)?);
        }
        if let Some(radii) = &self.first_radii {
            let size = (settings.width, settings.height);
            for (index, pixel) in self.pixels.iter_mut().enumerate() {
                let place = (index as u32 % settings.width, index as u32 / settings.width);
                *pixel = Pixel::new(radii.at(place, size));
            }
        }
        Some(())
    }

    /// Runs all passes of an iteration; `None` if stopped, and then no pixel has changed but for its first radius.
    fn run_iteration(&mut self, stop: &Stop) -> Option<()> {
        self.begin(stop)?;
        let still = self.still();
        if self.carried == Carried::Caustics && !still.has_photons() {
            self.progress.advance();
            return Some(());
        }
        let start = Instant::now();
        self.shrink();
        let photons = u64::from(self.progress.settings.photons_per_iteration);
        stop.meter().begin(self.pixels.len() as u64 + PHOTON_WORK * photons);
        let seen = self.camera_pass(&still, stop)?;
        let camera = Instant::now();
        let radius = |i: usize| seen.radii_squared[i].sqrt();
        let grid = Grid::build(&seen.points, radius, self.cell_size);
        let built = Instant::now();
        let settings = &self.progress.settings;
        let targets = self.targets.get_or_insert_with(|| survey_for(self.scene, settings, self.carried));
        let aim = Aim::new(&still, targets, settings.photons_per_iteration);
        let gathered = self.photon_pass((&still, &aim), &grid, &seen, stop)?;
        let traced = Instant::now();
        self.consolidate(&seen, &gathered, FluxUnit::new(still.lights.power, aim.scale()));
        self.progress.advance();
        let sums = self.global.as_ref().map_or(0, |global| size_of_val(&global.sums[..]));
        let held = size_of_val(&self.pixels[..]) + sums + seen.bytes();
        self.progress.stats.bytes = (held + size_of_val(&gathered[..]) + grid.bytes()) as u64;
        self.progress.stats.camera_seconds += (camera - start).as_secs_f64();
        self.progress.stats.build_grid_seconds += (built - camera).as_secs_f64();
        self.progress.stats.photon_seconds += (traced - built).as_secs_f64();
        self.progress.stats.consolidate_seconds += traced.elapsed().as_secs_f64();
        Some(())
    }

    /// If radii are global, gives all pixels that of the next iteration.
    fn shrink(&mut self) {
        let Progress { settings, next, .. } = &self.progress;
        let first = Pixel::new(settings.initial_radius).radius_squared;
        if let Some(global) = &mut self.global {
            let radius_squared = global.shrinking.radius_squared(first, *next);
            self.pixels.iter_mut().for_each(|pixel| pixel.radius_squared = radius_squared);
        }
    }

    /// Adds to the pixels what they have seen and gathered in an iteration.
    fn consolidate(&mut self, seen: &Seen, gathered: &[Gathered], unit: FluxUnit) {
        let points = seen.points.iter().zip(&seen.owners).zip(&seen.radii_squared).zip(gathered);
        let Some(Global { scale, sums, .. }) = &mut self.global else {
            for (pixel, direct) in self.pixels.iter_mut().zip(&seen.direct) {
                pixel.direct += *direct;
            }
            for (((visible, owner), radius_squared), gathered) in points {
                self.pixels[*owner].consolidate((visible.beta, *radius_squared), gathered, unit);
            }
            return;
        };
        let photons = self.progress.settings.photons_per_iteration;
        let mut gains: Vec<(Rgb, u32)> = seen.direct.iter().map(|direct| (*direct, 0)).collect();
        for (((visible, owner), radius_squared), gathered) in points {
            let direct = seen.direct[*owner];
            let radiance = estimate(direct, (visible.beta, gathered), unit, photons, *radius_squared);
            gains[*owner] = (radiance, gathered.m);
        }
        for (sum, (radiance, m)) in sums.iter_mut().zip(gains) {
            sum.gain(*scale, radiance, m);
        }
    }

    fn row(&self, y: u32) -> &[Pixel] {
        let width = self.progress.settings.width as usize;
        &self.pixels[y as usize * width..][..width]
    }
}

/// The first radii of a render with these settings, by pilots; `None` if stopped.
fn first_radii(scene: &Scene, settings: &Settings, carried: Carried, stop: &Stop) -> Option<FirstRadii> {
    FirstRadii::choose(settings, stop, |settings, stop| {
        let mut pilot = Sppm { carried, ..Sppm::new(scene, settings) };
        (0..settings.iterations).all(|_| pilot.iterate_unless(stop)).then(|| pilot.develop())
    })
}

/// True if a photon contributes to a visible point: it arrives within the radius, and on the visible side.
///
/// If both lie on the inside of the same shell, the photon is always on the visible side, whatever its angle to the
/// visible point's normal. Rejecting photons at grazing angles there would lose the share `R^2 / (8 r^2)` of uniform
/// light, and a furnace would come out too dark by that share.
pub fn contributes(still: &Still, deposit: &Deposit, visible: &VisiblePoint, radius_squared: f32) -> bool {
    let d = deposit.point - visible.point;
    let is_near = d.dot(d) < radius_squared;
    let shares_shell = deposit.sphere == visible.sphere
        && matches!(still.roles[visible.sphere as usize], Role::Enclosure(_));
    is_near && (shares_shell || deposit.wi.dot(visible.normal) > 0.0)
}

impl Engine for Sppm<'_> {
    fn progress(&self) -> &Progress {
        &self.progress
    }

    fn iterate_unless(&mut self, stop: &Stop) -> bool {
        let before = self.progress.stats;
        let is_whole = self.run_iteration(stop).is_some();
        if !is_whole {
            self.progress.stats = before;
            self.begin_again();
        }
        is_whole
    }

    fn probe(&self, x: u32, y: u32) -> Probe {
        let Progress { settings, iterations, next, .. } = self.progress;
        let pixel = &self.row(y)[x as usize];
        if let Some(global) = &self.global {
            let sums = &global.sums[y as usize * settings.width as usize + x as usize];
            let first = Pixel::new(settings.initial_radius).radius_squared;
            return Probe {
                radiance: if iterations > 0 { sums.develop(global.scale, iterations) } else { Rgb::ZERO },
                direct: Rgb::ZERO,
                radius: global.shrinking.clone().radius_squared(first, next).sqrt(),
                count: sums.photons as f32,
            };
        }
        let radiance = if iterations > 0 { pixel.develop(&settings, iterations) } else { Rgb::ZERO };
        Probe { radiance, direct: pixel.direct, radius: pixel.radius_squared.sqrt(), count: pixel.n }
    }
}

impl Resumable for Sppm<'_> {
    fn sums(&self) -> Sums {
        if self.global.is_some() { Sums::Exact } else { Sums::Photons }
    }

    fn save_row(&self, y: u32, words: &mut [u32]) {
        let row = self.row(y);
        assert_eq!(words.len(), row.len() * self.sums().words(), "not a row");
        if let Some(Global { sums, .. }) = &self.global {
            let sums = &sums[y as usize * row.len()..];
            for (words, sums) in words.as_chunks_mut().0.iter_mut().zip(sums) {
                *words = sums.to_words();
            }
            return;
        }
        for (words, &Pixel { direct, tau, n, radius_squared }) in words.as_chunks_mut().0.iter_mut().zip(row)
        {
            *words = PhotonSums { direct, tau, n, radius_squared }.to_words();
        }
    }

    fn load_row(&mut self, y: u32, words: &[u32]) {
        let width = self.progress.settings.width as usize;
        assert_eq!(words.len(), width * self.sums().words(), "not a row");
        if let Some(Global { sums, .. }) = &mut self.global {
            for (words, sums) in words.as_chunks().0.iter().zip(&mut sums[y as usize * width..]) {
                *sums = ExactSums::from_words(*words);
            }
            return;
        }
        let row = &mut self.pixels[y as usize * width..][..width];
        for (words, pixel) in words.as_chunks().0.iter().zip(row) {
            let PhotonSums { direct, tau, n, radius_squared } = PhotonSums::from_words(*words);
            *pixel = Pixel { direct, tau, n, radius_squared };
        }
    }

    fn go_on_after(&mut self, iterations: u32, stats: Stats) {
        self.progress.go_on_after(iterations, stats);
        self.shrink();
    }

    fn skip_to(&mut self, next: u32) {
        assert!(self.global.is_some(), "iteration {next} depends on those before it");
        self.progress.next = next;
        self.shrink();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene() -> Scene {
        let scene = files::builtin::scene("cornell").unwrap();
        let settings = Settings { width: 12, height: 9, photons_per_iteration: 2000, ..scene.settings };
        Scene { settings, ..scene }
    }

    /// All that a render holds of its pixels.
    fn state(engine: &Sppm) -> Vec<Vec<u32>> {
        let Settings { width, height, .. } = engine.progress.settings;
        let row = |y| {
            let mut words = vec![0; width as usize * engine.sums().words()];
            engine.save_row(y, &mut words);
            words
        };
        (0..height).map(row).collect()
    }

    fn iterated(mut engine: Sppm, iterations: u32) -> Sppm {
        (0..iterations).for_each(|_| engine.iterate());
        engine
    }

    fn schedules() -> [Settings; 2] {
        let settings = scene().settings;
        RadiusSchedule::ALL.map(|radius_schedule| Settings { radius_schedule, ..settings })
    }

    #[test]
    fn before_the_first_iteration_all_is_black_and_radii_are_the_first() {
        let scene = scene();
        for settings in schedules() {
            let probe = Sppm::new(&scene, &settings).probe(11, 8);
            assert_eq!((probe.radiance, probe.direct, probe.count), (Rgb::ZERO, Rgb::ZERO, 0.0));
            let is_own = settings.radius_schedule == RadiusSchedule::PerPixel;
            assert!(!is_own || probe.radius == settings.initial_radius, "{probe:?}");
        }
    }

    /// First radii hold for the first iteration, and shrink from then on as those of the settings do.
    #[test]
    fn given_first_radii_are_in_the_place_of_the_settings() {
        let scene = scene();
        let half = scene.settings.initial_radius / 2.0;
        let given = Sppm::new(&scene, &scene.settings).beginning_with(FirstRadii::even(half));
        let own = Sppm::new(&scene, &Settings { initial_radius: half, ..scene.settings });
        let (given, own) = (iterated(given, 3), iterated(own, 3));
        assert_eq!(state(&given), state(&own));
        assert!((0..12).any(|x| given.probe(x, 4).radius < half));
    }

    /// Pilots choose first radii if the settings ask for them, once.
    #[test]
    fn pilots_choose_first_radii_if_they_are_asked_for() {
        let scene = scene();
        let with =
            |radius_pilots| iterated(Sppm::new(&scene, &Settings { radius_pilots, ..scene.settings }), 2);
        assert!(with(0).first_radii.is_none());
        let chosen = with(1);
        let radii =
            first_radii(&scene, &Settings { radius_pilots: 1, ..scene.settings }, Carried::All, &Stop::new())
                .unwrap();
        let given = iterated(Sppm::new(&scene, &scene.settings).beginning_with(radii), 2);
        assert_eq!(state(&chosen), state(&given));
    }

    /// An iteration that is abandoned has changed nothing, whenever that is.
    #[test]
    fn an_abandoned_iteration_leaves_no_trace() {
        let (scene, stopped) = (scene(), Stop::new());
        stopped.request();
        for settings in schedules() {
            for iterations in [0, 2] {
                let mut engine = Sppm::new(&scene, &settings);
                if settings.radius_schedule == RadiusSchedule::PerPixel {
                    engine = engine.beginning_with(FirstRadii::even(0.5));
                }
                let mut engine = iterated(engine, iterations);
                let (before, stats) = (state(&engine), *engine.stats());
                assert!(!engine.iterate_unless(&stopped));
                assert_eq!(
                    (state(&engine), *engine.stats(), engine.iterations()),
                    (before, stats, iterations)
                );
            }
        }
    }

    /// From what is saved, a render goes on as if it had never ended.
    #[test]
    fn a_render_goes_on_from_its_rows() {
        let scene = scene();
        for settings in schedules() {
            let mut whole = iterated(Sppm::new(&scene, &settings), 2);
            let mut resumed = Sppm::new(&scene, &settings);
            for (y, words) in state(&whole).iter().enumerate() {
                resumed.load_row(y as u32, words);
            }
            resumed.go_on_after(2, *whole.stats());
            for iterations in [2, 3] {
                assert_eq!(state(&resumed), state(&whole), "{iterations}");
                assert_eq!(resumed.iterations(), iterations);
                for (x, y) in [(0, 0), (5, 0), (0, 5), (11, 8)] {
                    assert_eq!(resumed.probe(x, y), whole.probe(x, y), "{x}, {y}");
                }
                whole.iterate();
                resumed.iterate();
            }
        }
    }

    /// With global radii any iteration can be the first, and has the radius of its number.
    #[test]
    fn iterations_with_global_radii_are_independent() {
        let scene = scene();
        let [_, settings] = schedules();
        let mut engine = Sppm::new(&scene, &settings);
        engine.skip_to(2);
        assert_eq!(engine.progress().next, 2);
        let radius = engine.probe(0, 0).radius;
        engine.iterate();
        let after = engine.probe(0, 0).radius;
        assert!(after < radius && radius < settings.initial_radius, "{radius}, {after}");
        assert_eq!(iterated(Sppm::new(&scene, &settings), 3).probe(0, 0).radius, after);
    }

    /// Photons fly where they are aimed, by a survey unless that is known.
    #[test]
    fn photons_are_aimed_by_a_survey_or_as_told() {
        let scene = files::builtin::scene("terrace").unwrap();
        let settings = Settings {
            width: 12,
            height: 9,
            photons_per_iteration: 2000,
            radius_pilots: 0,
            ..scene.settings
        };
        let new = || Sppm::new(&scene, &settings);
        let by_survey = iterated(new(), 1);
        let told = iterated(new().aimed_at(crate::survey::survey(&scene, &settings)), 1);
        assert_eq!(state(&by_survey), state(&told));
        let alike = iterated(new().aimed_at(Targets::default()), 1);
        assert_ne!(state(&by_survey), state(&alike));
        assert_ne!(state(&iterated(new().lit_by_power(), 1)), state(&alike));
        assert_eq!(by_survey.stats().photons, 2000);
    }

    /// Of every pass.
    #[test]
    fn times_and_bytes_are_counted() {
        let scene = scene();
        for settings in schedules() {
            let engine = iterated(Sppm::new(&scene, &settings), 2);
            let Stats {
                camera_seconds, build_grid_seconds, photon_seconds, consolidate_seconds, bytes, ..
            } = *engine.stats();
            for seconds in [camera_seconds, build_grid_seconds, photon_seconds, consolidate_seconds] {
                assert!(seconds > 0.0, "{:?}", engine.stats());
            }
            // In the box each pixel sees a surface.
            let of_point = size_of::<VisiblePoint>() + size_of::<usize>() + size_of::<f32>();
            let per_pixel = size_of::<Pixel>() + size_of::<Rgb>() + of_point;
            let sums = if engine.global.is_some() { size_of::<ExactSums>() } else { 0 };
            let pixels = settings.pixels() * (per_pixel + size_of::<Gathered>() + sums);
            let empty = Grid::build(&[], |_| 1.0, CELL_SIZE).bytes();
            // An entry of a point has 16 bytes, and a point touches from 1 to 27 cells.
            let most = pixels + empty + 27 * 16 * settings.pixels();
            assert!((pixels + empty..=most).contains(&(bytes as usize)), "{bytes} for {pixels} and {empty}");
        }
    }
}
