//! Tests the program `sppm` from outside: arguments, output files, messages and exit codes.

mod bad_input;
#[path = "../shared/cases.rs"]
mod cases;
mod compare;
mod documents;
mod export;
mod exports_read;
mod failures;
#[cfg(unix)]
mod farm;
mod frames;
mod info;
#[cfg(unix)]
mod interrupt;
mod ladder;
#[cfg(unix)]
mod locks;
mod messages;
#[cfg(unix)]
mod names;
mod particles;
mod quality;
mod render;
#[cfg(unix)]
mod running;
mod sandbox;
mod scenes;
#[cfg(unix)]
mod streams;
#[cfg(target_os = "linux")]
mod terminal;
mod trace;
#[cfg(unix)]
mod tune;
mod verify;
#[cfg(unix)]
mod view;
