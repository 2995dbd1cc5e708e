//! The spheres that the rays of a shaft may meet.

use super::hull::{Extent, Shaft};
use super::walls::Walls;
use crate::paths::{Floats, ROOM, Words};
use crate::rays::Rays;
use crate::shapes::{BallShape, Shape};
use lanes::{Kernel, Lanes, MOST_LANES, V3};
use scene::Vec3;

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
    extent: Extent,
    /// So many listed spheres are few. With 0, nothing is culled.
    most: usize,
    walls: Walls,
}

/// What the rays of a batch may meet.
pub(crate) struct Culled {
    /// How many spheres are listed; `None` if they are not few, or if nothing can be told.
    pub(crate) listed: Option<usize>,
    /// The walls that no ray meets first, for [`Culling::take_out`].
    pub(crate) behind: u32,
}

impl Culled {
    /// Nothing can be told.
    pub(crate) const NOTHING: Self = Self { listed: None, behind: 0 };
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
            extent: Extent { middle, reach: balls().map(reach).fold(0.0, f32::max) },
            most,
            walls: Walls::new(shapes),
        }
    }

    /// Lists the places of the spheres that rays may meet, in ascending order, with all walls. Shadow rays have a `limit`: where
    /// they end, negative if they need not be traced.
    #[inline(always)]
    pub(crate) fn list<L: Lanes>(&self, rays: &Rays, limit: Option<&Floats>, list: &mut Words) -> Culled {
        L::call(Listing { culling: self, rays, limit, list })
    }

    /// Takes walls out of the first `count` places of a list that has all; returns how many are left.
    pub(crate) fn take_out(&self, walls: u32, list: &mut Words, count: usize) -> usize {
        if walls == 0 { count } else { self.walls.take_out(walls, list, count) }
    }

    /// Bytes of memory held.
    pub(crate) fn bytes(&self) -> usize {
        let [x, y, z] = &self.center;
        let [all, casting] = &self.radius;
        let balls = [x, y, z, all, casting].iter().map(|values| size_of_val(&values[..])).sum::<usize>();
        balls + self.walls.bytes()
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
    type Output = Culled;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Culled {
        let Self { culling, rays, limit, list } = self;
        if culling.most == 0 {
            return Culled::NOTHING;
        }
        let mut first = 0;
        if let Some(t) = limit {
            while first < rays.count && t[first] < 0.0 {
                first += 1;
            }
        }
        if first == rays.count {
            return Culled { listed: Some(0), behind: 0 };
        }
        let Some(shaft) = Shaft::around::<L>(culling.extent, rays, limit, first) else {
            return Culled::NOTHING;
        };
        let listed = culling.inside::<L>(&shaft, limit.is_some(), list);
        // Few walls cast shadows.
        let behind = if limit.is_some() { 0 } else { culling.walls.behind::<L>(&shaft) };
        Culled { listed, behind }
    }
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
        let listing = Listing { culling: &culling, rays: &rays, limit, list: &mut list };
        let Culled { listed, behind } = lanes::dispatch(lanes::LaneKind::Emulated, listing);
        let count = culling.take_out(behind, &mut list, listed?);
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
