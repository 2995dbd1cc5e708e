//! A render that runs on threads of its own.

use crate::columns;
use crate::errors::{RenderError, of_render};
use crate::options::Options;
use crate::scene::Scene;
use crate::watch::{Desk, Watch};
use crate::work::{work, work_until_interrupted};
use numpy::{PyArray2, PyArray3};
use pyo3::prelude::*;
use render::{End, Image, Job, Outcome, Running};
use scene::{Rgba, Stop};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// Colours, alpha if the background is transparent, radii, counts, and the text of the metadata.
type ImageTuple<'py> = (Bound<'py, PyArray3<f32>>, PlaneOf<'py>, PlaneOf<'py>, PlaneOf<'py>, String);

/// A value per pixel, if there is one.
type PlaneOf<'py> = Option<Bound<'py, PyArray2<f32>>>;

/// Iteration, iterations, seconds, elapsed seconds, photons, mean radius, estimated error, whether a checkpoint was
/// written, and the share of the next iteration that is done.
type StepTuple = (u32, u32, f64, f64, u64, Option<f64>, Option<f64>, bool, f64);

/// A render. Its threads stop when it is dropped.
#[pyclass(frozen, module = "sppm._sppm")]
pub(crate) struct Render {
    /// The process that started it. In others, which were forked from it, its threads do not exist.
    process: u32,
    /// Iterations asked for.
    #[pyo3(get)]
    iterations: u32,
    desk: Arc<Desk>,
    stop: Stop,
    running: Mutex<Option<Running>>,
}

#[pymethods]
impl Render {
    /// Starts a render of a copy of `scene`.
    #[staticmethod]
    fn start(py: Python, scene: &Scene, options: Options) -> PyResult<Self> {
        let (shared, file) = (scene.shared(), scene.file.clone());
        Self::begin(py, options, move || {
            let mut job = Job::new(shared.checked()?);
            job.inputs.extend(file.map(|file| (render::Field::Scene, file)));
            Ok(job)
        })
    }

    /// Resumes the render of a checkpoint, with so many iterations in all if given.
    #[staticmethod]
    fn resume(py: Python, path: PathBuf, iterations: Option<u32>, options: Options) -> PyResult<Self> {
        Self::begin(py, options, move || {
            let mut job = Job::resume(&path).map_err(|error| of_render(&error))?;
            // Its image files are those of the command; Python's images are in memory.
            job.outputs = render::Outputs::default();
            if let Some(iterations) = iterations {
                job.scene.settings.iterations = iterations;
            }
            Ok(job)
        })
    }

    /// Repeats the render that wrote a file, of `scene` if it is given.
    #[staticmethod]
    fn like(py: Python, path: PathBuf, scene: Option<&Scene>, options: Options) -> PyResult<Self> {
        let shared = scene.map(Scene::shared);
        // Files of particles that the image names may be where the scene comes from.
        let folder = scene.and_then(|scene| scene.file.as_deref()?.parent().map(PathBuf::from));
        Self::begin(py, options, move || {
            let scene = shared.map(|shared| shared.checked()).transpose()?;
            Job::like_in(&path, scene, folder.as_deref()).map_err(|error| of_render(&error))
        })
    }

    /// Progress so far; `None` before the end of the first iteration.
    fn progress(&self, py: Python) -> PyResult<Option<StepTuple>> {
        self.check_process()?;
        let step = work(py, || self.desk.state().step)?;
        Ok(step.map(|step| {
            let share = self.stop.meter().share();
            let (iteration, iterations, photons) = (step.iteration, step.iterations, step.photons);
            let (seconds, elapsed) = (step.seconds, step.elapsed_seconds);
            (
                iteration,
                iterations,
                seconds,
                elapsed,
                photons,
                step.mean_radius,
                step.estimated_error,
                step.saved,
                share,
            )
        }))
    }

    /// Waits until the render is over, at most so many seconds; returns whether it is.
    fn wait(&self, py: Python, seconds: f64) -> PyResult<bool> {
        self.wait_for(py, seconds, |_| false)
    }

    /// Waits until more than `iteration` iterations are done, or the render is over.
    fn wait_beyond(&self, py: Python, iteration: u32, seconds: f64) -> PyResult<bool> {
        self.wait_for(py, seconds, |state| state.step.is_some_and(|step| step.iteration > iteration))
    }

    /// Waits until the render is paused or over.
    fn wait_for_pause(&self, py: Python, seconds: f64) -> PyResult<bool> {
        self.wait_for(py, seconds, |state| state.is_paused)
    }

    /// Allows `more` iterations to a render that was started paused.
    fn allow(&self, py: Python, more: u32) -> PyResult<()> {
        self.check_process()?;
        work(py, || {
            self.desk.change(|state| {
                (state.image, state.is_paused) = (None, false);
                state.allowed = state.allowed.map(|allowed| allowed.saturating_add(more));
            });
        })
    }

    /// Asks for the image after the next iteration.
    fn want_image(&self, py: Python) -> PyResult<()> {
        self.check_process()?;
        work(py, || {
            self.desk.change(|state| {
                if state.image.is_none() && !state.is_over {
                    state.is_wanted = true;
                }
            });
        })
    }

    /// Waits until there is an image or the render is over.
    fn wait_for_image(&self, py: Python, seconds: f64) -> PyResult<bool> {
        self.wait_for(py, seconds, |state| state.image.is_some())
    }

