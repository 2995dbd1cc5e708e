//! Leaves: sixteen balls that are near each other.
//!
//! Clusters and tree end in the same leaves, which should be full and compact. Balls are ordered by splitting them along
//! the longest axis, so that the left side is a whole number of subtrees. That gives a complete tree: all leaves but the
//! last are full, and nodes need no pointers to their children.
//!
//! The many balls of a tree are ordered where their leaves will be, so no second copy of them is ever in memory.

use crate::pages::Pages;
use bytemuck::{Pod, Zeroable};
use lanes::{Lanes, V3};
use rayon::prelude::*;
use scene::ray::SphereId;
use scene::still::Role;
use scene::{Still, Vec3};

/// Balls of a leaf, and children of a node.
pub(crate) const WIDTH: usize = 16;
/// With so many balls in the left side of a split, its sides go to different threads.
const WORTH_A_THREAD: usize = 1 << 12;

/// Set in the id of a ball of glass.
pub(crate) const GLASS: u32 = 1 << 31;

/// A ball that is not yet in a leaf.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Ball {
    pub(crate) center: [f32; 3],
    pub(crate) radius: f32,
    /// Its sphere, and perhaps [`GLASS`].
    pub(crate) sphere: SphereId,
}

/// Sixteen balls as a structure of arrays. Missing balls have a squared radius of minus infinity and are never hit.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, align(32))]
pub(crate) struct Leaf {
    pub(crate) x: [f32; WIDTH],
    pub(crate) y: [f32; WIDTH],
    pub(crate) z: [f32; WIDTH],
    pub(crate) radius_squared: [f32; WIDTH],
    /// Each with [`GLASS`], if it is.
    pub(crate) spheres: [SphereId; WIDTH],
}

// A leaf has the place of its balls.
const _: () = assert!(size_of::<Leaf>() == WIDTH * size_of::<Ball>());

/// As many balls of a leaf as there are lanes.
#[derive(Clone, Copy)]
pub(crate) struct LeafPart<L: Lanes> {
    pub(crate) center: V3<L>,
    pub(crate) radius_squared: L::F,
    /// As [`Leaf::spheres`].
    pub(crate) spheres: L::U,
}

impl<L: Lanes> LeafPart<L> {
    /// The parts of a leaf.
    pub(crate) const COUNT: usize = WIDTH / L::N;

    #[inline(always)]
    fn from(leaf: &Leaf, at: usize) -> Self {
        let center = V3::new(L::load(&leaf.x[at..]), L::load(&leaf.y[at..]), L::load(&leaf.z[at..]));
        let radius_squared = L::load(&leaf.radius_squared[at..]);
        Self { center, radius_squared, spheres: L::load_u(&leaf.spheres[at..]) }
    }
}

impl Leaf {
    /// Its parts. If there is but one, the second repeats it.
    #[inline(always)]
    pub(crate) fn parts<L: Lanes>(&self) -> [LeafPart<L>; 2] {
        [LeafPart::from(self, 0), LeafPart::from(self, WIDTH - L::N)]
    }

    pub(crate) fn new(balls: &[Ball]) -> Self {
        let (zero, nothing) = ([0.0; WIDTH], [f32::NEG_INFINITY; WIDTH]);
        let mut leaf = Self { x: zero, y: zero, z: zero, radius_squared: nothing, spheres: [0; WIDTH] };
        for (k, ball) in balls.iter().enumerate() {
            [leaf.x[k], leaf.y[k], leaf.z[k]] = ball.center;
            leaf.radius_squared[k] = ball.radius * ball.radius;
            leaf.spheres[k] = ball.sphere;
        }
        leaf
    }

    /// Its balls. The root of the squared radius is the radius, as both are rounded to the nearest.
    pub(crate) fn balls(&self) -> impl Iterator<Item = Ball> {
        let is_there = |k: &usize| self.radius_squared[*k] != f32::NEG_INFINITY;
        (0..WIDTH).filter(is_there).map(|k| Ball {
            center: [self.x[k], self.y[k], self.z[k]],
            radius: self.radius_squared[k].sqrt(),
            sphere: self.spheres[k],
        })
    }

