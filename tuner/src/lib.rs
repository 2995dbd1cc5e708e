//! A search for the free parameters by which the fast engine renders a scene soonest.
//!
//! ```text
//! space      the parameters that are searched, and the candidate at each point
//! optimiser  proposes points: a process in Python
//! stopwatch      renders a candidate in turns with the defaults
//! search     proposes and measures until the budget is spent, and measures the best again
//! account    profile, table, plot and lines of text
//! ```
//!
//! A [`Request`] says what to tune; [`Request::run`] gives an [`Account`] of the search. The image does not depend on
//! the parameters, and that it does not is checked at every render. Nothing is printed.

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