    /// Takes the image that was asked for, or the last, if there is one.
    fn take_image<'py>(&self, py: Python<'py>) -> PyResult<Option<ImageTuple<'py>>> {
        self.check_process()?;
        let image = work(py, || self.desk.state().image.take())?;
        image.map(|image| arrays(py, image)).transpose()
    }

    /// Takes the warnings that were not given yet.
    fn warnings(&self, py: Python) -> PyResult<Vec<String>> {
        self.check_process()?;
        work(py, || std::mem::take(&mut self.desk.state().warnings))
    }

    /// Requests the render to stop.
    fn stop(&self) -> PyResult<()> {
        self.check_process()?;
        self.stop.request();
        Ok(())
    }

    /// Waits for the end, and returns the report as JSON, what ended the render, and the last checkpoint.
    fn finish(&self, py: Python) -> PyResult<(String, &'static str, Option<PathBuf>)> {
        self.check_process()?;
        let running = work(py, || self.running().take())?;
        let running = running.ok_or_else(|| RenderError::new_err("the render has been finished already"))?;
        let outcome = work(py, || running.wait())?.map_err(|error| of_render(&error))?;
        if let Some(fault) = &outcome.unsaved {
            self.desk.change(|state| state.warnings.push(format!("the checkpoint was not written: {fault}")));
        }
        let told = told(&outcome)?;
        // The job with its thread pool and buffers.
        work(py, || drop(outcome))?;
        Ok(told)
    }
}

impl Render {
    /// Starts the job that `make` gives, with these options. Ctrl-C abandons it.
    fn begin(
        py: Python,
        options: Options,
        make: impl FnOnce() -> PyResult<Job> + Send + 'static,
    ) -> PyResult<Self> {
        let (desk, stop) = (Arc::new(Desk::new(options.paused)), Stop::new());
        let watch = Watch::new(Arc::clone(&desk), stop.clone());
        let begun = work_until_interrupted(py, &stop.clone(), move || {
            let mut job = make()?;
            job.stop = watch.stop.clone();
            options.apply(&mut job)?;
            job.choose_settings().map_err(|error| of_render(&error))?;
            let iterations = job.scene.settings.iterations;
            let running = job.start(watch).map_err(|error| of_render(&error))?;
            Ok::<_, PyErr>((running, iterations))
        })?;
        let (running, iterations) = begun?;
        let process = std::process::id();
        Ok(Self { process, iterations, desk, stop, running: Mutex::new(Some(running)) })
    }

    fn running(&self) -> MutexGuard<'_, Option<Running>> {
        self.running.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn wait_for(
        &self,
        py: Python,
        seconds: f64,
        mut is_so: impl FnMut(&crate::watch::State) -> bool + Send,
    ) -> PyResult<bool> {
        self.check_process()?;
        let most = Duration::try_from_secs_f64(seconds).unwrap_or(Duration::ZERO);
        work(py, || self.desk.wait(most, |state| state.is_over || is_so(state)))
    }

    /// # Errors
    /// In a process that was forked after the render was started.
    fn check_process(&self) -> PyResult<()> {
        if self.process == std::process::id() {
            return Ok(());
        }
        let problem = "the render runs in the process that this one was forked from; start one here";
        Err(RenderError::new_err(problem))
    }
}

impl Drop for Render {
    fn drop(&mut self) {
        let running = self.running.get_mut().unwrap_or_else(PoisonError::into_inner).take();
        if self.process != std::process::id() {
            // Its threads do not exist here, and must not be waited for.
            std::mem::forget(running);
            return;
        }
        self.stop.request();
        // Dropping it waits for the iteration in progress to be abandoned.
        let mut running = Some(running);
        let detached = Python::try_attach(|py| py.detach(|| drop(running.take())));
        debug_assert!(detached.is_some() || running.is_some());
    }
}

fn arrays(py: Python<'_>, image: Image) -> PyResult<ImageTuple<'_>> {
    let Image { film, transparent, radius, count, metadata } = image;
    let size = [film.width, film.height];
    let plane = |values: Vec<f32>| columns::plane(py, size, values);
    // The image without the background takes the place of that with it.
    let mut pixels = film.pixels;
    let alpha = transparent.map(|transparent| {
        pixels.iter_mut().zip(&transparent).for_each(|(pixel, Rgba { color, .. })| *pixel = *color);
        transparent.iter().map(|pixel| pixel.alpha).collect()
    });
    let radiance = columns::picture(py, size, pixels)?;
    let [radius, count] = [radius, count].map(|plane| plane.map(|plane| plane.values));
    let [alpha, radius, count] = [alpha, radius, count].map(|values| values.map(plane).transpose());
    Ok((radiance, alpha?, radius?, count?, metadata.to_note()))
}

fn told(outcome: &Outcome) -> PyResult<(String, &'static str, Option<PathBuf>)> {
    let end = match outcome.end {
        End::Iterations => "iterations",
        End::Time => "time",
        End::Error => "error",
        End::Stopped => "stop",
    };
    let report = serde_json::to_string(&outcome.report);
    let report = report.map_err(|error| RenderError::new_err(error.to_string()))?;
    Ok((report, end, outcome.saved.as_ref().map(|saved| saved.path.clone())))
}
