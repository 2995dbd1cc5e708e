//! The scalar reference.
#![forbid(unsafe_code)]
