//! Every fact about light from every end: where the eye looks, where photons go, and where direct light falls.
//!
//! A file of this folder is a fact, such as tint. Its tests begin with `eye_`, `photons_` or `direct_`, and
//! [`table`] holds each fact to at least one of each. A fact that holds for the eye alone has shown to be a fault in the
//! other half of the engine.

mod closed_form;
mod depth;
mod fresnel;
mod lens;
mod mirror;
mod motion;
mod squared_index;
mod table;
mod tint;
mod total_reflection;

pub(crate) use closed_form::{assert_close, direct_light, lit};
