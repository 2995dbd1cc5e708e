//! The nearest place of a camera from which a frame holds all balls.

use glam::DVec3;

/// The directions of a camera: unit vectors to the right and to the top of the image, and the one it looks along.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Axes {
    pub(crate) right: DVec3,
    pub(crate) up: DVec3,
    pub(crate) forward: DVec3,
}

/// The eye from which all `balls`, centres with radii, are within a frame whose half width and half height at distance 1
/// are `half`, such that one of them touches each side of the frame that is tight, and both sides of the other pair are
/// equally far.
///
/// A ball is on the inner side of a plane through the eye if its centre is at least a radius away from the plane. With the
/// unit normal n of the plane that is n e <= min(n c - r): four linear bounds of the eye e, one per side of the frame, of
/// which those of opposite sides differ in the sign of one coordinate.
pub(crate) fn eye(axes: &Axes, half: [f64; 2], balls: impl Iterator<Item = (DVec3, f64)>) -> DVec3 {
    let sides = half.map(|tangent| {
        let length = (1.0 + tangent * tangent).sqrt();
        (1.0 / length, tangent / length) // cosine and sine of half the angle of view
    });
    let mut bounds = [[f64::INFINITY; 2]; 2];
    for (center, radius) in balls {
        let ahead = center.dot(axes.forward);
        for ((bounds, (cosine, sine)), across) in bounds.iter_mut().zip(sides).zip([axes.right, axes.up]) {
            let aside = center.dot(across);
            for (bound, sign) in bounds.iter_mut().zip([-1.0, 1.0]) {
                *bound = bound.min(sine * ahead + sign * cosine * aside - radius);
            }
        }
    }
    let [x, y] = [0, 1].map(|i| (bounds[i][1] - bounds[i][0]) / (2.0 * sides[i].0));
    let [zx, zy] = [0, 1].map(|i| (bounds[i][0] + bounds[i][1]) / (2.0 * sides[i].1));
    axes.right * x + axes.up * y + axes.forward * zx.min(zy)
}

/// How far a ball reaches towards the nearest side of the frame: 1 if it touches a side, above 1 if it is cut.
#[cfg(test)]
pub(crate) fn reach(axes: &Axes, half: [f64; 2], eye: DVec3, (center, radius): (DVec3, f64)) -> f64 {
    let d = center - eye;
    let ahead = d.dot(axes.forward);
    let mut most = f64::NEG_INFINITY;
    for (tangent, across) in half.into_iter().zip([axes.right, axes.up]) {
        for sign in [-1.0, 1.0] {
            // The extreme tangent of the cone of tangents from the eye, in the plane of `across` and `forward`.
            let aside = sign * d.dot(across);
            let squared = aside * aside + ahead * ahead;
            let along = (squared - radius * radius).max(0.0).sqrt();
            let [x, z] = [aside * along + ahead * radius, ahead * along - aside * radius];
            most = most.max(if z > 0.0 { x / z / tangent } else { f64::INFINITY });
        }
    }
    most
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Rounding in `f64`, at distances of up to a thousand times the size.
    const TOLERANCE: f64 = 1e-9;

    proptest! {
        #[test]
        fn every_ball_is_within_the_frame_and_two_sides_are_touched(
            balls in prop::collection::vec((prop::array::uniform3(-10.0..10.0), 0.01..5.0_f64), 1..30),
            half in (0.05..2.0_f64, 0.05..2.0_f64),
            turn in prop::array::uniform3(-3.0..3.0_f64),
        ) {
            let turn = glam::DMat3::from_euler(glam::EulerRot::XYZ, turn[0], turn[1], turn[2]);
            let axes = Axes { right: turn.col(0), up: turn.col(1), forward: turn.col(2) };
            let half = [half.0, half.1];
            let balls: Vec<_> = balls.iter().map(|(p, r)| (DVec3::from_array(*p), *r)).collect();
            let eye = eye(&axes, half, balls.iter().copied());
            let most = balls.iter().map(|&ball| reach(&axes, half, eye, ball)).fold(0.0, f64::max);
            prop_assert!((most - 1.0).abs() < TOLERANCE, "{most}");
        }
    }
}
