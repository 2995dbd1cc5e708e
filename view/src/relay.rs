//! Shows a render that runs elsewhere to pages that cannot change it, and to tev.

use crate::display::Display;
use crate::easel::{LAYERS, develop, lacks_layer, layers};
use crate::hub::{Hub, show};
use crate::pace::Schedule;
use crate::picture::{Caption, Picture, of_film, of_plane};
use axum::body::Bytes;
use render::{Image, Step};
use scene::settings::MAX_ITERATIONS;
use scene::{Plane, Resumable};
use serde_json::json;
use std::sync::Arc;
use std::time::Duration;

/// The share of the time that pictures may take.
const SHARE: f64 = 0.01;

/// Follows a render from its observer. Pictures are developed only when somebody looks.
#[derive(Debug)]
pub struct Relay {
    hub: Option<Arc<Hub>>,
    display: Option<Arc<Display>>,
    schedule: Schedule,
    number: u32,
    /// Counts the renders that were shown.
    version: u32,
    step: Step,
    workers: Option<u32>,
}

impl Relay {
    pub(crate) fn new(hub: Option<Arc<Hub>>, display: Option<Arc<Display>>, name: &str) -> Self {
        let schedule = Schedule::new(SHARE, Duration::ZERO);
        let step = Step::default();
        let relay = Self { hub, display, schedule, number: 0, version: 1, step, workers: None };
        relay.entitle(name);
        relay
    }

    /// The same with pictures that may take this `share` of the time.
    #[must_use]
    pub fn with_share(self, share: f64) -> Self {
        Self { schedule: Schedule::new(share, Duration::ZERO), ..self }
    }

    /// From now on the pictures are of another render, which is called `name`.
    pub fn begin(&mut self, name: &str) {
        self.version += 1;
        self.entitle(name);
    }

    fn entitle(&self, name: &str) {
        if let Some(hub) = &self.hub {
            let scene =
                json!({ "type": "scene", "mode": "watch", "name": name, "layers": LAYERS, "others": [] });
            show(&hub.scene, &scene);
        }
    }

    /// Tells how far a render is that so many `workers` compute, without a picture.
    pub fn tell(&mut self, step: &Step, workers: u32) {
        // The radius of the last picture.
        let mean_radius = step.mean_radius.or(self.step.mean_radius);
        (self.step, self.workers) = (Step { mean_radius, ..*step }, Some(workers));
        if let Some(hub) = &self.hub {
            self.show_status(hub, step.iteration >= step.iterations);
        }
    }

    /// Whether [`Self::after`] is to be called after this iteration: somebody looks, and a picture is due.
    pub fn wants(&self) -> bool {
        self.lacks() || (self.is_seen() && self.schedule.is_due())
    }

    /// Whether a page looks at a layer that the last picture lacks, so that a picture is wanted although nothing is new.
    pub fn lacks(&self) -> bool {
        self.hub.as_ref().is_some_and(|hub| hub.clients() > 0 && lacks_layer(hub))
    }

    fn is_seen(&self) -> bool {
        self.hub.as_ref().is_some_and(|hub| hub.clients() > 0)
            || self.display.as_ref().is_some_and(|display| display.is_due())
    }

    /// To be called after an iteration, if this relay [`Self::wants`] it.
    pub fn after(&mut self, step: &Step, engine: &dyn Resumable) {
        self.step = *step;
        let mut schedule = self.schedule;
        schedule.show(|| self.show(engine));
        self.schedule = schedule;
    }

    fn show(&mut self, engine: &dyn Resumable) {
        let film = develop(engine);
        if let Some(hub) = self.hub.clone().filter(|hub| hub.clients() > 0) {
            let caption = self.caption([film.width, film.height]);
            self.publish(&hub, layers(&hub, engine, &film, caption), false);
        }
        if let Some(display) = self.display.as_ref().filter(|display| display.is_due()) {
            display.show(film);
        }
    }

    /// To be called with the last image of the render.
    pub fn last(&mut self, image: Image) {
        self.step.iteration = image.metadata.settings.iterations;
        let caption = self.caption([image.film.width, image.film.height]);
        let plane =
            |layer: u32, plane: Option<&Plane>| plane.map(|plane| (layer, of_plane(plane, layer, caption)));
        let planes = [plane(2, image.radius.as_ref()), plane(3, image.count.as_ref())];
        let film = [0, 1].map(|layer| (layer, of_film(&image.film, layer, caption)));
        if let Some(hub) = self.hub.clone() {
            self.publish(&hub, film.into_iter().chain(planes.into_iter().flatten()).collect(), true);
        }
        if let Some(display) = &self.display {
            display.show(image.film);
        }
    }

    fn caption(&mut self, whole: [u32; 2]) -> Caption {
        self.number += 1;
        Caption { version: self.version, iterations: self.step.iteration, whole, number: self.number }
    }

    fn publish(&self, hub: &Hub, layers: Vec<(u32, Bytes)>, is_last: bool) {
        hub.pictures.send_replace(Some(Arc::new(Picture::new(layers))));
        self.show_status(hub, is_last);
    }

