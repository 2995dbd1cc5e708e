//! Grounds and enclosures: large spheres that the eye is close to or within. They are computed from an anchor, the point of the
//! sphere that is nearest to the eye.
//!
//! With `g = p - anchor`, the vector from the centre to a point p is `g + offset`, and the power of p (its squared distance
//! from the centre less the squared radius) is `g . (g + 2 offset)`, plus that of the anchor. Both stay accurate to about
//! 1e-6 of the distances in the picture, whatever the radius. At a radius of 10^4, `|p - centre|^2 - radius^2` in `f32` is
//! wrong by 10 square units, and points `centre + normal * radius` are a thousandth apart.

use crate::ray::SphereId;
use crate::sphere::Sphere;
use glam::{DVec3, Vec3};

/// An opaque sphere is a ground if its radius is at least so many times the distance of the eye from its surface. Seen from
/// farther away, the formulas of balls are as exact.
pub const NEAR: f64 = 16.0;

/// What the intersection needs to know of a ground: an opaque sphere that is met from outside, and that the eye is close to
/// ([`NEAR`]).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ground {
    /// Which sphere this is.
    pub sphere: SphereId,
    /// The point of the sphere nearest to the eye, rounded. The ground is moved by that rounding, so that it goes through it.
    pub anchor: Vec3,
    /// From the centre to the anchor.
    pub offset: Vec3,
    /// Twice `offset`, exactly.
    pub twice_offset: Vec3,
    /// `1 / radius`: turns the vector from the centre into the normal on the outside.
    pub inverse_radius: f32,
}

/// What the intersection from inside needs to know of an enclosure: an opaque sphere around the eye.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Enclosure {
    /// Which sphere this is.
    pub sphere: SphereId,
    /// The point of the sphere nearest to the eye.
    pub anchor: Vec3,
    /// From the centre to the anchor.
    pub offset: Vec3,
    /// Twice `offset`, exactly.
    pub twice_offset: Vec3,
    /// The power of the (rounded) anchor with respect to the sphere: almost zero.
    pub power: f32,
    /// `-1 / radius`: turns the vector from the centre into the normal on the inside.
    pub minus_inverse_radius: f32,
    /// True if the enclosure can stand between a visible point and a light. It cannot if all lights lie within
    /// it, as then so do the segments: a ball is convex.
    pub casts_shadow: bool,
}

impl Ground {
    /// True if a sphere is a ground at this distance of the eye from its surface. What glows is none: light is sent to it and
    /// from it by the formulas of balls.
    pub(crate) fn is_near(gap: f64, s: &Sphere) -> bool {
        gap * NEAR <= f64::from(s.radius) && !s.is_emitter()
    }

    pub(crate) fn new(id: SphereId, s: &Sphere, eye: Vec3) -> Self {
        let (anchor, offset) = anchor(s, eye);
        let inverse_radius = (1.0 / f64::from(s.radius)) as f32;
        let offset = offset.as_vec3();
        Self { sphere: id, anchor, offset, twice_offset: 2.0 * offset, inverse_radius }
    }

    /// The power of a point with respect to the ground: `h (h + 2 radius)` at the height `h` over it.
    #[inline]
    pub fn power(&self, point: Vec3) -> f32 {
        let from_anchor = point - self.anchor;
        from_anchor.dot(from_anchor + self.twice_offset)
    }
}

impl Enclosure {
    pub(crate) fn new(id: SphereId, s: &Sphere, eye: Vec3) -> Self {
        let (anchor, offset) = anchor(s, eye);
        let radius = f64::from(s.radius);
        Self {
            sphere: id,
            anchor,
            offset: offset.as_vec3(),
            twice_offset: 2.0 * offset.as_vec3(),
            power: (offset.dot(offset) - radius * radius) as f32,
            minus_inverse_radius: (-1.0 / radius) as f32,
            casts_shadow: false,
        }
    }
}

/// The point of a sphere nearest to the eye, and the vector to it from the centre.
fn anchor(s: &Sphere, eye: Vec3) -> (Vec3, DVec3) {
    let center = s.center.as_dvec3();
    let to_eye = eye.as_dvec3() - center;
    let length = to_eye.dot(to_eye).sqrt();
    let outward = if length > 0.0 { to_eye / length } else { DVec3::X };
    let anchor = (center + outward * f64::from(s.radius)).as_vec3();
    (anchor, anchor.as_dvec3() - center)
}
