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

    /// How many pages are to be small from now on.
    static SMALL: AtomicU32 = AtomicU32::new(0);

    /// Writes to `bytes` bytes of the large page at `at`. If the system refuses any of it, the pages are written to later.
    pub(super) fn write_page(map: &MmapMut, at: usize, bytes: usize) {
        let one_less = |count: u32| count.checked_sub(1);
        if SMALL.fetch_update(Ordering::Relaxed, Ordering::Relaxed, one_less).is_ok() {
            let _ = map.advise_range(Advice::PopulateWrite, at, bytes);
            // In a long render the system may join them later.
            let _ = map.advise_range(Advice::HugePage, at, LARGE);
            return;
        }
        let _ = map.advise_range(Advice::HugePage, at, LARGE);
        let begin = Instant::now();
        let _ = map.advise_range(Advice::PopulateWrite, at, LARGE);
        if begin.elapsed() > DEAR {
            SMALL.store(SMALL_AFTER_DEAR, Ordering::Relaxed);
        }
    }
}

/// Where pages are written to when something is put there.
#[cfg(not(target_os = "linux"))]
mod system {
    use memmap2::MmapMut;

    pub(super) fn write_page(_: &MmapMut, _: usize, _: usize) {}
}
