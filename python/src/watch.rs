//! What a render's thread and Python's threads tell each other.

use render::{Image, Notice, Observer, Step};
use scene::{Resumable, Stop, TRANSPORT};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Shared by a render's observer and its Python object.
#[derive(Default)]
pub(crate) struct Desk {
    state: Mutex<State>,
    changed: Condvar,
}

/// What is on the desk.
#[derive(Default)]
pub(crate) struct State {
    /// The last iteration.
    pub(crate) step: Option<Step>,
    /// Whether an image is asked for.
    pub(crate) is_wanted: bool,
    /// The newest image that was asked for, or the last.
    pub(crate) image: Option<Image>,
    /// How many more iterations may be done, if the render only does those that are asked for.
    pub(crate) allowed: Option<u32>,
    /// Whether the render waits to be allowed more.
    pub(crate) is_paused: bool,
    /// Warnings that Python has not given yet.
    pub(crate) warnings: Vec<String>,
    /// Whether the render has ended.
    pub(crate) is_over: bool,
}

impl Desk {
    /// For a render that only does the iterations that are asked for if it `is_paused`.
    pub(crate) fn new(is_paused: bool) -> Self {
        let allowed = is_paused.then_some(0);
        Self { state: Mutex::new(State { allowed, ..State::default() }), changed: Condvar::new() }
    }

    pub(crate) fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Changes the state and wakes who waits.
    pub(crate) fn change(&self, change: impl FnOnce(&mut State)) {
        change(&mut self.state());
        self.changed.notify_all();
    }

    /// Waits until `is_so`, or for `most`; returns whether it is so.
    pub(crate) fn wait(&self, most: Duration, mut is_so: impl FnMut(&State) -> bool) -> bool {
        let until = Instant::now() + most;
        let mut state = self.state();
        while !is_so(&state) {
            let left = until.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return false;
            }
            let waited = self.changed.wait_timeout(state, left);
            state = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
        true
    }
}

/// The observer of a render.
pub(crate) struct Watch {
    pub(crate) desk: Arc<Desk>,
    pub(crate) stop: Stop,
    /// Whether all iterations are done, or the render has ended otherwise.
    is_done: bool,
}

impl Watch {
    pub(crate) fn new(desk: Arc<Desk>, stop: Stop) -> Self {
        Self { desk, stop, is_done: false }
    }

    /// Waits while no more iterations are allowed, unless the render is to stop.
    fn pause(&self) {
        /// How often it is asked whether the render is to stop.
        const STEP: Duration = Duration::from_millis(10);
        if self.desk.state().allowed != Some(0) {
            return;
        }
        self.desk.change(|state| state.is_paused = true);
        while !self.stop.is_requested() && !self.desk.wait(STEP, |state| state.allowed != Some(0)) {}
        self.desk.change(|state| state.is_paused = false);
    }
}

impl Observer for Watch {
    fn after(&mut self, step: &Step, _: &dyn Resumable) {
        self.is_done = step.iteration >= step.iterations;
        self.desk.change(|state| {
            state.step = Some(*step);
            state.allowed = state.allowed.map(|allowed| allowed.saturating_sub(1));
        });
    }

    fn wants_image(&mut self, is_last: bool) -> bool {
        self.is_done |= is_last;
        let state = self.desk.state();
        is_last || state.is_wanted || state.allowed == Some(0)
    }

    fn image(&mut self, image: Image) {
        self.desk.change(|state| (state.image, state.is_wanted) = (Some(image), false));
        if !self.is_done {
            self.pause();
        }
    }

    fn notice(&mut self, notice: &Notice) {
        let warning = match notice {
            Notice::Resumed { fallback: Some(fault), .. } => {
                format!("{fault}; resumed from the older generation")
            }
            Notice::NotLocked(fault) => format!("{fault}; nothing keeps another render from writing it too"),
            Notice::NotSaved(fault) => format!("the checkpoint was not written: {fault}"),
            Notice::NotRefreshed(fault) | Notice::NoSnapshot(fault) => fault.to_string(),
            Notice::OtherTransport { path, transport } => format!(
                "{} was made by version {transport} of the light transport, and this is version {TRANSPORT}: the image \
                 will be another",
                path.display()
            ),
            Notice::Begun { .. } => return self.pause(),
            _ => return,
        };
        self.desk.change(|state| state.warnings.push(warning));
    }
}

impl Drop for Watch {
    fn drop(&mut self) {
        self.desk.change(|state| state.is_over = true);
    }
}
