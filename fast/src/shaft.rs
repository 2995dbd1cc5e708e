//! Shafts: which spheres can the rays of a whole batch meet?
//!
//! Camera rays of neighbouring pixels, and shadow rays from them to a lamp, run close together. All that they can meet
//! meets a shaft around them (Haines and Wallace, "Shaft culling for efficient ray-cast radiosity", 1991), often but a few
//! spheres:
//!
//! ```text
//! two bounding balls: around the origins of the rays, and around their ends
//! the shaft is the convex hull of both: the balls around o + s a of radius p + s q, for s in [0, 1]
//! for each packet of spheres, of centre c and radius r:
//!     s where |c - (o + s a)|^2 - (r + p + s q)^2 is least
//!     append those where it is not above 0 to a list
//! ```
//!
//! If few are listed, the rays are tested against these one by one, as if there were no others; else by the search.
//!
//! Why nothing is missed. Let u = 2^-24, and `scale` be a length that no coordinate of the rays' ends or of the spheres exceeds,
//! radii included. By [`may_meet`](crate::hierarchy), the reference lets a ray hit a ball only if it comes as near to it as
//! 13u |f|, with f from its centre to the origin, so 26u `scale`. If it takes a hit for nearer than `t`, where it is not, that is
//! by 16u |f| r in the square of half a chord, so that the end of the ray is within another 8u |f| of the ball.
//! Bounding balls, the vector between them and that to c err by 8u `scale` in sum. With |q| <= |a| / 2, `s` is off the least
//! by so little that the difference grows by less than 200u^2 `scale`^2. All that is less than the [`SLACK`] of 256u `scale` by
//! which each radius is larger.

use crate::paths::{Floats, ROOM, Words};
use crate::rays::Rays;
use crate::shapes::{BallShape, Shape};
use lanes::{Kernel, Lanes, MOST_LANES, V3};
use scene::Vec3;

/// See above.
const SLACK: f32 = 256.0 / (1 << 24) as f32;
/// Scales for which squares of the slack are normal numbers, and squares of lengths are finite.
const SCALES: std::ops::RangeInclusive<f32> = 1.0 / (1u64 << 40) as f32..=(1u64 << 40) as f32;
/// What ends a ray beyond all balls, over the distance at which it is beyond them.
const BEYOND: f32 = 1.0 + 1.0 / 1024.0;
/// The radius of what is in every shaft. Its square is finite.
const EVERYWHERE: f32 = 1e18;
/// So many balls are few: by its instructions, the search in clusters takes as long as some thirty that are tested one by one.
const MOST_BALLS: usize = 24;
/// The most spheres of a list.
const MOST_LISTED: usize = ROOM - MOST_LANES;

/// Spheres among which shafts choose, as a structure of arrays, filled up to whole vectors.
#[derive(Debug, Default)]
pub(crate) struct Culling {
    center: [Vec<f32>; 3],
    /// For rays, and for shadow rays. [`EVERYWHERE`] for walls and grounds; NaN where there is no sphere, or none that casts a
    /// shadow.
    radius: [Vec<f32>; 2],
    /// The middle of all balls, and the farthest that any reaches from it.
    middle: Vec3,
    reach: f32,
    /// So many listed spheres are few. With 0, nothing is culled.
    most: usize,
}

/// The convex hull of two balls.
struct Shaft {
    start: Vec3,
    /// From the centre of the first ball to that of the second.
    axis: Vec3,
    /// One over the squared length of the axis less the square of `growth`.
    inverse: f32,
    /// Of the first ball, with the slack.
    radius: f32,
    /// The radius of the second less that of the first.
    growth: f32,
}

