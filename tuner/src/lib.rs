//! Searches for the free parameters with which the fast engine renders a scene fastest.
//!
//! ```text
//! space      the parameters that are searched, and the candidate at each point
//! optimiser  proposes points; a process in Python
//! stopwatch  times a candidate in turns with the defaults
//! search     asks for points and measures them until the budget is spent; measures the best again
//! account    writes profile, table, plot and a summary
//! ```
//!
//! A [`Request`] says what to tune; [`Request::run`] returns an [`Account`] of the search. The image does not depend on
//! the parameters; this is checked at every render. Nothing is printed.

#![forbid(unsafe_code)]

mod account;
mod budget;
mod candidate;
mod error;
mod found;
mod optimiser;
mod ratios;
mod request;
mod search;
mod space;
mod stopwatch;

pub use account::Account;
pub use budget::Budget;
pub use error::Error;
pub use request::Request;
pub use search::Progress;
