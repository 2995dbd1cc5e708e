//! What to tune, and the search from its start to its account.

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

/// What to tune.
#[derive(Clone, Copy)]
pub struct Request<'a> {
    /// What the account calls the scene.
    pub name: &'a str,
    /// The scene.
    pub scene: &'a Scene,
    /// Of the renders that are timed.
    pub settings: &'a Settings,
    /// Where they run.
    pub pool: &'a ThreadPool,
    /// Lanes to tune on; `None` to search among those that the processor has.
    pub lanes: Option<LaneKind>,
    /// How much is tried.
    pub budget: Budget,
    /// Seed of the search.
    pub seed: u32,
    /// The Python that has scikit-optimize; `None` for that of the checkout that this program was built in, or else
    /// `python3`.
    pub python: Option<&'a Path>,
}

impl Request<'_> {
    /// Searches until the budget is spent or `stop` is requested. `None` if not even the defaults were measured by
    /// then.
    ///
    /// # Errors
    /// If the optimiser fails, or a candidate changes the image, which would be a fault of the engine.
    pub fn run(&self, stop: &Stop, progress: &mut Progress) -> Result<Option<Account>, Error> {
        let Self { name, scene, settings, pool, budget, seed, .. } = *self;
        let threads = pool.current_num_threads();
        let balls = fast::ball_count(&scene.at(scene.camera.shutter[0]));
        let space = Space::new(balls, threads, self.lanes);
        progress(0, "starting the optimiser; the first time it is installed");
        let mut optimiser = match Optimiser::start(self.python, &space, budget.initial(), seed) {
            // Ctrl-C reaches the process too, which may end before it answers.
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
