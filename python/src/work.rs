//! Runs work without the interpreter's lock.

use crate::errors::RenderError;
use pyo3::{PyResult, Python};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Runs `work` while other Python threads go on. A panic becomes an exception.
pub(crate) fn work<T: Send>(py: Python, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    let done = py.detach(|| catch_unwind(AssertUnwindSafe(work)));
    done.map_err(|_| RenderError::new_err("sppm broke down; this is a fault of sppm, please report it"))
}

/// As [`work`], on a thread pool of its own. The global pool would be missing in a process that was forked later.
pub(crate) fn work_on<T: Send>(
    py: Python,
    threads: Option<usize>,
    f: impl FnOnce() -> T + Send,
) -> PyResult<T> {
    work(py, || render::pool(threads).map(|pool| pool.install(f)))?
        .map_err(|error| crate::errors::of_render(&error))
}

/// Panics, for the test that no panic reaches Python.
#[cfg(debug_assertions)]
#[pyo3::pyfunction]
pub(crate) fn break_down(py: Python) -> PyResult<()> {
    work(py, || panic!("on purpose"))
}
