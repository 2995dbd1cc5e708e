//! How a command can end other than well.

use super::signals::{Signal, SignalError};
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
        ExitCode::from(self.code())
    }

    /// The same as a number.
    pub(crate) fn code(&self) -> u8 {
        match self {
            Self::BadInput(_) => 2,
            Self::Failed(_) => 1,
            Self::Interrupted(signal, _) => signal.exit_code(),
        }
    }
}

impl From<SignalError> for Error {
    fn from(error: SignalError) -> Self {
        Self::Failed(error.to_string())
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
