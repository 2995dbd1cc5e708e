//! How many threads work.

use crate::error::Error;
use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};

/// More threads than this are a slip of the keyboard.
pub(crate) const MAX_THREADS: u64 = 1024;

/// Starts the threads that engines share, `wanted` or one per core, and returns how many they are.
pub(crate) fn start(wanted: Option<usize>) -> Result<usize, Error> {
    // For rayon 0 means: as many as the machine has.
    ThreadPoolBuilder::new().num_threads(wanted.unwrap_or(0)).build_global().map_err(|e| failure(&e))?;
    Ok(rayon::current_num_threads())
}

/// A pool of `threads` threads of its own.
pub(crate) fn pool(threads: usize) -> Result<ThreadPool, Error> {
    ThreadPoolBuilder::new().num_threads(threads).build().map_err(|e| failure(&e))
}

/// One per core.
pub(crate) fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

fn failure(error: &ThreadPoolBuildError) -> Error {
    Error::Failed(format!("cannot start the threads: {error}; ask for fewer by --threads"))
}
