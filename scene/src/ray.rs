//! Rays, and the ids of the spheres that they start on.

use glam::Vec3;

/// The index of a sphere in [`crate::Still::spheres`], or [`NO_SPHERE`].
pub type SphereId = u32;

/// The id for "no sphere": what a camera ray starts on, and what a ray that escapes hits.
pub const NO_SPHERE: SphereId = u32::MAX;

/// A half line `origin + t * direction`, `t > 0`, with the surface that it starts on.
///
/// Knowing the surface replaces the epsilon by which renderers usually shift ray origins: for the sphere that a ray
/// leaves, one root of the intersection is zero by definition, at every scale (see `reference::intersect`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where the ray starts, in scene units.
    pub origin: Vec3,
    /// The direction, of unit length to within rounding.
    pub direction: Vec3,
    /// The sphere that `origin` lies on, or [`NO_SPHERE`].
    pub leaves: SphereId,
}
