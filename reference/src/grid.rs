//! A spatial hash grid that finds the visible points near a photon.
//!
//! As in the paper (section 3.1), a visible point is entered in every cell that its search sphere touches, and a photon
//! looks only into the cell that it lies in. Cells are hashed to a table. Unlike in the published program, each entry
//! stores its cell, so a point is found exactly once even if several of its cells share a bucket. Insertion
//! and lookup use the same function from coordinates to cells.

use crate::camera_pass::VisiblePoint;
use scene::Vec3;

/// The most buckets of a table. Any number is correct; a prime spreads the cells best.
const MOST_BUCKETS: usize = 262_147;

/// Search radii are widened by this factor on insertion, because the distance test rounds: it computes
/// `dx^2 + dy^2 + dz^2 < R^2` with 4 roundings, a relative error below 2^-21 of the distance.
const WIDENED: f32 = 1.0 + 1.0 / 1_048_576.0;

type Cell = [i32; 3];

struct Entry {
    cell: Cell,
    point: u32,
}

/// A hash grid over the visible points of one iteration.
pub struct Grid {
    inverse_cell_size: f32,
    /// Entries of bucket b: `entries[starts[b]..starts[b + 1]]`.
    starts: Vec<u32>,
    entries: Vec<Entry>,
}

impl Grid {
    /// Enters each point with its search radius. Cells measure `multiple` times the largest radius.
    pub fn build(points: &[VisiblePoint], radius: impl Fn(usize) -> f32, multiple: f32) -> Self {
        let largest = (0..points.len()).map(&radius).fold(0.0, f32::max);
        let inverse_cell_size = 1.0 / (largest * multiple).max(f32::MIN_POSITIVE);
        let mut entries = Vec::new();
        for (index, visible) in points.iter().enumerate() {
            let reach = Vec3::splat(radius(index) * WIDENED);
            let low = cell_of(visible.point - reach, inverse_cell_size);
            let high = cell_of(visible.point + reach, inverse_cell_size);
            entries.extend(cells_between(low, high).map(|cell| Entry { cell, point: index as u32 }));
        }
        // Small images have few entries: to clear a long table would take longer than all else.
        let buckets = (2 * entries.len() + 1).min(MOST_BUCKETS);
        entries.sort_by_cached_key(|entry| bucket_of(entry.cell, buckets));
        let mut starts = vec![0; buckets + 1];
        for entry in &entries {
            starts[bucket_of(entry.cell, buckets) + 1] += 1;
        }
        for b in 0..buckets {
            starts[b + 1] += starts[b];
        }
        Self { inverse_cell_size, starts, entries }
    }

    /// The indices of all points whose radius may contain `point`, each once.
    pub fn candidates(&self, point: Vec3) -> impl Iterator<Item = usize> {
        let cell = cell_of(point, self.inverse_cell_size);
        let bucket = bucket_of(cell, self.starts.len() - 1);
        let range = self.starts[bucket] as usize..self.starts[bucket + 1] as usize;
        self.entries[range].iter().filter(move |e| e.cell == cell).map(|e| e.point as usize)
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.starts.len() * size_of::<u32>() + self.entries.len() * size_of::<Entry>()
    }
}

/// The cell of a point. It is monotone in each coordinate, even where the conversion saturates, so a box covers exactly
/// the cells between those of its corners.
fn cell_of(point: Vec3, inverse_cell_size: f32) -> Cell {
    let scaled = point * inverse_cell_size;
    [scaled.x.floor() as i32, scaled.y.floor() as i32, scaled.z.floor() as i32]
}

fn cells_between(low: Cell, high: Cell) -> impl Iterator<Item = Cell> {
    (low[0]..=high[0])
        .flat_map(move |x| (low[1]..=high[1]).flat_map(move |y| (low[2]..=high[2]).map(move |z| [x, y, z])))
}

fn bucket_of(cell: Cell, buckets: usize) -> usize {
    let [x, y, z] = cell.map(|c| c as u32);
    let hash = x.wrapping_mul(73_856_093) ^ y.wrapping_mul(19_349_663) ^ z.wrapping_mul(83_492_791);
    (hash % buckets as u32) as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use scene::Rgb;

    fn grid(point: Vec3, radius: f32, multiple: f32) -> Grid {
        Grid::build(
            &[VisiblePoint { point, normal: Vec3::Z, sphere: 0, beta: Rgb::ONE }],
            |_| radius,
            multiple,
        )
    }

    /// A photon looks into its own cell alone, and a point is in no cell that its sphere does not touch.
    #[test]
    fn cells_are_as_large_as_asked_for() {
        for multiple in [2.5, 4.0] {
            // The first cell reaches from 0 to so many radii of 1.
            let grid = grid(Vec3::splat(multiple / 2.0), 1.0, multiple);
            let is_found = |x: f32| grid.candidates(Vec3::new(x, 1.0, 1.0)).count() == 1;
            assert!(is_found(1e-3) && is_found(multiple - 1e-3), "{multiple}");
            assert!(!is_found(-1e-3) && !is_found(multiple + 1e-3), "{multiple}");
        }
        assert_eq!(Grid::build(&[], |_| 1.0, 2.0).candidates(Vec3::ZERO).count(), 0);
    }

    /// What rounding may count as near has to be looked at.
    #[test]
    fn a_sphere_reaches_a_little_beyond_its_radius() {
        let grid = grid(Vec3::new(1.0, 1.5, 1.5), 1.0, 2.0);
        assert_eq!(grid.candidates(Vec3::new(-1e-7, 1.5, 1.5)).count(), 1);
    }

    #[test]
    fn bytes_are_those_of_buckets_and_entries() {
        // In one cell, and around the corner of eight.
        let (one, eight) = (grid(Vec3::splat(1.0), 0.9, 2.0 / 0.9), grid(Vec3::splat(2.0), 0.9, 2.0 / 0.9));
        // Twice as many buckets as entries, one more, and the end of the last.
        assert_eq!((one.bytes(), eight.bytes(), size_of::<Entry>()), (16 + 4 * 4, 8 * 16 + 4 * 18, 16));
    }
}
