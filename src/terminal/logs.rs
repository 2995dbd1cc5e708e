//! Messages on standard error by way of `tracing`: plain lines for people, or JSON for machines.

use super::error::Error;
use super::text::complain;
use clap::ValueEnum;
use indicatif::ProgressBar;
use scene::text::one_line;
use std::ffi::{OsStr, OsString};
use std::fmt;
use std::io::{self, Write};
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};
pub(crate) use tracing::Level;
use tracing::{Event, Subscriber};
use tracing_subscriber::fmt::format::{Writer, debug_fn};
use tracing_subscriber::fmt::{FmtContext, FormatEvent, FormatFields};
use tracing_subscriber::registry::LookupSpan;

/// How messages are written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum Format {
    /// A line each, for people
    #[default]
    Text,
    /// A JSON object each, with time, level, message and figures
    Json,
}

static CHOSEN: OnceLock<(Format, Level)> = OnceLock::new();
/// The progress bar at the bottom of the terminal; it is hidden while a message is printed.
static BAR: Mutex<Option<ProgressBar>> = Mutex::new(None);

/// Installs the subscriber that writes messages of `level` and above.
pub(crate) fn init(format: Format, level: Level) {
    let (format, level) = *CHOSEN.get_or_init(|| (format, level));
    let builder = tracing_subscriber::fmt().with_max_level(level).with_writer(|| Screen);
    // Only the first call in a process has an effect; a process runs one command.
    let _ = match format {
        Format::Json => tracing::subscriber::set_global_default(
            builder.json().flatten_event(true).with_target(false).finish(),
        ),
        Format::Text => {
            let message = debug_fn(|out, field, value| match field.name() {
                "message" => write!(out, "{value:?}"),
                _ => Ok(()),
            });
            tracing::subscriber::set_global_default(builder.fmt_fields(message).event_format(Lines).finish())
        }
    };
}

/// Installs the subscriber for arguments that could not be parsed, if they ask for JSON.
pub(crate) fn init_for(arguments: &[OsString]) {
    let option = OsStr::new("--log-format");
    let asks = arguments.iter().any(|argument| argument == "--log-format=json")
        || arguments.windows(2).any(|pair| pair[0] == option && pair[1] == "json");
    if asks {
        init(Format::Json, Level::INFO);
    }
}

/// Whether progress may be drawn on standard error: messages are for people, and not only of failures.
pub(crate) fn has_bars() -> bool {
    CHOSEN.get().is_none_or(|(format, level)| *format == Format::Text && *level >= Level::INFO)
}

/// Tells people `message` in any case, also those who asked for none but failures. Of lines of JSON the level decides.
pub(crate) fn say(level: Level, message: &str) {
    match CHOSEN.get() {
        Some((Format::Json, _)) => match level {
            Level::ERROR => tracing::error!("{message}"),
            Level::WARN => tracing::warn!("{message}"),
            _ => tracing::info!("{message}"),
        },
        _ if level == Level::ERROR => complain(&format!("error: {message}")),
        _ => complain(&message),
    }
}

/// Reports that the command failed.
pub(crate) fn fail(error: &Error) {
    match CHOSEN.get() {
        Some((Format::Json, _)) => {
            let (exit_code, signal) = (error.code(), error.signal());
            tracing::error!(exit_code, signal, "{error}");
        }
        _ => complain(&format!("{}: {error}", error.label())),
    }
}

/// Makes messages appear above `bar` from now on.
pub(crate) fn make_room(bar: Option<ProgressBar>) {
    *lock() = bar;
}

fn lock() -> MutexGuard<'static, Option<ProgressBar>> {
    BAR.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Standard error, above the progress bar.
struct Screen;

impl Write for Screen {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let write = || io::stderr().write_all(bytes);
        let bar = lock().clone();
        // A failure is ignored, as there is nowhere to report it.
        let _ = bar.map_or_else(write, |bar| bar.suspend(write));
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Formats messages for people: the text alone, labelled if it is a warning or an error.
struct Lines;

impl<S: Subscriber + for<'a> LookupSpan<'a>, N: for<'a> FormatFields<'a> + 'static> FormatEvent<S, N>
    for Lines
{
    fn format_event(
        &self,
        ctx: &FmtContext<'_, S, N>,
        mut out: Writer<'_>,
        event: &Event<'_>,
    ) -> fmt::Result {
        let mut text = String::new();
        ctx.field_format().format_fields(Writer::new(&mut text), event)?;
        writeln!(out, "{}{}", label(*event.metadata().level()), one_line(&text))
    }
}

/// What precedes a message of this level.
fn label(level: Level) -> &'static str {
    match level {
        Level::ERROR => "error: ",
        Level::WARN => "warning: ",
        _ => "",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn warnings_and_errors_have_a_label() {
        let labels = [Level::ERROR, Level::WARN, Level::INFO, Level::DEBUG].map(label);
        assert_eq!(labels, ["error: ", "warning: ", "", ""]);
    }
}
