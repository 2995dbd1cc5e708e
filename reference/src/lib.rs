//! The scalar reference.
#![forbid(unsafe_code)]

use scene::{Engine, Film, Plane, Scene, Settings, Stats};

macro_rules! engine {
    ($name:ident) => {
        /// Stub.
        pub struct $name {
            settings: Settings,
            done: u32,
            stats: Stats,
        }
        impl $name {
            /// Starts a render.
            pub fn new(_scene: &Scene, settings: &Settings) -> Self {
                Self {
                    settings: *settings,
                    done: 0,
                    stats: Stats::default(),
                }
            }
        }
        impl Engine for $name {
            fn iterate(&mut self) {
                self.done += 1;
            }
            fn iterations(&self) -> u32 {
                self.done
            }
            fn develop(&self) -> Film {
                Film::new(self.settings.width, self.settings.height)
            }
            fn radius(&self) -> Option<Plane> {
                None
            }
            fn count(&self) -> Option<Plane> {
                None
            }
            fn stats(&self) -> &Stats {
                &self.stats
            }
        }
    };
}
engine!(Sppm);
engine!(PathTracer);
