//! Maps uniform random numbers to directions and points. Each map states its density; all preserve stratification.

use scene::Vec3;
use std::f32::consts::FRAC_PI_2;

/// `(sin, cos)` of `2 pi u` for `u` in [0, 1), by one polynomial each after reduction to an eighth of a turn.
///
/// The coefficients are those of `sinf` and `cosf` in Moshier's Cephes library. The error is at most 1.2e-7.
pub fn sincos_turn(u: f32) -> (f32, f32) {
    let quarters = u * 4.0;
    let quadrant = (quarters + 0.5) as i32;
    let x = (quarters - quadrant as f32) * FRAC_PI_2;
    let x2 = x * x;
    let sine = x + x * x2 * (-1.666_665_5e-1 + x2 * (8.332_161e-3 + x2 * -1.951_529_6e-4));
    let cosine = 1.0 - 0.5 * x2 + x2 * x2 * (4.166_664_6e-2 + x2 * (-1.388_731_6e-3 + x2 * 2.443_315_7e-5));
    let (s, c) = if quadrant & 1 == 1 { (cosine, sine) } else { (sine, cosine) };
    let negate_s = quadrant & 2 == 2;
    let negate_c = (quadrant + 1) & 2 == 2;
    (if negate_s { -s } else { s }, if negate_c { -c } else { c })
}

/// A point of the unit sphere, uniformly: density `1 / (4 pi)` per steradian.
pub fn uniform_sphere(u: f32, v: f32) -> Vec3 {
    let (sin, cos) = sincos_turn(v);
    let r = 2.0 * (u * (1.0 - u)).sqrt();
    Vec3::new(r * cos, r * sin, 1.0 - 2.0 * u)
}

/// A unit direction about the unit normal `n`, density `cos / pi` per steradian.
///
/// The direction is that of `n` plus a uniform point of the unit sphere. A sphere that touches the surface, sampled
/// uniformly and seen from the point of contact, has this density. No frame around `n` is needed.
pub fn cosine_hemisphere(n: Vec3, u: f32, v: f32) -> Vec3 {
    let w = n + uniform_sphere(u, v);
    let length_squared = w.dot(w);
    // The point opposite to n gives no direction; any will do, but its length must be 1.
    if length_squared < 1e-10 { n } else { w * (1.0 / length_squared.sqrt()) }
}

/// A uniform unit direction in the cone of angles to the unit `axis` for which `1 - cos` is at most `height`: density
/// `1 / (2 pi height)` per steradian. Also returns `1 - cos` of its angle.
pub fn uniform_cone(axis: Vec3, height: f32, u: f32, v: f32) -> (Vec3, f32) {
    let (sin, cos) = sincos_turn(v);
    let h = u * height;
    let r = (h * (2.0 - h)).sqrt();
    let (s, t) = frame(axis);
    (s * (r * cos) + t * (r * sin) + axis * (1.0 - h), h)
}

/// A point of the unit disk, uniformly: density `1 / pi`.
pub fn uniform_disk(u: f32, v: f32) -> (f32, f32) {
    let (sin, cos) = sincos_turn(v);
    let r = u.sqrt();
    (r * cos, r * sin)
}

/// Two unit vectors that form a right-handed frame with the unit vector `n` (Duff et al., "Building an orthonormal
/// basis, revisited", JCGT 2017).
pub fn frame(n: Vec3) -> (Vec3, Vec3) {
    let sign = 1.0_f32.copysign(n.z);
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    (Vec3::new(1.0 + sign * (n.x * n.x * a), sign * b, -sign * n.x), Vec3::new(b, sign + n.y * n.y * a, -n.y))
}

/// `v` scaled to unit length.
pub fn unit(v: Vec3) -> Vec3 {
    v * (1.0 / v.dot(v).sqrt())
}
