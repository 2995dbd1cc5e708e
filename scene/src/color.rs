//! Colours: linear RGB.

use glam::Vec3;

/// A linear RGB triple (radiance, power or reflectance, per channel).
pub type Rgb = Vec3;

/// The largest of the three channels.
#[inline]
pub fn max_component(c: Rgb) -> f32 {
    let xy = if c.x > c.y { c.x } else { c.y };
    if xy > c.z { xy } else { c.z }
}
