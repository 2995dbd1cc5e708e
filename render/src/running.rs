//! Starts a job on its own thread, and controls the running render.

use crate::error::Error;
use crate::job::Job;
use crate::observer::Observer;
use crate::outcome::Outcome;
use crate::prepare::prepare;
use crate::session;
use crate::snapshot::{Snapshot, Window};
use crate::step::Step;
use files::atomic_file::reason;
use scene::Stop;
use std::sync::Arc;
use std::thread::{self, JoinHandle};

/// A running render. Dropping it stops the render and waits until it has ended.
#[derive(Debug)]
pub struct Running {
    stop: Stop,
    window: Arc<Window>,
    thread: Option<JoinHandle<Result<Outcome, Error>>>,
}

impl Job {
    /// Validates the job and starts the render on its own thread and thread pool.
    ///
    /// # Errors
    /// If the job is not valid, with the field at fault, or if the system denies a resource. No output is written then.
    pub fn start(self, mut observer: impl Observer) -> Result<Running, Error> {
        let ready = prepare(self)?;
        let (stop, window) = (ready.job.stop.clone(), Arc::new(Window::default()));
        let shown = Arc::clone(&window);
        let begun = thread::Builder::new()
            .name("render".into())
            .spawn(move || session::run(ready, &mut observer, &shown));
        let thread =
            begun.map_err(|error| Error::failed(format!("cannot start a thread: {}", reason(&error))))?;
        Ok(Running { stop, window, thread: Some(thread) })
    }
}

impl Running {
    /// A handle that stops the render from any thread. The current iteration is abandoned, and the outputs are written.
    pub fn stopper(&self) -> Stop {
        self.stop.clone()
    }

    /// The image after the latest complete iteration, without stopping the render; `None` before the first, or if the
    /// job is not [`Job::live`].
    pub fn latest(&self) -> Option<Arc<Snapshot>> {
        self.window.snapshot()
    }

    /// The latest progress; `None` before the end of the first iteration. The mean radius is given only if the observer
    /// follows the render.
    pub fn progress(&self) -> Option<Step> {
        self.window.step()
    }

    /// The share of the iteration in progress that is done, from 0 to 1; 0 between iterations.
    pub fn share_of_iteration(&self) -> f64 {
        self.stop.meter().share()
    }

    /// Whether the render has ended, so that [`Self::wait`] returns at once.
    pub fn is_over(&self) -> bool {
        self.thread.as_ref().is_none_or(JoinHandle::is_finished)
    }

    /// Waits for the end of the render.
    ///
    /// # Errors
    /// If the render panicked, or its checkpoint has changed since it was checked. Stopping a render is not an error.
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
            let _ = thread.join(); // there is nobody to report an error to
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    use crate::observer::Observer;
    use scene::Resumable;
    use std::sync::mpsc::{Receiver, Sender, channel};

    /// Waits after the first iteration until it may go on.
    struct Waiting {
        is_there: Sender<()>,
        may_go: Receiver<()>,
    }

    impl Observer for Waiting {
        fn after(&mut self, step: &Step, _: &dyn Resumable) {
            if step.iteration == 1 {
                let _ = self.is_there.send(());
                let _ = self.may_go.recv();
            }
        }
    }

    #[test]
    fn a_render_can_be_looked_at_while_it_runs() {
        let mut scene = files::builtin::scene("cornell").unwrap();
        scene.settings = scene::Settings {
            width: 8,
            height: 6,
            iterations: 2,
            photons_per_iteration: 100,
            ..scene.settings
        };
        let (is_there, arrived) = channel();
        let (go, may_go) = channel();
        let mut job = Job::new(scene);
        job.threads = Some(1);
        let running = job.start(Waiting { is_there, may_go }).unwrap();
        arrived.recv().unwrap();
        assert!(!running.is_over() && running.progress().is_some_and(|step| step.iteration == 1));
        assert_eq!(running.share_of_iteration(), 0.0);
        assert_eq!(running.latest().map(|shown| shown.iterations), Some(1));
        // As of an iteration of which a quarter is done.
        let stopper = running.stopper();
        stopper.meter().begin(8);
        stopper.meter().advance(2);
        assert_eq!(running.share_of_iteration(), 0.25);
        go.send(()).unwrap();
        let outcome = running.wait().unwrap();
        assert_eq!((outcome.report.iterations, outcome.report.interrupted), (2, false));
    }
}
