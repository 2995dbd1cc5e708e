//! Options of renders: engine, goals, checkpoints.

use crate::errors::{InputError, of_render};
use crate::values::{SettingsTuple, named, settings};
use pyo3::prelude::*;
use render::{
    EngineChoice, EngineName, Every, Field, Goals, Job, LanesName, MethodName, Renderer, Save,
    available_lanes,
};
use scene::{Automatic, Quality, Settings};
use std::path::PathBuf;
use std::time::Duration;

/// The options of a render. The package has checked their types and ranges.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Options {
    settings: Option<SettingsTuple>,
    quality: Option<String>,
    /// Whether iterations, photons, depth, radius, pilots and clearance are given.
    given: Option<[bool; 7]>,
    method: Option<String>,
    engine: Option<String>,
    lanes: Option<String>,
    profile: Option<PathBuf>,
    threads: Option<usize>,
    memory_limit: Option<u64>,
    /// In seconds.
    time: Option<f64>,
    until_error: Option<f64>,
    checkpoint: Option<PathBuf>,
    every_seconds: Option<f64>,
    every_iterations: Option<u32>,
    /// The iterations of a part.
    range: Option<(u32, u32)>,
    /// Whether iterations are only done when they are asked for.
    pub(crate) paused: bool,
}

impl Options {
    /// Sets what is given in `job`.
    pub(crate) fn apply(&self, job: &mut Job) -> PyResult<()> {
        if let Some(values) = &self.settings {
            job.scene.settings = settings(values.clone())?;
        }
        if let (Some(quality), Some(given)) = (&self.quality, self.given) {
            set_quality(job, quality, given)?;
        }
        job.automatic.method &= self.method.is_none();
        let (method, engine) = (self.method.as_deref(), self.engine.as_deref());
        job.engine =
            choose(method, engine, self.lanes.as_deref(), self.profile.as_ref(), job.engine.renderer())?;
        job.inputs.extend(self.profile.clone().map(|path| (Field::Profile, path)));
        job.threads = self.threads;
        job.memory_limit = self.memory_limit;
        let time = self.time.map(Duration::try_from_secs_f64).transpose();
        let time = time.map_err(|error| InputError::new_err(format!("time: {error}")))?;
        job.goals = Goals { time, error: self.until_error.or(job.goals.error) };
        job.automatic.iterations &= !job.goals.are_open();
        self.save(job);
        job.range = self.range.map(|(start, end)| start..end).or(job.range.take());
        // Images are developed when they are asked for.
        job.live = false;
        Ok(())
    }

    fn save(&self, job: &mut Job) {
        if let Some(path) = &self.checkpoint {
            job.save = Some(Save { path: path.clone(), every: Every::default(), keep: true });
        }
        let every = self.every_seconds.map(|seconds| Every::Time(Duration::from_secs_f64(seconds)));
        let every = every.or(self.every_iterations.map(Every::Iterations));
        if let (Some(save), Some(every)) = (&mut job.save, every) {
            save.every = every;
        }
    }
}

/// Leaves what is not given to be chosen at the quality `name`, in the order of [`Options::given`], or takes the paper's.
pub(crate) fn set_quality(job: &mut Job, name: &str, given: [bool; 7]) -> PyResult<()> {
    let quality = named("quality", name, Quality::ALL, Quality::name)?;
    job.automatic = automatic(quality, given);
    if quality == Quality::Paper {
        job.scene.settings = papers(&job.scene.settings, given);
    }
    Ok(())
}

/// What is chosen at this quality: what is not given, in the order of [`Options::given`].
fn automatic(
    quality: Quality,
    [iterations, photons, depth, radius, pilots, clearance, glints]: [bool; 7],
) -> Automatic {
    let all = Automatic::all(quality);
    Automatic {
        iterations: all.iterations && !iterations,
        photons_per_iteration: all.photons_per_iteration && !photons,
        max_depth: all.max_depth && !depth,
        initial_radius: all.initial_radius && !radius,
        radius_pilots: all.radius_pilots && !radius && !pilots,
        radius_clearance: all.radius_clearance && !radius && !clearance,
        glint_samples: all.glint_samples && !radius && !glints,
        ..all
    }
}

/// `settings` with the paper's in place of those that are not given.
fn papers(
    settings: &Settings,
    [iterations, photons, depth, radius, pilots, clearance, glints]: [bool; 7],
) -> Settings {
    let paper = settings.with_papers();
    let own = |is_given| if is_given { settings } else { &paper };
    Settings {
        iterations: own(iterations).iterations,
        photons_per_iteration: own(photons).photons_per_iteration,
        max_depth: own(depth).max_depth,
        initial_radius: own(radius).initial_radius,
        radius_pilots: own(pilots).radius_pilots,
        radius_clearance: own(clearance).radius_clearance,
        glint_samples: own(glints).glint_samples,
        ..paper
    }
}

/// The engine of these names; what is not given is as in `usual`.
pub(crate) fn choose(
    method: Option<&str>,
    engine: Option<&str>,
    lanes: Option<&str>,
    profile: Option<&PathBuf>,
    usual: Renderer,
) -> PyResult<EngineChoice> {
    let method = method.map(|name| named("method", name, MethodName::ALL, MethodName::name)).transpose()?;
    let engine = engine.map(|name| named("engine", name, EngineName::ALL, EngineName::name)).transpose()?;
    let lanes = lanes.map(|name| named("lanes", name, LanesName::ALL, LanesName::name)).transpose()?;
    let renderer =
        Renderer { method: method.unwrap_or(usual.method), engine: engine.unwrap_or(usual.engine) };
    match profile {
        Some(profile) => EngineChoice::with_profile(renderer, lanes, profile),
        None => EngineChoice::new(renderer, lanes),
    }
    .map_err(|error| of_render(&error))
}

/// Checks settings.
#[pyfunction]
pub(crate) fn check_settings(values: SettingsTuple) -> PyResult<()> {
    settings(values)?.validate().map_err(|error| InputError::new_err(error.to_string()))
}

/// The names of the lanes that this processor has.
#[pyfunction]
pub(crate) fn lanes() -> Vec<&'static str> {
    available_lanes().map(|kind| LanesName::from(kind).name()).collect()
}

/// The number of cores available to this process.
#[pyfunction]
pub(crate) fn cores() -> usize {
    render::cores()
}
