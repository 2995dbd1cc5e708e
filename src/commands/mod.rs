//! The commands, one file each: the options and what they run.

pub(crate) mod compare;
pub(crate) mod verify;
