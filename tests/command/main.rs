//! Tests the program `sppm` from outside: arguments, output files, messages and exit codes.

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
#[cfg(unix)]
mod locks;
mod render;
#[cfg(unix)]
mod running;
mod sandbox;
mod scenes;
mod trace;
#[cfg(unix)]
mod tune;
mod verify;
