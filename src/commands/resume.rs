//! The command `resume`: continues a render from its checkpoint.

use super::watch;
use crate::args::engine::EngineArgs;
use crate::args::goals::GoalArgs;
use crate::args::messages::MessageArgs;
use crate::args::outputs::{OutputArgs, default_name_of};
use crate::args::values::{every, whole};
use crate::args::view::WatchArgs;
use crate::terminal::busy::Busy;
use crate::terminal::error::Error;
use crate::terminal::logs;
use crate::terminal::signals::Requests;
use clap::{Args as ClapArgs, ValueHint};
use render::{Every, Field, Job};
use scene::settings::MAX_ITERATIONS;
use scene::text::one_line;
use std::mem::take;
use std::path::PathBuf;

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
    pub outputs: OutputArgs,

    #[command(flatten)]
    pub goals: GoalArgs,

    /// How often to save: a time, such as 30s or 5m, or a number of iterations [default: as before]
    #[arg(long, value_name = "T|N", value_parser = every, help_heading = "Checkpoints", allow_hyphen_values = true)]
    pub every: Option<Every>,

    #[command(flatten)]
    pub engine: EngineArgs,

    /// Serve a page that shows the image as it converges, and print its address
    #[arg(long, help_heading = "Viewers")]
    pub view: bool,

    #[command(flatten)]
    pub viewers: WatchArgs,

    #[command(flatten)]
    pub messages: MessageArgs,
}

const RESUME_EXAMPLES: &str = "\
Examples:
  sppm resume cornell.png.sppm
  sppm resume cornell.png.sppm --iterations 1000 -o more.exr
  sppm resume cornell.png.sppm --time 1h --engine reference";

/// Runs the command.
pub(crate) fn run(args: &ResumeArgs) -> Result<(), Error> {
    logs::init(args.messages.log_format, args.messages.level());
    let busy = Busy::with(format!("reading {}", one_line(&args.file.to_string_lossy())));
    let mut job = Job::resume(&args.file)?;
    drop(busy);
    job.goals = args.goals.or(job.goals);
    job.scene.settings.iterations = iterations(args, job.scene.settings.iterations, job.resumed_after());
    job.engine = args.engine.choose(job.engine.renderer())?;
    job.inputs.extend(args.engine.profile.clone().map(|path| (Field::Profile, path)));
    if let (Some(every), Some(save)) = (args.every, &mut job.save) {
        save.every = every;
    }
    let image = args.file.with_file_name(default_name_of(&job.scene.name));
    // A part of a render is no image, unless one is asked for.
    let has_image = job.range.is_none() || job.outputs.image.is_some() || args.outputs.output.is_some();
    job.outputs = args.outputs.or(take(&mut job.outputs), image)?;
    if !has_image {
        job.outputs.image = None;
    }
    (job.threads, job.memory_limit) = (args.engine.threads, args.engine.memory_limit);
    watch::run(job, None, &args.messages, (&args.viewers, args.view), &Requests::listen()?)
}

/// The total number of iterations asked for by this run, of a render of `usual` ones of which so many are `done`.
fn iterations(args: &ResumeArgs, usual: u32, done: Option<u32>) -> u32 {
    let is_done = done.is_some_and(|done| done >= usual);
    let is_open = args.goals.time.is_some() || args.goals.until_error.is_some();
    // A finished render that is given a new time or error goal needs more iterations to reach it.
    args.iterations.unwrap_or(if is_done && is_open { MAX_ITERATIONS } else { usual })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_finished_render_goes_on_to_a_new_goal() {
        use crate::commands::{Args, Command};
        use clap::Parser as _;
        let of = |words: &[&str], done| {
            let args = Args::try_parse_from(["sppm", "resume", "a.sppm"].iter().chain(words)).unwrap();
            let Command::Resume(args) = args.command else { panic!("another command") };
            iterations(&args, 8, done)
        };
        for goal in [&["--time", "3s"][..], &["--until-error", "0.1"]] {
            let found = [None, Some(0), Some(7), Some(8), Some(9)].map(|done| of(goal, done));
            assert_eq!(found, [8, 8, 8, MAX_ITERATIONS, MAX_ITERATIONS], "{goal:?}");
            assert_eq!(of(&[goal, &["--iterations", "20"]].concat(), Some(8)), 20);
        }
        assert_eq!([of(&[], Some(3)), of(&[], Some(8)), of(&["--iterations", "20"], Some(3))], [8, 8, 20]);
    }
}
