//! The fast renderer: the passes of an iteration, over all threads.

mod memory;
mod state;
#[cfg(test)]
mod tests;

use crate::camera_pass::{CameraBatch, CameraCounts, CameraPass, PixelRows, TileTable, slots};
use crate::consolidate::{consolidate_group, new_pixel};
use crate::direct_light::LightTable;
use crate::dispatch::{Kernel, LaneKind, dispatch};
use crate::hierarchy::ball_count;
use crate::jobs::singly;
use crate::join::cells::{Cells, WINDOW};
use crate::join::deposits::{Binned, Chunks, Sorted, bytes_at_rest, reserve};
use crate::join::gather::{Scratch, Sums};
use crate::join::occupancy::Occupancy;
use crate::join::{GROUP, JoinCounts, gather_group, mark};
use crate::lanes::{Lanes, Row};
use crate::pages::Pages;
use crate::parameters::Parameters;
use crate::photon_pass::{Emitters, PhotonBatch, PhotonCounts, PhotonPass, emission_shifts};
use crate::pool::Pool;
use crate::tables::Tables;
use rayon::current_num_threads;
use rayon::prelude::*;
use scene::{Scene, Settings, Stats, Still, Stop, Vec3};
use std::mem::take;
use std::ops::Range;
use std::sync::Arc;
use std::time::Instant;

/// Deposits that are held at most (but for one round of jobs) before they are joined, unless one asks for others.
pub const DEPOSITS_AT_ONCE: u32 = 1 << 22;
/// See [`Sppm::long_join`].
const LONG_JOIN: u64 = 1 << 29;
/// So many deposits are taken for a long join until one has been measured.
const MANY_DEPOSITS: usize = 1 << 20;

/// The fast renderer.
pub struct Sppm<'a> {
    scene: &'a Scene,
    settings: Settings,
    lanes: LaneKind,
    parameters: Parameters,
    deposits_at_once: u32,
    long_join: u64,
    iterations: u32,
    tiles: TileTable,
    /// What pixels have gathered, in tile order.
    pixels: Pages<Row>,
    /// This iteration's visible points and direct light, in tile order.
    rows: Pages<PixelRows>,
    /// This iteration's sums, in tile order; empty while one round of photons suffices.
    sums: Vec<Sums>,
    sorted: Sorted,
    camera_workers: Pool<CameraWorker>,
    photon_workers: Pool<PhotonWorker>,
    /// Room for deposits in bins.
    chunks: Arc<Chunks>,
    /// What follows from the scene alone, if nothing moves.
    prepared: Option<Prepared<'a>>,
    stats: Stats,
    /// Whether the last join took long.
    has_long_joins: Option<bool>,
    /// Photons that counted at a visible point in the last iteration, on average.
    neighbours: f64,
}

/// What a thread needs for the camera pass, and what it has found.
struct CameraWorker {
    batch: CameraBatch,
    occupancy: Option<Occupancy>,
    segments: u64,
    visible_points: u64,
}

impl CameraWorker {
    fn new() -> Self {
        Self { batch: CameraBatch::new(), occupancy: None, segments: 0, visible_points: 0 }
    }
}

/// What a thread needs for the photon pass, and what it has deposited.
struct PhotonWorker {
    batch: PhotonBatch,
    out: Binned,
    segments: u64,
    deposits: u64,
}

impl PhotonWorker {
    fn new(chunks: &Arc<Chunks>) -> Self {
        Self { batch: PhotonBatch::new(), out: Binned::new(chunks), segments: 0, deposits: 0 }
    }
}

/// A still, as the passes read it.
struct Prepared<'a> {
    still: Still<'a>,
    tables: Tables,
    lights: LightTable,
    emitters: Emitters,
}

impl<'a> Prepared<'a> {
    fn new(still: Still<'a>, parameters: &Parameters) -> Self {
        let tables = Tables::with_search(&still, parameters.search(ball_count(&still)));
        let lights = LightTable::new(&still);
        let emitters = Emitters::new(&still);
        Self { still, tables, lights, emitters }
    }
}

impl<'a> Sppm<'a> {
    /// A render that has not begun, on the best lanes there are.
    pub fn new(scene: &'a Scene, settings: &Settings) -> Self {
        Self::with_lanes(scene, settings, LaneKind::best())
    }

