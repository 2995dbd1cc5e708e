//! How many threads work.

use crate::error::Error;

/// More threads than this are a slip of the keyboard.
pub(crate) const MAX_THREADS: u64 = 1024;

/// Starts the threads that engines share, `wanted` or one per core, and returns how many they are.
pub(crate) fn start(wanted: Option<usize>) -> Result<usize, Error> {
    // For rayon 0 means: as many as the machine has.
    rayon::ThreadPoolBuilder::new().num_threads(wanted.unwrap_or(0)).build_global().map_err(|error| {
        Error::Failed(format!("cannot start the threads: {error}; ask for fewer by --threads"))
    })?;
    Ok(rayon::current_num_threads())
}
