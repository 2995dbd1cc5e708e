//! Whether balls overlap.
//!
//! Balls are sorted into cubes by their centres: on a grid for each power of two of radii, which are wide enough that balls
//! which overlap are in neighbouring cubes. A cube holds few balls of its size that do not overlap, so that the search ends
//! soon if there are many, and takes n log n if there are none.

use glam::DVec3;
use rayon::prelude::*;
use scene::{Sphere, Vec3};
use std::collections::BTreeMap;

/// Balls that overlap by less than this only touch.
const TOUCHING: f32 = 0.999;

/// Bits of a cube's number along an axis.
const AXIS_BITS: u32 = 21;

/// Whether any two of `balls` overlap by more than they would if they touched but for rounding.
pub(crate) fn overlaps<'a>(balls: impl Iterator<Item = &'a Sphere>) -> bool {
    let mut by_size = BTreeMap::<i32, Vec<&Sphere>>::new();
    for ball in balls {
        by_size.entry(octave(ball.radius)).or_default().push(ball);
    }
    let all = || by_size.values().flatten().map(|ball| ball.center.as_dvec3());
    let low = all().fold(DVec3::INFINITY, DVec3::min);
    let extent = (all().fold(DVec3::NEG_INFINITY, DVec3::max) - low).max_element();
    by_size.iter().any(|(size, coarse)| {
        let grid = Grid::new(*size, low, extent, coarse);
        // Each ball meets those of its own size, itself among them, and larger ones.
        let meets_another = |place: &Place| grid.meets(place.center, place.radius, 2);
        grid.places.par_iter().any(meets_another)
            || by_size
                .range(..size)
                .any(|(_, balls)| balls.par_iter().any(|ball| grid.meets(ball.center, ball.radius, 1)))
    })
}

/// The exponent of a radius.
fn octave(radius: f32) -> i32 {
    (radius.to_bits() >> 23) as i32 - 127
}

/// Balls of radii from a power of two to the next, by the cubes that their centres are in.
struct Grid {
    low: DVec3,
    width: f64,
    /// Sorted by the cube.
    places: Vec<Place>,
}

/// A ball in its cube: a copy, as those of a cube are far from each other among all spheres.
struct Place {
    cube: u64,
    center: Vec3,
    radius: f32,
}

impl Grid {
    /// For points that are at most `extent` from `low` along each axis.
    fn new(size: i32, low: DVec3, extent: f64, balls: &[&Sphere]) -> Self {
        // The centres of a ball of this size and of one no larger, which overlap, are nearer than twice the largest radius;
        // and along an axis there are no more cubes than numbers, with one to spare on each side.
        let width = (4.0 * f64::powi(2.0, size)).max(extent / f64::from((1 << AXIS_BITS) - 4));
        let mut grid = Self { low, width, places: Vec::new() };
        let place = |ball: &&Sphere| {
            let Sphere { center, radius, .. } = **ball;
            Place { cube: number(grid.cube(center)), center, radius }
        };
        grid.places = balls.par_iter().map(place).collect();
        grid.places.par_sort_unstable_by_key(|place| place.cube);
        grid
    }

    /// The cube that a centre is in; the first is 1.
    fn cube(&self, center: Vec3) -> [u64; 3] {
        ((center.as_dvec3() - self.low) / self.width).to_array().map(|x| x as u64 + 1)
    }

    /// Whether a ball, which is no larger than those of the grid, overlaps at least `least` of them.
    fn meets(&self, center: Vec3, radius: f32, least: usize) -> bool {
        let [x, y, z] = self.cube(center);
        let overlaps = |place: &&Place| center.distance(place.center) < (radius + place.radius) * TOUCHING;
        let rows = (z - 1..=z + 1).flat_map(|z| (y - 1..=y + 1).map(move |y| [x, y, z]));
        rows.flat_map(|cube| self.row(cube).filter(overlaps)).nth(least - 1).is_some()
    }

    /// The balls in a cube and its neighbours along x.
    fn row(&self, [x, y, z]: [u64; 3]) -> impl Iterator<Item = &Place> {
        let (first, last) = (number([x - 1, y, z]), number([x + 1, y, z]));
        let start = self.places.partition_point(|place| place.cube < first);
        self.places[start..].iter().take_while(move |place| place.cube <= last)
    }
}

/// The number of a cube: those next to each other along x follow each other.
fn number([x, y, z]: [u64; 3]) -> u64 {
    z << (2 * AXIS_BITS) | y << AXIS_BITS | x
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use scene::Rgb;

    fn ball(center: [f32; 3], radius: f32) -> Sphere {
        Sphere { center: Vec3::from(center), velocity: Vec3::ZERO, radius, material: 0, emission: Rgb::ZERO }
    }

    /// As [`overlaps`], by comparing all with all.
    fn one_by_one(balls: &[Sphere]) -> bool {
        balls.iter().enumerate().any(|(i, a)| {
            balls[..i].iter().any(|b| a.center.distance(b.center) < (a.radius + b.radius) * TOUCHING)
        })
    }

    #[test]
    fn balls_that_touch_do_not_overlap() {
        for scale in [1e-12_f32, 1.0, 1e12] {
            let row = |gap: f32| -> Vec<Sphere> {
                (0..100).map(|i| ball([i as f32 * gap * scale, 0.0, -scale], scale)).collect()
            };
            assert!(!overlaps(row(2.0).iter()), "{scale}");
            assert!(overlaps(row(1.99).iter()), "{scale}");
        }
        assert!(!overlaps([].iter()) && !overlaps([ball([1.0; 3], 1e15)].iter()));
        // A speck within a giant, and one beside it.
        let giant = ball([0.0; 3], 1e6);
        assert!(overlaps([giant, ball([9e5, 0.0, 0.0], 1e-3)].iter()));
        assert!(!overlaps([giant, ball([2e6, 0.0, 0.0], 1e-3)].iter()));
    }

    #[test]
    fn millions_that_do_not_overlap_are_soon_told() {
        // A slab of which every ball has thousands of others at its x.
        let slab: Vec<Sphere> =
            (0..1 << 20).map(|i| ball([0.0, (i >> 10) as f32, (i & 1023) as f32], 0.49)).collect();
        assert!(!overlaps(slab.iter()));
    }

    proptest! {
        #[test]
        fn overlaps_are_those_that_all_pairs_tell(
            balls in prop::collection::vec((prop::array::uniform3(-50.0..50.0_f32), -6.0..4.0_f32), 0..12),
            scale in -20_i32..20,
        ) {
            let scale = (scale as f32).exp2();
            let balls: Vec<Sphere> =
                balls.into_iter().map(|(center, size)| ball(center.map(|x| x * scale), size.exp2() * scale)).collect();
            prop_assert_eq!(overlaps(balls.iter()), one_by_one(&balls));
        }
    }
}
