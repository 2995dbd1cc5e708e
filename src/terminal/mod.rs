//! What the command shares with the terminal: signals, messages, progress, exit codes.

pub(crate) mod bar;
pub(crate) mod error;
pub(crate) mod logs;
pub(crate) mod signals;
pub(crate) mod text;
pub(crate) mod usage;
