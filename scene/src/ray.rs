//! Rays.

use glam::Vec3;

/// The name of a surface in [`crate::Still::spheres`]; [`NO_SPHERE`] stands for none.
pub type SphereId = u32;

/// "On no sphere": the id that a camera ray leaves from, and that a ray which escapes arrives at.
pub const NO_SPHERE: SphereId = u32::MAX;

/// A half line `origin + t * direction`, `t > 0`, that knows which surface it starts on.
///
/// Knowing the surface replaces the epsilon that renderers add to ray origins: on the sphere that a ray leaves,
/// one root of the intersection is zero by definition, at every scale (see `reference::intersect`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where the ray starts, in scene units.
    pub origin: Vec3,
    /// Where it goes; of unit length to within rounding.
    pub direction: Vec3,
    /// The sphere that `origin` lies on, or [`NO_SPHERE`].
    pub leaves: SphereId,
}
