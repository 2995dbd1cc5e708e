//! Shows a render that runs elsewhere to pages that cannot change it, and to tev.

use crate::display::Display;
use crate::easel::{LAYERS, lacks_layer, layers};
use crate::hub::{Hub, show};
use crate::pace::interval;
use crate::picture::{Caption, Picture};
use render::Step;
use scene::Resumable;
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
}

impl Relay {
    pub(crate) fn new(hub: Option<Arc<Hub>>, display: Option<Arc<Display>>, name: &str) -> Self {
        if let Some(hub) = &hub {
            let scene =
                json!({ "type": "scene", "mode": "watch", "name": name, "layers": LAYERS, "others": [] });
            show(&hub.scene, &scene);
        }
        Self { hub, display, began: Instant::now(), shown: None, number: 0 }
    }

    /// To be called after every iteration.
    pub fn after(&mut self, step: &Step, engine: &dyn Resumable) {
        let is_last = step.iteration >= step.iterations;
        if let Some(display) = self.display.as_ref().filter(|display| is_last || display.is_due()) {
            display.show(engine.develop());
        }
        let Some(hub) = self.hub.clone().filter(|hub| is_last || hub.clients() > 0) else { return };
        let is_due = self.shown.is_none_or(|at| at.elapsed() >= interval(self.began.elapsed()));
        if is_due || is_last || lacks_layer(&hub) {
            self.publish(&hub, step, engine);
        }
    }

    fn publish(&mut self, hub: &Hub, step: &Step, engine: &dyn Resumable) {
        self.number += 1;
        let settings = engine.settings();
        let whole = [settings.width, settings.height];
        let caption = Caption { version: 1, iterations: step.iteration, whole, number: self.number };
        let layers = layers(hub, engine, &engine.develop(), caption);
        hub.pictures.send_replace(Some(Arc::new(Picture::new(layers))));
        self.shown = Some(Instant::now());
        show(
            &hub.status,
            &json!({
                "type": "status",
                "version": 1,
                "preview": false,
                "iterations": step.iteration,
                "limit": step.iterations,
                "seconds": step.elapsed_seconds,
                "photons": step.photons,
                "camera_segments": step.camera_segments,
                "mean_radius": step.mean_radius,
                "error": step.estimated_error.filter(|error| error.is_finite()),
                "curve": [],
                "waiting": step.iteration >= step.iterations,
            }),
        );
    }
}
