//! Boxes around balls, and which of a node's boxes a ray enters.

use super::cull::trust;
use super::leaves::{Leaf, WIDTH};
use crate::paths::ROOM;
use bytemuck::{Pod, Zeroable};
use lanes::{Lanes, Row, V3};
use scene::Vec3;

/// Relative slack: of the radii of balls in boxes, and of distances to boxes. See [`Slabs`].
pub(super) const LOOSE: f32 = 1.0 / 512.0;

/// The boxes of a node's children: along each axis, their low planes and then their high ones. A missing child's box is empty.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, align(64))]
pub(super) struct Node {
    planes: [[f32; 2 * WIDTH]; 3],
}

/// An axis-aligned box.
#[derive(Clone, Copy, Debug)]
pub(super) struct BoundingBox {
    pub(super) low: Vec3,
    pub(super) high: Vec3,
}

impl BoundingBox {
    const EMPTY: Self = Self { low: Vec3::INFINITY, high: Vec3::NEG_INFINITY };

    /// Around the balls of a leaf.
    pub(super) fn of(leaf: &Leaf) -> Self {
        leaf.balls().fold(Self::EMPTY, |all, ball| {
            let (center, radius) = (Vec3::from(ball.center), Vec3::splat(ball.radius * (1.0 + LOOSE)));
            all.union(Self { low: center - radius, high: center + radius })
        })
    }

    /// Around all of these.
    pub(super) fn around(boxes: &[Self]) -> Self {
        boxes.iter().fold(Self::EMPTY, |all, one| all.union(*one))
    }

    fn union(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }
}

impl Node {
    pub(super) fn new(children: &[BoundingBox]) -> Self {
        let mut planes = [[f32::NEG_INFINITY; 2 * WIDTH]; 3];
        for axis in &mut planes {
            axis[..WIDTH].fill(f32::INFINITY);
        }
        for (k, child) in children.iter().enumerate() {
            for axis in 0..3 {
                planes[axis][k] = child.low[axis];
                planes[axis][WIDTH + k] = child.high[axis];
            }
        }
        Self { planes }
    }
}

/// What tests against boxes need to know of the rays of a batch, in two rows for each: the inverse direction, the offsets that
/// added to `plane * inverse` give the distances to the near and far planes of each axis, and where the near planes
/// begin; and what leaves need, the [`trust`] of its direction.
///
/// Why it misses no box that matters. With f from the centre of a ball to the origin, u = 2^-24, and D the distance
/// of the centre from the line of the ray, the reference accepts a ball only if D <= r (1 + 4u) + 8u |f|
/// ([`may_meet`](super::cull::may_meet) derives it). So the line meets the box around the ball if the box grows by 8u |f|, and |f| is at
/// most 4 times the sum of the largest coordinates of origin and boxes. `slack` is 64u times that sum, and so also
/// outweighs the rounding of this test, whose every step errs by a few u times the sum over the direction's
/// component. The distance that the reference finds, `power / (root - b)`, can be smaller than that to the grown
/// ball only by the rounding of `power`, 4u |f|^2, over |b|: less than 5e-4 |f|, in which |f| is at most the
/// distance plus the radius. Hence `LOOSE` in both.
pub(super) struct Slabs([[Row; ROOM]; 2]);

impl Slabs {
    #[allow(clippy::large_stack_arrays)] // A part of the box of a search.
    pub(super) const ZERO: Self = Self([[Row([0.0; 8]); ROOM]; 2]);

    /// Distances to the boxes of a node, and which of them a ray enters before `t`.
    #[inline(always)]
    pub(super) fn children<L: Lanes>(&self, ray: usize, node: &Node, t: f32) -> Children<L> {
        let first = self.meet::<L>(ray, node, 0, t);
        let second = if Children::<L>::PARTS == 1 { first } else { self.meet::<L>(ray, node, L::N, t) };
        Children([first, second])
    }

    /// The same for the children from `first` on.
    #[inline(always)]
    fn meet<L: Lanes>(&self, ray: usize, node: &Node, first: usize, t: f32) -> (L::F, L::M) {
        let Row([ix, iy, iz, nx, ny, nz, ..]) = &self.0[0][ray];
        let Row([fx, fy, fz, sx, sy, sz, ..]) = &self.0[1][ray];
        let [px, py, pz] = &node.planes;
        let [ix, iy, iz] = [L::f(*ix), L::f(*iy), L::f(*iz)];
        // The mask tells the compiler that they are in bounds.
        let [x, y, z] =
            [sx.to_bits() as usize & WIDTH, sy.to_bits() as usize & WIDTH, sz.to_bits() as usize & WIDTH];
        let near_x = L::fused(L::load(&px[x + first..]), ix, L::f(*nx));
        let near_y = L::fused(L::load(&py[y + first..]), iy, L::f(*ny));
        let near_z = L::fused(L::load(&pz[z + first..]), iz, L::f(*nz));
        let far_x = L::fused(L::load(&px[(x ^ WIDTH) + first..]), ix, L::f(*fx));
        let far_y = L::fused(L::load(&py[(y ^ WIDTH) + first..]), iy, L::f(*fy));
        let far_z = L::fused(L::load(&pz[(z ^ WIDTH) + first..]), iz, L::f(*fz));
        let enters = L::max(L::max(near_x, near_y), L::max(near_z, L::f(0.0)));
        let exits = L::min(L::min(far_x, far_y), L::min(far_z, L::f(t * (1.0 + LOOSE))));
        (enters, L::le(enters, exits))
    }

