//! The executable `sppm`: passes its arguments to the library.

use std::process::ExitCode;

fn main() -> ExitCode {
    sppm::run(std::env::args_os())
}
