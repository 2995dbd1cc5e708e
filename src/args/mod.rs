//! Groups of options that several commands share, and the parsers of their values.

pub(crate) mod engine;
mod fields;
pub(crate) mod files;
pub(crate) mod frames;
pub(crate) mod goals;
pub(crate) mod messages;
pub(crate) mod outputs;
pub(crate) mod part;
pub(crate) mod particles;
pub(crate) mod quick;
pub(crate) mod scene;
pub(crate) mod settings;
pub(crate) mod values;
pub(crate) mod view;

/// The options of `sppm render` with these words.
#[cfg(test)]
fn of_render(words: &[&str]) -> crate::commands::render::RenderArgs {
    use crate::commands::{Args, Command};
    use clap::Parser as _;
    let Command::Render(args) = Args::try_parse_from(["sppm", "render"].iter().chain(words)).unwrap().command
    else {
        panic!("another command")
    };
    args
}
