//! The ways in which a command can fail, with their exit codes.

use super::signals::{Signal, SignalError};
use std::fmt;
use std::process::ExitCode;

/// Why a command failed. Each text is one sentence and fits on one line.
#[derive(Debug)]
pub(crate) enum Error {
    /// The request is invalid. Nothing was written.
    BadInput(String),
    /// The command failed while running, or its verdict is negative (`compare`, `verify`).
    Failed(String),
    /// A signal ended the command early.
    Interrupted(Signal, String),
}

impl Error {
    /// The exit code of a command that ends with this error.
    pub(crate) fn exit_code(&self) -> ExitCode {
        ExitCode::from(self.code())
    }

    /// What precedes the sentence where it is printed for people.
    pub(crate) fn label(&self) -> &'static str {
        match self {
            Self::BadInput(_) | Self::Failed(_) => "error",
            Self::Interrupted(..) => "interrupted",
        }
    }

    /// The name of the signal that ended the command, if one did.
    pub(crate) fn signal(&self) -> Option<&'static str> {
        match self {
            Self::Interrupted(signal, _) => Some(signal.name()),
            Self::BadInput(_) | Self::Failed(_) => None,
        }
    }

    /// The exit code as a number.
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

/// The sentence without its label.
impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (Self::BadInput(what) | Self::Failed(what) | Self::Interrupted(_, what)) = self;
        f.write_str(what)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scripts_can_tell_why_a_command_ended() {
        for (error, code, label) in
            [(Error::BadInput("a".into()), 2, "error"), (Error::Failed("a".into()), 1, "error")]
        {
            assert_eq!((error.code(), error.label(), error.signal()), (code, label, None));
            assert_eq!(error.to_string(), "a");
        }
    }
}
