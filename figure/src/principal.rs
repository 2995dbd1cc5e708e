//! Principal axes of a set of points.

use glam::{DMat3, DVec3};

/// The principal axes of `points`, that of the greatest spread first: unit vectors, right-handed. The greatest component
/// of the first two is positive.
pub(crate) fn axes(points: impl Iterator<Item = DVec3> + Clone) -> [DVec3; 3] {
    let (sum, count) = points.clone().fold((DVec3::ZERO, 0.0), |(sum, count), p| (sum + p, count + 1.0));
    let mean = sum / f64::max(count, 1.0);
    let mut spread = DMat3::ZERO;
    for p in points {
        let d = p - mean;
        spread += DMat3::from_cols(d * d.x, d * d.y, d * d.z);
    }
    let (values, vectors) = eigen(spread);
    let mut order = [0, 1, 2];
    // Of equal spreads the earlier axis comes first, so a cube is seen from its front.
    order.sort_by(|&a, &b| values[b].total_cmp(&values[a]));
    let [first, second] = [order[0], order[1]].map(|i| upright(vectors.col(i)));
    [first, second, first.cross(second)]
}

/// The vector or its opposite: that whose greatest component is positive.
fn upright(v: DVec3) -> DVec3 {
    let [x, y, z] = v.to_array();
    let greatest = [x, y, z].into_iter().fold(0.0, |a: f64, b| if b.abs() > a.abs() { b } else { a });
    if greatest < 0.0 { -v } else { v }
}

/// Eigenvalues and eigenvectors of a symmetric matrix, by Jacobi's rotations (Golub and Van Loan, "Matrix Computations",
/// 8.5). Only exactly rounded operations, so that the same file gives the same camera on every machine.
fn eigen(mut m: DMat3) -> (DVec3, DMat3) {
    /// Convergence is quadratic; six sweeps are usual.
    const SWEEPS: usize = 16;
    let mut vectors = DMat3::IDENTITY;
    for _ in 0..SWEEPS {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            let off = m.col(q)[p];
            if off == 0.0 {
                continue;
            }
            let theta = (m.col(q)[q] - m.col(p)[p]) / (2.0 * off);
            let sign = if theta < 0.0 { -1.0 } else { 1.0 };
            let t = sign / (theta.abs() + (theta * theta + 1.0).sqrt());
            let c = 1.0 / (t * t + 1.0).sqrt();
            let s = t * c;
            let mut turn = DMat3::IDENTITY;
            turn.col_mut(p)[p] = c;
            turn.col_mut(q)[q] = c;
            turn.col_mut(q)[p] = s;
            turn.col_mut(p)[q] = -s;
            m = turn.transpose() * m * turn;
            vectors *= turn;
        }
    }
    (DVec3::new(m.col(0)[0], m.col(1)[1], m.col(2)[2]), vectors)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A rounding error of sums over the points, relative to their extent.
    const TOLERANCE: f64 = 1e-9;

    #[test]
    fn a_slanting_rod_and_a_plate_are_told() {
        let along = DVec3::new(1.0, 2.0, -2.0) / 3.0;
        let across = DVec3::new(2.0, 1.0, 2.0) / 3.0;
        let points = (0..50).map(|i| {
            let t = f64::from(i);
            along * t + across * (t * 7.0 % 5.0) + DVec3::splat(1e3)
        });
        let [first, second, third] = axes(points);
        assert!(first.dot(along).abs() > 0.999, "{first}");
        assert!(second.dot(across).abs() > 0.999, "{second}");
        assert!(third.dot(along.cross(across)).abs() > 0.999, "{third}");
    }

    #[test]
    fn what_has_no_shape_has_the_axes_of_its_file() {
        for points in [vec![], vec![DVec3::ONE], vec![DVec3::ONE; 3], vec![-DVec3::X, DVec3::X]] {
            assert_eq!(axes(points.iter().copied()), [DVec3::X, DVec3::Y, DVec3::Z]);
        }
    }

    proptest! {
        #[test]
        fn axes_are_orthonormal(points in prop::collection::vec(prop::array::uniform3(-1e3..1e3), 0..20)) {
            let [a, b, c] = axes(points.iter().map(|p| DVec3::from_array(*p)));
            let frame = DMat3::from_cols(a, b, c);
            prop_assert!((frame * frame.transpose()).abs_diff_eq(DMat3::IDENTITY, TOLERANCE), "{frame}");
            prop_assert!(frame.determinant() > 0.0);
        }
    }
}
