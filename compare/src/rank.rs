//! The values of given ranks among more values than fit into memory.
//!
//! The bits of floats that are not negative are ordered as they are. A first pass counts values by their upper 16 bits;
//! a second one counts those that share these with a wanted value by their lower 16 bits.

use std::collections::BTreeMap;

/// Counts of values by 16 of their bits.
type Counts = Vec<u64>;

fn no_counts() -> Counts {
    vec![0; 1 << 16]
}

/// The first pass.
pub(crate) struct Coarse {
    counts: Counts,
    pub(crate) count: u64,
    pub(crate) zeros: u64,
    pub(crate) greatest: f32,
}

/// The second pass.
pub(crate) struct Fine {
    /// By the upper bits of wanted values: how many values are less, and the counts of these.
    buckets: BTreeMap<u32, (u64, Counts)>,
}

impl Coarse {
    pub(crate) fn new() -> Self {
        Self { counts: no_counts(), count: 0, zeros: 0, greatest: 0.0 }
    }

    /// Counts `v`, which must not be negative or NaN.
    pub(crate) fn add(&mut self, v: f32) {
        self.counts[(v.to_bits() >> 16) as usize] += 1;
        self.count += 1;
        self.zeros += u64::from(v == 0.0);
        self.greatest = self.greatest.max(v);
    }

    /// Prepares to find the values of `ranks`, each less than the count. Rank 0 is the least value.
    pub(crate) fn refine(&self, ranks: impl IntoIterator<Item = u64>) -> Fine {
        let bucket = |rank: u64| {
            let mut less = 0;
            for (upper, &count) in self.counts.iter().enumerate() {
                if rank < less + count {
                    return (upper as u32, (less, no_counts()));
                }
                less += count;
            }
            unreachable!("rank {rank} of {} values", self.count)
        };
        Fine { buckets: ranks.into_iter().map(bucket).collect() }
    }
}

impl Fine {
    /// Counts `v` again.
    pub(crate) fn add(&mut self, v: f32) {
        if let Some((_, counts)) = self.buckets.get_mut(&(v.to_bits() >> 16)) {
            counts[(v.to_bits() & 0xffff) as usize] += 1;
        }
    }

    /// The value of one of the ranks that were asked for.
    pub(crate) fn value(&self, rank: u64) -> f32 {
        let bucket = self.buckets.iter().rev().find(|(_, (less, _))| *less <= rank);
        let (upper, (less, counts)) = bucket.expect("the rank was asked for");
        let mut less = *less;
        let lower = counts.iter().position(|&count| {
            less += count;
            rank < less
        });
        f32::from_bits(upper << 16 | lower.expect("the second pass saw the same values") as u32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranks_are_those_of_the_sorted_values() {
        let mut values: Vec<f32> = (0..5000_u32).map(|i| (i * 7919 % 1000) as f32 * 1e-3).collect();
        values.extend([f32::MAX, 1e-45, 0.5, 0.500_000_06]);
        let mut coarse = Coarse::new();
        for &v in &values {
            coarse.add(v);
        }
        let ranks = [0, 1, 5, 6, 2501, 2502, 5002, 5003];
        let mut fine = coarse.refine(ranks);
        for &v in &values {
            fine.add(v);
        }
        values.sort_unstable_by(f32::total_cmp);
        assert_eq!(ranks.map(|rank| fine.value(rank)), ranks.map(|rank| values[rank as usize]));
        assert_eq!((coarse.count, coarse.zeros, coarse.greatest), (5004, 5, f32::MAX));
    }

    #[test]
    fn what_was_not_asked_for_is_not_counted() {
        let mut coarse = Coarse::new();
        for v in [0.0, 1.0, 2.0, 4.0] {
            coarse.add(v);
        }
        let mut fine = coarse.refine([2]);
        for v in [4.0, 2.0, 1.0, 0.0] {
            fine.add(v);
        }
        assert_eq!((fine.value(2), fine.buckets.len()), (2.0, 1));
    }
}
