//! The memory layouts of pixels and visible points in the paper's stages.

mod columns;
mod gathered;
mod layout;
mod lines;
mod scalar;

pub(crate) use columns::Columns;
pub(crate) use layout::{PixelState, Pixels, Seen};
pub(crate) use lines::{Line8, Line16, Lines};
pub(crate) use scalar::{Objects, ScalarPixels, TypedArrays};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flux::IntegerSums;

    /// Of which layouts with lanes have 128 in a column, a power of two, and 112 elsewhere, whole vectors.
    const PIXELS: usize = 100;

    fn bytes<P: Pixels>(are_integers: bool) -> usize {
        P::new(PIXELS, 1.0, IntegerSums::new(PIXELS, are_integers)).bytes()
    }

    #[test]
    fn layouts_tell_all_that_they_hold() {
        // Radius and N, light, flux and throughput by channels, four sums, and an intersection: four vectors, the sphere and
        // a flag.
        let object = 8 + 36 + 16 + 56;
        assert_eq!(bytes::<ScalarPixels<Objects>>(false), PIXELS * object);
        // Another flag.
        assert_eq!(bytes::<ScalarPixels<TypedArrays<[f32; 3]>>>(false), PIXELS * (object + 1));
        let (film, sums) = (128 * (8 + 36), 112 * 16);
        assert_eq!(bytes::<Columns>(false), film + sums + 128 * (4 * 12 + 4));
        // Lines of 64 or 32 bytes, which may begin 32 later; spheres stand apart or in them.
        assert_eq!(bytes::<Lines<Line16>>(false), film + sums + 112 * 64 + 32 + 128 * 4);
        assert_eq!(bytes::<Lines<Line8>>(false), film + sums + 112 * 32 + 32);
    }

    #[test]
    fn integer_sums_are_held_as_well() {
        let more = |bytes: fn(bool) -> usize| bytes(true) - bytes(false);
        let layouts = [
            bytes::<ScalarPixels<Objects>>,
            bytes::<ScalarPixels<TypedArrays<glam::Vec3A>>>,
            bytes::<Columns>,
            bytes::<Lines<Line16>>,
            bytes::<Lines<Line8>>,
        ];
        assert_eq!(layouts.map(more), [112 * 4 * 8; 5]);
    }
}