    fn show_status(&self, hub: &Hub, is_last: bool) {
        let step = &self.step;
        show(
            &hub.status,
            &json!({
                "type": "status",
                "version": self.version,
                "preview": false,
                "iterations": step.iteration,
                "limit": (step.iterations < MAX_ITERATIONS).then_some(step.iterations),
                "seconds": step.elapsed_seconds,
                "photons": step.photons,
                "camera_segments": step.camera_segments,
                "mean_radius": step.mean_radius,
                "error": step.estimated_error.filter(|error| error.is_finite()),
                "curve": [],
                "workers": self.workers,
                "waiting": is_last,
            }),
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use render::{Job, Observer};
    use scene::Settings;
    use serde_json::Value;
    use std::io::Read as _;
    use std::net::TcpListener;

    /// What pages are told is what the step says, each figure by its own name.
    #[test]
    fn pages_are_told_what_the_step_says() {
        let hub = Arc::new(Hub::new(false, Vec::new()));
        let mut relay = Relay::new(Some(Arc::clone(&hub)), None, "box");
        let told = |board: &crate::hub::Board| serde_json::from_str::<Value>(&board.borrow()).unwrap();
        assert_eq!(told(&hub.scene)["name"], "box");
        let step = Step {
            iteration: 3,
            iterations: 8,
            seconds: 0.5,
            elapsed_seconds: 2.5,
            photons: 300,
            camera_segments: 77,
            mean_radius: Some(0.25),
            estimated_error: Some(0.125),
            saved: false,
        };
        relay.tell(&step, 5);
        let expected = json!({
            "type": "status", "version": 1, "preview": false, "iterations": 3, "limit": 8, "seconds": 2.5,
            "photons": 300, "camera_segments": 77, "mean_radius": 0.25, "error": 0.125, "curve": [], "workers": 5,
            "waiting": false,
        });
        assert_eq!(told(&hub.status), expected);
        // The radius of the last picture stays; an error that is no number is none.
        let later = Step { iteration: 8, mean_radius: None, estimated_error: Some(f64::INFINITY), ..step };
        relay.tell(&later, 4);
        let status = told(&hub.status);
        assert_eq!((&status["mean_radius"], &status["error"]), (&json!(0.25), &Value::Null));
        assert_eq!((&status["waiting"], &status["workers"]), (&json!(true), &json!(4)));
        // Without an end there is no limit.
        relay.tell(&Step { iterations: MAX_ITERATIONS, ..step }, 4);
        assert_eq!(told(&hub.status)["limit"], Value::Null);
        relay.begin("room");
        relay.tell(&step, 1);
        assert_eq!((&told(&hub.scene)["name"], &told(&hub.status)["version"]), (&json!("room"), &json!(2)));
    }

    /// However short a time ago another one was: no later one comes.
    #[test]
    fn the_last_image_is_sent_to_the_viewer() {
        struct Last(Relay);
        impl Observer for Last {
            fn wants_image(&mut self, is_last: bool) -> bool {
                is_last
            }
            fn image(&mut self, image: Image) {
                self.0.last(image);
            }
        }
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let display = Display::new(listener.local_addr().unwrap().to_string(), "box".into()).unwrap();
        let mut scene = files::builtin::scene("cornell").unwrap();
        scene.settings =
            Settings { width: 8, height: 6, iterations: 1, photons_per_iteration: 100, ..scene.settings };
        display.show(scene::Film::new(8, 6));
        assert!(!display.is_due());
        let relay = Relay::new(None, Some(Arc::new(display)), "box");
        let mut job = Job::new(scene);
        job.live = true;
        let film = job.start(Last(relay)).unwrap().wait().unwrap().last.unwrap().film.clone();
        let mut bytes = Vec::new();
        listener.accept().unwrap().0.read_to_end(&mut bytes).unwrap();
        let brightest = film.pixels.iter().map(|pixel| pixel.max_element()).fold(0.0, f32::max);
        assert!(brightest > 0.0 && bytes.windows(4).any(|four| four == brightest.to_le_bytes()));
    }

    /// One that the image does not have is shown as the image.
    #[test]
    fn the_last_picture_has_every_layer_in_its_place() {
        struct Last(Relay, Arc<Hub>);
        impl Observer for Last {
            fn wants_image(&mut self, is_last: bool) -> bool {
                is_last
            }
            fn image(&mut self, image: Image) {
                let caption = Caption { version: 1, iterations: 2, whole: [8, 6], number: 1 };
                let [radius, count] = [&image.radius, &image.count].map(|plane| plane.as_ref().unwrap());
                assert_ne!(radius, count);
                let expected = [
                    of_film(&image.film, 0, caption),
                    of_film(&image.film, 1, caption),
                    of_plane(radius, 2, caption),
                    of_plane(count, 3, caption),
                ];
                self.0.last(image);
                let picture = self.1.pictures.borrow().clone().unwrap();
                let shown = [0, 1, 2, 3].map(|layer| picture.layer(layer).unwrap());
                assert!(shown == expected);
            }
        }
        let hub = Arc::new(Hub::new(false, Vec::new()));
        let mut scene = files::builtin::scene("cornell").unwrap();
        scene.settings =
            Settings { width: 8, height: 6, iterations: 2, photons_per_iteration: 500, ..scene.settings };
        let relay = Relay::new(Some(Arc::clone(&hub)), None, "box");
        Job::new(scene).start(Last(relay, Arc::clone(&hub))).unwrap().wait().unwrap();
        assert!(hub.pictures.borrow().is_some());
    }

    /// Nobody looks, so nothing is developed.
    #[test]
    fn pictures_are_wanted_by_who_looks() {
        let hub = Arc::new(Hub::new(false, Vec::new()));
        let relay = Relay::new(Some(Arc::clone(&hub)), None, "box");
        assert!(!relay.wants() && !relay.lacks());
        let visit = hub.enter(1).unwrap();
        assert!(relay.wants() && !relay.lacks());
        drop(visit);
        assert!(!relay.wants());
        // A layer that is not in the last picture is wanted at once, though nothing is new.
        relay.publish(&hub, vec![(0, Bytes::new())], false);
        let mut visit = hub.enter(1).unwrap();
        assert!(!relay.lacks());
        visit.look_at(2);
        assert!(relay.wants() && relay.lacks());
        relay.publish(&hub, vec![(0, Bytes::new()), (2, Bytes::new())], false);
        assert!(!relay.lacks());
    }
}
