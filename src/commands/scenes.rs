//! The command `scenes`: lists the built-in scenes, or prints one.

use crate::args::scene::SceneName;
use crate::terminal::error::Error;
use crate::terminal::text::print;
use clap::Args as ClapArgs;
use files::builtin::{Builtin, SCENES};
use files::named;
use scene::text::counted;
use std::ffi::OsString;

/// List the built-in scenes, or print one as a scene file to start from
#[derive(Debug, ClapArgs)]
#[command(after_long_help = "Example:\n  sppm scenes cornell > mine.toml && sppm render mine.toml")]
pub(crate) struct ScenesArgs {
    /// The scene whose file to print; without a name, all are listed
    #[arg(value_name = "NAME", value_parser = SceneName, hide_possible_values = true)]
    pub name: Option<OsString>,
}

/// Runs the command.
pub(crate) fn run(args: &ScenesArgs) -> Result<(), Error> {
    match &args.name {
        Some(name) => print(named::find(name).map_err(Error::BadInput)?.text.as_bytes()),
        None => print(listing().as_bytes()),
    }
}

fn listing() -> String {
    let width = SCENES.iter().map(|s| s.name.len()).max().unwrap_or(0);
    let line = |builtin: &Builtin| {
        let spheres = counted(builtin.scene().without_sky().len() as u64, "sphere");
        format!("{:width$}  {spheres:>12}  {}\n", builtin.name, builtin.about)
    };
    SCENES.iter().map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_scene_has_a_line() {
        let listing = listing();
        assert_eq!(listing.lines().count(), SCENES.len());
        for (line, builtin) in listing.lines().zip(SCENES) {
            assert!(line.starts_with(builtin.name) && line.ends_with(builtin.about), "{line}");
            let count = builtin.text.lines().filter(|line| *line == "[[sphere]]").count();
            assert!(line.contains(&format!(" {count} sphere")), "{line}");
        }
    }
}
