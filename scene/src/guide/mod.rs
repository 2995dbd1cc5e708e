//! Guided photons: where lamps send them and surfaces scatter them, so that more of them land where the eye sees it.
//!
//! See docs/guiding.md for the derivation. Two uniform numbers choose a direction: at a surface by the cosine, at a lamp
//! alike from all directions. The unit square of these numbers is divided into [`SIDE`] x [`SIDE`] cells, each with a
//! probability, in a table of its own for each part of the scene, and one for all lamps. A photon weighs one over its cell's
//! probability times the number of cells: so whatever the tables hold, nothing is biased.
//!
//! At surfaces the numbers are bent, so that each cell gets its share of them. From lamps each cell gets a run of an iteration's
//! photons ([`Departures`]).
//!
//! What is computed here is set-up, shared by engines as [`crate::aim`] is: `f64`, of `+ - * /` and square roots, and the
//! choice of a table and of a cell in `f32`, which `fast` has in lanes.

mod departures;
mod found;
mod learn;
mod table;
mod tables;

pub use departures::{Cell, Departures, RUN};
pub use found::{Arrival, Edge, Found, Lit};
pub use table::{EVEN_SHARE, Guided, ROWS, SIDE, Shares};
pub use tables::{FACES, Guide, PARTS, SURFACES};

/// Of the surfaces that a photon meets, those up to this one guide it.
pub const GUIDED_BOUNCES: u32 = 3;

/// Fluxes of guided photons count in units of `2^-GUIDED_BITS` of the nominal power over
/// [`FLUX_ONE`](crate::film::FLUX_ONE), but for those that weigh more than `2^GUIDED_BITS`: few do. The most that one weighs,
/// from its lamp over all surfaces that guide it, is below 2^7.
pub const GUIDED_BITS: u32 = 3;

#[cfg(test)]
mod tests;
