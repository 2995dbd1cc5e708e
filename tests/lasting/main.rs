//! Renders that last: stopped, saved, killed and taken up again, they give the image of a render that was left alone;
//! and whatever cannot be written, nothing is lost.

#[cfg(unix)]
mod budgets;
#[path = "../shared/cases.rs"]
mod cases;
#[cfg(unix)]
mod kills;
mod metadata;
#[cfg(unix)]
mod outputs;
mod resume;
#[path = "../command/sandbox.rs"]
mod sandbox;
#[cfg(unix)]
mod signals;
