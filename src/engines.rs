//! The engines that `--engine` chooses from.

use clap::ValueEnum;
use reference::{PathTracer, Sppm};
use scene::{Engine, Scene, Settings};
use serde::Serialize;

/// An engine by its name on the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum EngineName {
    /// Stochastic progressive photon mapping in plain scalar code: the definition of the image
    Reference,
    /// A path tracer: ground truth without bias, noisy where there are caustics; iterations are samples per pixel
    Path,
}

impl EngineName {
    /// A render of `scene` before its first iteration.
    pub(crate) fn start<'a>(self, scene: &'a Scene, settings: &Settings) -> Box<dyn Engine + 'a> {
        match self {
            Self::Reference => Box::new(Sppm::new(scene, settings)),
            Self::Path => Box::new(PathTracer::new(scene, settings)),
        }
    }

    /// True if photons are traced, so that there are radii and photon counts.
    pub(crate) fn has_photons(self) -> bool {
        match self {
            Self::Reference => true,
            Self::Path => false,
        }
    }

    /// The name on the command line.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Reference => "reference",
            Self::Path => "path",
        }
    }
}
