//! Text out: what goes to standard output and to standard error, and never panics there.

use super::error::Error;
use scene::text::one_line;
use std::fmt::Display;
use std::io::{self, ErrorKind, Write as _};

/// Writes `text` to standard output. A reader that has seen enough (`sppm scenes | head -1`) is no failure.
pub(crate) fn print(text: &[u8]) -> Result<(), Error> {
    let mut out = io::stdout().lock();
    match out.write_all(text).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Error::Failed(format!("cannot write to standard output: {error}")))
        }
        _ => Ok(()),
    }
}

/// Writes `message` as one line to standard error; there is nowhere to tell if that fails.
pub(crate) fn complain(message: &impl Display) {
    let _ = writeln!(io::stderr(), "{}", one_line(&message.to_string()));
}
