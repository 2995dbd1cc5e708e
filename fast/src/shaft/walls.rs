//! Which walls can the rays of a shaft not meet first? Of a room most lie behind the rays, or to their sides.
//!
//! ```text
//! for each wall within which all rays begin: the least s at which the ball of the shaft lies beyond it
//! all rays are beyond some wall at the least s of all walls
//! drop the walls within which the ball of the shaft lies at 0 and at that s
//! ```
//!
//! Why the walls dropped are met by no ray first. The part of a ray up to s begins and ends within such a wall, which is
//! convex. By then it has met the wall that the ball lies beyond. Rays that leave a wall begin on it, not within.
//!
//! "Within" and "beyond" are by [`MARGIN`], for roundings. Let u = 2^-24, and `scale` be as for balls. The power of a point
//! is wrong by 8u |g| R, with g from the anchor to it, so its distance from a wall of radius R by 4u |g|: nothing to the
//! margin m, |g| / 512 and more. What the reference computes for the distance t to a wall is wrong by 3u R, the error of b, over
//! the root of 2 R m, or less. With t below 7 `scale` and R at most 1024 `scale` ([`LARGEST`]) this is a third of m. So
//! distances to walls that are dropped, and to the one beyond which the rays are, keep their order.

use super::hull::Shaft;
use crate::paths::least;
use crate::shapes::Shape;
use lanes::{Lanes, MOST_LANES, V3};
use scene::still::Enclosure;

/// See above.
const MARGIN: f32 = 1.0 / 512.0;
/// Walls of a larger radius, over the scale, are met by all rays.
const LARGEST: f32 = 1024.0;
/// How far rays are followed, over the length of the shaft.
const FARTHEST: f32 = 2.0;
/// The most walls that may be dropped.
const MOST_WALLS: usize = 32;

/// The first walls of a scene, as a structure of arrays, filled up to whole vectors.
#[derive(Debug, Default)]
pub(super) struct Walls {
    /// Their places among the shapes, in ascending order.
    places: Vec<u32>,
    /// As [`Enclosure`] has them.
    anchor: [Vec<f32>; 3],
    offset: [Vec<f32>; 3],
    power: Vec<f32>,
    /// NaN where there is no wall.
    radius: Vec<f32>,
}

/// Where the shaft is, as walls see it.
struct Places<L: Lanes> {
    /// From the anchors to the centre of the first ball.
    start: V3<L>,
    margin: L::F,
    /// The walls within which all rays begin.
    are_around: L::M,
    /// Where along the shaft its ball lies beyond the walls, if they are around.
    beyond: L::F,
}

impl Walls {
    pub(super) fn new(shapes: &[Shape]) -> Self {
        let wall = |(place, shape): (u32, &Shape)| match shape {
            Shape::Enclosure(enclosure) => Some((place, *enclosure)),
            _ => None,
        };
        let (places, walls): (Vec<u32>, Vec<Enclosure>) =
            (0..).zip(shapes).filter_map(wall).take(MOST_WALLS).unzip();
        let filled = |value: &dyn Fn(&Enclosure) -> f32| {
            let mut values: Vec<f32> = walls.iter().map(value).collect();
            values.resize(values.len().next_multiple_of(MOST_LANES), f32::NAN);
            values
        };
        Self {
            anchor: std::array::from_fn(|axis| filled(&|wall| wall.anchor[axis])),
            offset: std::array::from_fn(|axis| filled(&|wall| wall.offset[axis])),
            power: filled(&|wall| wall.power),
            radius: filled(&|wall| -1.0 / wall.minus_inverse_radius),
            places,
        }
    }

    /// The walls that no ray of the shaft meets first: bit k is the k-th.
    #[inline(always)]
    pub(super) fn behind<L: Lanes>(&self, shaft: &Shaft) -> u32 {
        let mut end = L::f(f32::INFINITY);
        for at in (0..self.radius.len()).step_by(L::N) {
            let places = self.places_of::<L>(shaft, at);
            end = L::min(L::select(places.are_around, places.beyond, L::f(f32::INFINITY)), end);
        }
        let end = least::<L>(end);
        if end > FARTHEST {
            return 0;
        }
        let mut behind = 0;
        for at in (0..self.radius.len()).step_by(L::N) {
            let Places { start, margin, are_around, .. } = self.places_of::<L>(shaft, at);
            let from_anchor = start + V3::splat(shaft.axis * end);
            let power = self.power_of::<L>(from_anchor, at);
            let inset = L::f(shaft.radius_at(end)) + margin;
            // The distance from the wall is at least that over its diameter.
            let ends_within = L::le(inset * self.diameter::<L>(at), -power);
            behind |= L::mask_bits(are_around & ends_within) << at;
        }
        behind
    }

