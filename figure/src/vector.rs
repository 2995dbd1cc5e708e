//! Vectors of scenes.

use glam::{DVec3, Vec3};

/// A vector in single precision, without negative zeros: scene files have none.
pub(crate) fn single(v: DVec3) -> Vec3 {
    v.as_vec3() + Vec3::ZERO
}
