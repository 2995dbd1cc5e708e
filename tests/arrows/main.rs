//! Checks the dependencies between crates, between the files of a crate, and between the folders of the command.

mod crates;
mod cycles;
mod files;
mod folders;
mod imports;
mod packages;