    /// The walls from `at` on.
    #[inline(always)]
    fn places_of<L: Lanes>(&self, shaft: &Shaft, at: usize) -> Places<L> {
        let start = V3::splat(shaft.start) - load::<L>(&self.anchor, at);
        let margin = L::f(MARGIN) * (L::f(shaft.scale) + L::sqrt(start.dot(start)));
        let from_center = start + load::<L>(&self.offset, at);
        let radius = L::load(&self.radius[at..]);
        let distance = L::sqrt(from_center.dot(from_center));
        // Negative within. Along the axis it grows by `rate` at least, as the distance from a point is convex.
        let height = self.power_of::<L>(start, at) / (distance + radius);
        let rate = from_center.dot(V3::splat(shaft.axis)) / distance;
        let (near, growth) = (L::f(shaft.radius), L::f(shaft.growth));
        let is_known = L::le(radius, L::f(LARGEST * shaft.scale));
        let are_around = is_known & L::le(near + margin, -height);
        // See `Shaft::radius_at`.
        let within_shaft = (margin + near - height) / (rate - growth);
        let past_it = (margin - near - height) / (rate - growth - (near + near));
        let is_within = L::lt(growth, rate) & L::le(within_shaft, L::f(1.0));
        let is_past = L::lt(growth + (near + near), rate);
        let past_it = L::select(is_past, past_it, L::f(f32::INFINITY));
        Places { start, margin, are_around, beyond: L::select(is_within, within_shaft, past_it) }
    }

    /// The power of points, from their vectors from the anchors, with respect to the walls from `at` on.
    #[inline(always)]
    fn power_of<L: Lanes>(&self, from_anchor: V3<L>, at: usize) -> L::F {
        let offset = load::<L>(&self.offset, at);
        from_anchor.dot(from_anchor + (offset + offset)) + L::load(&self.power[at..])
    }

    #[inline(always)]
    fn diameter<L: Lanes>(&self, at: usize) -> L::F {
        let radius = L::load(&self.radius[at..]);
        radius + radius
    }

    /// Takes the places of these walls out of the first `count` of a list, which has those of all; returns how many are left.
    pub(super) fn take_out(&self, walls: u32, list: &mut [u32], count: usize) -> usize {
        let (mut kept, mut next) = (0, 0);
        for k in 0..count {
            let place = list[k];
            let is_wall = self.places.get(next) == Some(&place);
            let is_out = is_wall && walls >> next & 1 == 1;
            next += usize::from(is_wall);
            list[kept] = place;
            kept += usize::from(!is_out);
        }
        kept
    }

    /// Bytes of memory held.
    pub(super) fn bytes(&self) -> usize {
        let floats = self.anchor.iter().chain(&self.offset).chain([&self.power, &self.radius]);
        size_of_val(&self.places[..]) + floats.map(|values| size_of_val(&values[..])).sum::<usize>()
    }
}

