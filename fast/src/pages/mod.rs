//! Arrays on large pages.
//!
//! The first write to a new array costs a page fault per 4 KiB, which takes a tenth of a short render. These arrays are written
//! to when they are made, on pages of 2 MiB where these are not dear ([`large`]; on Linux), by all threads (everywhere). So
//! arrays of [`WORTH_A_PAGE`] on have such pages. Smaller ones come from the heap, which gives the same memory out again
//! without asking the system each time.

mod large;

use bytemuck::{Pod, Zeroable};
pub(crate) use large::LARGE;
use memmap2::MmapMut;
use rayon::prelude::*;
use std::alloc::{Layout, handle_alloc_error};
use std::fmt;
use std::marker::PhantomData;
use std::ops::{Deref, DerefMut};

/// Elements of a work item.
const PER_JOB: usize = 1 << 14;

/// Arrays of so many bytes are worth a large page of their own, as they fill most of it.
const WORTH_A_PAGE: usize = LARGE / 4 * 3;

/// An array of a fixed length.
pub(crate) struct Pages<T> {
    memory: Memory,
    /// Bytes of the elements.
    bytes: usize,
    elements: PhantomData<T>,
}

/// Bytes that are zero at first, aligned to a cache line at least.
enum Memory {
    Heap(Vec<CacheLine>),
    /// Whole large pages, and where they begin: the system may have mapped others than were asked for.
    Mapped(MmapMut, usize),
}

#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C, align(64))]
struct CacheLine([u64; 8]);

impl Memory {
    /// If memory runs out this ends the process, as it does for a vector.
    fn new(bytes: usize) -> Self {
        if bytes < WORTH_A_PAGE {
            return Self::Heap(vec![CacheLine::zeroed(); bytes.div_ceil(size_of::<CacheLine>())]);
        }
        let map = MmapMut::map_anon(bytes.next_multiple_of(LARGE) + LARGE).unwrap_or_else(|_| {
            handle_alloc_error(Layout::array::<u8>(bytes).unwrap_or(Layout::new::<u8>()))
        });
        let start = map.as_ptr().align_offset(LARGE);
        large::write_first(&map, start, bytes);
        Self::Mapped(map, start)
    }

    fn bytes(&self) -> &[u8] {
        match self {
            Self::Heap(lines) => bytemuck::cast_slice(lines),
            Self::Mapped(map, start) => &map[*start..],
        }
    }

    fn bytes_mut(&mut self) -> &mut [u8] {
        match self {
            Self::Heap(lines) => bytemuck::cast_slice_mut(lines),
            Self::Mapped(map, start) => &mut map[*start..],
        }
    }
}

impl<T: Pod + Send + Sync> Pages<T> {
    /// `count` elements whose bytes are zero.
    pub(crate) fn zeros(count: usize) -> Self {
        let bytes = count * size_of::<T>();
        Self { memory: Memory::new(bytes), bytes, elements: PhantomData }
    }

    /// `count` elements of which no one asks what they are, in the memory of `old` if that holds as many.
    pub(crate) fn reused(old: Option<Self>, count: usize) -> Self {
        old.filter(|pages| pages.len() == count).unwrap_or_else(|| Self::zeros(count))
    }

    /// `count` times the same value, in the memory of `old` if that holds as many.
    pub(crate) fn refilled(old: Option<Self>, value: T, count: usize) -> Self {
        let mut pages = Self::reused(old, count);
        pages.par_chunks_mut(PER_JOB).for_each(|elements| elements.fill(value));
        pages
    }

    /// `count` elements, each made from its index. If memory runs out this ends the process, as it does for a vector.
    pub(crate) fn made(count: usize, make: impl Fn(usize) -> T + Sync) -> Self {
        let mut pages = Self::zeros(count);
        pages.par_chunks_mut(PER_JOB).enumerate().for_each(|(job, elements)| {
            for (element, index) in elements.iter_mut().zip(job * PER_JOB..) {
                *element = make(index);
            }
        });
        pages
    }
}

impl<T> fmt::Debug for Pages<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Pages").finish_non_exhaustive()
    }
}

impl<T: Pod> Deref for Pages<T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        bytemuck::cast_slice(&self.memory.bytes()[..self.bytes])
    }
}

impl<T: Pod> DerefMut for Pages<T> {
    fn deref_mut(&mut self) -> &mut [T] {
        bytemuck::cast_slice_mut(&mut self.memory.bytes_mut()[..self.bytes])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_elements_are_there_and_are_the_value() {
        let large = [WORTH_A_PAGE, LARGE].map(|bytes| bytes / size_of::<[u32; 3]>() + 1);
        for count in [0, 1, 2, 1023, PER_JOB, 3 * PER_JOB + 5, large[0], large[1]] {
            let mut pages = Pages::refilled(None, [7_u32, 8, 9], count);
            assert_eq!(pages.len(), count);
            assert!(pages.iter().all(|element| *element == [7, 8, 9]));
            let made = Pages::made(count, |index| index as u64);
            assert!(made.iter().copied().eq(0..count as u64));
            assert!(Pages::<[u32; 3]>::zeros(count).iter().eq(&vec![[0; 3]; count]));
            if let Some(last) = pages.last_mut() {
                *last = [1, 2, 3];
                assert_eq!(pages[count - 1], [1, 2, 3]);
            }
            let place = pages.as_ptr();
            let pages = Pages::refilled(Some(pages), [4, 5, 6], count);
            assert!(pages.as_ptr() == place && pages.iter().all(|element| *element == [4, 5, 6]));
            let other = Pages::refilled(Some(pages), [7, 8, 9], count + 1);
            assert!(other.len() == count + 1 && other.iter().all(|element| *element == [7, 8, 9]));
        }
    }

    /// Else the system could not fill them with large pages.
    #[test]
    fn large_arrays_begin_on_a_page() {
        for bytes in [WORTH_A_PAGE, LARGE, LARGE + 1] {
            let pages = Pages::<u8>::zeros(bytes);
            assert_eq!((pages.len(), pages.as_ptr().align_offset(LARGE)), (bytes, 0));
        }
    }
}
