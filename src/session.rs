//! A render on a thread of its own, so that a request to end is answered at once and not after an iteration.
//!
//! The engine is developed after every iteration; that takes milliseconds, where an iteration may take seconds,
//! and so the image after the last whole iteration is always at hand.

use crate::engines::EngineName;
use crate::error::Error;
use crate::interrupt::{Requests, Signal};
use scene::{Engine, Film, Plane, Scene, Settings, Stats};
use std::sync::mpsc::{RecvTimeoutError, SyncSender, sync_channel};
use std::time::{Duration, Instant};

/// A render after a whole iteration.
pub(crate) struct Snapshot {
    /// The image.
    pub film: Film,
    /// The radius of every pixel, for engines with photons.
    pub radius: Option<Plane>,
    /// The photons of every pixel, for engines with photons.
    pub count: Option<Plane>,
    /// What the engine did so far.
    pub stats: Stats,
    /// Iterations run so far.
    pub iterations: u32,
    /// Time spent developing so far.
    pub develop: Duration,
}

/// How a session ended.
pub(crate) struct Outcome {
    /// The render after its last whole iteration.
    pub last: Snapshot,
    /// The request to end that came before the last iteration was over, if one did.
    pub interrupted: Option<Signal>,
    /// Wall-clock time from the start.
    pub elapsed: Duration,
}

/// How long a request to end may wait.
const PATIENCE: Duration = Duration::from_millis(50);

/// Renders `scene` until all iterations are done or a request to end comes, and calls `watch` after each of them.
pub(crate) fn run(
    engine: EngineName,
    scene: Scene,
    settings: Settings,
    mut watch: impl FnMut(&Snapshot),
) -> Result<Outcome, Error> {
    let requests = Requests::listen()?;
    let began = Instant::now();
    // Room for one: an engine whose iterations are short waits rather than piles up films.
    let (snapshots, inbox) = sync_channel(1);
    std::thread::spawn(move || work(engine, &scene, &settings, &snapshots));

    let mut last: Option<Snapshot> = None;
    loop {
        last = match (last, requests.pending()) {
            (Some(last), interrupted) if interrupted.is_some() || last.iterations == settings.iterations => {
                return Ok(Outcome { last, interrupted, elapsed: began.elapsed() });
            }
            (None, Some(signal)) => {
                let what = "not one iteration was over, so nothing is written";
                return Err(Error::Interrupted(signal, what.into()));
            }
            (last, _) => last,
        };
        match inbox.recv_timeout(PATIENCE) {
            Ok(snapshot) => {
                watch(&snapshot);
                last = Some(snapshot);
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => {
                return Err(Error::Failed(
                    "the engine broke down; this is a fault of sppm, please report it".into(),
                ));
            }
        }
    }
}

fn work(engine: EngineName, scene: &Scene, settings: &Settings, snapshots: &SyncSender<Snapshot>) {
    let mut engine = engine.start(scene, settings);
    let mut develop = Duration::ZERO;
    for _ in 0..settings.iterations {
        engine.iterate();
        // Nobody listens any more once the last image is being written.
        if snapshots.send(snapshot(&*engine, &mut develop)).is_err() {
            return;
        }
    }
}

fn snapshot(engine: &dyn Engine, develop: &mut Duration) -> Snapshot {
    let began = Instant::now();
    let film = engine.develop();
    *develop += began.elapsed();
    Snapshot {
        film,
        radius: engine.radius(),
        count: engine.count(),
        stats: *engine.stats(),
        iterations: engine.iterations(),
        develop: *develop,
    }
}
