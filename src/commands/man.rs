//! The command `man`: generates manual pages from the definitions of the options.

use crate::terminal::error::Error;
use crate::terminal::text::print;
use clap::{Args as ClapArgs, Command};
use clap_mangen::Man;
use files::atomic_file;
use std::io::{self, Write as _};
use std::path::PathBuf;

/// Print the manual page, or write those of all commands into a folder
#[derive(Debug, ClapArgs)]
#[command(after_long_help = "Examples:\n  sppm man | man -l -\n  sppm man ~/.local/share/man/man1")]
pub(crate) struct ManArgs {
    /// The folder to write the pages into
    #[arg(value_name = "DIR")]
    folder: Option<PathBuf>,
}

/// Runs the command.
pub(crate) fn run(command: Command, args: &ManArgs) -> Result<(), Error> {
    let unmade = |error: io::Error| Error::Failed(format!("cannot make the manual pages: {error}"));
    let Some(folder) = &args.folder else {
        return print(&page(&Man::new(command)).map_err(unmade)?);
    };
    if !folder.is_dir() {
        return Err(Error::BadInput(format!("DIR: {} is not a folder; make it first", folder.display())));
    }
    let mut command = command.disable_help_subcommand(true);
    command.build();
    let all = [command.clone()].into_iter().chain(command.get_subcommands().cloned());
    let mut pages = Vec::new();
    for man in all.map(Man::new) {
        pages.push((folder.join(man.get_filename()), page(&man).map_err(unmade)?));
    }
    // All are checked before the first is written.
    let checked = pages.iter().try_for_each(|(path, _)| atomic_file::check(path));
    let write = |(path, page): &(PathBuf, Vec<u8>)| atomic_file::replace(path, |out| out.write_all(page));
    checked.and_then(|()| pages.iter().try_for_each(write)).map_err(|error| {
        Error::Failed(format!("cannot write the manual pages into {}: {error}", folder.display()))
    })
}

fn page(man: &Man) -> io::Result<Vec<u8>> {
    let mut page = Vec::new();
    man.render(&mut page)?;
    Ok(page)
}
