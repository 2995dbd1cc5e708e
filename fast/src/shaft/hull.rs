//! The shaft itself: the convex hull of two balls, around the rays of a batch.

use crate::paths::{Floats, least};
use crate::rays::Rays;
use lanes::{Lanes, V3};
use scene::Vec3;

/// See [the module](super).
const SLACK: f32 = 256.0 / (1 << 24) as f32;
/// Scales for which squares of the slack are normal numbers, and squares of lengths are finite.
const SCALES: std::ops::RangeInclusive<f32> = 1.0 / (1u64 << 40) as f32..=(1u64 << 40) as f32;
/// What ends a ray beyond all balls, over the distance at which it is beyond them.
const BEYOND: f32 = 1.0 + 1.0 / 1024.0;

/// All balls: what rays are followed past.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Extent {
    pub(super) middle: Vec3,
    /// The farthest that any ball reaches from the middle.
    pub(super) reach: f32,
}

/// The convex hull of two balls.
pub(super) struct Shaft {
    pub(super) start: Vec3,
    /// From the centre of the first ball to that of the second.
    pub(super) axis: Vec3,
    /// A length that no coordinate of the rays' ends or of balls exceeds, radii included.
    pub(super) scale: f32,
    /// One over the squared length of the axis less the square of `growth`.
    pub(super) inverse: f32,
    /// Of the first ball, with the slack.
    pub(super) radius: f32,
    /// The radius of the second less that of the first.
    pub(super) growth: f32,
}

impl Shaft {
    /// Around the rays of which `first` is one. `None` if it would not be one.
    #[inline(always)]
    pub(super) fn around<L: Lanes>(
        extent: Extent,
        rays: &Rays,
        limit: Option<&Floats>,
        first: usize,
    ) -> Option<Self> {
        // Those that are not searched are as the first.
        let origin = rays.origin.broadcast::<L>(first);
        let mut starts = Bounds { low: origin, high: origin };
        for at in (0..rays.count).step_by(L::N) {
            let (live, _) = searched::<L>(rays, limit, at);
            starts.add(V3::select(live, rays.origin.load(at), origin));
        }
        let (start, radius) = starts.ball();
        let far = (start.distance(extent.middle) + radius + extent.reach) * BEYOND;
        let reach = L::f(if let Some(t) = limit { far.min(t[first]) } else { far });
        let end = origin + rays.direction.broadcast::<L>(first).scale(reach);
        let mut ends = Bounds { low: end, high: end };
        for at in (0..rays.count).step_by(L::N) {
            let (live, t) = searched::<L>(rays, limit, at);
            let to = rays.origin.load::<L>(at) + rays.direction.load::<L>(at).scale(L::min(t, L::f(far)));
            ends.add(V3::select(live, to, end));
        }
        let (end, end_radius) = ends.ball();
        let coordinate = |v: Vec3| v.abs().max_element();
        let scale = (coordinate(start) + radius)
            .max(coordinate(end) + end_radius)
            .max(coordinate(extent.middle) + extent.reach);
        let (axis, growth) = (end - start, end_radius - radius);
        let length2 = axis.length_squared();
        let is_narrow = 4.0 * growth * growth <= length2;
        if !SCALES.contains(&scale) || !is_narrow {
            return None;
        }
        let inverse = 1.0 / (length2 - growth * growth);
        Some(Self { start, axis, scale, inverse, radius: radius + SLACK * scale, growth })
    }

    /// The radius of a ball around `start + s axis` that all rays cross there, for `s` from 0 on. Past the second ball they
    /// part, as lines through points of both balls.
    pub(super) fn radius_at(&self, s: f32) -> f32 {
        self.radius * (2.0 * s.max(1.0) - 1.0) + s * self.growth
    }

    /// False only where no ray of the shaft meets the ball.
    #[inline(always)]
    pub(super) fn may_meet<L: Lanes>(&self, center: V3<L>, radius: L::F) -> L::M {
        let (axis, growth) = (V3::<L>::splat(self.axis), L::f(self.growth));
        let f = center - V3::splat(self.start);
        let radius = radius + L::f(self.radius);
        let s = (f.dot(axis) + radius * growth) * L::f(self.inverse);
        let s = L::min(L::max(s, L::f(0.0)), L::f(1.0));
        let off = f - axis.scale(s);
        let radius = radius + s * growth;
        L::le(off.dot(off), radius * radius)
    }
}

/// Which of the rays from `at` on are searched, and up to where.
#[inline(always)]
fn searched<L: Lanes>(rays: &Rays, limit: Option<&Floats>, at: usize) -> (L::M, L::F) {
    let live = L::first(rays.count - at);
    let Some(t) = limit else { return (live, L::f(f32::INFINITY)) };
    let t = L::load(&t[at..]);
    (live & L::le(L::f(0.0), t), t)
}

/// A bounding box of points in lanes.
struct Bounds<L: Lanes> {
    low: V3<L>,
    high: V3<L>,
}

impl<L: Lanes> Bounds<L> {
    #[inline(always)]
    fn add(&mut self, p: V3<L>) {
        let Self { low: l, high: h } = *self;
        self.low = V3::new(L::min(l.x, p.x), L::min(l.y, p.y), L::min(l.z, p.z));
        self.high = V3::new(L::max(h.x, p.x), L::max(h.y, p.y), L::max(h.z, p.z));
    }

    /// The ball around the box of all lanes.
    #[inline(always)]
    fn ball(&self) -> (Vec3, f32) {
        let low = Vec3::new(least::<L>(self.low.x), least::<L>(self.low.y), least::<L>(self.low.z));
        let high = Vec3::new(least::<L>(-self.high.x), least::<L>(-self.high.y), least::<L>(-self.high.z));
        (0.5 * (low - high), 0.5 * low.distance(-high))
    }
}