    /// The number of its balls, if all of them are balls of `still`, at the same place and of the same size.
    pub(crate) fn count_in(&self, still: &Still) -> Option<usize> {
        let is_missing = |k: &usize| self.radius_squared[*k] == f32::NEG_INFINITY;
        let held: Vec<usize> = (0..WIDTH).filter(|k| !is_missing(k)).collect();
        let is_same = |k: &usize| {
            let id = (self.spheres[*k] & !GLASS) as usize;
            let is_glass = self.spheres[*k] & GLASS != 0;
            let is_same_role = |role: Role| match role {
                Role::Solid => !is_glass,
                Role::Glass => is_glass,
                Role::Ground(_) | Role::Enclosure(_) => false,
            };
            id < still.spheres.len() && is_same_role(still.roles[id]) && {
                let sphere = &still.spheres[id];
                let center = Vec3::new(self.x[*k], self.y[*k], self.z[*k]);
                center == sphere.center && self.radius_squared[*k] == sphere.radius * sphere.radius
            }
        };
        held.iter().all(is_same).then_some(held.len())
    }
}

/// The leaves of a tree over the balls of a still, of which there are `count`: each run of 16, 256, 4096, ... balls is compact.
pub(crate) fn arranged(still: &Still, count: usize) -> Pages<Leaf> {
    let mut leaves = Pages::<Leaf>::zeros(count.div_ceil(WIDTH));
    let balls = &mut bytemuck::cast_slice_mut(&mut leaves)[..count];
    for (place, ball) in balls.iter_mut().zip(self::balls(still)) {
        *place = ball;
    }
    arrange(balls);
    leaves.par_iter_mut().enumerate().for_each(|(i, leaf)| {
        let balls: [Ball; WIDTH] = bytemuck::cast(*leaf);
        *leaf = Leaf::new(&balls[..WIDTH.min(count - i * WIDTH)]);
    });
    leaves
}

/// The balls of a still, in order of their ids.
pub(crate) fn balls(still: &Still) -> impl Iterator<Item = Ball> {
    still.spheres.iter().zip(still.roles.iter()).zip(0..).filter_map(|((s, role), id): (_, SphereId)| {
        let glass = match role {
            Role::Solid => 0,
            Role::Glass => GLASS,
            Role::Ground(_) | Role::Enclosure(_) => return None,
        };
        Some(Ball { center: s.center.into(), radius: s.radius, sphere: id | glass })
    })
}

/// Orders balls so that each aligned run of 16, 256, 4096, ... is compact.
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
        rayon::join(|| arrange_in_units(left, unit), || arrange_in_units(right, unit));
    }
}

/// The axis along which the centres spread widest.
fn longest_axis(balls: &[Ball]) -> usize {
    let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for center in balls.iter().map(|ball| Vec3::from_array(ball.center)) {
        (low, high) = (low.min(center), high.max(center));
    }
    (high - low).max_position()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arranged_runs_of_sixteen_are_compact() {
        // A cube of 8^3 places in a scattered order.
        let place = |k: u32| [k & 7, k >> 3 & 7, k >> 6].map(|c| c as f32);
        let ball = |k: u32| Ball { center: place(k * 197 % 512), radius: 0.5, sphere: k };
        let mut balls: Vec<Ball> = (0..512).map(ball).collect();
        let extent = |run: &[Ball]| {
            let bound = |pick: fn(f32, f32) -> f32, axis: usize| {
                run.iter().map(|ball| ball.center[axis]).reduce(pick).unwrap()
            };
            (0..3).map(|axis| bound(f32::max, axis) - bound(f32::min, axis)).sum::<f32>()
        };
        let before = balls.chunks(WIDTH).map(extent).sum::<f32>();
        arrange(&mut balls);
        let after = balls.chunks(WIDTH).map(extent).sum::<f32>();
        // Boxes of 2 x 2 x 4 have an extent of 5.
        assert!(after < 0.5 * before && after < 32.0 * 6.5, "{before} before, {after} after");
        let mut spheres: Vec<SphereId> = balls.iter().map(|ball| ball.sphere).collect();
        spheres.sort_unstable();
        assert!(spheres.into_iter().eq(0..512), "a ball is lost");
    }
}
