//! Photons aimed at what is seen: at which balls, with which shares, and what a photon then weighs.
//!
//! See docs/aiming.md for the derivation. Photons of a Lambertian lamp carry their flux alike over the lines that cross
//! it, and so do those of a glowing shell over the lines through it. A photon aimed at a target ball is drawn alike over
//! the lines that cross both lamp and ball, of all lamps together. So the density of component k, relative to emission
//! from all lamps alike, is one number, `1 / flux_k`, on all lines that cross ball k, and 0 on others; and a photon of
//! the mixture weighs `1 / (share_0 + sum over the balls that its line crosses of share_k / flux_k)`, exactly.
//!
//! What is computed here is set-up, shared by engines as the [`crate::still::Lights`] are: `f64`, of `+ - * /` and square
//! roots. How lines are drawn and tested is theirs.

mod core;
mod groups;
mod mixture;
pub mod survey;
mod target;
mod targets;
mod units;

pub use self::core::Core;
pub use crate::guide::{Arrival, RUN};
pub use groups::Group;
pub use mixture::{AIMED_BOUNCES, Aim};
pub use target::{Target, cone};
pub use targets::{Targets, UNIFORM_SHARE};
pub use units::{EXPONENT_STEP, MOST_SCALE_BITS};