impl Culling {
    /// Among these spheres. Without balls, or with too many walls for a list, nothing is culled.
    pub(crate) fn new(shapes: &[Shape]) -> Self {
        let balls = || shapes.iter().filter_map(Shape::ball);
        let most = shapes.len() - balls().count() + MOST_BALLS;
        if most > MOST_LISTED || balls().next().is_none() {
            return Self::default();
        }
        let room = shapes.len().next_multiple_of(MOST_LANES);
        let filled = |values: &mut dyn Iterator<Item = f32>| {
            let mut values: Vec<f32> = values.collect();
            values.resize(room, f32::NAN);
            values
        };
        let center = |axis: usize| {
            filled(&mut shapes.iter().map(|shape| shape.ball().map_or(0.0, |ball| ball.center[axis])))
        };
        let radius = |casts_shadow: bool| {
            let of = |shape: &Shape| shape.ball().map_or(EVERYWHERE, |ball| ball.radius_squared.sqrt());
            let is_there = |shape: &Shape| !casts_shadow || shape.casts_shadow();
            filled(&mut shapes.iter().map(|shape| if is_there(shape) { of(shape) } else { f32::NAN }))
        };
        let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for ball in balls() {
            (low, high) = (low.min(ball.center), high.max(ball.center));
        }
        let middle = 0.5 * (low + high);
        let reach = |ball: &BallShape| middle.distance(ball.center) + ball.radius_squared.sqrt();
        Self {
            center: [center(0), center(1), center(2)],
            radius: [radius(false), radius(true)],
            middle,
            reach: balls().map(reach).fold(0.0, f32::max),
            most,
        }
    }

    /// Lists the places of the spheres that rays may meet, in ascending order. Shadow rays have a `limit`: where they end,
    /// negative if they need not be traced. `None` if the spheres are not few, or if nothing can be told.
    #[inline(always)]
    pub(crate) fn list<L: Lanes>(
        &self,
        rays: &Rays,
        limit: Option<&Floats>,
        list: &mut Words,
    ) -> Option<usize> {
        L::call(Listing { culling: self, rays, limit, list })
    }

    /// Bytes of memory held.
    pub(crate) fn bytes(&self) -> usize {
        let [x, y, z] = &self.center;
        let [all, casting] = &self.radius;
        [x, y, z, all, casting].iter().map(|values| size_of_val(&values[..])).sum()
    }

    #[inline(always)]
    fn inside<L: Lanes>(&self, shaft: &Shaft, casts_shadow: bool, list: &mut Words) -> Option<usize> {
        let radius = &self.radius[usize::from(casts_shadow)];
        let mut count = 0;
        for at in (0..radius.len()).step_by(L::N) {
            let [x, y, z] = &self.center;
            let center = V3::new(L::load(&x[at..]), L::load(&y[at..]), L::load(&z[at..]));
            let may = shaft.may_meet::<L>(center, L::load(&radius[at..]));
            L::compress_u(may, L::u(at as u32) + L::iota(), &mut list[count..]);
            count += L::mask_bits(may).count_ones() as usize;
            if count > self.most {
                return None;
            }
        }
        Some(count)
    }
}

struct Listing<'a> {
    culling: &'a Culling,
    rays: &'a Rays<'a>,
    limit: Option<&'a Floats>,
    list: &'a mut Words,
}

impl Kernel for Listing<'_> {
    type Output = Option<usize>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Option<usize> {
        let Self { culling, rays, limit, list } = self;
        if culling.most == 0 {
            return None;
        }
        let mut first = 0;
        if let Some(t) = limit {
            while first < rays.count && t[first] < 0.0 {
                first += 1;
            }
        }
        if first == rays.count {
            return Some(0);
        }
        let shaft = Shaft::around::<L>(culling, rays, limit, first)?;
        culling.inside::<L>(&shaft, limit.is_some(), list)
    }
}

impl Shaft {
    /// Around the rays of which `first` is one. `None` if it would not be one.
    #[inline(always)]
    fn around<L: Lanes>(
        culling: &Culling,
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
        let far = (start.distance(culling.middle) + radius + culling.reach) * BEYOND;
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
            .max(coordinate(culling.middle) + culling.reach);
        let (axis, growth) = (end - start, end_radius - radius);
        let length2 = axis.length_squared();
        let is_narrow = 4.0 * growth * growth <= length2;
        if !SCALES.contains(&scale) || !is_narrow {
            return None;
        }
        let inverse = 1.0 / (length2 - growth * growth);
        Some(Self { start, axis, inverse, radius: radius + SLACK * scale, growth })
    }

