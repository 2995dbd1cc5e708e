//! Leaves: eight balls that are near each other.
//!
//! Clusters and tree end in the same leaves, which should be full and compact. Balls are ordered by splitting them along
//! the longest axis, so that the left side is a whole number of subtrees. That gives a complete tree: all leaves but the
//! last are full, and nodes need no pointers to their children.

use rayon::join;
use scene::ray::SphereId;
use scene::still::Role;
use scene::{Still, Vec3};

/// Balls of a leaf, and children of a node.
pub(crate) const WIDTH: usize = 8;
/// With so many balls in the left side of a split, its sides go to different threads.
const WORTH_A_THREAD: usize = 1 << 12;

/// A ball that is not yet in a leaf.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ball {
    pub(crate) center: Vec3,
    pub(crate) radius: f32,
    pub(crate) sphere: SphereId,
}

/// Eight balls as a structure of arrays. Missing balls have a squared radius of minus infinity and are never hit.
#[derive(Clone, Debug)]
#[repr(C, align(32))]
pub(crate) struct Leaf {
    pub(crate) x: [f32; WIDTH],
    pub(crate) y: [f32; WIDTH],
    pub(crate) z: [f32; WIDTH],
    pub(crate) radius_squared: [f32; WIDTH],
    pub(crate) spheres: [SphereId; WIDTH],
}

impl Leaf {
    pub(crate) fn new(balls: &[Ball]) -> Self {
        let (zero, nothing) = ([0.0; WIDTH], [f32::NEG_INFINITY; WIDTH]);
        let mut leaf = Self { x: zero, y: zero, z: zero, radius_squared: nothing, spheres: [0; WIDTH] };
        for (k, ball) in balls.iter().enumerate() {
            (leaf.x[k], leaf.y[k], leaf.z[k]) = ball.center.into();
            leaf.radius_squared[k] = ball.radius * ball.radius;
            leaf.spheres[k] = ball.sphere;
        }
        leaf
    }

    /// The number of its balls, if all of them are balls of `still`, at the same place and of the same size.
    pub(crate) fn count_in(&self, still: &Still) -> Option<usize> {
        let is_missing = |k: &usize| self.radius_squared[*k] == f32::NEG_INFINITY;
        let held: Vec<usize> = (0..WIDTH).filter(|k| !is_missing(k)).collect();
        let is_same = |k: &usize| {
            let id = self.spheres[*k] as usize;
            let is_ball = still.roles.get(id).is_some_and(|role| !matches!(role, Role::Enclosure(_)));
            is_ball && {
                let sphere = &still.spheres[id];
                let center = Vec3::new(self.x[*k], self.y[*k], self.z[*k]);
                center == sphere.center && self.radius_squared[*k] == sphere.radius * sphere.radius
            }
        };
        held.iter().all(is_same).then_some(held.len())
    }
}

/// Orders balls so that each aligned run of 8, 64, 512, ... is compact.
pub(crate) fn arrange(balls: &mut [Ball]) {
    let mut unit = WIDTH;
    while unit < balls.len() {
        unit *= WIDTH;
    }
    arrange_in_units(balls, unit);
}

/// As [`arrange`], where runs of `unit` balls become the children of one node.
fn arrange_in_units(balls: &mut [Ball], unit: usize) {
    if balls.len() <= WIDTH {
        return;
    }
    let units = balls.len().div_ceil(unit);
    if units == 1 {
        return arrange_in_units(balls, unit / WIDTH);
    }
    let axis = longest_axis(balls);
    let left = units / 2 * unit;
    balls.select_nth_unstable_by(left, |a, b| a.center[axis].total_cmp(&b.center[axis]));
    let (left, right) = balls.split_at_mut(left);
    if left.len() < WORTH_A_THREAD {
        arrange_in_units(left, unit);
        arrange_in_units(right, unit);
    } else {
        join(|| arrange_in_units(left, unit), || arrange_in_units(right, unit));
    }
}

/// The axis along which the centres spread widest.
fn longest_axis(balls: &[Ball]) -> usize {
    let (mut low, mut high) = (balls[0].center, balls[0].center);
    for ball in balls {
        (low, high) = (low.min(ball.center), high.max(ball.center));
    }
    (high - low).max_position()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arranged_runs_of_eight_are_compact() {
        // A cube of 8^3 places in a scattered order.
        let place = |k: u32| [k & 7, k >> 3 & 7, k >> 6].map(|c| c as f32);
        let ball = |k: u32| Ball { center: place(k * 197 % 512).into(), radius: 0.5, sphere: k };
        let mut balls: Vec<Ball> = (0..512).map(ball).collect();
        let extent = |run: &[Ball]| {
            let bound = |pick: fn(f32, f32) -> f32, axis: usize| {
                run.iter().map(|ball| ball.center[axis]).reduce(pick).unwrap()
            };
            (0..3).map(|axis| bound(f32::max, axis) - bound(f32::min, axis)).sum::<f32>()
        };
        let before = balls.chunks(8).map(extent).sum::<f32>();
        arrange(&mut balls);
        let after = balls.chunks(8).map(extent).sum::<f32>();
        // Cubes of 2^3 have an extent of 3.
        assert!(after < 0.5 * before && after < 64.0 * 4.5, "{before} before, {after} after");
        let mut spheres: Vec<SphereId> = balls.iter().map(|ball| ball.sphere).collect();
        spheres.sort_unstable();
        assert!(spheres.into_iter().eq(0..512), "a ball is lost");
    }
}
