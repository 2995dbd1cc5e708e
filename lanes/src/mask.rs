//! Truth values in mask registers, a bit each: of the back ends that have AVX-512.

use std::ops::{BitAnd, BitOr, Not};

/// As many truth values as `T` has bits.
#[derive(Clone, Copy, Debug)]
pub(crate) struct M<T>(pub(crate) T);

impl<T: BitAnd<Output = T>> BitAnd for M<T> {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }
}

impl<T: BitOr<Output = T>> BitOr for M<T> {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

impl<T: Not<Output = T>> Not for M<T> {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self(!self.0)
    }
}
