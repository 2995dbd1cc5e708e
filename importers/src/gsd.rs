//! GSD.
pub(crate) const MAGIC: u64 = 0x65DF_65DF_65DF_65DF;
