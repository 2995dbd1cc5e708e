//! Follows a render on its own thread: publishes its pictures, tells its progress, and waits where it is to pause.

use crate::display::Display;
use crate::hub::{Hub, show};
use crate::kept::{Kept, Subject};
use crate::pace::Schedule;
use crate::picture::{Caption, Picture, of_film, of_plane};
use axum::body::Bytes;
use rayon::prelude::*;
use render::{Estimate, Observer, Step};
use scene::{Film, Resumable, Rgb, Settings, Stop};
use serde_json::json;
use std::cell::OnceCell;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// The layers of a render.
pub(crate) const LAYERS: [&str; 4] = ["image", "direct", "radius", "count"];
/// So many points of the noise curve are told.
const MOST_POINTS: usize = 120;
/// The share of the time that pictures may take, but for those of the first second, which come often.
const SHARE: f64 = 0.04;
const FREE: Duration = Duration::from_secs(1);
/// How often progress is told, at most.
const TELL: Duration = Duration::from_millis(100);
/// How often a paused render looks what is asked of it, if nobody wakes it.
const LOOK: Duration = Duration::from_millis(100);

/// What the studio asks of the render in progress.
#[derive(Debug, Default)]
pub(crate) struct Desk {
    wishes: Mutex<Wishes>,
    changed: Condvar,
}

/// What is asked.
#[derive(Debug, Default)]
pub(crate) struct Wishes {
    /// Whether the render waits between iterations.
    pub(crate) is_paused: bool,
    /// Iterations after which it waits.
    pub(crate) limit: u32,
    /// Whether the image is to be kept.
    pub(crate) wants_kept: bool,
    /// The image that was kept.
    pub(crate) kept: Option<Result<Arc<Kept>, String>>,
}

impl Desk {
    /// Changes what is asked, and wakes who waits for it.
    pub(crate) fn change<T>(&self, change: impl FnOnce(&mut Wishes) -> T) -> T {
        let changed = change(&mut self.wishes());
        self.changed.notify_all();
        changed
    }

    /// Wakes who waits.
    pub(crate) fn wake(&self) {
        self.changed.notify_all();
    }

    fn wishes(&self) -> MutexGuard<'_, Wishes> {
        self.wishes.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The observer of a render in the studio.
pub(crate) struct Easel {
    pub(crate) hub: Arc<Hub>,
    pub(crate) desk: Arc<Desk>,
    pub(crate) display: Option<Arc<Display>>,
    /// The request that stops the render.
    pub(crate) stop: Stop,
    pub(crate) subject: Arc<Subject>,
    /// The version of what is rendered.
    pub(crate) version: u32,
    /// The size of the whole image.
    pub(crate) whole: [u32; 2],
    /// Whether this is a picture of reduced size, of one iteration.
    pub(crate) is_preview: bool,
    /// Numbers pictures.
    pub(crate) numbers: Arc<AtomicU32>,
    /// Set when the render is over.
    pub(crate) is_over: Arc<AtomicBool>,
    pub(crate) history: History,
}

/// What is remembered from iteration to iteration.
pub(crate) struct History {
    schedule: Schedule,
    told: Option<Instant>,
    estimate: Estimate,
    curve: Vec<(u32, f64)>,
}

impl Default for History {
    fn default() -> Self {
        let schedule = Schedule::new(SHARE, FREE);
        Self { schedule, told: None, estimate: Estimate::default(), curve: Vec::new() }
    }
}

impl History {
    fn learn(&mut self, iterations: u32, develop: impl FnOnce() -> Film) {
        let before = self.estimate.error;
        self.estimate.update(iterations, develop);
        if self.estimate.error == before {
            return;
        }
        self.curve.extend(self.estimate.error.map(|error| (iterations, error)));
        if self.curve.len() > MOST_POINTS {
            let mut i = 0;
            self.curve.retain(|_| (i += 1, i % 2 == 1).1);
        }
    }
}

impl Easel {
    /// Publishes the picture in the layers that somebody looks at.
    fn publish(&mut self, engine: &dyn Resumable, film: &Film) {
        let caption = Caption {
            version: self.version,
            iterations: engine.iterations(),
            whole: self.whole,
            number: self.numbers.fetch_add(1, Ordering::Relaxed) + 1,
        };
        let publish = || {
            let layers = layers(&self.hub, engine, film, caption);
            self.hub.pictures.send_replace(Some(Arc::new(Picture::new(layers))));
        };
        self.history.schedule.show(publish);
    }

