//! Options for the engine and the machine: lanes, profile, threads, memory. The image does not depend on the machine.

use super::values::{bytes, whole};
use clap::{Args as ClapArgs, ValueHint};
use render::{EngineChoice, EngineName, Error, LanesName};
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

/// The engine, and what the image does not depend on.
#[derive(Debug, Default, ClapArgs)]
#[command(next_help_heading = "Machine")]
pub(crate) struct EngineArgs {
    /// How to render [default: fast, or the engine recorded in the resumed or repeated file]
    #[arg(long, value_enum)]
    pub engine: Option<EngineName>,

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
    /// The engine given on the command line, else the `usual` one.
    pub(crate) fn choose(&self, usual: EngineName) -> Result<EngineChoice, Error> {
        let name = self.engine.unwrap_or(usual);
        match &self.profile {
            Some(profile) => EngineChoice::with_profile(name, self.lanes, profile),
            None => EngineChoice::new(name, self.lanes),
        }
    }
}
