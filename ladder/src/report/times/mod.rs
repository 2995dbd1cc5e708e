//! Reports the times of rows as text, table and plots.

pub(crate) mod plots;
pub(crate) mod records;
pub(crate) mod text;