    fn tell(&mut self, step: &Step, is_waiting: bool) {
        self.history.told = Some(Instant::now());
        let limit = self.desk.wishes().limit;
        show(
            &self.hub.status,
            &json!({
                "type": "status",
                "version": self.version,
                "preview": self.is_preview,
                "iterations": step.iteration,
                "limit": (limit < u32::MAX).then_some(limit),
                "seconds": step.elapsed_seconds,
                "photons": step.photons,
                "camera_segments": step.camera_segments,
                "mean_radius": step.mean_radius,
                "error": self.history.estimate.error.filter(|error| error.is_finite()),
                "curve": self.history.curve,
                "waiting": is_waiting,
            }),
        );
    }

    fn keep(&mut self, engine: &dyn Resumable) {
        if self.is_preview || !self.desk.wishes().wants_kept {
            return;
        }
        let number = self.numbers.fetch_add(1, Ordering::Relaxed) + 1;
        let kept = Kept::new(number, engine, &self.subject).map(Arc::new);
        self.desk.change(|wishes| (wishes.kept, wishes.wants_kept) = (Some(kept), false));
        self.hub.requests.ring();
    }

    /// Waits as long as the render is to pause, and serves what is asked meanwhile.
    fn wait(&mut self, step: &Step, engine: &dyn Resumable) {
        let is_to_wait = |wishes: &Wishes| {
            wishes.is_paused || step.iteration >= wishes.limit || step.iteration >= step.iterations
        };
        if self.is_preview || !is_to_wait(&self.desk.wishes()) {
            return;
        }
        self.publish(engine, &develop(engine));
        self.tell(step, true);
        while !self.stop.is_requested() && is_to_wait(&self.desk.wishes()) {
            self.keep(engine);
            if lacks_layer(&self.hub) {
                self.publish(engine, &develop(engine));
            }
            let wishes = self.desk.wishes();
            if !wishes.wants_kept {
                drop(self.desk.changed.wait_timeout(wishes, LOOK));
            }
        }
    }
}

impl Observer for Easel {
    fn after(&mut self, step: &Step, engine: &dyn Resumable) {
        let film = OnceCell::new();
        let film = || film.get_or_init(|| develop(engine));
        if !self.is_preview {
            self.history.learn(step.iteration, || film().clone());
        }
        if self.history.schedule.is_due() || lacks_layer(&self.hub) {
            self.publish(engine, film());
        }
        if let Some(display) = self.display.as_ref().filter(|display| display.is_due()) {
            display.show(film().clone());
        }
        if self.is_preview || self.history.told.is_none_or(|at| at.elapsed() >= TELL) {
            self.tell(step, false);
        }
        self.keep(engine);
        self.wait(step, engine);
    }
}

impl Drop for Easel {
    fn drop(&mut self) {
        self.is_over.store(true, Ordering::Release);
        self.hub.requests.ring();
    }
}

/// The image, developed on the current thread pool.
pub(crate) fn develop(engine: &dyn Resumable) -> Film {
    let Settings { width, height, .. } = *engine.settings();
    let row = |y| (0..width).map(move |x| engine.probe(x, y).radiance);
    Film { width, height, pixels: (0..height).into_par_iter().flat_map_iter(row).collect() }
}

/// Whether somebody looks at a layer that the last picture lacks.
pub(crate) fn lacks_layer(hub: &Hub) -> bool {
    let picture = hub.pictures.borrow();
    picture.as_ref().is_some_and(|picture| hub.wanted().into_iter().any(|layer| !picture.has(layer)))
}

/// The bytes of all layers of `engine` that somebody looks at. A layer that the method lacks is shown as the image.
pub(crate) fn layers(hub: &Hub, engine: &dyn Resumable, film: &Film, caption: Caption) -> Vec<(u32, Bytes)> {
    let share = 1.0 / caption.iterations.max(1) as f32;
    let plain = |layer| of_film(film, layer, caption);
    let bytes = |layer: u32| match LAYERS.get(layer as usize) {
        Some(&"direct") => engine.direct().map(|film| of_film(&scaled(film, share), layer, caption)),
        Some(&"radius") => engine.radius().map(|plane| of_plane(&plane, layer, caption)),
        Some(&"count") => engine.count().map(|plane| of_plane(&plane, layer, caption)),
        _ => None,
    };
    hub.wanted().into_iter().map(|layer| (layer, bytes(layer).unwrap_or_else(|| plain(layer)))).collect()
}

fn scaled(film: Film, factor: f32) -> Film {
    Film { pixels: film.pixels.into_iter().map(|pixel: Rgb| pixel * factor).collect(), ..film }
}

#[cfg(test)]
mod tests {
    use super::*;
    /// Compares the layers of the page with the engine's values after every iteration.
    struct Layers(Arc<Hub>);

