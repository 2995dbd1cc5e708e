//! The engines that `--engine` chooses from, and the lanes that `--lanes` does.

use crate::args::EngineArgs;
use crate::error::Error;
use crate::profile::Profile;
use crate::text::list;
use clap::ValueEnum;
use fast::{Intersector, LaneKind, Parameters};
use rayon::prelude::*;
use reference::PathTracer;
use reference::intersect::intersect;
use scene::ray::{NO_SPHERE, SphereId};
use scene::{Ray, Resumable, Scene, Settings, Still, Sums, Vec3};
use serde::{Deserialize, Serialize};

/// Rays that a thread traces before it asks for more.
const RAYS_AT_ONCE: usize = 1 << 14;

/// An engine by its name on the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum EngineName {
    /// Stochastic progressive photon mapping on vectors and all threads: the reference's image, bit for bit
    Fast,
    /// Stochastic progressive photon mapping in plain scalar code: the definition of the image
    Reference,
    /// A path tracer: ground truth without bias, noisy where there are caustics; iterations are samples per pixel
    Path,
}

/// An engine whose intersections can be asked for by themselves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum TracerName {
    /// The fast engine's, on vectors
    Fast,
    /// The reference's, one ray at a time
    Reference,
}

impl From<TracerName> for EngineName {
    fn from(name: TracerName) -> Self {
        match name {
            TracerName::Fast => Self::Fast,
            TracerName::Reference => Self::Reference,
        }
    }
}

/// The vectors that the fast engine runs on, by their name on the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum LanesName {
    /// The widest that this processor has
    Auto,
    /// 8 lanes of AVX2
    Avx2,
    /// 16 lanes of AVX-512 (F, BW, DQ and VL)
    Avx512,
    /// 8 lanes of plain code, for any processor
    Emulated,
}

/// An engine, with its lanes and free parameters if it has any.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Chosen {
    name: EngineName,
    lanes: LaneKind,
    parameters: Parameters,
}

impl EngineName {
    /// True if photons are traced, so that there are radii and photon counts.
    pub(crate) fn has_photons(self) -> bool {
        match self {
            Self::Fast | Self::Reference => true,
            Self::Path => false,
        }
    }

    /// The usual engine that goes on with `sums`.
    pub(crate) fn of(sums: Sums) -> Self {
        match sums {
            Sums::Photons => Self::Fast,
            Sums::Paths => Self::Path,
        }
    }

    /// Every engine that goes on with `sums`, by its name.
    pub(crate) fn all_of(sums: Sums) -> String {
        let names =
            Self::value_variants().iter().filter(|engine| engine.sums() == sums).map(|engine| engine.name());
        list(&names.collect::<Vec<_>>())
    }

    /// What it keeps of a pixel.
    pub(crate) fn sums(self) -> Sums {
        if self.has_photons() { Sums::Photons } else { Sums::Paths }
    }

    /// The name on the command line.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Fast => "fast",
            Self::Reference => "reference",
            Self::Path => "path",
        }
    }
}

impl LanesName {
    /// The name on the command line.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Avx2 => "avx2",
            Self::Avx512 => "avx512",
            Self::Emulated => "emulated",
        }
    }

    fn kind(self) -> LaneKind {
        match self {
            Self::Auto => LaneKind::best(),
            Self::Avx2 => LaneKind::Avx2,
            Self::Avx512 => LaneKind::Avx512,
            Self::Emulated => LaneKind::Emulated,
        }
    }
}

impl From<LaneKind> for LanesName {
    fn from(kind: LaneKind) -> Self {
        match kind {
            LaneKind::Emulated => Self::Emulated,
            LaneKind::Avx2 => Self::Avx2,
            LaneKind::Avx512 => Self::Avx512,
        }
    }
}

/// The kinds of lanes that this processor has, the plainest first.
pub(crate) fn available_lanes() -> impl Iterator<Item = LaneKind> {
    LaneKind::ALL.into_iter().filter(|kind| kind.is_available())
}

impl Chosen {
    /// The engine `name` on the lanes that were asked for, if any were and it can have them.
    pub(crate) fn new(name: EngineName, lanes: Option<LanesName>) -> Result<Self, Error> {
        let kind = lanes.map_or_else(LaneKind::best, LanesName::kind);
        match lanes {
            Some(_) if name != EngineName::Fast => Err(Error::BadInput(format!(
                "--lanes: --engine {} has no lanes, only fast has; leave out one of the two",
                name.name()
            ))),
            Some(lanes) if !kind.is_available() => Err(Error::BadInput(lacking(lanes))),
            _ => Ok(Self { name, lanes: kind, parameters: Parameters::default() }),
        }
    }

