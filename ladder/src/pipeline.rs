//! The pipeline of all rows: the passes of an iteration, generic over the parts that a row names.

use crate::camera_pass::CameraPass;
use crate::counted::{self, Operations};
use crate::flux::IntegerSums;
use crate::index::Index;
use crate::numbers::{Generator, Numbers};
use crate::options::{Options, Random, Sums};
use crate::photon_pass::PhotonPass;
use crate::pixels::{PixelState, Pixels};
use crate::rung::Rung;
use crate::tables::Tables;
use crate::vector::{Pass, Vector, Width};
use lanes::Lanes;
use scene::{Engine, Probe, Progress, Rgb, Scene, Settings, Stop};
use std::f32::consts::PI;
use std::time::Instant;

/// The parts of a row.
pub(crate) trait Parts: 'static {
    /// The vectors, and so the number of paths and candidates processed at a time.
    type Width: Width;
    /// The layout of pixels and visible points.
    type Pixels: Pixels;
    /// The spatial index.
    type Index: Index;
    /// True if the properties of hit spheres are read from columns, word by word.
    const FROM_COLUMNS: bool;
}

/// A render with the parts `P`.
pub(crate) struct Pipeline<'a, P: Parts> {
    scene: &'a Scene,
    progress: Progress,
    numbers: Numbers,
    pixels: P::Pixels,
    index: P::Index,
    /// The operations of each pass, if they are counted.
    operations: Option<[Operations; 4]>,
}

impl<'a, P: Parts> Pipeline<'a, P> {
    /// A render that has not begun.
    pub(crate) fn new(
        scene: &'a Scene,
        settings: &Settings,
        options: &Options,
        generator: Generator,
    ) -> Self {
        let numbers = match options.random {
            Random::Keyed => Numbers::keyed(settings),
            Random::Paper => Numbers::of(generator, settings.seed),
        };
        let sums = IntegerSums::new(settings.pixels(), options.sums == Sums::Integer);
        Self {
            scene,
            progress: Progress::new(settings),
            numbers,
            pixels: Pixels::new(settings.pixels(), settings.initial_radius, sums),
            index: Index::new(settings.pixels(), &options.tuning),
            operations: options.counts_operations.then(Default::default),
        }
    }

    /// Runs all passes of one iteration.
    #[inline(always)]
    fn run<V: Vector>(&mut self, tables: &Tables) {
        let Self { progress, numbers, pixels, index, operations, .. } = self;
        let Progress { settings, iterations: iteration, stats, .. } = progress;
        let (iteration, count) = (*iteration, settings.pixels());
        let frame = self.scene.camera.frame(settings.width, settings.height);
        let from_columns = P::FROM_COLUMNS;

        let start = Instant::now();
        let pass = CameraPass { tables, frame: &frame, settings, iteration, from_columns };
        pass.run::<V, _>(pixels, numbers, stats);
        enter(operations, 0);
        let camera = Instant::now();
        index.build::<V, _>(pixels, count);
        enter(operations, 1);
        let built = Instant::now();
        let pass = PhotonPass { tables, settings, iteration, from_columns };
        pass.run::<V, _, _>(pixels, index, numbers, stats);
        enter(operations, 2);
        let traced = Instant::now();
        for at in (0..count).step_by(V::L::N) {
            pixels.consolidate::<V>(at, tables.still.lights.power);
        }
        enter(operations, 3);

        stats.camera_seconds += (camera - start).as_secs_f64();
        stats.build_grid_seconds += (built - camera).as_secs_f64();
        stats.photon_seconds += (traced - built).as_secs_f64();
        stats.consolidate_seconds += traced.elapsed().as_secs_f64();
        stats.bytes = (pixels.bytes() + index.bytes()) as u64;
    }

    /// As `reference::consolidate::Pixel::develop`.
    fn developed(&self, pixel: &PixelState) -> Rgb {
        let n = self.progress.iterations as f32;
        let photons = n * self.progress.settings.photons_per_iteration as f32;
        let density = 1.0 / (photons * (PI * pixel.radius_squared));
        pixel.direct * (1.0 / n) + pixel.tau * density
    }
}

/// Adds the operations that a pass has counted.
#[inline(always)]
fn enter(operations: &mut Option<[Operations; 4]>, pass: usize) {
    if let Some(operations) = operations {
        operations[pass] += counted::take();
    }
}

/// One iteration.
struct Iteration<'a, 'b, P: Parts> {
    pipeline: &'a mut Pipeline<'b, P>,
    tables: &'a Tables<'a>,
}

impl<P: Parts> Pass for Iteration<'_, '_, P> {
    #[inline(always)]
    fn run<V: Vector>(self) {
        self.pipeline.run::<V>(self.tables);
    }
}

impl<P: Parts> Engine for Pipeline<'_, P> {
    fn progress(&self) -> &Progress {
        &self.progress
    }

    fn iterate_unless(&mut self, _: &Stop) -> bool {
        let still = self
            .scene
            .at(self.scene.camera.shutter_time(self.progress.settings.seed, self.progress.iterations));
        let tables = Tables::new(&still);
        if self.operations.is_some() {
            counted::take();
            P::Width::run_counted(Iteration { pipeline: self, tables: &tables });
        } else {
            P::Width::run(Iteration { pipeline: self, tables: &tables });
        }
        self.progress.advance();
        true
    }

    fn probe(&self, x: u32, y: u32) -> Probe {
        let Settings { width, height, .. } = self.progress.settings;
        assert!(x < width && y < height, "no such pixel");
        let pixel = self.pixels.state(y as usize * width as usize + x as usize);
        let radiance = if self.progress.iterations > 0 { self.developed(&pixel) } else { Rgb::ZERO };
        let PixelState { direct, n, radius_squared, .. } = pixel;
        Probe { radiance, direct, radius: radius_squared.sqrt(), count: n }
    }
}

impl<P: Parts> Rung for Pipeline<'_, P> {
    fn operations(&self) -> Option<[Operations; 4]> {
        self.operations
    }
}
