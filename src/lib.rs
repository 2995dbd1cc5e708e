//! The parts of the `sppm` command that are of use without it.

pub mod compare;
