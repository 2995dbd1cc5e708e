//! Groups of options that several commands share, and the parsers of their values.

pub(crate) mod engine;
mod fields;
pub(crate) mod files;
pub(crate) mod frames;
pub(crate) mod goals;
pub(crate) mod messages;
pub(crate) mod outputs;
pub(crate) mod part;
pub(crate) mod particles;
pub(crate) mod quick;
pub(crate) mod scene;
pub(crate) mod settings;
pub(crate) mod values;
pub(crate) mod view;
