//! The options of `tune`.

use crate::args::engine::MachineArgs;
use crate::args::scene::SceneArg;
use crate::args::settings::SettingsArgs;
use crate::args::values::{time, whole};
use clap::{Args, ValueHint};
use render::LanesName;
use std::path::PathBuf;
use std::time::Duration;

/// Search for the free parameters by which the fast engine renders a scene soonest
///
/// Sizes of cells, tables, batches and jobs, how balls are searched, and the lanes: the image does not depend on them,
/// only the time does. Bayesian optimisation proposes values (a Gaussian process with a Matern kernel and white noise,
/// an acquisition hedged among lower confidence bound, expected improvement and probability of improvement), and each
/// proposal is measured in turns with the defaults, on this machine. At the end the best is measured anew. If it
/// gains, the profile holds it, else the defaults; `sppm render SCENE --profile FILE` goes by it.
///
/// The optimiser is scikit-optimize, in Python. In a checkout it is installed by itself, once; elsewhere it must be
/// there (pip install scikit-optimize). Close other programs: what is measured is time.
///
/// Ctrl-C ends the search and keeps the best so far; the profile says that it was not measured anew.
#[derive(Debug, Args)]
#[command(after_long_help = EXAMPLES)]
pub(crate) struct TuneArgs {
    #[command(flatten)]
    pub scene: SceneArg,

    /// The profile to write [default: the scene's name, .profile.toml]
    #[arg(short, long, value_name = "PROFILE.toml", help_heading = "Output")]
    pub output: Option<PathBuf>,

    /// Draw how the search went
    #[arg(long, value_name = "FILE.svg", help_heading = "Output")]
    pub plot: Option<PathBuf>,

    /// Write all that was tried, with its ratio, as a table of comma-separated values
    #[arg(long, value_name = "FILE.csv", help_heading = "Output")]
    pub csv: Option<PathBuf>,

    /// Points to try, the defaults among them [default: 40; with --quick, 12]
    #[arg(long, value_name = "N", value_parser = whole::<u32>(2, 10_000), allow_hyphen_values = true)]
    #[arg(help_heading = "Search")]
    pub evaluations: Option<u32>,

    /// End the search after so much time, such as 90s or 10m
    #[arg(long, value_name = "T", value_parser = time, allow_hyphen_values = true, help_heading = "Search")]
    pub time: Option<Duration>,

    /// Pairs of renders, by the defaults and by the point, whose median ratio counts [default: 3; with --quick, 1]
    #[arg(long, value_name = "N", value_parser = whole::<u32>(1, 1000), allow_hyphen_values = true)]
    #[arg(help_heading = "Search")]
    pub pairs: Option<u32>,

    /// Pairs by which the best is measured anew [default: 25; with --quick, 7]
    #[arg(long, value_name = "N", value_parser = whole::<u32>(6, 1000), allow_hyphen_values = true)]
    #[arg(help_heading = "Search")]
    pub final_pairs: Option<u32>,

    /// Seed of the search
    #[arg(long, value_name = "S", value_parser = whole::<u32>(0, u32::MAX.into()), default_value = "1")]
    #[arg(allow_hyphen_values = true, help_heading = "Search")]
    pub search_seed: u32,

    /// Small images and few photons: to see that it works, not for what is best
    #[arg(long, help_heading = "Search")]
    pub quick: bool,

    /// Tune on these lanes alone [default: all but emulated ones are tried]
    #[arg(long, value_enum, value_name = "LANES", help_heading = "Machine")]
    pub lanes: Option<LanesName>,

    /// The Python that has scikit-optimize [default: the checkout's own, else python3]
    #[arg(long, value_name = "PYTHON", value_hint = ValueHint::ExecutablePath, help_heading = "Machine")]
    pub python: Option<PathBuf>,

    #[command(flatten)]
    pub machine: MachineArgs,

    #[command(flatten)]
    pub settings: SettingsArgs,
}

const EXAMPLES: &str = "\
Examples:
  sppm tune cornell && sppm render cornell --profile cornell.profile.toml
  sppm tune random --threads 1 --evaluations 100 --plot search.svg --csv tried.csv
  sppm verify cornell --width 64 --height 48 --profile cornell.profile.toml";
