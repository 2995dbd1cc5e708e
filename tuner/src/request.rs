//! The request for a search, and its run from the start of the optimiser to the account.

use crate::account::{Account, Outcome, Subject};
use crate::budget::Budget;
use crate::error::Error;
use crate::optimiser::Optimiser;
use crate::search::{Progress, search};
use crate::space::Space;
use crate::stopwatch::Stopwatch;
use fast::LaneKind;
use rayon::ThreadPool;
use scene::{Scene, Settings, Stop};
use std::path::Path;

/// The request for a search.
#[derive(Clone, Copy)]
pub struct Request<'a> {
    /// The name of the scene in the account.
    pub name: &'a str,
    /// The scene.
    pub scene: &'a Scene,
    /// The settings of the timed renders.
    pub settings: &'a Settings,
    /// The threads that run them.
    pub pool: &'a ThreadPool,
    /// Lanes to tune on; `None` to search among those that the processor has.
    pub lanes: Option<LaneKind>,
    /// The budget of the search.
    pub budget: Budget,
    /// Seed of the search.
    pub seed: u32,
    /// The Python that has scikit-optimize. `None` selects that of the checkout in which this program was built, else
    /// `python3`.
    pub python: Option<&'a Path>,
}

impl Request<'_> {
    /// Searches until the budget is spent or `stop` is requested. `None` if not even the defaults were measured by
    /// then.
    ///
    /// # Errors
    /// If the optimiser fails, or if a candidate changes the image, which would be a bug in the engine.
    pub fn run(&self, stop: &Stop, progress: &mut Progress) -> Result<Option<Account>, Error> {
        let Self { name, scene, settings, pool, budget, seed, .. } = *self;
        let threads = pool.current_num_threads();
        let balls = fast::ball_count(&scene.at(scene.camera.shutter[0]));
        let space = Space::new(balls, threads, self.lanes);
        progress(0, "starting the optimiser; the first time it is installed");
        let mut optimiser = match Optimiser::start(self.python, &space, budget.initial(), seed) {
            // Ctrl-C also reaches the Python process, which may end before it answers.
            Err(_) if stop.is_requested() => return Ok(None),
            started => started?,
        };
        let defaults = space.defaults();
        let Some(stopwatch) = Stopwatch::new(scene, settings, pool, defaults, stop) else { return Ok(None) };
        let Some(found) = search(&stopwatch, &space, &mut optimiser, &budget, progress)? else {
            return Ok(None);
        };
        Ok(Some(Account::new(Outcome {
            subject: Subject::new(name, scene, *settings, threads),
            defaults,
            found,
            optimiser: optimiser.name.clone(),
            seed,
            pairs: budget.pairs,
        })))
    }
}
