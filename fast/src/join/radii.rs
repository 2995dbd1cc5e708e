//! Search radii of an iteration, and the size of cells that suits them.

use super::cells::WINDOW;
use crate::pixels::{GROUP, Pixel};
use lanes::Lanes;
use rayon::prelude::*;

/// The search radii of an iteration.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Radii {
    pub(crate) largest: f32,
    /// The quadratic mean over pixels that have counted photons; the largest, if there is no such pixel.
    typical: f32,
}

impl Radii {
    /// Those of pixels, `per_job` in a work item: as many as in those of a join, so that these are the same bits.
    pub(crate) fn of(pixels: &[Pixel], per_job: usize) -> Self {
        let sums: Vec<RadiiSums> = pixels.par_chunks(per_job).map(RadiiSums::of).collect();
        Self::of_sums(&sums)
    }

    /// Those of the pixels in all of these sums. It depends on their order.
    pub(crate) fn of_sums<'a>(all: impl IntoIterator<Item = &'a RadiiSums>) -> Self {
        let (mut largest, mut sum, mut count) = (0.0_f32, 0.0, 0);
        for sums in all {
            largest = sums.largest.into_iter().fold(largest, f32::max);
            sum += sums.sums.into_iter().map(f64::from).sum::<f64>();
            count += sums.count;
        }
        // No mean is above the largest, but sums may be rounded up, or be too large to be numbers.
        let typical = if count > 0 { ((sum / f64::from(count)) as f32).min(largest) } else { largest };
        Self { largest: largest.sqrt(), typical: typical.sqrt() }
    }

    /// The same radius in all pixels.
    pub(crate) fn global(radius_squared: f32) -> Self {
        let radius = radius_squared.sqrt();
        Self { largest: radius, typical: radius }
    }

    /// The size of the join's cells where `neighbours` photons count at a visible point; `for_one` is their size over the
    /// typical radius where one photon counts.
    pub(crate) fn cell_size(self, for_one: f32, neighbours: f64) -> f32 {
        self.cell_of(size_over_radius(for_one, neighbours))
    }

    /// `size` times the typical radius. But a single visible point spans twice its radius, and for the largest radius
    /// that must fit into the window (unless coordinates are so large that they round to many cells).
    fn cell_of(self, size: f32) -> f32 {
        const LEAST: f32 = 2.0 / (WINDOW - 3) as f32;
        (self.typical * size).max(self.largest * LEAST)
    }
}

/// The best size of cells over the typical radius falls with the fourth root of the photons that count at a point:
/// `ARCHITECTURE.md` has the measurements.
fn size_over_radius(for_one: f32, neighbours: f64) -> f32 {
    (f64::from(for_one) / neighbours.max(0.1).sqrt().sqrt()).clamp(1.0, 6.0) as f32
}

/// The squared radii of some pixels. Apart for the pixels of a group, so that the sums are the same whatever the lanes.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct RadiiSums {
    largest: [f32; GROUP],
    /// Of the pixels that have counted photons.
    sums: [f32; GROUP],
    /// How many these are.
    count: u32,
}

impl RadiiSums {
    /// Those of pixels, by groups.
    fn of(pixels: &[Pixel]) -> Self {
        let mut all = Self::default();
        for group in pixels.chunks(GROUP) {
            for (at, pixel) in group.iter().enumerate() {
                all.add_one(at, pixel);
            }
        }
        all
    }

    /// Adds a pixel, which is number `at` of its group.
    fn add_one(&mut self, at: usize, Pixel { n, radius_squared, .. }: &Pixel) {
        let counts = *n > 0.0;
        self.largest[at] = self.largest[at].max(*radius_squared);
        self.sums[at] += if counts { *radius_squared } else { 0.0 };
        self.count += u32::from(counts);
    }

    /// Adds the pixels of a group from number `at` on, by the photons they have counted and their squared radii.
    #[inline(always)]
    pub(crate) fn add<L: Lanes>(&mut self, at: usize, n: L::F, radius_squared: L::F) {
        let (counts, largest, sums) = (L::lt(L::f(0.0), n), &mut self.largest[at..], &mut self.sums[at..]);
        L::store(L::max(L::load(largest), radius_squared), largest);
        L::store(L::load(sums) + L::select(counts, radius_squared, L::f(0.0)), sums);
        self.count += L::mask_bits(counts).count_ones();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lanes::{Kernel, LaneKind, dispatch};

    const PER_JOB: usize = 1024;

    /// Adds pixels in lanes.
    struct Add<'a>(&'a [Pixel]);

    impl Kernel for Add<'_> {
        type Output = RadiiSums;
        fn run<L: Lanes>(self) -> RadiiSums {
            let mut all = RadiiSums::default();
            for group in self.0.chunks(GROUP) {
                for at in (0..GROUP).step_by(L::N) {
                    let column = |value: fn(&Pixel) -> f32| {
                        let values: Vec<f32> = group[at..].iter().map(value).collect();
                        L::load(&values)
                    };
                    all.add::<L>(at, column(|pixel| pixel.n), column(|pixel| pixel.radius_squared));
                }
            }
            all
        }
    }

    #[test]
    fn lanes_add_what_pixels_add_one_by_one() {
        let pixel = |k: u32| Pixel { n: (k % 3) as f32, ..Pixel::new(1.0 / (1.0 + k as f32)) };
        let pixels: Vec<Pixel> = (0..5 * GROUP as u32).map(pixel).collect();
        let expected = RadiiSums::of(&pixels);
        assert_eq!(expected.count, pixels.iter().filter(|pixel| pixel.n > 0.0).count() as u32);
        for lanes in LaneKind::ALL {
            assert_eq!(dispatch(lanes, Add(&pixels)), expected, "{lanes:?}");
        }
    }

    /// Sums of squares that are too large are no reason for cells of infinite size.
    #[test]
    fn the_typical_radius_is_a_number() {
        let pixels = vec![Pixel { n: 1.0, ..Pixel::new(1e19) }; 100 * GROUP];
        let Radii { largest, typical } = Radii::of(&pixels, PER_JOB);
        assert_eq!((largest, typical), (1e19, 1e19));
    }

    #[test]
    fn cells_shrink_as_more_photons_count() {
        assert_eq!([1.0, 16.0, 1e9].map(|neighbours| size_over_radius(5.0, neighbours)), [5.0, 2.5, 1.0]);
        assert_eq!(size_over_radius(12.0, 0.0), 6.0);
    }

    #[test]
    fn typical_radii_are_those_of_pixels_that_count_photons() {
        let pixel = |n, radius: f32| Pixel { n, ..Pixel::new(radius) };
        // In three chunks, the last of which is short.
        let mut pixels = vec![pixel(0.0, 9.0); 2 * PER_JOB + 5];
        for at in [1, PER_JOB + 2, 2 * PER_JOB] {
            pixels[at] = pixel(3.0, 2.0);
        }
        let Radii { largest, typical } = Radii::of(&pixels, PER_JOB);
        assert_eq!((largest, typical), (9.0, 2.0));
        let Radii { largest, typical } = Radii::of(&pixels[3..9], PER_JOB);
        assert_eq!((largest, typical), (9.0, 9.0));
    }

    #[test]
    fn cells_fit_the_typical_radius_but_hold_the_largest_in_a_window() {
        assert_eq!(Radii { largest: 1.0, typical: 0.5 }.cell_of(5.0), 2.5);
        assert_eq!(Radii { largest: 10.0, typical: 0.5 }.cell_of(5.0), 4.0);
    }
}