    impl Observer for Layers {
        fn after(&mut self, step: &Step, engine: &dyn Resumable) {
            let iterations = step.iteration;
            let caption = Caption { version: 1, iterations, whole: [24, 18], number: 1 };
            let film = develop(engine);
            let share = 1.0 / iterations as f32;
            let direct = Film::from_fn(24, 18, |x, y| engine.probe(x, y).direct * share);
            let [radius, count] = [engine.radius(), engine.count()].map(Option::unwrap);
            let expected = [
                (0, of_film(&film, 0, caption)),
                (1, of_film(&direct, 1, caption)),
                (2, of_plane(&radius, 2, caption)),
                (3, of_plane(&count, 3, caption)),
            ];
            assert!(layers(&self.0, engine, &film, caption) == expected, "after {iterations} iterations");
        }
    }

    /// Each layer shows means over the iterations, those of direct light too.
    #[test]
    fn layers_are_means_over_the_iterations() {
        let mut scene = files::builtin::scene("cornell").unwrap();
        scene.settings =
            Settings { width: 24, height: 18, iterations: 3, photons_per_iteration: 2000, ..scene.settings };
        let hub = Arc::new(Hub::new(true, Vec::new()));
        let mut visits: Vec<_> = (0..LAYERS.len()).map(|_| hub.enter(9).unwrap()).collect();
        visits.iter_mut().enumerate().for_each(|(layer, visit)| visit.look_at(layer));
        let outcome = render::Job::new(scene).start(Layers(hub)).unwrap().wait().unwrap();
        assert_eq!(outcome.report.iterations, 3);
    }

    /// The curve of errors has the whole render, however long: points are left out evenly.
    #[test]
    fn a_long_curve_keeps_its_beginning_and_its_end() {
        let mut history = History::default();
        let noise = std::cell::Cell::new(1_u32);
        for iterations in 1..=1 << 12 {
            history.learn(iterations, || {
                Film::from_fn(8, 8, |_, _| {
                    noise.set(noise.get().wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
                    Rgb::splat(
                        1.0 + (noise.get() >> 8) as f32 / (1 << 24) as f32 / (iterations as f32).sqrt(),
                    )
                })
            });
        }
        let curve = &history.curve;
        assert!((MOST_POINTS / 2..=MOST_POINTS).contains(&curve.len()), "{}", curve.len());
        assert!(curve.is_sorted_by_key(|(iterations, _)| *iterations));
        assert!(curve[0].0 <= 2 && curve.last().unwrap().0 > 3600, "{curve:?}");
        let early = curve.iter().filter(|(iterations, _)| *iterations <= 64).count();
        assert!(early > curve.len() / 4, "{early} of {}", curve.len());
    }
}
