//! What photons are aimed at: a ball, crossed in some directions.

use glam::Vec3;

/// [`Target::height`] of all directions, whatever rounding.
pub(super) const ALL_DIRECTIONS: f32 = 3.0;

/// What photons are aimed at: a ball, and the directions in which it is to be crossed, a cap of the unit sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    /// Centre of the ball.
    pub center: Vec3,
    /// Its radius.
    pub radius: f32,
    /// The square of that.
    pub radius_squared: f32,
    /// The middle of the cap.
    pub axis: Vec3,
    /// `1 - cos` of its half angle; above 2 for all directions.
    pub height: f32,
}

impl Target {
    /// A ball, to be crossed in any direction.
    pub fn ball(center: Vec3, radius: f32) -> Self {
        Self { center, radius, radius_squared: radius * radius, axis: Vec3::Z, height: ALL_DIRECTIONS }
    }

    /// The directions to draw from for lines that come from another ball: the smaller of the cone that holds all lines
    /// which cross both balls, and the cap.
    pub fn directions(&self, from: Vec3, from_radius: f32) -> (Vec3, f32) {
        let (axis, height) = cone(from, from_radius, self.center, self.radius);
        if self.height < height { (self.axis, self.height) } else { (axis, height) }
    }

    /// True if the half line from `origin` crosses the ball. Whatever asks for the weight of a line asks this, so that a
    /// line belongs to a component or does not, whichever component drew it.
    #[inline]
    pub fn is_crossed(&self, origin: Vec3, direction: Vec3) -> bool {
        let f = origin - self.center;
        let b = f.dot(direction);
        let nearest = f - direction * b;
        nearest.dot(nearest) < self.radius_squared
            && (b < 0.0 || f.dot(f) < self.radius_squared)
            && 1.0 - direction.dot(self.axis) < self.height
    }
}

/// The cone of directions of all lines that cross both of two balls: its axis, and `1 - cos` of its half angle. All
/// directions if the balls touch.
pub fn cone(from: Vec3, from_radius: f32, to: Vec3, to_radius: f32) -> (Vec3, f32) {
    let axis = to - from;
    let d2 = axis.dot(axis);
    let reach = from_radius + to_radius;
    let sin2 = reach * reach / d2;
    if sin2 < 1.0 { (axis * (1.0 / d2.sqrt()), sin2 / (1.0 + (1.0 - sin2).sqrt())) } else { (Vec3::Z, 2.0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The sine of the half angle is both radii over the distance.
    #[test]
    fn a_cone_holds_all_lines_through_both_balls() {
        let (axis, height) = cone(Vec3::ZERO, 1.0, Vec3::X * 10.0, 5.0);
        assert_eq!(axis, Vec3::X);
        assert!((height - 0.2).abs() < 1e-6, "{height}"); // 1 - cos, of a sine of 0.6
        // Balls that touch are crossed by lines of all directions.
        assert_eq!(cone(Vec3::ZERO, 5.0, Vec3::X * 10.0, 5.0).1, 2.0);
        assert_eq!(cone(Vec3::ZERO, 1.0, Vec3::ZERO, 1.0).1, 2.0);
    }

    /// The smaller of the cone and the cap is drawn from.
    #[test]
    fn directions_are_those_of_the_smaller_cone() {
        let ball = Target::ball(Vec3::X * 10.0, 5.0);
        let narrow = Target { axis: Vec3::Y, height: 0.1, ..ball };
        let wide = Target { height: 0.3, ..narrow };
        assert_eq!(narrow.directions(Vec3::ZERO, 1.0), (Vec3::Y, 0.1));
        assert_eq!(wide.directions(Vec3::ZERO, 1.0), cone(Vec3::ZERO, 1.0, ball.center, 5.0));
        assert_eq!(ball.directions(Vec3::ZERO, 1.0), cone(Vec3::ZERO, 1.0, ball.center, 5.0));
    }

    #[test]
    fn half_lines_cross_what_is_before_them() {
        let ball = Target::ball(Vec3::X * 10.0, 2.0);
        let crosses = |x: f32, y: f32, direction| ball.is_crossed(Vec3::new(x, y, 0.0), direction);
        assert!(crosses(0.0, 0.0, Vec3::X) && crosses(0.0, 1.99, Vec3::X) && crosses(20.0, 0.0, Vec3::NEG_X));
        assert!(
            !crosses(0.0, 2.01, Vec3::X) && !crosses(0.0, 0.0, Vec3::NEG_X) && !crosses(20.0, 0.0, Vec3::X)
        );
        // From within, in every direction.
        assert!(
            crosses(11.5, 0.0, Vec3::X) && crosses(8.5, 0.0, Vec3::NEG_X) && !crosses(12.5, 0.0, Vec3::X)
        );
        let cap = Target { axis: Vec3::X, height: 0.1, ..ball };
        let tilted = |cos: f32| Vec3::new(cos, (1.0 - cos * cos).sqrt(), 0.0);
        assert!(cap.is_crossed(ball.center, tilted(0.91)) && !cap.is_crossed(ball.center, tilted(0.89)));
    }
}
