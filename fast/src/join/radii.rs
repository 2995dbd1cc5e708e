//! Search radii of an iteration, and the size of cells that suits them.

use super::cells::WINDOW;
use crate::pixels::Pixel;
use rayon::prelude::*;

/// Pixels of a work item.
const PIXELS_AT_ONCE: usize = 4096;
/// Pixels that are summed apart.
const APART: usize = 4;

/// The search radii of an iteration.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Radii {
    pub(crate) largest: f32,
    /// The quadratic mean over pixels that have counted photons; the largest, if there is no such pixel.
    typical: f32,
}

impl Radii {
    pub(crate) fn of(pixels: &[Pixel]) -> Self {
        // Summed in the order of chunks, so that it does not depend on threads.
        let of_chunks: Vec<_> = pixels.par_chunks(PIXELS_AT_ONCE).map(Self::of_some).collect();
        let (mut largest, mut sum, mut count) = (0.0_f32, 0.0, 0.0);
        for (of_chunk, more, further) in of_chunks {
            (largest, sum, count) = (largest.max(of_chunk), sum + more, count + further);
        }
        let typical = if count > 0.0 { (sum / count).sqrt() as f32 } else { largest.sqrt() };
        Self { largest: largest.sqrt(), typical }
    }

    /// The same radius in all pixels.
    pub(crate) fn global(radius_squared: f32) -> Self {
        let radius = radius_squared.sqrt();
        Self { largest: radius, typical: radius }
    }

    /// The largest squared radius; and the sum and number of those of pixels that have counted photons.
    fn of_some(pixels: &[Pixel]) -> (f32, f64, f64) {
        // Apart for each of four pixels, as each addition waits for the one before.
        let (mut largest, mut sums, mut counts) = ([0.0_f32; APART], [0.0; APART], [0.0; APART]);
        for pixels in pixels.chunks(APART) {
            for (k, Pixel { n, radius_squared, .. }) in pixels.iter().enumerate() {
                largest[k] = if largest[k] < *radius_squared { *radius_squared } else { largest[k] };
                let count = if *n > 0.0 { 1.0 } else { 0.0 };
                sums[k] += count * f64::from(*radius_squared);
                counts[k] += count;
            }
        }
        (largest.into_iter().fold(0.0, f32::max), sums.iter().sum(), counts.iter().sum())
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_shrink_as_more_photons_count() {
        assert_eq!([1.0, 16.0, 1e9].map(|neighbours| size_over_radius(5.0, neighbours)), [5.0, 2.5, 1.0]);
        assert_eq!(size_over_radius(12.0, 0.0), 6.0);
    }

    #[test]
    fn typical_radii_are_those_of_pixels_that_count_photons() {
        let pixel = |n, radius: f32| Pixel { n, ..Pixel::new(radius) };
        // In three chunks, the last of which is short.
        let mut pixels = vec![pixel(0.0, 9.0); 2 * PIXELS_AT_ONCE + 5];
        for at in [1, PIXELS_AT_ONCE + 2, 2 * PIXELS_AT_ONCE] {
            pixels[at] = pixel(3.0, 2.0);
        }
        let Radii { largest, typical } = Radii::of(&pixels);
        assert_eq!((largest, typical), (9.0, 2.0));
        let Radii { largest, typical } = Radii::of(&pixels[3..9]);
        assert_eq!((largest, typical), (9.0, 9.0));
    }

    #[test]
    fn cells_fit_the_typical_radius_but_hold_the_largest_in_a_window() {
        assert_eq!(Radii { largest: 1.0, typical: 0.5 }.cell_of(5.0), 2.5);
        assert_eq!(Radii { largest: 10.0, typical: 0.5 }.cell_of(5.0), 4.0);
    }
}
