//! Shows a render that runs elsewhere to pages that cannot change it, and to tev.

use crate::display::Display;
use crate::easel::{LAYERS, lacks_layer, layers};
use crate::hub::{Hub, show};
use crate::pace::interval;
use crate::picture::{Caption, Picture, of_film, of_plane};
use axum::body::Bytes;
use render::{Image, Step};
use scene::settings::MAX_ITERATIONS;
use scene::{Plane, Resumable};
use serde_json::json;
use std::sync::Arc;
use std::time::Instant;

/// Follows a render from its observer. Pictures are developed only when somebody looks.
#[derive(Debug)]
pub struct Relay {
    hub: Option<Arc<Hub>>,
    display: Option<Arc<Display>>,
    began: Instant,
    shown: Option<Instant>,
    number: u32,
    step: Step,
}

impl Relay {
    pub(crate) fn new(hub: Option<Arc<Hub>>, display: Option<Arc<Display>>, name: &str) -> Self {
        if let Some(hub) = &hub {
            let scene =
                json!({ "type": "scene", "mode": "watch", "name": name, "layers": LAYERS, "others": [] });
            show(&hub.scene, &scene);
        }
        Self { hub, display, began: Instant::now(), shown: None, number: 0, step: Step::default() }
    }

    /// To be called after every iteration.
    pub fn after(&mut self, step: &Step, engine: &dyn Resumable) {
        if let Some(display) = self.display.as_ref().filter(|display| display.is_due()) {
            display.show(engine.develop());
        }
        self.step = *step;
        let Some(hub) = self.hub.clone().filter(|hub| hub.clients() > 0) else { return };
        let is_due = self.shown.is_none_or(|at| at.elapsed() >= interval(self.began.elapsed()));
        if is_due || lacks_layer(&hub) {
            let settings = engine.settings();
            let caption = self.caption([settings.width, settings.height]);
            self.publish(&hub, layers(&hub, engine, &engine.develop(), caption), false);
        }
    }

    /// To be called with the last image of the render.
    pub fn last(&mut self, image: Image) {
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
        Caption { version: 1, iterations: self.step.iteration, whole, number: self.number }
    }

    fn publish(&mut self, hub: &Hub, layers: Vec<(u32, Bytes)>, is_last: bool) {
        hub.pictures.send_replace(Some(Arc::new(Picture::new(layers))));
        self.shown = Some(Instant::now());
        let step = &self.step;
        show(
            &hub.status,
            &json!({
                "type": "status",
                "version": 1,
                "preview": false,
                "iterations": step.iteration,
                "limit": (step.iterations < MAX_ITERATIONS).then_some(step.iterations),
                "seconds": step.elapsed_seconds,
                "photons": step.photons,
                "camera_segments": step.camera_segments,
                "mean_radius": step.mean_radius,
                "error": step.estimated_error.filter(|error| error.is_finite()),
                "curve": [],
                "waiting": is_last,
            }),
        );
    }
}
