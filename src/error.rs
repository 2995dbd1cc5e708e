//! How a command can end other than well.

use crate::interrupt::Signal;
use std::fmt;
use std::process::ExitCode;

/// Why a command did not do what it was asked for. Each text is one sentence for one line.
#[derive(Debug)]
pub(crate) enum Error {
    /// The command was asked for something it cannot do; nothing was written.
    BadInput(String),
    /// The command failed while running, or its answer is no.
    Failed(String),
    /// A signal ended the command early.
    Interrupted(Signal, String),
}

impl Error {
    /// The exit code of a command that ends so.
    pub(crate) fn exit_code(&self) -> ExitCode {
        match self {
            Self::BadInput(_) => ExitCode::from(2),
            Self::Failed(_) => ExitCode::from(1),
            Self::Interrupted(signal, _) => ExitCode::from(signal.exit_code()),
        }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::BadInput(what) | Self::Failed(what) => write!(f, "error: {what}"),
            Self::Interrupted(_, what) => write!(f, "interrupted: {what}"),
        }
    }
}
