//! Finds where two engines first differ, by comparing the bits of every value of every plane.

use crate::bits::differing_values;
use scene::{Engine, Film, Plane, Rgb};
use std::fmt;

/// A kind of plane that engines provide: one value per pixel, or one per pixel and channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlaneKind {
    /// [`Engine::direct`].
    DirectLight,
    /// [`Engine::count`].
    Count,
    /// [`Engine::radius`].
    Radius,
    /// [`Engine::develop`].
    Image,
}

impl PlaneKind {
    /// All kinds, in the order of the passes that produce them.
    pub const ALL: [Self; 4] = [Self::DirectLight, Self::Count, Self::Radius, Self::Image];

    /// The name of the plane in messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::DirectLight => "direct light",
            Self::Count => "count",
            Self::Radius => "radius",
            Self::Image => "image",
        }
    }

    /// The pass whose faults show first in this plane.
    pub fn pass(self) -> &'static str {
        match self {
            Self::DirectLight => "camera pass",
            Self::Count => "photon pass",
            Self::Radius => "consolidate",
            // No other plane shows the flux of the pixels.
            Self::Image => "flux of the photon pass, or develop",
        }
    }
}

/// The values of one plane.
#[derive(Clone, Debug)]
pub struct EnginePlane {
    /// The kind of plane.
    pub kind: PlaneKind,
    /// Pixels in a row.
    pub width: u32,
    /// Values of a pixel: 3 for colours, else 1.
    pub channels: usize,
    /// Pixel by pixel, row by row from the top; none if the engine does not have this plane.
    pub values: Vec<f32>,
}

/// All planes of a render, in the order of [`PlaneKind::ALL`].
pub fn planes(engine: &(impl Engine + ?Sized)) -> [EnginePlane; 4] {
    let image = engine.develop();
    let width = image.width;
    let colors = |kind, film: Option<Film>| {
        let pixels = film.map_or(Vec::new(), |film| film.pixels);
        EnginePlane { kind, width, channels: 3, values: pixels.iter().flat_map(Rgb::to_array).collect() }
    };
    let numbers = |kind, plane: Option<Plane>| {
        let values = plane.map_or(Vec::new(), |plane| plane.values);
        EnginePlane { kind, width, channels: 1, values }
    };
    [
        colors(PlaneKind::DirectLight, engine.direct()),
        numbers(PlaneKind::Count, engine.count()),
        numbers(PlaneKind::Radius, engine.radius()),
        colors(PlaneKind::Image, Some(image)),
    ]
}

/// A difference between two planes of the same kind. `Display` writes a sentence with pass, plane, pixel, both values
/// and their bits.
#[derive(Clone, Copy, Debug)]
pub enum PlaneDifference {
    /// The planes have different numbers of values.
    Length {
        /// The plane.
        kind: PlaneKind,
        /// The expected number of values.
        expected: usize,
        /// The actual number.
        actual: usize,
    },
    /// A value differs in its bits.
    Value {
        /// The plane.
        kind: PlaneKind,
        /// Column of the pixel, from the left, from 0.
        x: usize,
        /// Row of the pixel, from the top, from 0.
        y: usize,
        /// The expected value.
        expected: f32,
        /// The actual value.
        actual: f32,
        /// How many values of the plane differ.
        count: usize,
    },
}

impl fmt::Display for PlaneDifference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Length { kind, expected, actual } => {
                write!(f, "{}: {} has {actual} values instead of {expected}", kind.pass(), kind.name())
            }
            Self::Value { kind, x, y, expected, actual, .. } => {
                let (have, want) = (actual.to_bits(), expected.to_bits());
                write!(
                    f,
                    "{}: {} of pixel ({x}, {y}) is {actual:?} ({have:#010x}) instead of {expected:?} ({want:#010x})",
                    kind.pass(),
                    kind.name()
                )
            }
        }
    }
}

/// The first difference of `actual` from `expected`. Both must have planes of the same kinds in the same order.
pub fn first_difference(expected: &[EnginePlane], actual: &[EnginePlane]) -> Option<PlaneDifference> {
    expected.iter().zip(actual).find_map(|(expected, actual)| difference(expected, actual))
}

fn difference(expected: &EnginePlane, actual: &EnginePlane) -> Option<PlaneDifference> {
    let EnginePlane { kind, width, channels, ref values } = *expected;
    if values.len() != actual.values.len() {
        let (expected, actual) = (values.len(), actual.values.len());
        return Some(PlaneDifference::Length { kind, expected, actual });
    }
    let mut differing = differing_values(values, &actual.values);
    let index = differing.next()?;
    let pixel = index / channels;
    Some(PlaneDifference::Value {
        kind,
        x: pixel % width as usize,
        y: pixel / width as usize,
        expected: values[index],
        actual: actual.values[index],
        count: 1 + differing.count(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plane(kind: PlaneKind, channels: usize, values: &[f32]) -> EnginePlane {
        EnginePlane { kind, width: 2, channels, values: values.to_vec() }
    }

    fn told(expected: &[EnginePlane], actual: &[EnginePlane]) -> Option<String> {
        first_difference(expected, actual).map(|difference| difference.to_string())
    }

    #[test]
    fn a_bit_is_found_with_its_pixel() {
        let image =
            |value| [plane(PlaneKind::Image, 3, &[[0.25; 9].as_slice(), &[value, 0.5, 0.5]].concat())];
        assert_eq!(told(&image(0.25), &image(0.25)), None);
        assert_eq!(
            told(&image(0.25), &image(f32::from_bits(0x3e80_0001))).as_deref(),
            Some(
                "flux of the photon pass, or develop: image of pixel (1, 1) is 0.25000003 (0x3e800001) instead of \
                 0.25 (0x3e800000)"
            )
        );
    }

    #[test]
    fn the_first_plane_with_a_difference_is_named() {
        let both = |count: [f32; 2], radius| {
            [plane(PlaneKind::Count, 1, &count), plane(PlaneKind::Radius, 1, &[radius])]
        };
        let expected = both([0.0, 1.0], 1.5);
        let difference = told(&expected, &both([0.0, 2.0], 1.25)).unwrap();
        assert!(difference.starts_with("photon pass: count of pixel (1, 0) is 2.0 ("), "{difference}");
        let difference = told(&expected, &both([0.0, 1.0], 1.25)).unwrap();
        assert!(difference.starts_with("consolidate: radius of pixel (0, 0) is 1.25 ("), "{difference}");
    }

    #[test]
    fn a_negative_zero_is_a_difference_and_nan_is_none() {
        let count = |values: &[f32]| [plane(PlaneKind::Count, 1, values)];
        assert!(matches!(
            first_difference(&count(&[0.0; 3]), &count(&[0.0, -0.0, -0.0])),
            Some(PlaneDifference::Value { x: 1, y: 0, count: 2, .. })
        ));
        assert_eq!(told(&count(&[f32::NAN]), &count(&[f32::NAN])), None);
    }

    #[test]
    fn a_missing_value_is_a_difference() {
        let count = |values: &[f32]| [plane(PlaneKind::Count, 1, values)];
        let difference = told(&count(&[0.0; 6]), &count(&[0.0; 5])).unwrap();
        assert_eq!(difference, "photon pass: count has 5 values instead of 6");
    }
}
