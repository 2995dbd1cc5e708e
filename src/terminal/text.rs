//! Writes text to standard output and standard error without panicking when that fails.

use super::error::Error;
use files::atomic_file::reason;
use scene::text::one_line;
use std::fmt::Display;
use std::io::{self, ErrorKind, Write as _};

/// Writes `text` to standard output. A pipe closed by its reader (`sppm scenes | head -1`) is not an error.
pub(crate) fn print(text: &[u8]) -> Result<(), Error> {
    let mut out = io::stdout().lock();
    match out.write_all(text).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Error::Failed(format!("cannot write to standard output: {}", reason(&error))))
        }
        _ => Ok(()),
    }
}

/// Writes `message` as one line to standard error. A failed write is ignored, as there is nowhere to report it.
pub(crate) fn complain(message: &impl Display) {
    let _ = writeln!(io::stderr(), "{}", one_line(&message.to_string()));
}
