//! Shell completions and manual pages, made from the command line's own description.

use crate::args::{Args, CompletionsArgs, ManArgs};
use crate::error::Error;
use crate::text;
use clap::CommandFactory;

/// The command `completions`.
pub(crate) fn completions(args: &CompletionsArgs) -> Result<(), Error> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Args::command(), "sppm", &mut script);
    text::print(&script)
}

/// The command `man`.
pub(crate) fn man(args: &ManArgs) -> Result<(), Error> {
    let Some(folder) = &args.folder else {
        let mut page = Vec::new();
        clap_mangen::Man::new(Args::command())
            .render(&mut page)
            .map_err(|error| Error::Failed(format!("cannot make the manual page: {error}")))?;
        return text::print(&page);
    };
    if !folder.is_dir() {
        return Err(Error::BadInput(format!("DIR: {} is not a folder; make it first", folder.display())));
    }
    clap_mangen::generate_to(Args::command(), folder).map_err(|error| {
        let folder = folder.display();
        Error::Failed(format!("cannot write the manual pages into {folder}: {error}"))
    })
}
