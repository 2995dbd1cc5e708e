//! The command `farm`: hands on to the Python package, where the farm is.

use crate::terminal::error::Error;
use crate::terminal::logs;
use clap::Args as ClapArgs;
use std::ffi::OsString;
use std::io::{self, ErrorKind};
use std::process::{Command, Stdio};

/// The variable that names the Python to run.
const PYTHON: &str = "SPPM_PYTHON";
/// Succeeds if the farm can be imported.
const PROBE: &str = "import sppm.farm, distributed";

/// Render on many machines, by Dask distributed
///
/// The farm is in the Python package `sppm`, with its dependencies for farms: `pip install "./python[farm]"` in the
/// repository. `SPPM_PYTHON` names the Python that has it, if it is not `python3`. All words that follow are handed on to
/// `python3 -m sppm.farm`, whose --help shows them all. docs/farm.md has more.
#[derive(Debug, ClapArgs)]
#[command(after_long_help = FARM_EXAMPLES)]
pub(crate) struct FarmArgs {
    /// Scenes and options of the farm
    #[arg(value_name = "WORDS", trailing_var_arg = true, allow_hyphen_values = true)]
    pub words: Vec<OsString>,
}

const FARM_EXAMPLES: &str = "\
Examples:
  sppm farm cornell -n 4096 -o cornell.exr                       one worker per core of this machine
  sppm farm cornell -n 4096 -o cornell.exr --workers 2
  sppm farm cornell -n 4096 -o cornell.exr --scheduler tcp://head:8786
  sppm farm scenes/ -n 64 -o images/                             all scene files of a folder
  sppm farm cornell --sweep radius=0.5,1,2 -o sweep/
  sppm farm cornell -n 4096 -o cornell.exr --view                watch it in the browser

Begun again, it goes on from where it was.";

/// Runs the command.
pub(crate) fn run(args: &FarmArgs) -> Result<(), Error> {
    // The words are the farm's, this one among them.
    logs::init_for(&args.words);
    let python = std::env::var_os(PYTHON).unwrap_or_else(|| "python3".into());
    let named = python.to_string_lossy().into_owned();
    let probe = Command::new(&python).args(["-c", PROBE]).stdin(Stdio::null()).stderr(Stdio::null()).status();
    match probe {
        Ok(status) if status.success() => {}
        Ok(_) => {
            let problem = format!(
                "farm: {named} lacks the package sppm or Dask; install both by `pip install \"./python[farm]\"` in the \
                 repository, or name a Python that has them by {PYTHON}"
            );
            return Err(Error::BadInput(problem));
        }
        Err(error) => {
            return Err(unrunnable(&named, &error));
        }
    }
    hand_on(Command::new(&python).args(["-m", "sppm.farm"]).args(&args.words), &named)
}

fn unrunnable(named: &str, error: &io::Error) -> Error {
    let why = if error.kind() == ErrorKind::NotFound { "there is none".into() } else { error.to_string() };
    Error::BadInput(format!(
        "farm: {named} cannot be run: {why}; install Python 3.10 or later, or name one by {PYTHON}"
    ))
}

/// Becomes the farm, so that signals reach it.
#[cfg(unix)]
fn hand_on(command: &mut Command, named: &str) -> Result<(), Error> {
    use std::os::unix::process::CommandExt;
    let error = command.exec();
    Err(Error::Failed(format!("farm: {named} cannot be run: {error}")))
}

/// Runs the farm, and ends with its exit code.
#[cfg(not(unix))]
fn hand_on(command: &mut Command, named: &str) -> Result<(), Error> {
    let ended = command.status();
    let status = ended.map_err(|error| Error::Failed(format!("farm: {named} cannot be run: {error}")))?;
    std::process::exit(status.code().unwrap_or(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_told_why_there_is_no_python() {
        let said = |kind: ErrorKind| unrunnable("py", &kind.into()).to_string();
        assert!(
            said(ErrorKind::NotFound).starts_with("farm: py cannot be run: there is none; install Python")
        );
        assert!(said(ErrorKind::PermissionDenied).starts_with("farm: py cannot be run: permission denied; "));
    }
}
