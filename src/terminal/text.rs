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

/// A word as a shell reads it.
pub(crate) fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_./+,:=@%".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        word.into()
    } else {
        format!("'{}'", word.replace('\'', "'\\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_quoted_only_where_a_shell_needs_it() {
        for plain in ["part.sppm", "/a-b/c_d+1,2:3=4@5%6.sppm"] {
            assert_eq!(quoted(plain), plain);
        }
        for (word, text) in
            [("", "''"), ("a b", "'a b'"), ("$(x)", "'$(x)'"), ("it's", "'it'\\''s'"), ("\u{fc}", "'\u{fc}'")]
        {
            assert_eq!(quoted(word), text);
        }
    }
}
