//! The commands `completions` and `man`: generate shell completions and manual pages from the options' definitions.

use crate::terminal::error::Error;
use crate::terminal::text::print;
use clap::{Args as ClapArgs, Command};
use clap_complete::Shell;
use std::path::PathBuf;

/// Print a script that completes commands and options in a shell
#[derive(Debug, ClapArgs)]
#[command(
    after_long_help = "Example:\n  sppm completions bash > ~/.local/share/bash-completion/completions/sppm"
)]
pub(crate) struct CompletionsArgs {
    /// The shell
    shell: Shell,
}

/// Print the manual page, or write those of all commands into a folder
#[derive(Debug, ClapArgs)]
#[command(after_long_help = "Examples:\n  sppm man | man -l -\n  sppm man ~/.local/share/man/man1")]
pub(crate) struct ManArgs {
    /// The folder to write the pages into
    #[arg(value_name = "DIR")]
    folder: Option<PathBuf>,
}

/// Runs the command `completions`.
pub(crate) fn completions(mut command: Command, args: &CompletionsArgs) -> Result<(), Error> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut command, "sppm", &mut script);
    print(&script)
}

/// Runs the command `man`.
pub(crate) fn man(command: Command, args: &ManArgs) -> Result<(), Error> {
    let Some(folder) = &args.folder else {
        let mut page = Vec::new();
        clap_mangen::Man::new(command)
            .render(&mut page)
            .map_err(|error| Error::Failed(format!("cannot make the manual page: {error}")))?;
        return print(&page);
    };
    if !folder.is_dir() {
        return Err(Error::BadInput(format!("DIR: {} is not a folder; make it first", folder.display())));
    }
    clap_mangen::generate_to(command, folder).map_err(|error| {
        let folder = folder.display();
        Error::Failed(format!("cannot write the manual pages into {folder}: {error}"))
    })
}
