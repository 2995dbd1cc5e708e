//! The subcommands, one file each with their options and what they run.

pub(crate) mod compare;
mod completions;
mod conclusion;
mod export;
mod farm;
mod frames;
mod info;
mod instants;
mod ladder;
mod man;
mod merge;
pub(crate) mod render;
mod resume;
mod scenes;
mod trace;
mod tune;
pub(crate) mod verify;
mod view;
mod watch;

use crate::terminal::error::Error;
use crate::terminal::logs;
use clap::{CommandFactory, Parser, Subcommand};
use compare::CompareArgs;
use completions::CompletionsArgs;
use export::ExportArgs;
use farm::FarmArgs;
use info::InfoArgs;
use ladder::LadderArgs;
use man::ManArgs;
use merge::MergeArgs;
use render::RenderArgs;
use resume::ResumeArgs;
use scenes::ScenesArgs;
use trace::TraceArgs;
use tune::TuneArgs;
use verify::VerifyArgs;
use view::ViewArgs;

/// Render scenes of spheres with full global illumination, caustics and all
///
/// sppm renders by stochastic progressive photon mapping (Hachisuka and Jensen 2009). Every iteration sends one
/// ray per pixel from the eye and a batch of photons from the lights; photons that land near what a pixel sees add
/// to its radiance. As iterations go by the search radius of each pixel shrinks, and the image converges.
///
/// An image is a function of scene, settings and seed: the same on any machine, with any number of threads.
#[derive(Debug, Parser)]
#[command(name = "sppm", version, after_long_help = EXAMPLES)]
pub(crate) struct Args {
    #[command(subcommand)]
    pub command: Command,
}

const EXAMPLES: &str = "\
Examples:
  sppm render cornell                      cornell.png, with settings chosen from the scene
  sppm render cornell -o box.exr -n 64     linear radiance, 64 iterations
  sppm render water.pdb                    molecules and particles, from the files of their fields
  sppm scenes                              what can be rendered by name
  sppm scenes cornell > mine.toml          a scene file to start from
  sppm render mine.toml
  sppm view cornell                        render in the browser, and change the scene there
  sppm resume cornell.png.sppm             go on with a render that was interrupted
  sppm compare box.exr truth.exr --max-flip 0.05

Exit codes: 0 done; 1 failed while running, or the answer is no; 2 bad input; 130 ended by Ctrl-C,
143 by SIGTERM, 129 by SIGHUP.";

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    Render(RenderArgs),
    Resume(ResumeArgs),
    Merge(MergeArgs),
    Farm(FarmArgs),
    View(ViewArgs),
    Info(InfoArgs),
    Scenes(ScenesArgs),
    Compare(CompareArgs),
    Verify(VerifyArgs),
    Trace(TraceArgs),
    Export(ExportArgs),
    Ladder(LadderArgs),
    Tune(TuneArgs),
    Completions(CompletionsArgs),
    Man(ManArgs),
}

impl Args {
    /// Runs the command.
    pub(crate) fn run(&self) -> Result<(), Error> {
        match &self.command {
            Command::Render(args) => {
                // Before the range is read, so that what is wrong with it is told in the format that is asked for.
                logs::init(args.messages.log_format, args.messages.level());
                match args.source.particles.frames()? {
                    Some(range) => frames::run(args, range),
                    None => render::run(args),
                }
            }
            Command::Resume(args) => resume::run(args),
            Command::Merge(args) => merge::run(args),
            Command::Farm(args) => farm::run(args),
            Command::View(args) => view::run(args),
            Command::Info(args) => info::run(args),
            Command::Scenes(args) => scenes::run(args),
            Command::Compare(args) => compare::run(args),
            Command::Verify(args) => verify::run(args),
            Command::Trace(args) => trace::run(args),
            Command::Export(args) => export::run(args),
            Command::Ladder(args) => ladder::run(args),
            Command::Tune(args) => tune::run(args),
            Command::Completions(args) => completions::run(Self::command(), args),
            Command::Man(args) => man::run(Self::command(), args),
        }
    }
}
