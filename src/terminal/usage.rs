//! Turns clap's errors into one line each: what is wrong with the command line, and what would be right.

use super::error::Error;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use files::atomic_file::reason;
use scene::text::list;
use std::error::Error as _;
use std::ffi::OsString;
use std::io::{self, Write as _};

/// Prints help or version if `error` stands for a request of these; else returns one line on what is wrong with
/// `arguments`.
pub(crate) fn answer(error: &clap::Error, arguments: &[OsString]) -> Result<(), Error> {
    match error.kind() {
        ErrorKind::DisplayHelp | ErrorKind::DisplayVersion => {
            // Clap knows whether the terminal wants colours.
            match error.print().and_then(|()| io::stdout().flush()) {
                Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
                    Err(Error::Failed(format!("cannot write to standard output: {}", reason(&error))))
                }
                _ => Ok(()), // A closed pipe is not an error.
            }
        }
        kind => Err(Error::BadInput(Wrong { error, arguments }.describe(kind))),
    }
}

struct Wrong<'a> {
    error: &'a clap::Error,
    arguments: &'a [OsString],
}

impl Wrong<'_> {
    fn describe(&self, kind: ErrorKind) -> String {
        let argument = self.argument();
        match kind {
            ErrorKind::ValueValidation => {
                let reason = self.error.source().map(ToString::to_string).unwrap_or_default();
                format!("{argument}: {:?} {reason}", self.value())
            }
            ErrorKind::InvalidValue if self.value().is_empty() => {
                format!("{argument}: the value is missing{}", self.choices())
            }
            ErrorKind::InvalidValue => {
                format!("{argument}: {:?} is no choice{}", self.value(), self.choices())
            }
            ErrorKind::UnknownArgument if argument.starts_with('-') && argument != "-" => {
                format!("there is no option {argument}; {}", self.hint(ContextKind::SuggestedArg))
            }
            ErrorKind::UnknownArgument => {
                format!("{argument:?} is one argument too many; {}", self.see_help())
            }
            ErrorKind::InvalidSubcommand => {
                let name = self.strings(ContextKind::InvalidSubcommand).concat();
                format!("there is no command {name:?}; {}", self.hint(ContextKind::SuggestedSubcommand))
            }
            ErrorKind::MissingSubcommand | ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
                "a command is missing; try `sppm render cornell`, or `sppm --help`".into()
            }
            ErrorKind::MissingRequiredArgument => {
                let are = if self.strings(ContextKind::InvalidArg).len() > 1 { "are" } else { "is" };
                format!("{argument} {are} missing; {}", self.see_help())
            }
            ErrorKind::ArgumentConflict => self.conflict(&argument),
            ErrorKind::InvalidUtf8 => self.not_unicode(),
            _ => self.as_clap_says(),
        }
    }

    /// The argument at fault, without its value names.
    fn argument(&self) -> String {
        let names: Vec<String> = self.strings(ContextKind::InvalidArg).iter().map(|s| bare(s)).collect();
        list(&names)
    }

    fn value(&self) -> String {
        self.strings(ContextKind::InvalidValue).concat()
    }

    /// The list of allowed values, if the argument has one.
    fn choices(&self) -> String {
        let values: Vec<String> =
            self.strings(ContextKind::ValidValue).into_iter().filter(|v| !v.is_empty()).collect();
        if values.is_empty() { String::new() } else { format!("; there are {}", list(&values)) }
    }

    fn conflict(&self, argument: &str) -> String {
        let others: Vec<String> = self.strings(ContextKind::PriorArg).iter().map(|s| bare(s)).collect();
        if others.is_empty() || others == [argument] {
            format!("{argument} is given twice; once is enough")
        } else {
            format!("{argument} contradicts {}; give one of them", list(&others))
        }
    }

    fn not_unicode(&self) -> String {
        match self.arguments.iter().find(|a| a.to_str().is_none()) {
            Some(argument) => {
                format!("{} is not valid UTF-8, which only file names need not be", argument.display())
            }
            None => self.as_clap_says(),
        }
    }

    /// Suggests the nearest valid spelling, or else the help.
    fn hint(&self, kind: ContextKind) -> String {
        match self.strings(kind).as_slice() {
            [] => self.see_help(),
            near => format!("did you mean {}?", near.join(" or ")),
        }
    }

    fn see_help(&self) -> String {
        // The usage line names the command: "Usage: sppm render [OPTIONS] <SCENE>".
        let usage = self.strings(ContextKind::Usage).concat();
        let is_name = |word: &&str| word.starts_with(|c: char| c.is_ascii_lowercase());
        let command: Vec<&str> = usage.split_whitespace().skip(1).take_while(is_name).collect();
        if command.is_empty() {
            "see `sppm --help`".into()
        } else {
            format!("see `{} --help`", command.join(" "))
        }
    }

    fn as_clap_says(&self) -> String {
        let text = self.error.to_string();
        let first = text.lines().next().unwrap_or_default();
        first.trim_start_matches("error: ").into()
    }

    fn strings(&self, kind: ContextKind) -> Vec<String> {
        match self.error.get(kind) {
            Some(ContextValue::String(s)) => vec![s.clone()],
            Some(ContextValue::Strings(all)) => all.clone(),
            Some(ContextValue::StyledStr(s)) => vec![s.to_string()],
            _ => Vec::new(),
        }
    }
}

