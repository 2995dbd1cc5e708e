//! Runs work without the interpreter's lock.

use crate::errors::{RenderError, of_render};
use pyo3::{PyErr, PyResult, Python};
use scene::Stop;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::Duration;

/// Runs `work` while other Python threads go on. A panic becomes an exception.
pub(crate) fn work<T: Send>(py: Python, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    let done = py.detach(|| catch_unwind(AssertUnwindSafe(work)));
    done.map_err(|_| broken())
}

/// As [`work`], on a thread pool of its own. The global pool would be missing in a process that was forked later.
pub(crate) fn work_on<T: Send>(
    py: Python,
    threads: Option<usize>,
    f: impl FnOnce() -> T + Send,
) -> PyResult<T> {
    work(py, || render::pool(threads).map(|pool| pool.install(f)))?.map_err(|error| of_render(&error))
}

/// As [`work_on`] on all cores, but Ctrl-C ends the wait: the `stop` is then requested, and what the work gives in the end
/// is dropped on its thread.
pub(crate) fn work_until_interrupted<T: Send + 'static>(
    py: Python,
    stop: &Stop,
    work: impl FnOnce() -> T + Send + 'static,
) -> PyResult<T> {
    /// How often signals are looked for.
    const LOOK: Duration = Duration::from_millis(20);
    let (give, get) = sync_channel(1);
    let begun = thread::Builder::new().name("work".into()).spawn(move || {
        let done = render::pool(None).map(|pool| pool.install(work));
        // Nobody waits for it after an interruption.
        let _ = give.send(done);
    });
    begun.map_err(|error| RenderError::new_err(format!("cannot start a thread: {error}")))?;
    // Behind a lock that nobody else takes, as a receiver alone cannot be used where Python is detached.
    let get = Mutex::new(get);
    loop {
        match py.detach(|| get.lock().unwrap_or_else(PoisonError::into_inner).recv_timeout(LOOK)) {
            Ok(done) => return done.map_err(|error| of_render(&error)),
            Err(RecvTimeoutError::Disconnected) => return Err(broken()),
            Err(RecvTimeoutError::Timeout) => py.check_signals().inspect_err(|_| stop.request())?,
        }
    }
}

fn broken() -> PyErr {
    RenderError::new_err("sppm broke down; this is a fault of sppm, please report it")
}

/// Panics, for the test that no panic reaches Python.
#[cfg(debug_assertions)]
#[pyo3::pyfunction]
pub(crate) fn break_down(py: Python) -> PyResult<()> {
    work(py, || panic!("on purpose"))
}
