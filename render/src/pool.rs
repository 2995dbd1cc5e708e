//! Threads: a pool for each render.

use crate::error::{Error, Field, Problem};
use rayon::{ThreadPool, ThreadPoolBuilder};

/// A pool of `threads` threads, or one per core.
///
/// # Errors
/// If the system does not give as many.
pub fn pool(threads: Option<usize>) -> Result<ThreadPool, Error> {
    // For rayon 0 means one per core.
    ThreadPoolBuilder::new().num_threads(threads.unwrap_or(0)).build().map_err(|error| {
        let said = format!("cannot start the threads: {error}; ask for fewer by ");
        Error::failed(Problem::from(said).field(Field::Threads))
    })
}

/// One per core.
pub fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}
