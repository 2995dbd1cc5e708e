//! The path tracer as an engine: iterations that can be stopped, images, and state that can be saved and resumed.

use super::batch::PathPass;
use super::memory::bytes_at_most;
use super::workers::{PathPlan, PathWorkers};
use crate::eye::Eye;
use crate::pages::Pages;
use crate::parameters::Parameters;
use crate::pixels::{slot_of, slots};
use crate::prepared::Prepared;
use lanes::LaneKind;
use rayon::prelude::*;
use scene::hybrid::Sampler;
use scene::{Engine, Probe, Progress, Resumable, Rgb, Scene, Settings, Stats, Stop, Sums};
use std::time::Instant;

/// The fast path tracer; an iteration is one sample per pixel.
pub struct PathTracer<'a> {
    scene: &'a Scene,
    progress: Progress,
    lanes: LaneKind,
    parameters: Parameters,
    eye: Eye,
    /// Sums of radiance, in tile order.
    sums: Pages<[f64; 3]>,
    /// The samples of the current iteration, in tile order.
    samples: Pages<[f32; 3]>,
    workers: PathWorkers,
    /// The scene's only still and its tables, if nothing moves.
    prepared: Option<Prepared<'a>>,
    /// See [`PathTracer::without_caustics`].
    has_caustics: bool,
    /// What the samples took that are not added yet.
    sampled: Stats,
}

impl<'a> PathTracer<'a> {
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
        Self {
            scene,
            progress: Progress::new(settings),
            lanes,
            parameters: *parameters,
            eye: Eye::new(scene, settings),
            sums: Pages::zeros(slots(settings)),
            samples: Pages::zeros(slots(settings)),
            workers: PathWorkers::new(),
            prepared: (!scene.moves()).then(|| prepared(scene, 0.0, parameters)),
            has_caustics: true,
            sampled: Stats::default(),
        }
    }

    /// The same render without the light of lamps that mirrors and glass send on to a diffuse surface: what photons carry in
    /// [`scene::Hybrid`].
    #[must_use]
    pub fn without_caustics(self) -> Self {
        Self { has_caustics: false, ..self }
    }

    /// The most bytes that a render of a scene of so many `spheres` takes on so many threads.
    pub fn bytes_at_most(settings: &Settings, spheres: usize, threads: usize) -> u64 {
        bytes_at_most(settings, spheres, threads)
    }

    /// Takes a sample of every pixel; returns the number of segments traced, or `None` if stopped.
    fn sample(&mut self, stop: &Stop) -> Option<u64> {
        let Self { scene, parameters, progress: Progress { settings, next, .. }, .. } = self;
        let moved;
        let prepared = if let Some(prepared) = &self.prepared {
            prepared
        } else {
            let time = scene.camera.shutter_time(settings.seed, *next);
            moved = prepared(scene, time, parameters);
            &moved
        };
        let pass = PathPass::new(prepared, &self.eye, settings, *next).with_caustics(self.has_caustics);
        let plan = PathPlan {
            pixels_per_job: parameters.pixels_per_job as usize,
            paths_per_batch: parameters.pixels_per_batch as usize,
        };
        self.workers.run(&pass, (self.lanes, plan), &mut self.samples, stop)
    }

    fn slot(&self, x: u32, y: u32) -> usize {
        slot_of(self.progress.settings.width, x, y)
    }
}

/// The scene at shutter time `time`. Shadow rays choose among its lamps.
fn prepared<'a>(scene: &'a Scene, time: f32, parameters: &Parameters) -> Prepared<'a> {
    Prepared::new(scene.at(time).with_choice_of_lamps(), parameters, None)
}

impl Engine for PathTracer<'_> {
    fn progress(&self) -> &Progress {
        &self.progress
    }

    fn has_photons(&self) -> bool {
        false
    }

    fn probe(&self, x: u32, y: u32) -> Probe {
        assert!(x < self.progress.settings.width && y < self.progress.settings.height, "no such pixel");
        let scale = 1.0 / f64::from(self.progress.iterations.max(1));
        let mean = self.sums[self.slot(x, y)].map(|sum| (sum * scale) as f32);
        Probe { radiance: Rgb::from_array(mean), ..Probe::default() }
    }

    fn iterate_unless(&mut self, stop: &Stop) -> bool {
        self.sample_and_add_unless(stop)
    }
}

impl Sampler for PathTracer<'_> {
    fn sample_unless(&mut self, stop: &Stop) -> bool {
        let start = Instant::now();
        stop.meter().begin(self.samples.len() as u64);
        let Some(segments) = self.sample(stop) else { return false };
        self.sampled = Stats {
            camera_segments: segments,
            camera_seconds: start.elapsed().as_secs_f64(),
            bytes: (size_of_val(&self.sums[..]) + size_of_val(&self.samples[..])) as u64,
            ..Stats::default()
        };
        true
    }

    fn add_samples(&mut self) {
        let per_job = self.parameters.pixels_per_job as usize;
        let jobs = self.sums.par_chunks_mut(per_job).zip(self.samples.par_chunks(per_job));
        jobs.for_each(|(sums, samples)| {
            for (sum, sample) in sums.as_flattened_mut().iter_mut().zip(samples.as_flattened()) {
                *sum += f64::from(*sample);
            }
        });
        self.progress.stats.add(&self.sampled);
        self.progress.advance();
    }
}

impl Resumable for PathTracer<'_> {
    fn sums(&self) -> Sums {
        Sums::Paths
    }

    fn save_row(&self, y: u32, words: &mut [u32]) {
        let (width, words) = (self.progress.settings.width, words.as_chunks_mut::<6>().0);
        assert_eq!(words.len(), width as usize, "not a row");
        for (words, x) in words.iter_mut().zip(0..width) {
            let halves = |sum: f64| [sum.to_bits() as u32, (sum.to_bits() >> 32) as u32];
            words.copy_from_slice(self.sums[self.slot(x, y)].map(halves).as_flattened());
        }
    }

    fn load_row(&mut self, y: u32, words: &[u32]) {
        let (width, words) = (self.progress.settings.width, words.as_chunks::<6>().0);
        assert_eq!(words.len(), width as usize, "not a row");
        for (words, x) in words.iter().zip(0..width) {
            let sum = |k: usize| f64::from_bits(u64::from(words[k]) | u64::from(words[k + 1]) << 32);
            let slot = self.slot(x, y);
            self.sums[slot] = [sum(0), sum(2), sum(4)];
        }
    }

    fn go_on_after(&mut self, iterations: u32, stats: Stats) {
        self.progress.go_on_after(iterations, stats);
    }
}