#[inline(always)]
fn load<L: Lanes>([x, y, z]: &[Vec<f32>; 3], at: usize) -> V3<L> {
    V3::new(L::load(&x[at..]), L::load(&y[at..]), L::load(&z[at..]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use lanes::{Kernel, LaneKind, dispatch};
    use scene::{Rgb, Sphere, Vec3};

    /// A room of 20 x 20 x 20 around the origin, by walls of this radius: left, right, bottom, top, back, front. There is a ball
    /// before the walls, and one among them.
    fn room(radius: f32) -> Vec<Shape> {
        let mut scene = files::builtin::scene("cornell").unwrap();
        scene.camera.eye = Vec3::ZERO;
        let sphere = |center, radius| Sphere {
            center,
            velocity: Vec3::ZERO,
            radius,
            material: 0,
            emission: Rgb::ZERO,
        };
        let ways = Vec3::AXES.into_iter().flat_map(|axis| [-axis, axis]);
        let mut spheres: Vec<Sphere> = ways.map(|way| sphere(way * (10.0 - radius), radius)).collect();
        spheres.insert(2, sphere(Vec3::ONE, 1.0));
        spheres.insert(0, sphere(Vec3::NEG_ONE, 1.0));
        scene.spheres = spheres.into();
        let still = scene.at(0.0);
        (0..8).map(|id| Shape::of(&still, id)).collect()
    }

    struct Behind<'a>(&'a Walls, &'a Shaft);

    impl Kernel for Behind<'_> {
        type Output = u32;
        #[inline(always)]
        fn run<L: Lanes>(self) -> u32 {
            self.0.behind::<L>(self.1)
        }
    }

    /// The walls that a shaft between two balls may meet first.
    fn ahead(walls: &Walls, (start, radius): (Vec3, f32), (end, end_radius): (Vec3, f32)) -> Vec<u32> {
        let (axis, growth) = (end - start, end_radius - radius);
        let shaft = Shaft { start, axis, scale: 32.0, inverse: 1.0 / axis.length_squared(), radius, growth };
        let behind = dispatch(LaneKind::Emulated, Behind(walls, &shaft));
        (0..6).filter(|wall| behind >> wall & 1 == 0).collect()
    }

    #[test]
    fn walls_that_rays_do_not_meet_first_are_behind() {
        const RIGHT: u32 = 1;
        const TOP: u32 = 3;
        let walls = Walls::new(&room(1e4));
        let right = (Vec3::X * 16.0, 1.0);
        assert_eq!(ahead(&walls, (Vec3::ZERO, 0.0), right), [RIGHT]);
        // As far as twice the length of the shaft.
        assert_eq!(ahead(&walls, (Vec3::ZERO, 0.0), (Vec3::X * 6.0, 0.1)), [RIGHT]);
        assert_eq!(ahead(&walls, (Vec3::ZERO, 0.0), (Vec3::X * 4.0, 0.1)).len(), 6);
        // Towards an edge, and beside it.
        assert_eq!(ahead(&walls, (Vec3::ZERO, 0.0), (Vec3::new(16.0, 16.0, 0.0), 0.5)), [RIGHT, TOP]);
        assert_eq!(ahead(&walls, (Vec3::ZERO, 0.0), (Vec3::new(16.0, 11.0, 0.0), 0.5)), [RIGHT]);
        // So wide that some rays meet the top.
        assert_eq!(ahead(&walls, (Vec3::Y * 5.0, 4.0), (Vec3::new(16.0, 9.0, 0.0), 4.0)), [RIGHT, TOP]);
        assert_eq!(ahead(&walls, (Vec3::Y * 5.0, 0.5), (Vec3::new(16.0, 5.0, 0.0), 6.0)), [RIGHT, TOP]);
        // Rays that come together at the second ball part again.
        let (high, parting) = (Vec3::Y * 8.45, Vec3::new(6.0, 8.65, 0.0));
        assert_eq!(ahead(&walls, (high, 1.3), (parting, 0.1)), [RIGHT, TOP]);
        // From the top, rays may leave it as they go.
        assert_eq!(ahead(&walls, (Vec3::Y * 10.0, 0.0), (Vec3::new(16.0, 5.0, 0.0), 0.5)), [RIGHT, TOP]);
        // From beyond the room nothing is known.
        assert_eq!(ahead(&walls, (Vec3::X * -20.0, 0.0), right), [0, RIGHT]);
    }

    #[test]
    fn walls_too_large_for_their_roundings_are_ahead() {
        for (radius, count) in [(3.2e4, 1), (3.4e4, 6)] {
            let walls = Walls::new(&room(radius));
            assert_eq!(ahead(&walls, (Vec3::ZERO, 0.0), (Vec3::X * 16.0, 1.0)).len(), count, "{radius}");
        }
    }

    #[test]
    fn places_of_walls_are_taken_out_and_others_stay() {
        let walls = Walls::new(&room(1e3));
        assert_eq!(walls.places, [1, 2, 4, 5, 6, 7]);
        assert_eq!(walls.bytes(), 6 * 4 + 8 * MOST_LANES * 4);
        let mut list = [0, 1, 2, 3, 4, 5, 6, 7, 9];
        let count = walls.take_out(0b101_010, &mut list, 8);
        assert_eq!(list[..count], [0, 1, 3, 4, 6]);
        assert_eq!(walls.take_out(0b111_111, &mut [1, 2, 4, 5, 6, 7], 6), 0);
    }
}
