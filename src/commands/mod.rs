//! The commands, one file each: the options and what they run.

pub(crate) mod compare;
pub(crate) mod ladder;
pub(crate) mod quick;
pub(crate) mod verify;
