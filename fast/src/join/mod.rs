//! The join: which photons count at which visible points, and what they bring.
//!
//! ```text
//! for each group of 16 pixels (a block of 4x4):
//!     if the group's visible points, with their radii, fit into a window of cells:
//!         for each row of cells, for 8 or 16 photons of the row at once: keep those near the box of all points
//!         for each photon kept: test it against all points at once
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
//! 3. Rows of cells hold several times the photons that the box of the points reaches. Testing the box costs a
//!    tenth of testing the points, as photons then stand in lanes.
//! 4. The side on which a photon arrives is tested only where it is in doubt (see [`deposits::SAFE`]).
//! 5. Sums are integers. A sum of 32 bits holds 2047 photons of at most 2^21; it is emptied before that.

pub(crate) mod cells;
pub(crate) mod deposits;
pub(crate) mod gather;
pub(crate) mod occupancy;

use crate::camera_pass::PixelRows;
use crate::lanes::{Lanes, Row};
use cells::{Bounds, Cells};
use deposits::{SAFE, Sorted};
use gather::{Gathering, Group, Scratch, Single, Sums};
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

/// The same of some pixels; [`Bounds::EMPTY`] if none has a visible point.
#[inline(always)]
fn bounds_of_all(rows: &[PixelRows], pixels: &[Row]) -> Bounds {
    let Bounds { mut low, mut high, .. } = Bounds::EMPTY;
    let mut radius_squared = 0.0;
    for (row, pixel) in rows.iter().zip(pixels) {
        let [x, y, z, sphere, ..] = row.visible.0;
        if sphere.to_bits() != NO_SPHERE {
            let point = Vec3::new(x, y, z);
            (low, high) = (low.min(point), high.max(point));
            radius_squared = if radius_squared < pixel.0[7] { pixel.0[7] } else { radius_squared };
        }
    }
    Bounds { low, high, reach: reach(radius_squared) }
}

/// Marks the cells that a group's visible points reach.
#[inline(always)]
pub(crate) fn mark<L: Lanes>(occupancy: &mut Occupancy, rows: &[PixelRows], pixels: &[Row]) {
    let all = bounds_of_all(rows, pixels);
    if all.is_empty() {
        return;
    }
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
    scratch: &mut Scratch,
    sums: &mut Sums,
    counts: &mut JoinCounts,
) {
    let halves = [0, GROUP / 2].map(|at| bounds_of_all(&rows[at..][..GROUP / 2], &pixels[at..]));
    let all = halves[0].and(&halves[1]);
    if all.is_empty() {
        return;
    }
    let span = cells.span(&all);
    if span.fits() {
        scratch.runs.look_up(sorted, &cells.query::<L>(span, &all));
        let group = Group { rows, pixels, halves, all };
        Gathering::<L>::run(&group, sorted, scratch, sums, counts);
        return;
    }
    for (lane, (row, pixel)) in rows.iter().zip(pixels).enumerate() {
        if let Some(bounds) = bounds_of_one(row, pixel) {
            let mut one = Single { row, radius_squared: pixel.0[7], sums, lane };
            let span = cells.span(&bounds);
            if span.fits() {
                scratch.runs.look_up(sorted, &cells.query::<L>(span, &bounds));
                one.run::<L>(sorted, scratch, counts);
            } else {
                // Coordinates that round to many cells.
                one.run_on_all::<L>(sorted, scratch, counts);
            }
        }
    }
}

/// What a photon's surface must be for its side not to be in doubt.
#[inline(always)]
fn safe_surface(sphere: u32) -> u32 {
    sphere | SAFE
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_looked_up_within_the_radius_and_hardly_beyond() {
        for radius in [1e-3_f32, 0.1, 1.0, 7.0, 1e5] {
            let (reached, radius) = (f64::from(reach(radius * radius)), f64::from(radius));
            assert!(radius < reached && reached < 1.000_003 * radius, "{reached} of {radius}");
        }
    }
}
