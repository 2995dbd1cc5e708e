//! Sets of iterations, by their numbers from 0: which of a render are in a file.

use serde::{Deserialize, Serialize};
use std::fmt;
use std::ops::Range;

/// A set of iterations: ranges `[start, end)`, in order, none empty, with gaps between them.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Iterations {
    ranges: Vec<[u32; 2]>,
}

impl From<Range<u32>> for Iterations {
    fn from(Range { start, end }: Range<u32>) -> Self {
        Self { ranges: if start < end { vec![[start, end]] } else { Vec::new() } }
    }
}

impl Iterations {
    /// The ranges.
    pub fn ranges(&self) -> impl ExactSizeIterator<Item = Range<u32>> {
        self.ranges.iter().map(|[start, end]| *start..*end)
    }

    /// Whether the ranges are as they must be, after they have been read from a file.
    pub fn is_valid(&self) -> bool {
        self.ranges.iter().all(|[start, end]| start < end)
            && self.ranges.windows(2).all(|pair| pair[0][1] < pair[1][0])
    }

    /// How many there are.
    pub fn count(&self) -> u32 {
        self.ranges.iter().map(|[start, end]| end - start).sum()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.ranges.is_empty()
    }

    /// The least number above all in the set; 0 if there are none.
    pub fn end(&self) -> u32 {
        self.ranges.last().map_or(0, |[_, end]| *end)
    }

    /// Whether they are the first ones, without gaps.
    pub fn are_first(&self) -> bool {
        self.count() == self.end()
    }

    /// Those that are in both.
    #[must_use]
    pub fn common(&self, other: &Self) -> Self {
        let mut ranges = Vec::new();
        let (mut ours, mut theirs) = (self.ranges.iter().peekable(), other.ranges.iter().peekable());
        while let (Some(&&[a, b]), Some(&&[c, d])) = (ours.peek(), theirs.peek()) {
            if a.max(c) < b.min(d) {
                ranges.push([a.max(c), b.min(d)]);
            }
            if b < d {
                ours.next()
            } else {
                theirs.next()
            };
        }
        Self { ranges }
    }

    /// Those that are in either.
    #[must_use]
    pub fn with(&self, other: &Self) -> Self {
        let mut all: Vec<[u32; 2]> = self.ranges.iter().chain(&other.ranges).copied().collect();
        all.sort_unstable();
        let mut ranges: Vec<[u32; 2]> = Vec::with_capacity(all.len());
        for [start, end] in all {
            match ranges.last_mut() {
                Some(last) if start <= last[1] => last[1] = last[1].max(end),
                _ => ranges.push([start, end]),
            }
        }
        Self { ranges }
    }

    /// Those of this set that are not in the other.
    #[must_use]
    pub fn without(&self, other: &Self) -> Self {
        let mut ranges = Vec::new();
        let mut others = other.ranges.iter().peekable();
        for &[mut start, end] in &self.ranges {
            while let Some(&&[from, to]) = others.peek() {
                if from >= end {
                    break;
                }
                if start < from {
                    ranges.push([start, from]);
                }
                start = start.max(to);
                if to > end {
                    break;
                }
                others.next();
            }
            if start < end {
                ranges.push([start, end]);
            }
        }
        Self { ranges }
    }

    /// The first that is in `all` and not in this set.
    pub fn first_missing(&self, all: &Range<u32>) -> Option<u32> {
        let mut next = all.start;
        for &[start, end] in &self.ranges {
            if start <= next && next < end {
                next = end;
            }
        }
        (next < all.end).then_some(next)
    }
}

/// As `0..10, 20..30`; `none` if there are none.
impl fmt::Display for Iterations {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.ranges.is_empty() {
            return f.write_str("none");
        }
        for (k, [start, end]) in self.ranges.iter().enumerate() {
            write!(f, "{}{start}..{end}", if k > 0 { ", " } else { "" })?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The set whose members are the bits of `bits`.
    fn of(bits: u16) -> Iterations {
        let one = |k: u32| Iterations::from(k..k + u32::from(bits >> k & 1 == 1));
        (0..16).map(one).fold(Iterations::default(), |all, one| all.with(&one))
    }

    fn bits(set: &Iterations) -> u16 {
        set.ranges().flatten().fold(0, |bits, k| bits | 1 << k)
    }

    /// All pairs of sets of numbers below 8, in the bits of one number.
    #[test]
    fn sets_are_those_of_their_bits() {
        for pair in 0..=u16::MAX {
            let (a, b) = (pair & 0xff, pair >> 8);
            let (ours, theirs) = (of(a), of(b));
            let sets = [ours.with(&theirs), ours.common(&theirs), ours.without(&theirs)];
            assert_eq!(sets.each_ref().map(bits), [a | b, a & b, a & !b], "{ours} and {theirs}");
            assert!(sets.iter().all(Iterations::is_valid), "{ours} and {theirs} give {sets:?}");
        }
    }

    #[test]
    fn numbers_of_sets_are_those_of_their_bits() {
        for a in 0..=0xff_u16 {
            let set = of(a);
            assert_eq!(set.count(), a.count_ones());
            assert_eq!(set.end(), 16 - a.leading_zeros());
            assert_eq!((set.is_empty(), set.are_first()), (a == 0, (a + 1).is_power_of_two()));
            for (start, end) in (0..8).flat_map(|start| (0..8).map(move |end| (start, end))) {
                let first = (start..end).find(|k| a >> k & 1 == 0);
                assert_eq!(set.first_missing(&(start..end)), first, "{set} in {start}..{end}");
            }
        }
        assert_eq!(of(0b1110_0101).to_string(), "0..1, 2..3, 5..8");
        assert_eq!(Iterations::default().to_string(), "none");
    }

    #[test]
    fn ranges_out_of_order_are_not_valid() {
        let is_valid = |ranges: &[[u32; 2]]| Iterations { ranges: ranges.into() }.is_valid();
        for ranges in [&[[3, 2]][..], &[[2, 2]], &[[0, 2], [2, 3]], &[[4, 5], [1, 2]], &[[0, 3], [2, 5]]] {
            assert!(!is_valid(ranges), "{ranges:?}");
        }
        assert!(is_valid(&[[0, 2], [3, 4]]) && is_valid(&[]));
    }
}
