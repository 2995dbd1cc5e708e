//! The region around visible points in which photons may count: of several, or of each by itself.

use crate::pixels::{PixelRow, PixelRowLanes};
use lanes::{Lanes, V3};
use scene::Vec3;
use scene::ray::NO_SPHERE;

/// The radius of search is widened by this factor where cells are looked up, as the test of the distance rounds.
const WIDENED: f32 = 1.0 + 1.0 / 1_048_576.0;

/// The bounding box of some visible points, and the distance from it within which photons may count.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Region {
    pub(crate) low: Vec3,
    pub(crate) high: Vec3,
    pub(crate) reach: f32,
}

impl Region {
    /// The region of no points.
    pub(crate) const EMPTY: Self = Self { low: Vec3::INFINITY, high: Vec3::NEG_INFINITY, reach: 0.0 };

    /// The region of a pixel's visible point, if it has one.
    #[inline(always)]
    pub(crate) fn of_one(row: &PixelRow) -> Option<Self> {
        let point = row.visible()?;
        Some(Self { low: point, high: point, reach: reach(row.radius_squared) })
    }

    /// The region of some pixels' visible points; [`Region::EMPTY`] if none has one.
    #[inline(always)]
    pub(crate) fn of_all(rows: &[PixelRow]) -> Self {
        let Self { mut low, mut high, .. } = Self::EMPTY;
        let mut largest = 0.0;
        for row in rows {
            if let Some(point) = row.visible() {
                (low, high) = (low.min(point), high.max(point));
                largest = if largest < row.radius_squared { row.radius_squared } else { largest };
            }
        }
        Self { low, high, reach: reach(largest) }
    }

    /// True for the region of no points.
    #[inline(always)]
    pub(crate) fn is_empty(&self) -> bool {
        self.reach <= 0.0
    }

    /// A region around both.
    #[inline(always)]
    pub(crate) fn and(&self, other: &Self) -> Self {
        let (low, high) = (self.low.min(other.low), self.high.max(other.high));
        Self { low, high, reach: self.reach.max(other.reach) }
    }
}

/// Visible points in lanes, with the distance from each within which photons may count.
pub(crate) struct ReachLanes<L: Lanes> {
    pub(crate) point: V3<L>,
    pub(crate) reach: L::F,
    /// Where there is a visible point.
    pub(crate) are_there: L::M,
}

impl<L: Lanes> ReachLanes<L> {
    /// Those of the first `L::N` pixels.
    #[inline(always)]
    pub(crate) fn load(rows: &[PixelRow]) -> Self {
        let PixelRowLanes { point, sphere, radius_squared, .. } = PixelRowLanes::<L>::load(rows);
        let reach = L::sqrt(radius_squared) * L::f(WIDENED);
        Self { point, reach, are_there: !L::eq(sphere, L::u(NO_SPHERE)) }
    }
}

/// The search radius, widened.
#[inline(always)]
fn reach(radius_squared: f32) -> f32 {
    radius_squared.sqrt() * WIDENED
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regions_reach_beyond_the_radius_but_hardly() {
        for radius in [1e-3_f32, 0.1, 1.0, 7.0, 1e5] {
            let (reached, radius) = (f64::from(reach(radius * radius)), f64::from(radius));
            assert!(radius < reached && reached < 1.000_003 * radius, "{reached} of {radius}");
        }
    }
}
