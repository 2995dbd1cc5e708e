//! A render on its way, on a thread of its own.

use crate::error::Error;
use crate::job::Job;
use crate::observer::Observer;
use crate::outcome::Outcome;
use crate::prepare::prepare;
use crate::session;
use crate::snapshot::{Snapshot, Window};
use crate::step::Step;
use scene::Stop;
use std::sync::Arc;
use std::thread::{self, JoinHandle};

/// A render on its way. Dropping it stops the render and waits for that.
#[derive(Debug)]
pub struct Running {
    stop: Stop,
    window: Arc<Window>,
    thread: Option<JoinHandle<Result<Outcome, Error>>>,
}

impl Job {
    /// Checks everything that can be refused, and begins to render, on a thread and a pool of its own.
    ///
    /// # Errors
    /// Names the field at fault, or says what the system refuses. Nothing is written then.
    pub fn start(self, mut observer: impl Observer) -> Result<Running, Error> {
        let ready = prepare(self)?;
        let (stop, window) = (ready.job.stop.clone(), Arc::new(Window::default()));
        let shown = Arc::clone(&window);
        let begun = thread::Builder::new()
            .name("render".into())
            .spawn(move || session::run(ready, &mut observer, &shown));
        let thread = begun.map_err(|error| Error::failed(format!("cannot start a thread: {error}")))?;
        Ok(Running { stop, window, thread: Some(thread) })
    }
}

impl Running {
    /// What stops the render, from any thread: the iteration in progress is abandoned, and what was asked for is
    /// written.
    pub fn stopper(&self) -> Stop {
        self.stop.clone()
    }

    /// The newest whole image, at any time and without stopping; `None` before the first, and if the job is not
    /// [`Job::live`].
    pub fn latest(&self) -> Option<Arc<Snapshot>> {
        self.window.snapshot()
    }

    /// The newest progress; `None` before the end of the first iteration. Its mean radius is known only while an
    /// observer follows.
    pub fn progress(&self) -> Option<Step> {
        self.window.step()
    }

    /// Whether the render is over, so that [`Self::wait`] returns at once.
    pub fn is_over(&self) -> bool {
        self.thread.as_ref().is_none_or(JoinHandle::is_finished)
    }

    /// Waits for the end.
    ///
    /// # Errors
    /// If the render broke down, or its checkpoint changed since it was checked. A render that was stopped is no error.
    pub fn wait(mut self) -> Result<Outcome, Error> {
        let thread = self.thread.take().ok_or_else(|| Error::failed("the render is over"))?;
        let broken = "the render broke down; this is a fault of sppm, please report it";
        thread.join().unwrap_or_else(|_| Err(Error::failed(broken)))
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        if let Some(thread) = self.thread.take() {
            self.stop.request();
            let _ = thread.join(); // nobody is left to tell
        }
    }
}
