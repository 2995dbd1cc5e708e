//! The command as its users meet it: arguments in; files, lines and an exit code out.

mod bad_input;
#[path = "../shared/cases.rs"]
mod cases;
mod compare;
mod documents;
mod export;
mod failures;
#[cfg(unix)]
mod interrupt;
mod ladder;
mod render;
mod sandbox;
mod scenes;
mod trace;
#[cfg(unix)]
mod tune;
mod verify;