    /// The engine `name` as the options ask for it.
    pub(crate) fn from_args(name: EngineName, args: &EngineArgs) -> Result<Self, Error> {
        let Some(path) = &args.profile else { return Self::new(name, args.lanes) };
        if name != EngineName::Fast {
            return Err(Error::BadInput(format!(
                "--profile: --engine {} has no free parameters, only fast has; leave out one of the two",
                name.name()
            )));
        }
        let profile = Profile::read(path)?;
        let from_profile = |error: Error| match args.lanes {
            Some(_) => error,
            None => Error::BadInput(format!("--profile: {}: {}", path.display(), error.text())),
        };
        let chosen = Self::new(name, args.lanes.or(profile.lanes)).map_err(from_profile)?;
        Ok(Self { parameters: profile.parameters, ..chosen })
    }

    /// A render of `scene` before its first iteration.
    /// The fast engine holds so many `deposits` at once.
    pub(crate) fn start<'a>(
        self,
        scene: &'a Scene,
        settings: &Settings,
        deposits: u32,
    ) -> Box<dyn Resumable + 'a> {
        match self.name {
            EngineName::Fast => {
                let engine = fast::Sppm::with_parameters(scene, settings, self.lanes, &self.parameters);
                Box::new(engine.deposits_at_once(deposits))
            }
            EngineName::Reference => Box::new(reference::Sppm::new(scene, settings)),
            EngineName::Path => Box::new(PathTracer::new(scene, settings)),
        }
    }

    /// The free parameters of the fast engine.
    pub(crate) fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// The lanes that it would run on, whether it has any or not.
    pub(crate) fn lane_kind(self) -> LaneKind {
        self.lanes
    }

    /// The lanes that it runs on.
    pub(crate) fn lanes(self) -> Option<LanesName> {
        (self.name == EngineName::Fast).then(|| self.lanes.into())
    }

    /// Distance, sphere and normal of the nearest hit of each ray; a miss is infinitely far.
    pub(crate) fn surfaces(self, still: &Still, rays: &[Ray]) -> Vec<(f32, SphereId, Vec3)> {
        const MISS: (f32, SphereId, Vec3) = (f32::INFINITY, NO_SPHERE, Vec3::ZERO);
        let intersector = Intersector::new(still, self.lanes);
        let one_by_one =
            |ray: &Ray| intersect(still, ray).map_or(MISS, |hit| (hit.t, hit.sphere, hit.normal));
        let trace = |rays: &[Ray]| -> Vec<_> {
            match self.name {
                EngineName::Fast => {
                    let met = intersector.surfaces(rays).into_iter();
                    met.map(|met| met.map_or(MISS, |met| (met.t, met.sphere, met.normal))).collect()
                }
                EngineName::Reference | EngineName::Path => rays.iter().map(one_by_one).collect(),
            }
        };
        rays.par_chunks(RAYS_AT_ONCE).flat_map_iter(trace).collect()
    }

    /// The engine.
    pub(crate) fn name(self) -> EngineName {
        self.name
    }
}

/// What to say where the processor lacks `lanes`.
fn lacking(lanes: LanesName) -> String {
    let there: Vec<_> = available_lanes().map(|kind| LanesName::from(kind).name()).collect();
    format!("--lanes {}: this processor has none; it has {}", lanes.name(), list(&there))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_lacking_is_told_with_what_is_there() {
        let said = lacking(LanesName::Avx512);
        assert!(said.starts_with("--lanes avx512: this processor has none; it has emulated"), "{said}");
    }

    #[test]
    fn lanes_go_with_the_fast_engine_alone() {
        for lanes in [LanesName::Auto, LanesName::Emulated] {
            assert!(Chosen::new(EngineName::Reference, Some(lanes)).is_err());
            assert!(Chosen::new(EngineName::Fast, Some(lanes)).unwrap().lanes().is_some());
        }
        assert_eq!(Chosen::new(EngineName::Path, None).unwrap().lanes(), None);
        assert_eq!(Chosen::new(EngineName::Fast, None).unwrap().lanes(), Some(LaneKind::best().into()));
    }

    #[test]
    fn lanes_that_the_processor_lacks_are_refused() {
        for lanes in [LanesName::Emulated, LanesName::Avx2, LanesName::Avx512] {
            let chosen = Chosen::new(EngineName::Fast, Some(lanes));
            assert_eq!(chosen.is_ok(), lanes.kind().is_available(), "{lanes:?}");
        }
    }
}
