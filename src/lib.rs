//! The command `sppm`: renders scenes of spheres by stochastic progressive photon mapping, compares images,
//! verifies that engines agree bit for bit, traces rays, and exports scenes to other renderers.
//!
//! The command is thin. Scenes and image files are the business of the `scene` crate, light transport that of the
//! engines; here options become settings, and what an engine computes becomes files and lines of text.
//!
//! Exit codes: 0 done; 1 failed while running, an image out of bounds (`compare`) or engines that differ
//! (`verify`); 2 bad input; 130, 143 or 129 ended by SIGINT, SIGTERM or SIGHUP. Whatever goes wrong is told in one line on standard error.

#![forbid(unsafe_code)]

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

mod args;
mod budget;
mod checkpoints;
mod commands;
mod documents;
mod engines;
mod error;
mod export;
mod info;
mod interrupt;
mod job;
mod like;
mod logs;
mod memory;
mod metadata;
mod outputs;
mod profile;
mod progress;
mod render;
mod report;
mod resume;
mod scenes;
mod session;
mod text;
mod threads;
mod trace;
mod tune_command;
mod usage;
mod values;

use args::{Args, Command};
use clap::Parser;
use error::Error;
use std::ffi::OsString;
use std::process::ExitCode;

/// Runs the command with `arguments`, of which the first is the program's name, and returns how it ended.
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    interrupt::outlive_limits();
    let arguments: Vec<OsString> = arguments.into_iter().collect();
    let result = match Args::try_parse_from(&arguments) {
        Ok(args) => process(&args),
        Err(error) => usage::answer(&error, &arguments),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            logs::fail(&error);
            error.exit_code()
        }
    }
}

fn process(args: &Args) -> Result<(), Error> {
    match &args.command {
        Command::Render(args) => render::render(args),
        Command::Resume(args) => resume::resume(args),
        Command::Info(args) => info::info(args),
        Command::Scenes(args) => scenes::show(args),
        Command::Compare(args) => commands::compare::run(args),
        Command::Verify(args) => commands::verify::run(args),
        Command::Trace(args) => trace::trace(args),
        Command::Export(args) => export::run(args),
        Command::Ladder(args) => commands::ladder::run(args),
        Command::Tune(args) => tune_command::run(args),
        Command::Completions(args) => documents::completions(args),
        Command::Man(args) => documents::man(args),
    }
}
