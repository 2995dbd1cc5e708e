//! Options for method, engine and machine: lanes, profile, threads, memory. The image depends on the method alone.

use super::values::{bytes, whole};
use crate::terminal::error::Error;
use clap::{Args as ClapArgs, ValueEnum, ValueHint};
use render::{EngineChoice, EngineName, LanesName, MethodName, Renderer};
use std::path::PathBuf;

/// A larger number of threads is taken for a typing error.
const MAX_THREADS: u64 = 1024;

/// What the image does not depend on.
#[derive(Debug, ClapArgs)]
pub(crate) struct MachineArgs {
    /// Threads that work [default: one per core]; the image does not depend on it
    #[arg(long, value_name = "T", help_heading = "Machine", allow_hyphen_values = true)]
    #[arg(value_parser = whole::<usize>(1, MAX_THREADS))]
    pub threads: Option<usize>,
}

/// How `--engine` may be given.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Engine {
    /// On vectors: the reference's image, bit for bit
    Fast,
    /// In plain scalar code: the definition of the image
    Reference,
    /// The same as `--method path --engine fast`
    Path,
}

/// The method, the engine, and what else the image does not depend on.
#[derive(Debug, Default, ClapArgs)]
#[command(next_help_heading = "Machine")]
pub(crate) struct EngineArgs {
    /// How to render [default: sppm, or the method recorded in the resumed or repeated file; but `sppm render` chooses it with
    /// the quality, unless photons or a radius are given]
    #[arg(long, value_enum, help_heading = "Method")]
    pub method: Option<MethodName>,

    /// The code that renders; the image does not depend on it [default: fast, or the engine recorded in the resumed or
    /// repeated file]
    #[arg(long, value_enum)]
    pub engine: Option<Engine>,

    /// The vectors that the fast engine runs on; the image does not depend on it [default: auto]
    #[arg(long, value_enum, value_name = "LANES")]
    pub lanes: Option<LanesName>,

    /// Have the fast engine go by the free parameters of this profile, which `sppm tune` wrote; the image does not depend
    /// on them
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub profile: Option<PathBuf>,

    /// Threads that work [default: one per core]; the image does not depend on it
    #[arg(long, value_name = "T", allow_hyphen_values = true)]
    #[arg(value_parser = whole::<usize>(1, MAX_THREADS))]
    pub threads: Option<usize>,

    /// Refuse to render with more memory than this, such as 500M or 4G; photons are joined in smaller rounds if that
    /// helps
    #[arg(long, value_name = "SIZE", value_parser = bytes, allow_hyphen_values = true)]
    pub memory_limit: Option<u64>,
}

impl EngineArgs {
    /// The method and the engine given on the command line, else the `usual` ones.
    pub(crate) fn choose(&self, usual: Renderer) -> Result<EngineChoice, Error> {
        let method = self.method.unwrap_or(usual.method);
        let renderer = match self.engine {
            None => Renderer { method, ..usual },
            Some(Engine::Fast) => Renderer { method, engine: EngineName::Fast },
            Some(Engine::Reference) => Renderer { method, engine: EngineName::Reference },
            Some(Engine::Path) => self.by_path()?,
        };
        let chosen = match &self.profile {
            Some(profile) => EngineChoice::with_profile(renderer, self.lanes, profile)?,
            None => EngineChoice::new(renderer, self.lanes)?,
        };
        Ok(if self.method.is_none() && self.engine == Some(Engine::Path) {
            chosen.method_by_engine()
        } else {
            chosen
        })
    }

    /// Whether a method is given, by the old name of the path tracer too.
    pub(crate) fn states_method(&self) -> bool {
        self.method.is_some() || self.engine == Some(Engine::Path)
    }

    /// What `--engine path` means.
    fn by_path(&self) -> Result<Renderer, Error> {
        if let Some(other) = self.method.filter(|method| *method != MethodName::Path) {
            let problem = format!(
                "--engine path means --method path: --method {} is another; leave out one of the two",
                other.name()
            );
            return Err(Error::BadInput(problem));
        }
        Ok(MethodName::Path.into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chosen(method: Option<MethodName>, engine: Option<Engine>, usual: Renderer) -> Option<Renderer> {
        let args = EngineArgs { method, engine, ..EngineArgs::default() };
        args.choose(usual).ok().map(EngineChoice::renderer)
    }

    #[test]
    fn method_and_engine_are_two_options_and_the_old_name_of_the_path_tracer_is_both() {
        let (sppm, path) = (MethodName::Sppm, MethodName::Path);
        let by = |method, engine| Some(Renderer { method, engine });
        let usual = Renderer { method: path, engine: EngineName::Reference };
        assert_eq!(chosen(None, None, usual), Some(usual));
        assert_eq!(chosen(Some(sppm), None, usual), by(sppm, EngineName::Reference));
        assert_eq!(chosen(None, Some(Engine::Fast), usual), by(path, EngineName::Fast));
        assert_eq!(chosen(Some(sppm), Some(Engine::Fast), usual), by(sppm, EngineName::Fast));
        let usual = Renderer::default();
        assert_eq!(chosen(None, Some(Engine::Reference), usual), by(sppm, EngineName::Reference));
        assert_eq!(chosen(Some(path), None, usual), by(path, EngineName::Fast));
        assert_eq!(chosen(None, Some(Engine::Path), usual), by(path, EngineName::Fast));
        assert_eq!(chosen(Some(path), Some(Engine::Path), usual), by(path, EngineName::Fast));
        for other in [sppm, MethodName::Hybrid] {
            assert_eq!(chosen(Some(other), Some(Engine::Path), usual), None);
        }
    }

    /// Messages name the option that chose the method: the engine, if that is an old name of both.
    #[test]
    fn the_option_that_chose_the_method_is_known() {
        let by = |method, engine| {
            let args = EngineArgs { method, engine, ..EngineArgs::default() };
            format!("{:?}", args.choose(Renderer::default()).unwrap()).contains("method_field: Engine")
        };
        assert!(by(None, Some(Engine::Path)) && !by(Some(MethodName::Path), Some(Engine::Path)));
        assert!(!by(None, None) && !by(None, Some(Engine::Fast)) && !by(Some(MethodName::Path), None));
    }
}
