//! What a job keeps for its next start: its thread pool and reusable parts of the fast engine.

use crate::error::Error;
use crate::pool::pool;
use fast::Parts;
use rayon::ThreadPool;
use std::fmt;

/// What a job keeps for its next start.
#[derive(Default)]
pub(crate) struct Warm {
    /// The pool, and the number of threads that was requested for it.
    pool: Option<(Option<usize>, ThreadPool)>,
    /// Reusable parts of the fast engine.
    pub(crate) parts: Parts,
}

impl Warm {
    /// The kept pool, if it was made for the same number of threads; else a new one.
    pub(crate) fn take_pool(&mut self, threads: Option<usize>) -> Result<ThreadPool, Error> {
        match self.pool.take() {
            Some((asked, pool)) if asked == threads => Ok(pool),
            _ => pool(threads),
        }
    }

    /// Keeps a pool that was made for `threads`.
    pub(crate) fn keep_pool(&mut self, threads: Option<usize>, pool: ThreadPool) {
        self.pool = Some((threads, pool));
    }
}

impl fmt::Debug for Warm {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Warm").field("has_pool", &self.pool.is_some()).finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A pool is taken once, and only for as many threads as it was made for.
    #[test]
    fn a_pool_is_kept_for_its_number_of_threads() {
        let kept = || {
            let mut warm = Warm::default();
            warm.keep_pool(Some(2), pool(Some(2)).unwrap());
            warm
        };
        assert_eq!(kept().take_pool(Some(2)).unwrap().current_num_threads(), 2);
        assert_eq!(kept().take_pool(Some(1)).unwrap().current_num_threads(), 1);
        let mut warm = kept();
        assert!(format!("{warm:?}").contains("has_pool: true"), "{warm:?}");
        warm.take_pool(Some(2)).unwrap();
        assert!(format!("{warm:?}").contains("has_pool: false"), "{warm:?}");
    }
}
