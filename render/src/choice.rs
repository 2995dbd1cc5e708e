//! The choice of a method and an engine, with the fast engine's lanes and free parameters.

use crate::error::{Error, Field, Problem};
use crate::names::{EngineName, LanesName, MethodName, Renderer, available_lanes};
use crate::profile::Profile;
use fast::{LaneKind, Parameters, Parts};
use scene::text::list;
use scene::{FirstRadii, Resumable, Scene};
use std::path::Path;

/// A method and an engine, with lanes and free parameters if it is the fast engine.
#[derive(Clone, Copy, Debug)]
pub struct EngineChoice {
    renderer: Renderer,
    /// The field that chose the method, for messages.
    method_field: Field,
    lanes: LaneKind,
    parameters: Parameters,
}

impl Default for EngineChoice {
    /// Photon mapping by the fast engine on the widest lanes.
    fn default() -> Self {
        Self {
            renderer: Renderer::default(),
            method_field: Field::Method,
            lanes: LaneKind::best(),
            parameters: Parameters::default(),
        }
    }
}

impl EngineChoice {
    /// The `renderer`, on `lanes` or else on the widest lanes. A method alone is by the fast engine, and an engine alone is
    /// for photon mapping.
    ///
    /// # Errors
    /// If `lanes` are given for an engine without lanes, or if the processor does not support them.
    pub fn new(renderer: impl Into<Renderer>, lanes: Option<LanesName>) -> Result<Self, Error> {
        let renderer = renderer.into();
        let kind = lanes.map_or_else(LaneKind::best, LanesName::kind);
        match lanes {
            Some(_) if renderer.engine != EngineName::Fast => {
                Err(only_fast_has(Field::Lanes, renderer.engine, "lanes"))
            }
            Some(lanes) if !kind.is_available() => Err(lacking(lanes)),
            _ => Ok(Self { renderer, lanes: kind, ..Self::default() }),
        }
    }

    /// The `renderer` with the free parameters in the file `profile`, on `lanes` or else on those of the profile.
    ///
    /// # Errors
    /// If the file is not a valid profile, if the engine has no free parameters, or as [`Self::new`].
    pub fn with_profile(
        renderer: impl Into<Renderer>,
        lanes: Option<LanesName>,
        profile: &Path,
    ) -> Result<Self, Error> {
        let renderer = renderer.into();
        if renderer.engine != EngineName::Fast {
            return Err(only_fast_has(Field::Profile, renderer.engine, "free parameters"));
        }
        let Profile { parameters, lanes: usual } = Profile::read(profile)?;
        let told = |error: Error| {
            let said = Problem::of(Field::Profile).text(format_args!(": {}: ", profile.display()));
            Error::input(Field::Profile, said.join(error.problem()))
        };
        let chosen = match lanes {
            Some(_) => Self::new(renderer, lanes)?,
            None => Self::new(renderer, usual).map_err(told)?,
        };
        Ok(Self { parameters, ..chosen })
    }

    /// The same, with messages that name the field `engine` where it was that which chose the method: by `path`, its name
    /// of earlier versions.
    #[must_use]
    pub fn method_by_engine(self) -> Self {
        Self { method_field: Field::Engine, ..self }
    }

    /// The same by another method.
    pub(crate) fn by(self, method: MethodName) -> Self {
        Self { renderer: Renderer { method, ..self.renderer }, ..self }
    }

    /// The field that chose the method.
    pub(crate) fn method_field(self) -> Field {
        self.method_field
    }

    /// The method and the engine.
    pub fn renderer(self) -> Renderer {
        self.renderer
    }

    /// The method.
    pub fn method(self) -> MethodName {
        self.renderer.method
    }

    /// The name of the engine.
    pub fn name(self) -> EngineName {
        self.renderer.engine
    }

    /// The lanes that it runs on; `None` if it has none.
    pub fn lanes(self) -> Option<LanesName> {
        (self.name() == EngineName::Fast).then(|| self.lanes.into())
    }

    /// The lanes that the fast engine would run on.
    pub fn lane_kind(self) -> LaneKind {
        self.lanes
    }

