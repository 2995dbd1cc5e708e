//! The join: which photons count at which visible points, and what they bring.
//!
//! ```text
//! for each group of 16 pixels (a block of 4x4):
//!     if the group's visible points, with their radii, fit into a window of cells:
//!         for each row of cells, for each photon of the row: test it against all 16 points at once
//!     else, for each point, for each row of its own cells: test it against 8 or 16 photons at once
//!     consolidate
//! ```
//!
//! How it differs from the reference's hash grid, and why:
//!
//! 1. Photons are sorted and visible points look them up, not the other way round: then sums stay in registers.
//! 2. Points of a group lie close together, so they share the look-up and each photon is loaded once for 16 tests,
//!    by broadcast, with no gather, no scatter and no horizontal sum. Behind a glass ball neighbours in the picture
//!    are far apart in space: such groups go point by point, with photons in lanes.
//! 3. The side on which a photon arrives is tested only where it is in doubt (see [`deposits::SAFE`]).
//! 4. Sums are integers. A sum of 32 bits holds 2047 photons of at most 2^21; it is emptied before that.

pub(crate) mod cells;
pub(crate) mod deposits;
pub(crate) mod gather;
pub(crate) mod occupancy;

use crate::camera_pass::PixelRows;
use crate::lanes::{Lanes, Row};
use cells::{Bounds, Cells};
use deposits::{SAFE, Sorted};
use gather::{Group, Sums};
use occupancy::Occupancy;
use scene::Vec3;
use scene::ray::NO_SPHERE;

/// Pixels of a group.
pub(crate) const GROUP: usize = 16;

/// The sphere of search is widened by so much where cells are looked up, as the test of the distance rounds.
const WIDENED: f32 = 1.0 + 1.0 / 1_048_576.0;

/// The search radius, for looking up cells.
#[inline(always)]
fn reach(radius_squared: f32) -> f32 {
    radius_squared.sqrt() * WIDENED
}

/// Where a pixel's visible point is and how far it gathers, if it has one.
#[inline(always)]
fn bounds_of_one(rows: &PixelRows, pixel: &Row) -> Option<Bounds> {
    let [x, y, z, sphere, ..] = rows.visible.0;
    let point = Vec3::new(x, y, z);
    (sphere.to_bits() != NO_SPHERE).then(|| Bounds { low: point, high: point, reach: reach(pixel.0[7]) })
}

/// The same of some pixels; `None` if none has a visible point.
#[inline(always)]
fn bounds_of_all(rows: &[PixelRows], pixels: &[Row]) -> Option<Bounds> {
    let (mut low, mut high, mut radius_squared) = (Vec3::INFINITY, Vec3::NEG_INFINITY, 0.0);
    for (row, pixel) in rows.iter().zip(pixels) {
        let [x, y, z, sphere, ..] = row.visible.0;
        if sphere.to_bits() != NO_SPHERE {
            let point = Vec3::new(x, y, z);
            (low, high) = (low.min(point), high.max(point));
            radius_squared = if radius_squared < pixel.0[7] { pixel.0[7] } else { radius_squared };
        }
    }
    (radius_squared > 0.0).then(|| Bounds { low, high, reach: reach(radius_squared) })
}

/// Marks the cells that a group's visible points reach.
#[inline(always)]
pub(crate) fn mark<L: Lanes>(occupancy: &mut Occupancy, rows: &[PixelRows], pixels: &[Row]) {
    let Some(all) = bounds_of_all(rows, pixels) else {
        return;
    };
    if occupancy.mark::<L>(&all) {
        return;
    }
    for (row, pixel) in rows.iter().zip(pixels) {
        if let Some(one) = bounds_of_one(row, pixel)
            && !occupancy.mark::<L>(&one)
        {
            occupancy.mark_all();
        }
    }
}

/// Counted work.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct JoinCounts {
    pub(crate) candidates: u64,
    pub(crate) contributions: u64,
}

/// Adds up the photons that count at each pixel of a group.
#[inline(always)]
pub(crate) fn gather_group<L: Lanes>(
    sorted: &Sorted,
    cells: Cells,
    rows: &[PixelRows],
    pixels: &[Row],
    sums: &mut Sums,
    counts: &mut JoinCounts,
) {
    let Some(all) = bounds_of_all(rows, pixels) else {
        return;
    };
    let span = cells.span(&all);
    if span.fits() {
        let group = Group::<L>::new(rows, pixels);
        let mut gathering = gather::Gathering::new(&group, sorted, sums, counts);
        let query = cells.query::<L>(span, &all);
        for z in query.slabs() {
            let mut rows = query.rows(z);
            while let Some(row) = rows.next() {
                let [run, wrapped] = sorted.photons(row);
                gathering.take(run);
                gathering.take(wrapped);
            }
        }
        gathering.finish();
        return;
    }
    for (lane, (rows, pixel)) in rows.iter().zip(pixels).enumerate() {
        if let Some(one) = bounds_of_one(rows, pixel) {
            let (span, mut own) = (cells.span(&one), sums.lane(lane));
            if !span.fits() {
                // Coordinates that round to many cells.
                gather::single::<L>(sorted, 0..sorted.count(), rows, pixel.0[7], &mut own, counts);
                continue;
            }
            let query = cells.query::<L>(span, &one);
            for z in query.slabs() {
                let mut found = query.rows(z);
                while let Some(row) = found.next() {
                    for run in sorted.photons(row) {
                        gather::single::<L>(sorted, run, rows, pixel.0[7], &mut own, counts);
                    }
                }
            }
        }
    }
}

/// What a photon's surface must be for its side not to be in doubt.
#[inline(always)]
fn safe_surface(sphere: u32) -> u32 {
    sphere | SAFE
}
