//! Options for messages and progress.

use crate::terminal::bar::Progress;
use crate::terminal::logs::{Format, Level};
use clap::Args as ClapArgs;

/// What is told on the way.
#[derive(Debug, Default, ClapArgs)]
#[command(next_help_heading = "Messages")]
pub(crate) struct MessageArgs {
    /// Say nothing unless something goes wrong
    #[arg(short, long, conflicts_with = "verbose")]
    pub quiet: bool,

    /// Also tell settings, memory and the seconds of each pass
    #[arg(short, long)]
    pub verbose: bool,

    /// How to show progress: a bar on standard error if that is a terminal, or a JSON object per iteration, each on a
    /// line of standard output
    #[arg(long, value_enum, default_value = "bar")]
    pub progress: Progress,

    /// How messages on standard error are written: for people, or as a JSON object per line
    #[arg(long, value_enum, value_name = "FORMAT", default_value = "text")]
    pub log_format: Format,
}

impl MessageArgs {
    /// Which messages are written.
    pub(crate) fn level(&self) -> Level {
        match (self.quiet, self.verbose) {
            (true, _) => Level::WARN,
            (_, true) => Level::DEBUG,
            _ => Level::INFO,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::args::of_render;

    #[test]
    fn more_or_less_is_told() {
        let level = |words: &[&str]| of_render(&[&["cornell"], words].concat()).messages.level();
        assert_eq!([level(&[]), level(&["-q"]), level(&["-v"])], [Level::INFO, Level::WARN, Level::DEBUG]);
    }
}
