//! An iteration: the passes in order, each over all threads.
//!
//! ```text
//! camera pass: visible points and direct light of all pixels         (camera_pass/)
//! until all photons of the iteration are traced:
//!     photon pass: photons to deposits in bins                       (photon_pass/)
//!     sort the deposits by cell                                      (join/sorted.rs)
//!     join: each visible point adds up the photons that count        (join/)
//! consolidate: add the sums to the pixels, and shrink their radii    (consolidate.rs, as part of the last join)
//! ```

use super::memory::bytes_at_most;
use crate::camera_pass::{CameraPass, CameraPlan, CameraWorkers};
use crate::consolidate::density;
use crate::eye::Eye;
use crate::global::Global;
use crate::hierarchy::Hierarchy;
use crate::join::{Cells, Join, Occupancy, Radii, Round, Sorted};
use crate::pages::Pages;
use crate::parameters::Parameters;
use crate::photon_pass::{Emission, Emitters, PHOTON_WORK, PhotonPass, PhotonPlan, PhotonWorkers, Rounding};
use crate::pixels::{Pixel, Seen, slots};
use crate::prepared::Prepared;
use crate::survey::survey;
use lanes::LaneKind;
use scene::aim::{Aim, Targets};
use scene::film::FluxUnit;
use scene::still::Carried;
use scene::{Clearance, FirstRadii, Progress, Scene, Settings, Stop};
use std::time::Instant;

/// The work of sorting and joining the deposits of a photon, in units as [`PHOTON_WORK`].
const JOIN_WORK: u64 = 3;

/// Deposits that are held at once, at most: they are joined before there are more (unless [`Sppm::deposits_at_once`] says
/// otherwise).
pub const DEPOSITS_AT_ONCE: u32 = 1 << 22;

/// What outlives a render, for another one.
#[derive(Default)]
pub struct Parts {
    pixels: Option<Pages<Pixel>>,
    seen: Option<Seen>,
    sorted: Option<Sorted>,
    camera_workers: Option<CameraWorkers>,
    photon_workers: Option<PhotonWorkers>,
    hierarchy: Option<Hierarchy>,
}

impl Parts {
    /// The hierarchy of a scene alone.
    pub(super) fn of_hierarchy(hierarchy: Option<Hierarchy>) -> Self {
        Self { hierarchy, ..Self::default() }
    }

    /// The hierarchy, if there is one.
    pub(super) fn into_hierarchy(self) -> Option<Hierarchy> {
        self.hierarchy
    }
}

/// The fast renderer.
pub struct Sppm<'a> {
    pub(super) scene: &'a Scene,
    pub(super) progress: Progress,
    pub(super) lanes: LaneKind,
    pub(super) parameters: Parameters,
    deposits_at_once: u32,
    eye: Eye,
    /// What pixels have gathered, in tile order.
    pub(super) pixels: Pages<Pixel>,
    /// What they have gained, if radii are global; `pixels` then hold the gain of an iteration.
    pub(super) global: Option<Global>,
    /// This iteration's visible points and direct light, in tile order.
    seen: Seen,
    sorted: Sorted,
    pub(super) camera_workers: CameraWorkers,
    pub(super) photon_workers: PhotonWorkers,
    pub(super) join: Join,
    /// The scene's only still and its tables, if nothing moves.
    pub(super) prepared: Option<Prepared<'a>>,
    /// What photons are aimed at, once it is known. It is the same for all iterations, so it need not be saved.
    targets: Option<Targets>,
    /// The tables of emission, once they are known and if nothing moves.
    pub(super) emitters: Option<Emitters>,
    /// The radii with which pixels begin, if they are given or known.
    pub(super) first_radii: Option<FirstRadii>,
    /// The search radii of the next iteration, if the last one has told them.
    pub(super) radii: Option<Radii>,
    /// The limit of first radii by what is near, at this iteration's instant.
    clearance: Option<Clearance>,
    /// Photons that counted at a visible point in the last iteration, on average.
    neighbours: f64,
    pub(super) carried: Carried,
}

impl<'a> Sppm<'a> {
    /// A render before its first iteration, on the best lanes that the processor has.
    pub fn new(scene: &'a Scene, settings: &Settings) -> Self {
        Self::with_lanes(scene, settings, LaneKind::best())
    }

    /// The same on other lanes.
    pub fn with_lanes(scene: &'a Scene, settings: &Settings, lanes: LaneKind) -> Self {
        Self::with_parameters(scene, settings, lanes, &Parameters::default())
    }

    /// The same with other parameters, which change its speed.
    pub fn with_parameters(
        scene: &'a Scene,
        settings: &Settings,
        lanes: LaneKind,
        parameters: &Parameters,
    ) -> Self {
        Self::with_parts(scene, settings, lanes, parameters, Parts::default())
    }