/// `--width` of `--width <W>`, `<SCENE>` of `<SCENE>`.
fn bare(argument: &str) -> String {
    argument.split_once([' ', '=']).map_or(argument, |(name, _)| name).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(arguments: &[&str]) -> String {
        use clap::Parser as _;
        let arguments: Vec<OsString> = ["sppm"].iter().chain(arguments).map(Into::into).collect();
        let error = crate::commands::Args::try_parse_from(&arguments).unwrap_err();
        answer(&error, &arguments).unwrap_err().to_string()
    }

    #[test]
    fn arguments_are_named_without_their_values() {
        let names = ["--width <W>", "--width=<W>", "<SCENE>", "-n"].map(bare);
        assert_eq!(names, ["--width", "--width", "<SCENE>", "-n"]);
    }

    /// What is wrong, then what would be right.
    #[test]
    fn each_fault_of_a_command_line_has_its_sentence() {
        for (arguments, text) in [
            (
                &["render", "cornell", "--seed", "x"][..],
                "--seed: \"x\" is not a whole number from 0 to 18446744073709551615",
            ),
            (
                &["render", "cornell", "--engine"],
                "--engine: the value is missing; there are fast, reference and path",
            ),
            (
                &["render", "cornell", "--engine", "gpu"],
                "--engine: \"gpu\" is no choice; there are fast, reference and path",
            ),
            (&["render", "cornell", "--widht", "3"], "there is no option --widht; did you mean --width?"),
            (&["render", "cornell", "--qqqqqqq"], "there is no option --qqqqqqq; see `sppm render --help`"),
            (&["info", "a", "b"], "\"b\" is one argument too many; see `sppm info --help`"),
            (&["info", "-", "-"], "\"-\" is one argument too many; see `sppm info --help`"),
            (&["rendr"], "there is no command \"rendr\"; did you mean render?"),
            (&["re"], "there is no command \"re\"; did you mean render or resume?"),
            (&["zzzzzz"], "there is no command \"zzzzzz\"; see `sppm --help`"),
            (&[], "a command is missing; try `sppm render cornell`, or `sppm --help`"),
            (&["render"], "<SCENE> is missing; see `sppm render --help`"),
            (&["compare"], "<A> and <B> are missing; see `sppm compare --help`"),
            (&["render", "cornell", "--seed", "1", "--seed", "2"], "--seed is given twice; once is enough"),
            (&["render", "cornell", "-q", "-v"], "--quiet contradicts --verbose; give one of them"),
        ] {
            assert_eq!(told(arguments), text, "{arguments:?}");
        }
    }

    /// Whoever leaves out one of them would be refused again.
    #[test]
    fn all_that_an_option_contradicts_is_told() {
        let text = told(&["ladder", "--images", "a", "--sweep", "depth", "--repeat", "2"]);
        assert!(text.starts_with("--images contradicts ") && text.ends_with("; give one of them"), "{text}");
        assert!(text.contains("--sweep") && text.contains("--repeat"), "{text}");
    }

    /// In one line, and with the label of all errors alone.
    #[test]
    fn what_has_no_sentence_of_its_own_is_told_as_by_the_parser() {
        let text = told(&["render", "cornell", "--quiet=yes"]);
        assert!(text.starts_with("unexpected value 'yes' for '--quiet'") && !text.contains('\n'), "{text}");
    }
}
