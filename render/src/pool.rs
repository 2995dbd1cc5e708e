//! The thread pool of a render.

use crate::error::{Error, Field, Problem};
use files::atomic_file::reason;
use rayon::{ThreadPool, ThreadPoolBuilder};

/// A pool of `threads` threads, or of one per core.
///
/// # Errors
/// If the system cannot start that many threads.
pub fn pool(threads: Option<usize>) -> Result<ThreadPool, Error> {
    // In rayon, 0 means one per core.
    ThreadPoolBuilder::new().num_threads(threads.unwrap_or(0)).build().map_err(|error| {
        let said = format!("cannot start the threads: {}; ask for fewer by ", reason(&error));
        Error::failed(Problem::from(said).field(Field::Threads))
    })
}

/// The number of cores available to this process.
pub fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}
