//! Failed attempt 2: several hash tables in place of one. Sorted by sphere, the points of a table share their colour.
//! Blocked, the points of a table are near each other in memory and fit the cache. But a photon has to look into every
//! table.

use super::bins::{Bins, TypedBins, next_of_slice};
use super::tuning::Tuning;
use lanes::Lanes;

/// Chooses the table of a point.
pub(crate) trait Partition: 'static {
    /// True if all points of a table lie on the same sphere.
    const BY_SPHERE: bool;
    /// The key of the table. Tables are numbered in the order in which keys are first seen.
    fn key(point: u32, sphere: u32, tuning: &Tuning) -> u32;
}

/// One table per sphere.
pub(crate) struct BySphere;

impl Partition for BySphere {
    const BY_SPHERE: bool = true;
    #[inline(always)]
    fn key(_: u32, sphere: u32, _: &Tuning) -> u32 {
        sphere
    }
}

/// One table per block of pixels.
pub(crate) struct ByBlock;

impl Partition for ByBlock {
    const BY_SPHERE: bool = false;
    #[inline(always)]
    fn key(point: u32, _: u32, tuning: &Tuning) -> u32 {
        point / tuning.block as u32
    }
}

/// The bins of several tables.
pub(crate) struct Partitioned<K> {
    tables: Vec<(u32, TypedBins)>,
    /// The table of each key, or `u32::MAX` if it has none.
    table_of: Vec<u32>,
    bins: usize,
    tuning: Tuning,
    partition: std::marker::PhantomData<K>,
}

/// The entries of a bin, over all tables, that are still to be read.
pub(crate) struct Cursor<'a> {
    tables: &'a [(u32, TypedBins)],
    bin: usize,
    key: u32,
    rest: &'a [u32],
    by_sphere: bool,
}

impl<K: Partition> Partitioned<K> {
    #[inline(always)]
    fn table(&mut self, key: u32) -> &mut TypedBins {
        if self.table_of.len() <= key as usize {
            self.table_of.resize(key as usize + 1, u32::MAX);
        }
        if self.table_of[key as usize] == u32::MAX {
            self.table_of[key as usize] = self.tables.len() as u32;
            // No room is reserved, as most of these bins stay empty.
            let tuning = Tuning { first_capacity: 0, ..self.tuning };
            self.tables.push((key, TypedBins::new(self.bins, 0, &tuning)));
        }
        &mut self.tables[self.table_of[key as usize] as usize].1
    }
}

impl<K: Partition> Bins for Partitioned<K> {
    type Cursor<'a> = Cursor<'a>;

    fn new(bins: usize, _: usize, tuning: &Tuning) -> Self {
        let partition = std::marker::PhantomData;
        Self { tables: Vec::new(), table_of: Vec::new(), bins, tuning: *tuning, partition }
    }

    fn clear(&mut self) {
        for (_, table) in &mut self.tables {
            table.clear();
        }
    }

    #[inline(always)]
    fn insert(&mut self, bin: usize, point: u32, sphere: u32) {
        let key = K::key(point, sphere, &self.tuning);
        self.table(key).insert(bin, point, sphere);
    }

    #[inline(always)]
    fn open(&self, bin: usize) -> Cursor<'_> {
        Cursor { tables: &self.tables, bin, key: 0, rest: &[], by_sphere: K::BY_SPHERE }
    }

    #[inline(always)]
    fn next<L: Lanes>(cursor: &mut Cursor<'_>) -> Option<(L::U, L::M)> {
        while cursor.rest.is_empty() {
            let ((key, table), later) = cursor.tables.split_first()?;
            cursor.tables = later;
            cursor.key = *key;
            cursor.rest = table.points(cursor.bin);
        }
        next_of_slice::<L>(&mut cursor.rest)
    }

    #[inline(always)]
    fn shared_sphere(cursor: &Cursor<'_>) -> Option<u32> {
        cursor.by_sphere.then_some(cursor.key)
    }

    fn bytes(&self) -> usize {
        self.tables.iter().map(|(_, table)| table.bytes()).sum::<usize>() + self.table_of.len() * 4
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::one::One;

    /// Points of two spheres, by fours in blocks of neighbouring pixels.
    const POINTS: [(u32, u32); 6] = [(0, 9), (3, 2), (4, 2), (7, 9), (8, 9), (11, 2)];

    /// The tables of one bin: their keys and points, in the order in which they are looked into.
    fn tables<K: Partition>() -> Vec<(u32, Vec<u32>)> {
        let mut all = Partitioned::<K>::new(2, 0, &Tuning { block: 4, ..Tuning::PAPER });
        for (point, sphere) in POINTS {
            all.insert(1, point, sphere);
        }
        let mut found: Vec<(u32, Vec<u32>)> = Vec::new();
        let mut cursor = all.open(1);
        while let Some((point, _)) = Partitioned::<K>::next::<One>(&mut cursor) {
            let shared = Partitioned::<K>::shared_sphere(&cursor);
            assert_eq!(shared, K::BY_SPHERE.then_some(cursor.key));
            match found.last_mut() {
                Some((key, points)) if *key == cursor.key => points.push(point.0),
                _ => found.push((cursor.key, vec![point.0])),
            }
        }
        let mut other = all.open(0);
        assert!(Partitioned::<K>::next::<One>(&mut other).is_none());
        found
    }

    #[test]
    fn a_table_has_the_points_of_a_block_or_of_a_sphere() {
        assert_eq!(tables::<ByBlock>(), [(0, vec![0, 3]), (1, vec![4, 7]), (2, vec![8, 11])]);
        assert_eq!(tables::<BySphere>(), [(9, vec![0, 7, 8]), (2, vec![3, 4, 11])]);
    }
}
