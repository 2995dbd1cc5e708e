//! Colours: linear RGB.

use glam::Vec3;

/// A linear RGB triple (radiance, power or reflectance, per channel).
pub type Rgb = Vec3;

/// A pixel of an image with alpha.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rgba {
    /// What the pixel adds to whatever is behind it: radiance times the share that is covered ("associated", or
    /// premultiplied).
    pub color: Rgb,
    /// The share of the pixel that is covered, from 0 to 1; filters with negative weights may leave this range.
    pub alpha: f32,
}

/// The largest of the three channels.
#[inline]
pub fn max_component(c: Rgb) -> f32 {
    let xy = if c.x > c.y { c.x } else { c.y };
    if xy > c.z { xy } else { c.z }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_brightest_channel_counts_wherever_it_is() {
        for (color, most) in [
            (Rgb::new(3.0, 2.0, 1.0), 3.0),
            (Rgb::new(1.0, 3.0, 2.0), 3.0),
            (Rgb::new(1.0, 2.0, 3.0), 3.0),
            (Rgb::new(2.0, 1.0, 3.0), 3.0),
            (Rgb::new(-3.0, -2.0, -1.0), -1.0),
            (Rgb::splat(2.0), 2.0),
        ] {
            assert_eq!(max_component(color), most);
        }
    }
}
