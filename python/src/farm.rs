//! What the driver of a farm needs besides parts: chosen settings, a lock, and the page and viewer that show it.

use crate::errors::{FileError, InputError, RenderError, SceneError, of_render};
use crate::options::set_quality;
use crate::scene::Scene;
use crate::values::{SettingsTuple, of_settings, settings};
use crate::work::{work, work_on};
use files::lock;
use files::named as scenes;
use pyo3::prelude::*;
use render::merge::Merge;
use render::{Job, Step};
use scene::Automatic;
use std::ffi::OsStr;
use std::net::IpAddr;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use view::{Display, Place, Relay, View, tev};

/// The share of the driver's time that pictures may take. It renders nothing itself.
const SHARE: f64 = 0.03;

/// What the scene `source` leaves to be chosen: the quality, and whether iterations, photons, depth, radius and samples of glints
/// are.
#[pyfunction]
pub(crate) fn left_open(py: Python, source: &str) -> PyResult<(&'static str, [bool; 5])> {
    let opened = work(py, || scenes::open(OsStr::new(source), [None; 2], u64::MAX))?;
    let Automatic {
        quality,
        iterations,
        photons_per_iteration,
        max_depth,
        initial_radius,
        glint_samples,
        ..
    } = opened.map_err(SceneError::new_err)?.automatic;
    Ok((quality.name(), [iterations, photons_per_iteration, max_depth, initial_radius, glint_samples]))
}

/// The settings of `scene`, with those that are not `given`, in the order of [`left_open`], chosen at this quality. They do not
/// depend on the machine.
#[pyfunction]
pub(crate) fn choose_settings(
    py: Python,
    scene: &Scene,
    values: SettingsTuple,
    quality: &str,
    given: [bool; 5],
) -> PyResult<SettingsTuple> {
    let (shared, values) = (scene.shared(), settings(values)?);
    let [iterations, photons, depth, radius, glints] = given;
    let job = work(py, || {
        let mut job = Job::new(shared.checked()?);
        job.scene.settings = values;
        // A farm's radii are global: pilots and clearance have nothing to choose.
        set_quality(&mut job, quality, [iterations, photons, depth, radius, true, true, glints])?;
        job.choose_settings().map_err(|error| of_render(&error))?;
        PyResult::Ok(job)
    })??;
    Ok(of_settings(&job.scene.settings))
}

/// The exclusive right to replace a file, as long as it lives.
#[pyclass(frozen, module = "sppm._sppm")]
pub(crate) struct Lock {
    _lock: lock::Lock,
}

#[pymethods]
impl Lock {
    /// Locks the file `path`, which need not exist.
    #[new]
    fn new(py: Python, path: PathBuf) -> PyResult<Self> {
        let lock = work(py, || lock::Lock::take(&path))?;
        Ok(Self { _lock: lock.map_err(|error| FileError::new_err(error.to_string()))? })
    }
}

/// A page, or a viewer like tev, or both, that show what a farm has rendered so far. Nothing can be changed there.
#[pyclass(frozen, module = "sppm._sppm")]
pub(crate) struct Viewer {
    page: Option<View>,
    relay: Mutex<Relay>,
}

#[pymethods]
impl Viewer {
    /// A viewer of a render called `name`. `page` is the address and port to serve a page at, each of which may be left to the
    /// program; `display` is the place of a viewer like tev.
    #[new]
    fn new(
        py: Python,
        name: &str,
        page: Option<(Option<String>, Option<u16>)>,
        display: Option<&str>,
    ) -> PyResult<Self> {
        let place = page.map(|(ip, port)| place(ip.as_deref(), port)).transpose()?;
        let display =
            display.map(|at| tev::place(at).map_err(|bad| InputError::new_err(format!("display {bad}"))));
        let display = display.transpose()?;
        let begun = work(py, || {
            let display = display.map(|at| Display::new(at, name.into())).transpose()?;
            View::relay(name, display.map(Arc::new), place.as_ref())
        })?;
        let (page, relay) = begun.map_err(RenderError::new_err)?;
        Ok(Self { page, relay: Mutex::new(relay.with_share(SHARE)) })
    }

    /// The address of the page, if there is one.
    #[getter]
    fn address(&self) -> Option<&str> {
        self.page.as_ref().map(View::address)
    }

    /// Opens the page in the browser of this machine, if it has one.
    fn open(&self, py: Python) -> PyResult<()> {
        work(py, || self.page.iter().for_each(View::open))
    }

    /// From now on the pictures are of another render, which is called `name`.
    fn begin(&self, py: Python, name: &str) -> PyResult<()> {
        work(py, || self.relay().begin(name))
    }

    /// Whether a picture is due and somebody looks. If nothing `is_new`, only a layer that was not shown is wanted.
    fn wants(&self, py: Python, is_new: bool) -> PyResult<bool> {
        work(py, || if is_new { self.relay().wants() } else { self.relay().lacks() })
    }

    /// Tells how far the render is: iterations done and asked for, photons, seconds, and the number of workers.
    fn tell(&self, py: Python, done: (u32, u32), photons: u64, seconds: f64, workers: u32) -> PyResult<()> {
        let (iteration, iterations) = done;
        let step = Step { iteration, iterations, photons, elapsed_seconds: seconds, ..Step::default() };
        work(py, || self.relay().tell(&step, workers))
    }

    /// Shows the checkpoint `file`, of a render of so many `iterations` that has taken so many seconds.
    fn show(&self, py: Python, file: PathBuf, iterations: u32, seconds: f64) -> PyResult<()> {
        // On one thread, as workers may have the others.
        let shown = work_on(py, Some(1), || {
            let sum = Merge::open(&[file])?.add_up()?;
            let step = Step { iterations, elapsed_seconds: seconds, ..Step::of(&sum) };
            self.relay().after(&step, &sum);
            Ok::<_, render::Error>(())
        })?;
        shown.map_err(|error| of_render(&error))
    }
}

impl Viewer {
    fn relay(&self) -> MutexGuard<'_, Relay> {
        self.relay.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Where a page is to be served.
fn place(ip: Option<&str>, port: Option<u16>) -> PyResult<Place> {
    let bad =
        |ip| InputError::new_err(format!("listen {ip} is no address of a machine, such as 0.0.0.0 for all"));
    let ip = ip.map(|ip| ip.parse::<IpAddr>().map_err(|_| bad(ip))).transpose()?;
    Ok(Place::new(ip, port))
}