    /// The same render on other lanes.
    pub fn with_lanes(scene: &'a Scene, settings: &Settings, lanes: LaneKind) -> Self {
        Self::with_parameters(scene, settings, lanes, &Parameters::default())
    }

    /// The same render, faster or slower.
    pub fn with_parameters(
        scene: &'a Scene,
        settings: &Settings,
        lanes: LaneKind,
        parameters: &Parameters,
    ) -> Self {
        let slots = slots(settings);
        let moves = scene.spheres.iter().any(|s| s.velocity != Vec3::ZERO);
        Self {
            scene,
            settings: *settings,
            lanes,
            parameters: *parameters,
            deposits_at_once: DEPOSITS_AT_ONCE,
            long_join: LONG_JOIN,
            iterations: 0,
            tiles: TileTable::new(),
            pixels: Pages::filled(new_pixel(settings.initial_radius), slots),
            rows: Pages::filled(PixelRows::NOTHING, slots),
            sums: Vec::new(),
            sorted: Sorted::new(),
            camera_workers: Pool::new(),
            photon_workers: Pool::new(),
            chunks: Arc::new(Pool::new()),
            prepared: (!moves).then(|| Prepared::new(scene.at(0.0), parameters)),
            stats: Stats::default(),
            has_long_joins: None,
            neighbours: parameters.neighbours_at_first.into(),
        }
    }

    /// The same render with the photons of an iteration traced and joined in rounds, each over (but for one round of
    /// jobs) once it has `most` deposits: less memory, the same bits.
    #[must_use]
    pub fn deposits_at_once(mut self, most: u32) -> Self {
        self.deposits_at_once = most.clamp(1, 1 << 30);
        self
    }

    /// The same render with joins that can be abandoned half-way if the last one tested more than so many `pairs`:
    /// they add up all photons before they consolidate, for a little more time and memory.
    #[must_use]
    pub fn long_join(mut self, pairs: u64) -> Self {
        (self.long_join, self.has_long_joins) = (pairs, (pairs == 0).then_some(true));
        self
    }

    /// Fills this iteration's rows; `None` if stopped.
    fn camera_pass(&mut self, p: &Prepared, radii: Radii, stop: &Stop) -> Option<Occupancy> {
        let Parameters { occupancy_cell_size, occupancy_bits, pixels_per_batch, pixels_per_job, .. } =
            self.parameters;
        // By the largest radius, though some pixels keep theirs: as cells shrank such a pixel would mark ever more of them,
        // until most are marked, and memory would grow.
        let cell = radii.largest * occupancy_cell_size;
        let nothing_marked = || Occupancy::new(cell, occupancy_bits);
        let (at_once, per_job) = (pixels_per_batch as usize, pixels_per_job as usize);
        let pass = CameraPass {
            still: &p.still,
            tables: &p.tables,
            lights: &p.lights,
            tiles: &self.tiles,
            frame: self.scene.camera.frame(self.settings.width, self.settings.height),
            settings: &self.settings,
            iteration: self.iterations,
        };
        let (lanes, pixels) = (self.lanes, &self.pixels);
        let jobs = self.rows.par_chunks_mut(per_job).zip(pixels.par_chunks(per_job)).enumerate();
        let workers = &self.camera_workers;
        workers.fill(jobs.len().min(current_num_threads()), CameraWorker::new);
        singly(jobs).for_each(|(job, (rows, pixels))| {
            if stop.is_requested() {
                return;
            }
            let mut worker = workers.take(CameraWorker::new);
            let CameraWorker { batch, occupancy, .. } = &mut worker;
            let occupancy = occupancy.get_or_insert_with(nothing_marked);
            let job =
                CameraJob { pass: &pass, batch, at_once, first: job * per_job, rows, pixels, occupancy };
            let counts = dispatch(lanes, job);
            worker.segments += counts.segments;
            worker.visible_points += counts.visible_points;
            workers.put(worker);
        });
        let mut all = nothing_marked();
        for worker in self.camera_workers.all() {
            worker.occupancy.take().iter().for_each(|occupancy| all.merge(occupancy));
            self.stats.camera_segments += take(&mut worker.segments);
            let visible_points = take(&mut worker.visible_points);
            self.stats.shadow_rays += visible_points;
            self.stats.visible_points += visible_points;
        }
        (!stop.is_requested()).then_some(all)
    }