    /// The same with the `parts` of an earlier render, of this scene or another: what did not change is not built again.
    /// The image does not depend on them.
    pub fn with_parts(
        scene: &'a Scene,
        settings: &Settings,
        lanes: LaneKind,
        parameters: &Parameters,
        parts: Parts,
    ) -> Self {
        Self {
            scene,
            progress: Progress::new(settings),
            lanes,
            parameters: *parameters,
            deposits_at_once: DEPOSITS_AT_ONCE,
            eye: Eye::new(scene, settings),
            pixels: Pages::refilled(parts.pixels, Pixel::new(settings.initial_radius), slots(settings)),
            global: Global::new(scene, settings),
            seen: Seen::new(parts.seen, settings),
            sorted: parts.sorted.unwrap_or_else(Sorted::new),
            camera_workers: parts.camera_workers.unwrap_or_else(CameraWorkers::new),
            photon_workers: parts.photon_workers.unwrap_or_else(PhotonWorkers::new),
            join: Join::new(),
            prepared: Prepared::only(scene, Carried::All, parameters, parts.hierarchy),
            targets: None,
            emitters: None,
            first_radii: None,
            radii: None,
            clearance: Clearance::new(settings),
            neighbours: parameters.neighbours_at_first.into(),
            carried: Carried::All,
        }
    }

    /// What another render can use: memory, and the hierarchy of balls.
    pub fn into_parts(self) -> Parts {
        Parts {
            pixels: Some(self.pixels),
            seen: Some(self.seen),
            sorted: Some(self.sorted),
            camera_workers: Some(self.camera_workers),
            photon_workers: Some(self.photon_workers),
            hierarchy: self.prepared.map(|prepared| prepared.tables.hierarchy),
        }
    }

    /// The same render with the photons of an iteration traced and joined in rounds, each of which ends once it has
    /// `most` deposits: less memory, the same bits.
    #[must_use]
    pub fn deposits_at_once(mut self, most: u32) -> Self {
        self.deposits_at_once = most.clamp(1, 1 << 30);
        self
    }

