//! The command `sppm`; everything it does is in the library.

use std::process::ExitCode;

fn main() -> ExitCode {
    sppm::run(std::env::args_os())
}
