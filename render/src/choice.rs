//! The choice of an engine, with the fast engine's lanes and free parameters.

use crate::error::{Error, Field, Problem};
use crate::names::{EngineName, LanesName, available_lanes};
use crate::profile::Profile;
use fast::{LaneKind, Parameters, Parts};
use reference::PathTracer;
use scene::text::list;
use scene::{Resumable, Scene};
use std::path::Path;

/// An engine, with lanes and free parameters if it is the fast engine.
#[derive(Clone, Copy, Debug)]
pub struct EngineChoice {
    name: EngineName,
    lanes: LaneKind,
    parameters: Parameters,
}

impl Default for EngineChoice {
    /// The fast engine on the widest lanes.
    fn default() -> Self {
        Self { name: EngineName::Fast, lanes: LaneKind::best(), parameters: Parameters::default() }
    }
}

impl EngineChoice {
    /// The engine `name`, on `lanes` or else on the widest lanes.
    ///
    /// # Errors
    /// If `lanes` are given for an engine without lanes, or if the processor does not support them.
    pub fn new(name: EngineName, lanes: Option<LanesName>) -> Result<Self, Error> {
        let kind = lanes.map_or_else(LaneKind::best, LanesName::kind);
        match lanes {
            Some(_) if name != EngineName::Fast => Err(only_fast_has(Field::Lanes, name, "lanes")),
            Some(lanes) if !kind.is_available() => Err(lacking(lanes)),
            _ => Ok(Self { name, lanes: kind, parameters: Parameters::default() }),
        }
    }

    /// The engine `name` with the free parameters in the file `profile`, on `lanes` or else on those of the profile.
    ///
    /// # Errors
    /// If the file is not a valid profile, if the engine has no free parameters, or as [`Self::new`].
    pub fn with_profile(name: EngineName, lanes: Option<LanesName>, profile: &Path) -> Result<Self, Error> {
        if name != EngineName::Fast {
            return Err(only_fast_has(Field::Profile, name, "free parameters"));
        }
        let Profile { parameters, lanes: usual } = Profile::read(profile)?;
        let told = |error: Error| {
            let said = Problem::of(Field::Profile).text(format_args!(": {}: ", profile.display()));
            Error::input(Field::Profile, said.join(error.problem()))
        };
        let chosen = match lanes {
            Some(_) => Self::new(name, lanes)?,
            None => Self::new(name, usual).map_err(told)?,
        };
        Ok(Self { parameters, ..chosen })
    }

    /// The name of the engine.
    pub fn name(self) -> EngineName {
        self.name
    }

    /// The lanes that it runs on; `None` if it has none.
    pub fn lanes(self) -> Option<LanesName> {
        (self.name == EngineName::Fast).then(|| self.lanes.into())
    }

    /// The lanes that the fast engine would run on.
    pub fn lane_kind(self) -> LaneKind {
        self.lanes
    }

    /// The free parameters of the fast engine.
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// A new render of `scene` with the scene's settings. The fast engine holds at most about `deposits` deposits at a
    /// time, and reuses the `parts` of an earlier render.
    pub(crate) fn start(self, scene: &Scene, deposits: u32, parts: Parts) -> Started<'_> {
        let settings = &scene.settings;
        match self.name {
            EngineName::Fast => {
                let engine = fast::Sppm::with_parts(scene, settings, self.lanes, &self.parameters, parts);
                Started::Fast(Box::new(engine.deposits_at_once(deposits)))
            }
            EngineName::Reference => Started::Other(Box::new(reference::Sppm::new(scene, settings))),
            EngineName::Path => Started::Other(Box::new(PathTracer::new(scene, settings))),
        }
    }
}

/// A started engine. The fast engine has its own variant, because its parts can be reused.
pub(crate) enum Started<'a> {
    Fast(Box<fast::Sppm<'a>>),
    Other(Box<dyn Resumable + 'a>),
}

impl<'a> Started<'a> {
    pub(crate) fn engine(&mut self) -> &mut (dyn Resumable + 'a) {
        match self {
            Self::Fast(engine) => &mut **engine,
            Self::Other(engine) => &mut **engine,
        }
    }

    /// The parts that a later render can reuse.
    pub(crate) fn into_parts(self) -> Parts {
        match self {
            Self::Fast(engine) => engine.into_parts(),
            Self::Other(_) => Parts::default(),
        }
    }
}

/// The error for a `field` that needs `what`, which this engine does not have.
fn only_fast_has(field: Field, name: EngineName, what: &str) -> Error {
    let problem = Problem::of(field).text(": ").field(Field::Engine);
    let rest = format!(" {} has no {what}, only fast has; leave out one of the two", name.name());
    Error::input(field, problem.text(rest))
}

/// The error for `lanes` that the processor does not support.
fn lacking(lanes: LanesName) -> Error {
    let there: Vec<_> = available_lanes().map(|kind| LanesName::from(kind).name()).collect();
    let problem = format!(" {}: this processor has none; it has {}", lanes.name(), list(&there));
    Error::input(Field::Lanes, Problem::of(Field::Lanes).text(problem))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_for_missing_lanes_lists_the_available_ones() {
        let said = lacking(LanesName::Avx512).to_string();
        assert!(said.starts_with("lanes avx512: this processor has none; it has emulated"), "{said}");
    }

    #[test]
    fn only_the_fast_engine_has_lanes() {
        for lanes in [LanesName::Auto, LanesName::Emulated] {
            assert!(EngineChoice::new(EngineName::Reference, Some(lanes)).is_err());
            assert!(EngineChoice::new(EngineName::Fast, Some(lanes)).unwrap().lanes().is_some());
        }
        assert_eq!(EngineChoice::new(EngineName::Path, None).unwrap().lanes(), None);
        let usual = EngineChoice::new(EngineName::Fast, None).unwrap();
        assert_eq!(usual.lanes(), Some(LaneKind::best().into()));
    }

    #[test]
    fn lanes_that_the_processor_lacks_are_rejected() {
        for lanes in [LanesName::Emulated, LanesName::Avx2, LanesName::Avx512] {
            let chosen = EngineChoice::new(EngineName::Fast, Some(lanes));
            assert_eq!(chosen.is_ok(), lanes.kind().is_available(), "{lanes:?}");
        }
    }
}
