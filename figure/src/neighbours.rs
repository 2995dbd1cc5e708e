//! The usual distance between nearest neighbours.

use rayon::slice::ParallelSliceMut as _;

/// Particles whose neighbours are searched; enough for a median.
const SAMPLES: usize = 1000;

/// The median distance from a particle to its nearest neighbour, of those that do not coincide; `None` if there are no
/// such two. It does not depend on the order of the particles.
///
/// Particles are sorted along the axis of their greatest extent, and searched from each sample to both sides.
pub(crate) fn nearest(positions: &[[f64; 3]]) -> Option<f64> {
    let axis = widest(positions);
    let mut sorted = positions.to_vec();
    sorted.par_sort_unstable_by(|a, b| {
        let key = |p: &[f64; 3]| [p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]];
        let (a, b) = (key(a), key(b));
        a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])).then(a[2].total_cmp(&b[2]))
    });
    let step = sorted.len().div_ceil(SAMPLES).max(1);
    let samples = (step / 2..sorted.len()).step_by(step);
    let mut distances: Vec<f64> = samples.filter_map(|i| nearest_to(&sorted, i, axis)).collect();
    distances.sort_unstable_by(f64::total_cmp);
    distances.get(distances.len() / 2).map(|squared| squared.sqrt())
}

fn widest(positions: &[[f64; 3]]) -> usize {
    let extent = |axis: usize| {
        let (low, high) = positions
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| (low.min(p[axis]), high.max(p[axis])));
        high - low
    };
    let extents = [0, 1, 2].map(extent);
    (0..3).max_by(|&a, &b| extents[a].total_cmp(&extents[b])).unwrap_or(0)
}

/// The squared distance from particle `i` to the nearest one elsewhere.
fn nearest_to(sorted: &[[f64; 3]], i: usize, axis: usize) -> Option<f64> {
    let here = sorted[i];
    let mut least = f64::INFINITY;
    let mut search = |there: &[f64; 3]| {
        let apart = [0, 1, 2].map(|axis| there[axis] - here[axis]);
        let squared = apart.iter().map(|x| x * x).sum::<f64>();
        if squared > 0.0 && squared < least {
            least = squared;
        }
        apart[axis] * apart[axis] <= least
    };
    let _ = sorted[..i].iter().rev().all(&mut search);
    let _ = sorted[i + 1..].iter().all(&mut search);
    least.is_finite().then_some(least)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_distance_of_neighbours_is_that_of_a_lattice() {
        let mut lattice: Vec<[f64; 3]> = (0..20)
            .flat_map(|x| {
                (0..20).flat_map(move |y| (0..20).map(move |z| [x, y, z].map(|i| f64::from(i) * 0.3)))
            })
            .collect();
        lattice.push([1e3, 0.0, 0.0]);
        let distance = nearest(&lattice).unwrap();
        assert!((distance - 0.3).abs() < 1e-9, "{distance}");
        lattice.reverse();
        assert_eq!(nearest(&lattice), Some(distance));
    }

    #[test]
    fn what_coincides_is_no_neighbour() {
        assert_eq!(nearest(&[]), None);
        assert_eq!(nearest(&[[1.0; 3]]), None);
        assert_eq!(nearest(&[[1.0; 3], [1.0; 3]]), None);
        assert_eq!(nearest(&[[1.0; 3], [1.0; 3], [1.0, 1.0, 3.0]]), Some(2.0));
    }
}
