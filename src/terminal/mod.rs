//! The command's side of the terminal: signals, messages, progress, errors and exit codes.

pub(crate) mod bar;
pub(crate) mod busy;
pub(crate) mod error;
pub(crate) mod line;
pub(crate) mod logs;
pub(crate) mod radii;
pub(crate) mod signals;
pub(crate) mod text;
pub(crate) mod told;
pub(crate) mod usage;
