//! Tests of long renders. If they are stopped or killed and then resumed, they give the same image as an undisturbed
//! render. If a file cannot be written, no work is lost.

#[cfg(unix)]
mod budgets;
#[path = "../shared/cases.rs"]
mod cases;
#[cfg(unix)]
mod kills;
#[cfg(unix)]
mod merge;
mod metadata;
#[cfg(unix)]
mod outputs;
mod resume;
#[path = "../command/sandbox.rs"]
mod sandbox;
#[cfg(unix)]
mod signals;
