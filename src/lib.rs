//! The command `sppm`: renders scenes of spheres by stochastic progressive photon mapping, compares images,
//! verifies that engines agree bit for bit, traces rays, and exports scenes to other renderers.
//!
//! This crate is thin. `commands` has one file per subcommand, `args` the options that they share, and `terminal`
//! handles signals, messages and progress. The crate `render` runs renders; the crate `files` reads and writes files.
//!
//! Exit codes: 0 done; 1 failed while running, an image out of bounds (`compare`) or engines that differ
//! (`verify`); 2 bad input; 130, 143 or 129 ended by SIGINT, SIGTERM or SIGHUP. Every error is one line on standard
//! error.

#![forbid(unsafe_code)]

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

mod args;
mod commands;
mod terminal;

use clap::Parser;
use commands::Args;
use std::ffi::OsString;
use std::process::ExitCode;
use terminal::{logs, signals, usage};

/// Runs the command with `arguments`, the first of which is the program's name, and returns its exit code.
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    signals::outlive_limits();
    let arguments: Vec<OsString> = arguments.into_iter().collect();
    let result = match Args::try_parse_from(&arguments) {
        Ok(args) => args.run(),
        Err(error) => {
            logs::init_for(&arguments);
            usage::answer(&error, &arguments)
        }
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            logs::fail(&error);
            error.exit_code()
        }
    }
}