    /// False only where no ray of the shaft meets the ball.
    #[inline(always)]
    fn may_meet<L: Lanes>(&self, center: V3<L>, radius: L::F) -> L::M {
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

/// The least of all lanes.
#[inline(always)]
fn least<L: Lanes>(v: L::F) -> f32 {
    let mut lanes = [f32::INFINITY; MOST_LANES];
    L::store(v, &mut lanes);
    let mut least = lanes[0];
    for lane in &lanes[1..L::N] {
        least = least.min(*lane);
    }
    least
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::paths::Vectors;
    use scene::ray::NO_SPHERE;

    /// Balls in a row along x, ten apart.
    fn row(count: u32) -> Vec<Shape> {
        let ball =
            |k| BallShape { sphere: k, center: Vec3::new(10.0 * k as f32, 0.0, 0.0), radius_squared: 1.0 };
        (0..count).map(|k| Shape::Solid(ball(k))).collect()
    }

    /// What is listed for rays from these origins in these directions.
    fn listed(shapes: &[Shape], rays: &[(Vec3, Vec3)], limit: Option<&[f32]>) -> Option<Vec<u32>> {
        let (mut origin, mut direction) = (Vectors::ZERO, Vectors::ZERO);
        for (k, (o, d)) in rays.iter().enumerate() {
            (origin.x[k], origin.y[k], origin.z[k]) = (*o).into();
            (direction.x[k], direction.y[k], direction.z[k]) = (*d).into();
        }
        let (leaves, mut t, mut list) = ([NO_SPHERE; ROOM], [0.0; ROOM], [0; ROOM]);
        let (origin, direction, ignores, count) = (&origin, &direction, &leaves, rays.len());
        let rays = Rays { origin, direction, leaves: &leaves, ignores, count, are_close: true };
        let limit = limit.map(|limit| {
            t[..limit.len()].copy_from_slice(limit);
            &t
        });
        let culling = Culling::new(shapes);
        let culling = Listing { culling: &culling, rays: &rays, limit, list: &mut list };
        let count = lanes::dispatch(lanes::LaneKind::Emulated, culling)?;
        Some(list[..count].to_vec())
    }

    #[test]
    fn what_rays_cannot_meet_is_not_listed() {
        let down = |x| (Vec3::new(x, 50.0, 0.0), -Vec3::Y);
        assert_eq!(listed(&row(40), &[down(20.0)], None), Some(vec![2]));
        assert_eq!(listed(&row(40), &[down(18.0), down(32.0)], None), Some(vec![2, 3]));
        assert_eq!(listed(&row(40), &[down(25.0)], None), Some(vec![]));
        // Along the row too many are met.
        assert_eq!(listed(&row(24), &[(-Vec3::X, Vec3::X)], None).map(|list| list.len()), Some(24));
        assert_eq!(listed(&row(25), &[(-Vec3::X, Vec3::X)], None), None);
        // What lies behind is not met, nor what lies beyond a limit.
        assert_eq!(listed(&row(25), &[(Vec3::new(215.0, 0.0, 0.0), Vec3::X)], None), Some(vec![22, 23, 24]));
        let from_5 = (Vec3::new(5.0, 0.0, 0.0), Vec3::X);
        assert_eq!(listed(&row(40), &[from_5], Some(&[10.0])), Some(vec![1]));
        // Rays that are not traced count for nothing.
        assert_eq!(listed(&row(40), &[from_5, from_5], Some(&[-1.0, 10.0])), Some(vec![1]));
        assert_eq!(listed(&row(40), &[from_5, from_5], Some(&[10.0, -1.0])), Some(vec![1]));
        assert_eq!(listed(&row(40), &[from_5], Some(&[-1.0])), Some(vec![]));
        // In all directions, there is no shaft.
        assert_eq!(listed(&row(2), &[(Vec3::Y, Vec3::X), (Vec3::Y, -Vec3::X)], None), None);
    }
}