    /// The free parameters of the fast engine.
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// A new render of `scene` with the scene's settings. The fast engine, for photon mapping, holds at most about `deposits`
    /// deposits at a time, and reuses the `parts` of an earlier render. `radii` are the first ones that the settings choose, if
    /// they are known already.
    pub(crate) fn start(
        self,
        scene: &Scene,
        deposits: u32,
        parts: Parts,
        radii: Option<FirstRadii>,
    ) -> Started<'_> {
        let settings = &scene.settings;
        match (self.method(), self.name()) {
            (MethodName::Sppm, EngineName::Fast) => {
                let engine = fast::Sppm::with_parts(scene, settings, self.lanes, &self.parameters, parts)
                    .deposits_at_once(deposits);
                Started::Fast(Box::new(match radii {
                    Some(radii) => engine.beginning_with(radii),
                    None => engine,
                }))
            }
            (MethodName::Sppm, EngineName::Reference) => {
                let engine = reference::Sppm::new(scene, settings);
                Started::Other(Box::new(match radii {
                    Some(radii) => engine.beginning_with(radii),
                    None => engine,
                }))
            }
            (MethodName::Path, EngineName::Fast) => {
                let engine = fast::PathTracer::with_parameters(scene, settings, self.lanes, &self.parameters);
                Started::Other(Box::new(engine))
            }
            (MethodName::Path, EngineName::Reference) => {
                Started::Other(Box::new(reference::PathTracer::new(scene, settings)))
            }
            (MethodName::Hybrid, EngineName::Fast) => {
                let paths = fast::PathTracer::with_parameters(scene, settings, self.lanes, &self.parameters);
                let photons = fast::Sppm::with_parameters(scene, settings, self.lanes, &self.parameters)
                    .deposits_at_once(deposits);
                let photons = match radii {
                    Some(radii) => photons.beginning_with(radii),
                    None => photons,
                };
                Started::Other(Box::new(fast::hybrid(paths, photons)))
            }
            (MethodName::Hybrid, EngineName::Reference) => {
                let paths = reference::PathTracer::new(scene, settings);
                let photons = reference::Sppm::new(scene, settings);
                let photons = match radii {
                    Some(radii) => photons.beginning_with(radii),
                    None => photons,
                };
                Started::Other(Box::new(reference::hybrid(paths, photons)))
            }
        }
    }
}

/// A started engine. The fast engine for photon mapping has its own variant, because its parts can be reused.
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

    /// The same, to be read.
    pub(crate) fn get(&self) -> &(dyn Resumable + 'a) {
        match self {
            Self::Fast(engine) => &**engine,
            Self::Other(engine) => &**engine,
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
        for method in MethodName::ALL {
            let usual = EngineChoice::new(method, None).unwrap();
            assert_eq!(usual.lanes(), Some(LaneKind::best().into()));
            let reference = Renderer { method, engine: EngineName::Reference };
            assert_eq!(EngineChoice::new(reference, None).unwrap().lanes(), None);
            assert!(EngineChoice::new(reference, Some(LanesName::Auto)).is_err());
        }
    }

    #[test]
    fn a_profile_gives_parameters_and_lanes_but_those_asked_for_win() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("profile.toml");
        let parameters = Parameters::default().with("photons_per_job", 4096.0).unwrap();
        let profile = Profile { parameters, lanes: Some(LanesName::Emulated) };
        std::fs::write(&path, profile.to_text()).unwrap();
        let usual = EngineChoice::with_profile(MethodName::Sppm, None, &path).unwrap();
        assert_eq!((usual.parameters(), usual.lanes()), (&parameters, Some(LanesName::Emulated)));
        let asked = Some(LaneKind::best().into());
        let asked_for = EngineChoice::with_profile(MethodName::Sppm, asked, &path).unwrap();
        assert_eq!((asked_for.parameters(), asked_for.lanes()), (&parameters, asked));
        let reference = Renderer { method: MethodName::Sppm, engine: EngineName::Reference };
        assert!(EngineChoice::with_profile(reference, None, &path).is_err());
    }

    /// By each method that has photons: they take several rounds where there is no room for all of their deposits.
    #[test]
    fn a_render_holds_as_many_deposits_as_there_is_room_for() {
        let mut scene = files::builtin::scene("cornell").unwrap();
        (scene.settings.width, scene.settings.height) = (40, 30);
        scene.settings.photons_per_iteration = 600_000;
        let pool = crate::pool::pool(Some(1)).unwrap();
        for method in [MethodName::Sppm, MethodName::Hybrid] {
            let choice = EngineChoice::new(method, None).unwrap();
            let held = |deposits| {
                let mut started = choice.start(&scene, deposits, Parts::default(), None);
                let engine = started.engine();
                pool.install(|| engine.iterate());
                engine.stats().bytes
            };
            let (few, all) = (held(2000), held(1 << 20));
            // Room is made for tens of thousands of deposits at a time.
            assert!(few + 2_000_000 < all, "{method:?}: {few} and {all} bytes");
        }
    }

    #[test]
    fn lanes_that_the_processor_lacks_are_rejected() {
        for lanes in [LanesName::Emulated, LanesName::Avx2, LanesName::Avx512] {
            let chosen = EngineChoice::new(EngineName::Fast, Some(lanes));
            assert_eq!(chosen.is_ok(), lanes.kind().is_available(), "{lanes:?}");
        }
    }
}
