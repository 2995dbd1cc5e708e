//! Large pages, and the first write to them.
//!
//! A virtual machine may give free memory back to its host, and it does so by large pages. Whoever writes to such a page first
//! waits until the host has found it again, five times as long as the first write to the same memory on small pages takes
//! (docs/benchmarks.md). Small pages come from memory that the machine has kept. Nothing tells which pages were given
//! back, so the clock decides, on pages alone: no result depends on them.
//!
//! ```text
//! for each large page of the array:
//!     ask for a large page, and write to it; if that took long, the next 16 are small pages
//! ```

use memmap2::MmapMut;
use rayon::prelude::*;

/// Bytes of a large page.
pub(crate) const LARGE: usize = 2 << 20;

/// Writes to all pages of an array of so many bytes that starts on a large page, `start` bytes from the start of the map.
pub(super) fn write_first(map: &MmapMut, start: usize, bytes: usize) {
    (0..bytes.div_ceil(LARGE)).into_par_iter().for_each(|page| {
        let first = page * LARGE;
        system::write_page(map, start + first, LARGE.min(bytes - first));
    });
}

#[cfg(target_os = "linux")]
mod system {
    use super::LARGE;
    use memmap2::{Advice, MmapMut};
    use std::sync::atomic::{AtomicU32, Ordering};
    use std::time::{Duration, Instant};

    /// A first write that takes longer is dear. To 2 MiB of small pages it takes 0.7 to 1.4 ms, to a large page 0.2 ms if the
    /// system has its memory, and 3 to 9 ms if it has not.
    const DEAR: Duration = Duration::from_millis(2);

    /// After a dear page, so many are small before a large one is tried again: the tries take a third of the time of the others
    /// then, and a page that took long by accident has little effect.
    const SMALL_AFTER_DEAR: u32 = 16;

    /// Which pages are to be small.
    struct Choice {
        /// So many pages, from now on.
        small: AtomicU32,
    }

    /// That of all threads.
    static CHOICE: Choice = Choice { small: AtomicU32::new(0) };

    impl Choice {
        /// Whether the next page is to be small.
        fn takes_small(&self) -> bool {
            self.small
                .fetch_update(Ordering::Relaxed, Ordering::Relaxed, |count| count.checked_sub(1))
                .is_ok()
        }

        /// Takes note of the time of the first write to a large page.
        fn note(&self, time: Duration) {
            if time > DEAR {
                self.small.store(SMALL_AFTER_DEAR, Ordering::Relaxed);
            }
        }
    }

    /// Writes to `bytes` bytes of the large page at `at`. If the system refuses any of it, the pages are written to later.
    pub(super) fn write_page(map: &MmapMut, at: usize, bytes: usize) {
        if CHOICE.takes_small() {
            let _ = map.advise_range(Advice::PopulateWrite, at, bytes);
            // In a long render the system may join them later.
            let _ = map.advise_range(Advice::HugePage, at, LARGE);
            return;
        }
        let _ = map.advise_range(Advice::HugePage, at, LARGE);
        let begin = Instant::now();
        let _ = map.advise_range(Advice::PopulateWrite, at, LARGE);
        CHOICE.note(begin.elapsed());
    }

    #[cfg(test)]
    mod tests {
        use super::*;

        #[test]
        fn pages_are_small_for_a_while_after_a_dear_one() {
            let choice = Choice { small: AtomicU32::new(0) };
            assert!(!choice.takes_small());
            choice.note(DEAR);
            assert!(!choice.takes_small());
            choice.note(2 * DEAR);
            let run = (0..100).take_while(|_| choice.takes_small()).count();
            assert_eq!(run, SMALL_AFTER_DEAR as usize);
            assert!(!choice.takes_small());
        }
    }
}

/// Where pages are written to when something is put there.
#[cfg(not(target_os = "linux"))]
mod system {
    use memmap2::MmapMut;

    pub(super) fn write_page(_: &MmapMut, _: usize, _: usize) {}
}
