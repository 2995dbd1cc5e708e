//! Options of renders that last: goals, checkpoints, machine and messages.

use crate::checkpoints::Every;
use crate::engines::{EngineName, LanesName};
use crate::logs::Format;
use crate::progress::Shown;
use crate::threads::MAX_THREADS;
use crate::values::{bytes, every, positive, time, whole};
use clap::{Args as ClapArgs, ValueHint};
use scene::settings::MAX_ITERATIONS;
use std::path::PathBuf;
use std::time::Duration;

/// When a render ends, beside its iterations.
#[derive(Debug, Default, ClapArgs)]
#[command(next_help_heading = "Goals (the render ends with the first that is reached)")]
pub(crate) struct GoalArgs {
    /// End after so much time, such as 90s, 10m or 2h; iterations are then as many as it takes, unless -n says more
    ///
    /// The first iteration is always finished; the one in progress when time is up is abandoned.
    #[arg(long, value_name = "T", value_parser = time, allow_hyphen_values = true)]
    pub time: Option<Duration>,

    /// End once the estimated relative error is at most E, such as 0.05
    ///
    /// The estimate is the root of the relative mean-square error that `sppm compare` would give against the
    /// converged image, so far as it is noise: from how much the image changed since an earlier iteration.
    #[arg(long, value_name = "E", value_parser = positive, allow_hyphen_values = true)]
    pub until_error: Option<f64>,
}

/// What is kept of a render on its way.
#[derive(Debug, Default, ClapArgs)]
#[command(next_help_heading = "Checkpoints")]
pub(crate) struct CheckpointArgs {
    /// Save the render to FILE as it goes, and keep the last state [default: OUT.sppm, which goes when all is done]
    ///
    /// `sppm resume FILE` goes on from there, and so does the same `sppm render`. The generation before is in FILE.1.
    #[arg(long, value_name = "FILE", conflicts_with = "no_checkpoint", value_hint = ValueHint::FilePath)]
    pub checkpoint: Option<PathBuf>,

    /// How often to save, and to refresh the image: a time, such as 30s or 5m, or a number of iterations [default: 60s]
    #[arg(long, value_name = "T|N", value_parser = every, conflicts_with = "no_checkpoint", allow_hyphen_values = true)]
    pub every: Option<Every>,

    /// Save nothing
    #[arg(long)]
    pub no_checkpoint: bool,
}

/// The engine, and what the image does not depend on.
#[derive(Debug, Default, ClapArgs)]
#[command(next_help_heading = "Machine")]
pub(crate) struct EngineArgs {
    /// How to render [default: fast, or what rendered the file that is gone on from or repeated]
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

/// What is told on the way.
#[derive(Debug, Default, ClapArgs)]
#[command(next_help_heading = "Messages")]
pub(crate) struct MessageArgs {
    /// Say nothing unless something goes wrong
    #[arg(short, long, conflicts_with = "verbose")]
    pub quiet: bool,

    /// Also tell settings, memory and the seconds of each pass
    #[arg(short, long)]
    pub verbose: bool,

    /// How to show progress: a bar on standard error if that is a terminal, or a JSON object per iteration, each on a
    /// line of standard output
    #[arg(long, value_enum, default_value = "bar")]
    pub progress: Shown,

    /// How messages on standard error are written: for people, or as a JSON object per line
    #[arg(long, value_enum, value_name = "FORMAT", default_value = "text")]
    pub log_format: Format,
}

/// Go on with a render that was interrupted, or add iterations to one that is done
///
/// FILE is a checkpoint. Image, settings and outputs are those of the render that wrote it, and so are all bits of the
/// image, whatever the engine, the lanes and the threads. Where FILE is damaged, the generation before, FILE.1, is
/// gone on from.
#[derive(Debug, ClapArgs)]
#[command(after_long_help = RESUME_EXAMPLES)]
pub(crate) struct ResumeArgs {
    /// The checkpoint
    #[arg(value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub file: PathBuf,

    /// Iterations in all, those already done among them [default: as the render was asked for]
    #[arg(short = 'n', long, value_name = "N", allow_hyphen_values = true)]
    #[arg(value_parser = whole::<u32>(1, MAX_ITERATIONS.into()))]
    pub iterations: Option<u32>,

    #[command(flatten)]
    pub outputs: super::OutputArgs,

    #[command(flatten)]
    pub goals: GoalArgs,

    /// How often to save: a time, such as 30s or 5m, or a number of iterations [default: as before]
    #[arg(long, value_name = "T|N", value_parser = every, help_heading = "Checkpoints", allow_hyphen_values = true)]
    pub every: Option<Every>,

    #[command(flatten)]
    pub engine: EngineArgs,

    #[command(flatten)]
    pub messages: MessageArgs,
}

const RESUME_EXAMPLES: &str = "\
Examples:
  sppm resume cornell.png.sppm
  sppm resume cornell.png.sppm --iterations 1000 -o more.exr
  sppm resume cornell.png.sppm --time 1h --engine reference";

/// Tell what made an image, or what a checkpoint holds
///
/// Prints version, scene, settings, engine and iterations as they are written into .png and .exr images and into
/// checkpoints.
#[derive(Debug, ClapArgs)]
#[command(
    after_long_help = "Examples:\n  sppm info cornell.png\n  sppm info cornell.png --scene > again.toml"
)]
pub(crate) struct InfoArgs {
    /// An image by sppm, .png or .exr, or a checkpoint
    #[arg(value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub file: PathBuf,

    /// Print one JSON object
    #[arg(long, conflicts_with = "scene")]
    pub json: bool,

    /// Print the scene file, with the settings of the render
    #[arg(long)]
    pub scene: bool,
}
