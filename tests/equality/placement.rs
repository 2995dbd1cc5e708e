//! Random placement of spheres: anywhere, as walls or shells, or relative to another sphere.

use proptest::prelude::*;
use scene::Vec3;

/// The placement of a sphere, possibly relative to another one.
#[derive(Clone, Debug)]
pub(crate) enum Placement {
    /// Anywhere near the origin.
    Loose { center: Vec3, radius: f32 },
    /// A solid wall, whose nearest point to the origin is on an axis at this distance.
    Wall { axis: Vec3, distance: f32, radius: f32 },
    /// A shell around the origin but not centred there, whose nearest point is on an axis at this distance.
    Shell { axis: Vec3, distance: f32, radius: f32 },
    /// Relative to an earlier sphere; if there is none, to a unit sphere at the origin.
    By { other: prop::sample::Index, direction: Vec3, relation: Relation },
}

/// The position of a sphere relative to another. `ratio` is the ratio of the radii.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Relation {
    /// Centre and radius are the same.
    Coincident,
    /// The spheres touch from outside, at one point.
    Touching { ratio: f32 },
    /// This sphere touches the other one from inside, at one point.
    TouchingWithin { ratio: f32 },
    /// The centre is the same.
    Concentric { ratio: f32 },
    /// The centre is on the other's surface.
    Sunk { ratio: f32 },
}

impl Placement {
    /// Centre and radius, given those of all earlier spheres.
    pub(crate) fn resolve(&self, before: &[(Vec3, f32)]) -> (Vec3, f32) {
        match self {
            Self::Loose { center, radius } => (*center, *radius),
            Self::Wall { axis, distance, radius } => (*axis * (distance + radius), *radius),
            Self::Shell { axis, distance, radius } => (*axis * (distance - radius), *radius),
            Self::By { other, direction, relation } => {
                let (center, radius) = if before.is_empty() { (Vec3::ZERO, 1.0) } else { *other.get(before) };
                let mine = |ratio: f32| (radius * ratio).clamp(1e-3, 1e5);
                match *relation {
                    Relation::Coincident => (center, radius),
                    Relation::Touching { ratio } => {
                        (center + *direction * (radius + mine(ratio)), mine(ratio))
                    }
                    Relation::TouchingWithin { ratio } => {
                        (center + *direction * (radius - mine(ratio)), mine(ratio))
                    }
                    Relation::Concentric { ratio } => (center, mine(ratio)),
                    Relation::Sunk { ratio } => (center + *direction * radius, mine(ratio)),
                }
            }
        }
    }
}

/// A number above 0 whose logarithm is distributed nearly uniformly: the bits of floats grow nearly as their logarithms. Without
/// the functions of a library, so that a number that is drawn is the same on every machine.
pub(crate) fn log_uniform(low: f32, high: f32) -> impl Strategy<Value = f32> + Clone {
    (low.to_bits()..high.to_bits()).prop_map(f32::from_bits)
}

/// A point in the cube from `-side` to `side`.
pub(crate) fn point(side: f32) -> impl Strategy<Value = Vec3> + Clone {
    [-side..side, -side..side, -side..side].prop_map(Vec3::from_array)
}

fn axis() -> impl Strategy<Value = Vec3> {
    prop::sample::select(vec![Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z])
}

fn direction() -> impl Strategy<Value = Vec3> {
    prop_oneof![axis(), point(1.0).prop_map(|v| v.normalize_or(Vec3::X))]
}

fn relation() -> impl Strategy<Value = Relation> {
    prop_oneof![
        1 => Just(Relation::Coincident),
        2 => log_uniform(0.02, 20.0).prop_map(|ratio| Relation::Touching { ratio }),
        1 => log_uniform(0.02, 1.0).prop_map(|ratio| Relation::TouchingWithin { ratio }),
        2 => log_uniform(0.5, 2.0).prop_map(|ratio| Relation::Concentric { ratio }),
        2 => log_uniform(0.02, 2.0).prop_map(|ratio| Relation::Sunk { ratio }),
    ]
}

/// Loose, or relative to another sphere.
pub(crate) fn among_others() -> impl Strategy<Value = Placement> {
    prop_oneof![
        10 => (point(5.0), log_uniform(0.05, 2.0)).prop_map(|(center, radius)| Placement::Loose { center, radius }),
        1 => (point(5.0), log_uniform(1e-3, 0.05)).prop_map(|(center, radius)| Placement::Loose { center, radius }),
        5 => (any::<prop::sample::Index>(), direction(), relation())
            .prop_map(|(other, direction, relation)| Placement::By { other, direction, relation }),
    ]
}

/// Walls and shells.
pub(crate) fn around_all() -> impl Strategy<Value = Placement> {
    let distance = 4.0..9.0_f32;
    let radius = prop_oneof![1 => Just(1e4), 2 => log_uniform(20.0, 1e4)];
    prop_oneof![
        (axis(), distance.clone(), radius).prop_map(|(axis, distance, radius)| Placement::Wall {
            axis,
            distance,
            radius
        }),
        (axis(), distance, log_uniform(8.0, 1e4)).prop_map(|(axis, distance, radius)| Placement::Shell {
            axis,
            distance,
            radius
        }),
    ]
}