    /// Traces photons from `from` on until there are enough for a join, into the workers' bins; gives where it
    /// ended. `None` if stopped.
    fn photon_pass(&mut self, pass: &PhotonPass, from: u32, stop: &Stop) -> Option<u32> {
        let (lanes, total) = (self.lanes, self.settings.photons_per_iteration);
        let (mut next, mut deposits) = (from, 0);
        // A round is what may be deposited at once if every photon is deposited at every bounce.
        let at_once = self.deposits_at_once;
        let per_job = self.parameters.photons_per_job;
        let most = at_once.div_ceil(self.settings.max_depth).next_multiple_of(per_job);
        while next < total && deposits < at_once as usize {
            let end = total.min(next.saturating_add(most));
            let jobs: Vec<u32> = (next..end).step_by(per_job as usize).collect();
            let (workers, chunks) = (&self.photon_workers, &self.chunks);
            workers.fill(jobs.len().min(current_num_threads()), || PhotonWorker::new(chunks));
            singly(jobs.into_par_iter()).for_each(|start| {
                if stop.is_requested() {
                    return;
                }
                let mut worker = workers.take(|| PhotonWorker::new(chunks));
                let photons = start..end.min(start.saturating_add(per_job));
                let (batch, out) = (&mut worker.batch, &mut worker.out);
                let counts = dispatch(lanes, PhotonJob { pass, batch, photons, out });
                worker.segments += counts.segments;
                worker.deposits += counts.deposits;
                workers.put(worker);
            });
            deposits = self.photon_workers.all().iter().map(|worker| worker.out.count).sum();
            self.stats.photons += u64::from(end - next);
            next = end;
        }
        for worker in self.photon_workers.all() {
            self.stats.photon_segments += take(&mut worker.segments);
            self.stats.deposits += take(&mut worker.deposits);
        }
        (!stop.is_requested()).then_some(next)
    }

    /// Sorts the deposits in the workers' bins, and empties these.
    fn build_grid(&mut self, cells: Cells) {
        let workers = self.photon_workers.all();
        let parts: Vec<&Binned> = workers.iter().map(|worker| &worker.out).collect();
        self.sorted.fill(&parts, cells);
        let deposits = parts.iter().map(|part| part.count).sum();
        for worker in workers {
            worker.out.clear();
        }
        reserve(&self.chunks, deposits);
    }

    /// Joins the sorted deposits with all visible points; on the last round of the iteration, consolidates.
    /// `None` if stopped, with no pixel touched.
    fn join(&mut self, cells: Cells, is_last: bool, nominal: f32, stop: &Stop) -> Option<()> {
        let is_long = self.has_long_joins.unwrap_or(self.sorted.count() > MANY_DEPOSITS);
        if is_last && !is_long {
            self.join_round(cells, true, nominal, &Stop::new());
            return Some(());
        }
        self.sums.resize(self.pixels.len() / GROUP, Sums::default());
        self.join_round(cells, false, nominal, stop);
        if stop.is_requested() {
            return None;
        }
        if is_last {
            self.sorted.clear();
            self.join_round(cells, true, nominal, &Stop::new());
        }
        Some(())
    }

    /// Adds the sorted deposits to the sums if there are any, and consolidates if this is the last round.
    fn join_round(&mut self, cells: Cells, is_last: bool, nominal: f32, stop: &Stop) {
        let (lanes, sorted) = (self.lanes, &self.sorted);
        let per_job = self.parameters.pixels_per_job as usize;
        // None for any job, where one round suffices.
        let mut sums: Vec<&mut [Sums]> = self.sums.chunks_mut(per_job / GROUP).collect();
        sums.resize_with(self.pixels.len().div_ceil(per_job), Default::default);
        let jobs = self.pixels.par_chunks_mut(per_job).zip(self.rows.par_chunks(per_job)).zip(sums);
        let counts: Vec<JoinCounts> = singly(jobs)
            .map(|((pixels, rows), sums)| {
                if stop.is_requested() {
                    return JoinCounts::default();
                }
                dispatch(lanes, JoinJob { sorted, cells, pixels, rows, sums, is_last, nominal })
            })
            .collect();
        for counts in counts {
            self.stats.candidates += counts.candidates;
            self.stats.contributions += counts.contributions;
        }
    }

