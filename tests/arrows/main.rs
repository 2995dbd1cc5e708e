//! Who may import whom: crates by a table, files of a crate without a circle, and folders of the command in one direction.

mod crates;
mod cycles;
mod files;
mod folders;
mod imports;