    /// The [`trust`] of a ray's direction.
    #[inline(always)]
    pub(super) fn trust(&self, ray: usize) -> f32 {
        let Row([.., trust, _]) = &self.0[0][ray];
        *trust
    }
}

/// Distances to the children of a node, and which of them are hit: in one vector of 16, or two of 8. If it is one, the second
/// repeats the first and is not used.
pub(super) struct Children<L: Lanes>(pub(super) [(L::F, L::M); 2]);

impl<L: Lanes> Children<L> {
    /// The number of vectors.
    pub(super) const PARTS: usize = WIDTH / L::N;

    /// The nearest child that is hit; any, if none is.
    #[inline(always)]
    pub(super) fn nearest(&self) -> u32 {
        let [(first, first_hit), (second, second_hit)] = self.0;
        let far = L::f(f32::INFINITY);
        let (first, second) = (L::select(first_hit, first, far), L::select(second_hit, second, far));
        let lane = L::min_lane(L::min(first, second));
        let in_second = L::mask_bits(L::lt(second, first)) >> lane & 1;
        lane + in_second * L::N as u32
    }

    /// True if some child is hit.
    #[inline(always)]
    pub(super) fn is_any_hit(&self) -> bool {
        let [(_, first), (_, second)] = self.0;
        L::any(first | second)
    }
}

/// What the test against boxes needs to know of rays, a ray per lane: see [`Slabs`].
pub(super) struct SlabLanes<L: Lanes> {
    axes: [Axis<L>; 3],
    trust: L::F,
}

/// Of rays along one axis: the inverse direction, the offsets to the near and far planes, and where in a node the near
/// planes begin.
struct Axis<L: Lanes> {
    inverse: L::F,
    near: L::F,
    far: L::F,
    side: L::F,
}

impl<L: Lanes> SlabLanes<L> {
    /// Of rays among boxes with coordinates up to `extent`.
    #[inline(always)]
    pub(super) fn new(origin: V3<L>, direction: V3<L>, extent: f32) -> Self {
        let largest = L::max(L::abs(origin.x), L::max(L::abs(origin.y), L::abs(origin.z)));
        let slack = (largest + L::f(extent)) * L::f(1.0 / (1 << 18) as f32);
        let axes = [
            Axis::new(origin.x, direction.x, slack),
            Axis::new(origin.y, direction.y, slack),
            Axis::new(origin.z, direction.z, slack),
        ];
        Self { axes, trust: trust(direction) }
    }

    /// Stores these as the rays from `at` on.
    #[inline(always)]
    pub(super) fn store(&self, at: usize, to: &mut Slabs) {
        let (Self { axes: [x, y, z], trust }, zero) = (self, L::f(0.0));
        let near = [x.inverse, y.inverse, z.inverse, x.near, y.near, z.near, *trust, zero];
        L::transpose(near, &mut to.0[0][at..]);
        L::transpose([x.far, y.far, z.far, x.side, y.side, z.side, zero, zero], &mut to.0[1][at..]);
    }

    /// Distances to a box, and which rays enter it before `t`: as [`Slabs::meet`].
    #[inline(always)]
    pub(super) fn entry(&self, bounds: &BoundingBox, t: L::F) -> (L::F, L::M) {
        let (mut enters, mut exits) = (L::f(0.0), t * L::f(1.0 + LOOSE));
        for (k, axis) in self.axes.iter().enumerate() {
            let (low, high) = (L::f(bounds.low[k]), L::f(bounds.high[k]));
            // Which plane is near differs between lanes, and is the one of the smaller distance.
            let near =
                L::min(L::fused(low, axis.inverse, axis.near), L::fused(high, axis.inverse, axis.near));
            let far = L::max(L::fused(low, axis.inverse, axis.far), L::fused(high, axis.inverse, axis.far));
            enters = L::max(near, enters);
            exits = L::min(far, exits);
        }
        (enters, L::le(enters, exits))
    }
}

impl<L: Lanes> Axis<L> {
    #[inline(always)]
    fn new(origin: L::F, direction: L::F, slack: L::F) -> Self {
        // Zero is replaced by a number too small to matter.
        let tiny = L::f(1e-18);
        let is_tiny = L::lt(L::abs(direction), tiny);
        let inverse = L::f(1.0) / L::select(is_tiny, tiny, direction);
        let (middle, slack) = (-(origin * inverse), L::abs(inverse) * slack);
        let side = L::select_u(L::lt(inverse, L::f(0.0)), L::u(WIDTH as u32), L::u(0));
        Self { inverse, near: middle - slack, far: middle + slack, side: L::from_bits(side) }
    }
}