    /// All passes of an iteration; `None` if stopped, with no pixel touched.
    fn run_iteration(&mut self, p: &Prepared, stop: &Stop) -> Option<()> {
        let (start, before) = (Instant::now(), (self.stats.contributions, self.stats.visible_points));
        let radii = Radii::of(&self.pixels);
        let occupancy = self.camera_pass(p, radii, stop)?;
        let camera = Instant::now();
        self.stats.camera_seconds += (camera - start).as_secs_f64();
        let Parameters { cell_size, photons_per_batch, .. } = self.parameters;
        let buckets = self.parameters.buckets(self.settings.photons_per_iteration);
        let cells = Cells::new(radii.cell(fitting_cells(cell_size, self.neighbours)), buckets);
        let shifts = emission_shifts(self.settings.seed, self.iterations);
        let pass = PhotonPass {
            still: &p.still,
            tables: &p.tables,
            emitters: &p.emitters,
            lights: &p.lights.choice,
            settings: &self.settings.clone(),
            iteration: self.iterations,
            cells,
            occupancy: &occupancy,
            reach: radii.largest,
            slack: rounding_of_points(&p.still),
            shifts,
            at_once: photons_per_batch as usize,
        };
        let mut next = 0;
        while next < self.settings.photons_per_iteration {
            let traced = Instant::now();
            next = self.photon_pass(&pass, next, stop)?;
            let sorting = Instant::now();
            self.build_grid(cells);
            let (joining, tested) = (Instant::now(), self.stats.candidates);
            self.join(cells, next == self.settings.photons_per_iteration, p.still.lights.power, stop)?;
            // By counted work and not by the clock: so memory does not depend on how busy the machine is.
            self.has_long_joins = Some(self.stats.candidates - tested >= self.long_join);
            self.stats.photon_seconds += (sorting - traced).as_secs_f64();
            self.stats.build_grid_seconds += (joining - sorting).as_secs_f64();
            self.stats.consolidate_seconds += joining.elapsed().as_secs_f64();
        }
        let (contributions, points) =
            (self.stats.contributions - before.0, self.stats.visible_points - before.1);
        self.neighbours = contributions as f64 / points.max(1) as f64;
        self.stats.bytes = self.bytes() as u64;
        self.sums.clear();
        self.iterations += 1;
        Some(())
    }

    fn bytes(&mut self) -> usize {
        let pixels =
            size_of_val(&self.pixels[..]) + size_of_val(&self.rows[..]) + size_of_val(&self.sums[..]);
        let bins: usize = self.photon_workers.all().iter().map(|worker| worker.out.bytes()).sum();
        pixels + self.sorted.bytes() + bins + bytes_at_rest(&self.chunks)
    }
}

/// Size of the cells of the join over the typical radius, where so many photons count at a point; `for_one` is what it
/// would be for one.
fn fitting_cells(for_one: f32, neighbours: f64) -> f32 {
    (f64::from(for_one) / neighbours.max(0.1).sqrt().sqrt()).clamp(1.0, 6.0) as f32
}

/// Radii of a unit of parallel work.
const RADII_AT_ONCE: usize = 4096;

/// The search radii of an iteration.
#[derive(Clone, Copy, Debug)]
struct Radii {
    largest: f32,
    /// The quadratic mean over pixels that have counted photons; the largest, if there is none.
    typical: f32,
}

impl Radii {
    fn of(pixels: &[Row]) -> Self {
        // Of chunks and in their order, so that it does not depend on threads.
        let of_chunks: Vec<_> = pixels.par_chunks(RADII_AT_ONCE).map(Self::of_some).collect();
        let (mut largest, mut sum, mut count) = (0.0_f32, 0.0, 0.0);
        for (of_chunk, more, further) in of_chunks {
            (largest, sum, count) = (largest.max(of_chunk), sum + more, count + further);
        }
        let typical = if count > 0.0 { (sum / count).sqrt() as f32 } else { largest.sqrt() };
        Self { largest: largest.sqrt(), typical }
    }