    /// The same render with a join that can be stopped half-way whenever the last one tested `pairs` or more. Such a
    /// join adds up all photons before it consolidates, which takes a little more time and memory.
    #[must_use]
    pub fn long_join(mut self, pairs: u64) -> Self {
        self.join.set_long(pairs);
        self
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

    /// The image of caustics alone, and of what they light: of lamps' light whose first surface is a mirror or glass, as
    /// photons bring it to diffuse surfaces. A part of [`scene::Hybrid`].
    #[must_use]
    pub fn of_caustics(self) -> Self {
        self.carrying(Carried::Caustics)
    }

    /// The same render with photons that carry this light.
    pub(super) fn carrying(mut self, carried: Carried) -> Self {
        if carried != self.carried {
            self.carried = carried;
            let hierarchy = self.prepared.take().map(|prepared| prepared.tables.hierarchy);
            self.prepared = Prepared::only(self.scene, carried, &self.parameters, hierarchy);
        }
        self
    }

    /// How many deposits were kept for the last join: those that are near some visible point.
    pub fn kept(&self) -> usize {
        self.sorted.count()
    }

    /// What its photons are aimed at; `None` before the first iteration has found that by a survey.
    pub fn targets(&self) -> Option<&Targets> {
        self.targets.as_ref()
    }

    /// The most bytes that a render of a scene of so many `spheres` takes, with so many `deposits_at_once`
    /// ([`Sppm::deposits_at_once`]): if every photon is deposited at every bounce where something can be seen.
    pub fn bytes_at_most(
        settings: &Settings,
        spheres: usize,
        threads: usize,
        deposits_at_once: u32,
        parameters: &Parameters,
    ) -> u64 {
        bytes_at_most(settings, spheres, threads, deposits_at_once, parameters)
    }

    /// The tables of emission for the iteration of this still.
    pub(super) fn new_emitters(&mut self, p: &Prepared) -> Emitters {
        let Progress { settings, next, .. } = &self.progress;
        let (scene, parameters, lanes) = (self.scene, &self.parameters, self.lanes);
        let targets = self.targets.get_or_insert_with(|| {
            if *next == 0 || !scene.moves() {
                return survey(scene, settings, p, lanes);
            }
            // Resumed: the survey is that of the first iteration.
            let first = scene.at_for(scene.camera.shutter_time(settings.seed, 0), p.still.carried);
            survey(scene, settings, &Prepared::new(first, parameters, None), lanes)
        });
        Emitters::new(&p.still, Aim::new(&p.still, targets, settings.photons_per_iteration))
    }

    /// All passes of an iteration; `None` if stopped, and then no pixel has changed.
    pub(super) fn run_iteration(&mut self, p: &Prepared, emitters: &Emitters, stop: &Stop) -> Option<()> {
        if self.carried == Carried::Caustics && !p.still.has_photons() {
            self.progress.advance();
            return Some(());
        }
        let (start, before) =
            (Instant::now(), (self.progress.stats.contributions, self.progress.stats.visible_points));
        let photons = u64::from(self.progress.settings.photons_per_iteration);
        stop.meter().begin(self.pixels.len() as u64 + (PHOTON_WORK + JOIN_WORK) * photons);
        if self.scene.moves() {
            self.clearance = Clearance::new(&self.progress.settings);
        }
        let radii = self.radii();
        let occupancy = self.camera_pass(p, radii, stop)?;
        self.progress.stats.camera_seconds += start.elapsed().as_secs_f64();
        let Parameters { cell_size, photons_per_batch, .. } = self.parameters;
        let total = self.progress.settings.photons_per_iteration;
        let cells = Cells::new(radii.cell_size(cell_size, self.neighbours), self.parameters.buckets(total));
        let key = (self.progress.settings.seed, self.progress.next);
        let pass = PhotonPass {
            emission: Emission::new(&p.still, emitters, &p.lights.choice, key),
            tables: &p.tables,
            max_depth: self.progress.settings.max_depth,
            carried: p.still.carried,
            cells,
            occupancy: &occupancy,
            reach: radii.largest,
            rounding: Rounding::of(&p.still),
            at_once: photons_per_batch as usize,
        };
        let unit = FluxUnit::new(p.still.lights.power, emitters.scale().unwrap_or(1.0));
        let density = self.global.as_ref().map(|global| density(total, global.radius_squared));
        let mut next = 0;
        while next < total {
            next = self.round(&pass, next, (unit, density), stop)?;
        }
        if let Some(global) = &mut self.global {
            global.add(&self.pixels);
        }
        let (contributions, points) =
            (self.progress.stats.contributions - before.0, self.progress.stats.visible_points - before.1);
        self.neighbours = contributions as f64 / points.max(1) as f64;
        self.progress.stats.bytes = self.bytes() as u64;
        self.join.clear();
        self.progress.advance();
        self.shrink();
        Some(())
    }

    /// The search radii of this iteration.
    fn radii(&mut self) -> Radii {
        let (known, per_job) = (self.radii.take(), self.parameters.pixels_per_job as usize);
        let Some(global) = &self.global else {
            return known.unwrap_or_else(|| Radii::of(&self.pixels, per_job));
        };
        global.prepare(&mut self.pixels);
        Radii::global(global.radius_squared)
    }

    /// If radii are global, sets that of the next iteration.
    pub(super) fn shrink(&mut self) {
        if let Some(global) = &mut self.global {
            global.shrink(&self.progress.settings, self.progress.next);
        }
    }

    /// The camera pass; returns the cells that visible points reach.
    fn camera_pass(&mut self, p: &Prepared, radii: Radii, stop: &Stop) -> Option<Occupancy> {
        let parameters = &self.parameters;
        let plan = CameraPlan {
            pixels_per_job: parameters.pixels_per_job as usize,
            pixels_per_batch: parameters.pixels_per_batch as usize,
            // By the largest radius, although only some pixels keep it. If cells shrank, such a pixel would mark ever more
            // of them, until most are marked, and memory would grow.
            occupancy_cell: radii.largest * parameters.occupancy_cell_size,
            occupancy_bits: parameters.occupancy_bits,
        };
        let pass = CameraPass {
            still: &p.still,
            tables: &p.tables,
            lights: &p.lights,
            eye: &self.eye,
            settings: &self.progress.settings,
            iteration: self.progress.next,
            clearance: self.clearance.as_ref(),
        };
        let lanes = (self.lanes, plan);
        self.camera_workers.run(&pass, lanes, &mut self.seen, &self.pixels, &mut self.progress.stats, stop)
    }

    /// A round: traces the photons from `from` on until there are enough deposits, sorts these, and joins them with the
    /// visible points. Returns where the next round begins.
    fn round(
        &mut self,
        pass: &PhotonPass,
        from: u32,
        (unit, density): (FluxUnit, Option<f32>),
        stop: &Stop,
    ) -> Option<u32> {
        let start = Instant::now();
        let total = self.progress.settings.photons_per_iteration;
        let Parameters { photons_per_job, pixels_per_job, .. } = self.parameters;
        let plan = PhotonPlan { from, total, deposits_at_once: self.deposits_at_once, photons_per_job };
        self.photon_workers.take_back(&mut self.sorted);
        let next = self.photon_workers.run(pass, (self.lanes, plan), &mut self.progress.stats, stop)?;
        let traced = Instant::now();
        self.photon_workers.sort_into(&mut self.sorted, pass.cells);
        let sorted = Instant::now();
        let is_last = next == total;
        let round = Round { sorted: Some(&self.sorted), cells: pass.cells, is_last, unit, density };
        let lanes = (self.lanes, pixels_per_job as usize);
        self.radii =
            self.join.run(round, lanes, &mut self.pixels, &self.seen, &mut self.progress.stats, stop)?.radii;
        stop.meter().advance(JOIN_WORK * u64::from(next - from));
        self.progress.stats.photon_seconds += (traced - start).as_secs_f64();
        self.progress.stats.build_grid_seconds += (sorted - traced).as_secs_f64();
        self.progress.stats.consolidate_seconds += sorted.elapsed().as_secs_f64();
        Some(next)
    }

    fn bytes(&mut self) -> usize {
        let pixels = size_of_val(&self.pixels[..]) + self.seen.bytes() + self.join.bytes();
        let global = self.global.as_ref().map_or(0, Global::bytes);
        pixels + global + self.sorted.bytes() + self.photon_workers.bytes()
    }
}