    /// The largest squared radius; and the sum and number of those of pixels that have counted photons.
    fn of_some(pixels: &[Row]) -> (f32, f64, f64) {
        let (mut largest, mut sum, mut count) = (0.0_f32, 0.0_f64, 0.0);
        for Row([.., n, radius_squared]) in pixels {
            largest = largest.max(*radius_squared);
            if *n > 0.0 {
                sum += f64::from(*radius_squared);
                count += 1.0;
            }
        }
        (largest, sum, count)
    }

    /// The size of cells: `size` times the typical radius, but such that the span of a single visible point, twice
    /// its radius, fits into the window (unless coordinates are so large that they round to many cells).
    fn cell(self, size: f32) -> f32 {
        const LEAST: f32 = 2.0 / (WINDOW - 3) as f32;
        (self.typical * size).max(self.largest * LEAST)
    }
}

/// A bound on how far a point computed to lie on a solid ball is from where its normal says: some ulps of the
/// largest coordinate of any such ball.
pub(crate) fn rounding_of_points(still: &Still) -> f32 {
    let solid =
        still.spheres.iter().zip(&still.roles).filter(|(_, role)| **role == scene::still::Role::Solid);
    solid.map(|(s, _)| s.center.abs().max_element() + s.radius).fold(0.0, f32::max) * 1e-6
}

pub(crate) struct CameraJob<'a> {
    pub(crate) pass: &'a CameraPass<'a>,
    pub(crate) batch: &'a mut CameraBatch,
    /// Pixels of a batch.
    pub(crate) at_once: usize,
    pub(crate) first: usize,
    pub(crate) rows: &'a mut [PixelRows],
    pub(crate) pixels: &'a [Row],
    pub(crate) occupancy: &'a mut Occupancy,
}

impl Kernel for CameraJob<'_> {
    type Output = CameraCounts;
    #[inline(always)]
    fn run<L: Lanes>(self) -> CameraCounts {
        let mut counts = CameraCounts::default();
        for (number, rows) in self.rows.chunks_mut(self.at_once).enumerate() {
            let more = self.pass.run::<L>(self.batch, self.first + number * self.at_once, rows);
            counts.segments += more.segments;
            counts.visible_points += more.visible_points;
        }
        for (rows, pixels) in self.rows.chunks(GROUP).zip(self.pixels.chunks(GROUP)) {
            mark::<L>(self.occupancy, rows, pixels);
        }
        counts
    }
}

pub(crate) struct PhotonJob<'a> {
    pub(crate) pass: &'a PhotonPass<'a>,
    pub(crate) batch: &'a mut PhotonBatch,
    pub(crate) photons: Range<u32>,
    pub(crate) out: &'a mut Binned,
}

impl Kernel for PhotonJob<'_> {
    type Output = PhotonCounts;
    #[inline(always)]
    fn run<L: Lanes>(self) -> PhotonCounts {
        self.pass.run::<L>(self.batch, self.photons, self.out)
    }
}

struct JoinJob<'a> {
    sorted: &'a Sorted,
    cells: Cells,
    pixels: &'a mut [Row],
    rows: &'a [PixelRows],
    /// Sums of earlier rounds; empty if there is but one.
    sums: &'a mut [Sums],
    is_last: bool,
    nominal: f32,
}

impl Kernel for JoinJob<'_> {
    type Output = JoinCounts;
    #[inline(always)]
    fn run<L: Lanes>(self) -> JoinCounts {
        let (mut counts, mut scratch) = (JoinCounts::default(), Scratch::new());
        let groups = self.pixels.chunks_mut(GROUP).zip(self.rows.chunks(GROUP));
        for (number, (pixels, rows)) in groups.enumerate() {
            let mut sums = self.sums.get(number).copied().unwrap_or_default();
            gather_group::<L>(self.sorted, self.cells, rows, pixels, &mut scratch, &mut sums, &mut counts);
            if self.is_last {
                consolidate_group::<L>(pixels, rows, &sums, self.nominal);
            } else if let Some(kept) = self.sums.get_mut(number) {
                *kept = sums;
            }
        }
        counts
    }
}
