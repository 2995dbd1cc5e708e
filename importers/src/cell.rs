//! Periodic cells: made from what files state, wrapping, and edges.

use crate::particles::{Cell, Particles};

/// A cell, if the numbers are finite and the vectors are linearly independent: files write zeros for "no cell".
pub(crate) fn cell(origin: [f64; 3], vectors: [[f64; 3]; 3], periodic: [bool; 3]) -> Option<Cell> {
    let numbers = origin.iter().chain(vectors.iter().flatten());
    if !numbers.into_iter().all(|number| number.abs() <= Particles::FARTHEST) {
        return None;
    }
    let cell = Cell { origin, vectors, periodic };
    cell.reciprocal().map(|_| cell)
}

/// A cell by the lengths of its edges and the angles between them in degrees: the first edge along x, the second in the
/// plane of x and y, as crystallographers place them.
pub(crate) fn by_angles(lengths: [f64; 3], degrees: [f64; 3]) -> Option<Cell> {
    let [a, b, c] = lengths;
    // Right angles are exact.
    let cos = degrees.map(|angle| if angle == 90.0 { 0.0 } else { angle.to_radians().cos() });
    let sin_gamma = (1.0 - cos[2] * cos[2]).sqrt();
    let (x, y) = (cos[1], (cos[0] - cos[1] * cos[2]) / sin_gamma);
    let z = (1.0 - x * x - y * y).sqrt();
    let vectors = [[a, 0.0, 0.0], [b * cos[2], b * sin_gamma, 0.0], [c * x, c * y, c * z]];
    cell([0.0; 3], vectors, [true; 3])
}

/// The cell along whose vectors these rows, with the constants added, give the coordinates of a point.
pub(crate) fn inverse(rows: [[f64; 3]; 3], constants: [f64; 3], periodic: [bool; 3]) -> Option<Cell> {
    // The rows are the vectors of a cell whose coordinates' gradients are the vectors that are looked for.
    let dual = cell([0.0; 3], rows, periodic)?;
    let vectors = dual.reciprocal()?;
    let from = |axis: usize| -(0..3).map(|vector| constants[vector] * vectors[vector][axis]).sum::<f64>();
    cell(std::array::from_fn(from), vectors, periodic)
}

impl Cell {
    /// The point with these coordinates along the cell's vectors, 0 to 1 inside.
    pub fn point(&self, fractions: [f64; 3]) -> [f64; 3] {
        let [a, b, c] = self.vectors;
        let [u, v, w] = fractions;
        std::array::from_fn(|axis| self.origin[axis] + u * a[axis] + v * b[axis] + w * c[axis])
    }

    /// The coordinates of a point along the cell's vectors.
    pub fn fractions(&self, point: [f64; 3]) -> [f64; 3] {
        let from = std::array::from_fn(|axis| point[axis] - self.origin[axis]);
        self.reciprocal().unwrap_or_default().map(|row| dot(row, from))
    }

    /// Moves a point into the cell along the vectors that repeat.
    pub fn wrap(&self, point: [f64; 3]) -> [f64; 3] {
        let fractions = self.fractions(point);
        let mut wrapped = point;
        for (vector, (fraction, repeats)) in self.vectors.iter().zip(fractions.into_iter().zip(self.periodic))
        {
            let turns = if repeats { fraction.floor() } else { 0.0 };
            for (coordinate, component) in wrapped.iter_mut().zip(vector) {
                *coordinate -= turns * component;
            }
        }
        wrapped
    }

    /// The eight corners: bit 0 of the index goes along the first vector, bit 1 along the second, bit 2 along the third.
    pub fn corners(&self) -> [[f64; 3]; 8] {
        std::array::from_fn(|corner| self.point([0, 1, 2].map(|bit| f64::from(corner as u32 >> bit & 1))))
    }

    /// The twelve edges, as pairs of corners.
    pub fn edges(&self) -> [[[f64; 3]; 2]; 12] {
        let corners = self.corners();
        let mut edges = [[[0.0; 3]; 2]; 12];
        let pairs = (0..8).flat_map(|from| [1, 2, 4].map(|bit| (from, from | bit)));
        for (edge, (from, to)) in edges.iter_mut().zip(pairs.filter(|(from, to)| from != to)) {
            *edge = [corners[from], corners[to]];
        }
        edges
    }

    /// Points along the edges, evenly spaced and at most `spacing` apart, corners among them once each: where small balls
    /// stand that draw the cell.
    ///
    /// # Panics
    /// If the spacing is not positive.
    pub fn beads(&self, spacing: f64) -> Vec<[f64; 3]> {
        /// No picture shows more on an edge.
        const MOST: f64 = 1e5;
        assert!(spacing > 0.0, "a spacing of {spacing}");
        let mut beads = self.corners().to_vec();
        for [from, to] in self.edges() {
            let along: [f64; 3] = std::array::from_fn(|axis| to[axis] - from[axis]);
            let steps = (dot(along, along).sqrt() / spacing).ceil().clamp(1.0, MOST);
            for step in 1..steps as u32 {
                let share = f64::from(step) / steps;
                beads.push(std::array::from_fn(|axis| from[axis] + share * along[axis]));
            }
        }
        beads
    }

    /// The volume.
    pub fn volume(&self) -> f64 {
        let [a, b, c] = self.vectors;
        dot(a, cross(b, c)).abs()
    }

    /// Rows that give the coordinates along the vectors; `None` if the vectors are not linearly independent.
    fn reciprocal(&self) -> Option<[[f64; 3]; 3]> {
        /// The least volume, as a share of that of a box with edges of the same lengths.
        const FLAT: f64 = 1e-9;
        let [a, b, c] = self.vectors;
        let volume = dot(a, cross(b, c));
        let most = [a, b, c].map(|vector| dot(vector, vector).sqrt()).iter().product::<f64>();
        if !(volume.is_finite() && volume.abs() > FLAT * most) {
            return None;
        }
        Some([cross(b, c), cross(c, a), cross(a, b)].map(|row| row.map(|number| number / volume)))
    }
}

impl Particles {
    /// Moves all particles into the cell, along the vectors that repeat. Without a cell nothing moves.
    pub fn wrap(&mut self) {
        let Some(cell) = self.cell else { return };
        for position in &mut self.positions {
            *position = cell.wrap(*position);
        }
    }
}

pub(crate) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of a few operations of size 10.
    const ROUNDING: f64 = 1e-12;

    fn slanted() -> Cell {
        cell([1.0, 2.0, 3.0], [[4.0, 0.0, 0.0], [1.0, 5.0, 0.0], [-1.0, 2.0, 6.0]], [true, true, false])
            .unwrap()
    }

    fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
        let between = std::array::from_fn(|axis| a[axis] - b[axis]);
        dot(between, between).sqrt()
    }

    #[test]
    fn points_are_wrapped_along_vectors_that_repeat() {
        let cell = slanted();
        let inside = [0.25, 0.5, 0.75];
        assert!(distance(cell.fractions(cell.point(inside)), inside) < ROUNDING);
        let wrapped = cell.wrap(cell.point([3.25, -1.5, 1.75]));
        assert!(distance(wrapped, cell.point([0.25, 0.5, 1.75])) < ROUNDING);
        assert_eq!(cell.wrap([1.5, 2.5, 3.5]), [1.5, 2.5, 3.5], "nothing moves that is inside");
    }

    #[test]
    fn edges_join_neighbouring_corners() {
        let cell = slanted();
        let lengths = cell.edges().map(|[from, to]| distance(from, to));
        let total: f64 = cell.vectors.iter().map(|vector| 4.0 * dot(*vector, *vector).sqrt()).sum();
        assert!((lengths.iter().sum::<f64>() - total).abs() < ROUNDING * total);
        assert_eq!(cell.corners()[7], [5.0, 9.0, 9.0]);
        assert!((cell.volume() - 120.0).abs() < ROUNDING * 120.0);
    }

    #[test]
    fn beads_are_evenly_spaced() {
        let cube = cell([0.0; 3], [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], [true; 3]).unwrap();
        assert_eq!(cube.beads(0.5).len(), 8 + 12);
        assert_eq!(cube.beads(9.0).len(), 8);
        assert_eq!(cube.beads(1e-30).len(), 8 + 12 * 99_999, "bounded");
    }

    #[test]
    fn a_flat_or_infinite_cell_is_none() {
        assert_eq!(cell([0.0; 3], [[0.0; 3]; 3], [true; 3]), None);
        assert_eq!(cell([0.0; 3], [[1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 0.0, 1.0]], [true; 3]), None);
        assert_eq!(cell([f64::NAN, 0.0, 0.0], slanted().vectors, [true; 3]), None);
        assert_eq!(by_angles([1.0, 1.0, 1.0], [10.0, 10.0, 90.0]), None);
    }

    #[test]
    fn an_inverse_gives_back_the_cell() {
        let cell = slanted();
        let origin = cell.fractions([0.0; 3]);
        let again = inverse(cell.reciprocal().unwrap(), origin, cell.periodic).unwrap();
        assert!(distance(again.origin, cell.origin) < ROUNDING);
        assert!(again.vectors.iter().zip(cell.vectors).all(|(a, b)| distance(*a, b) < ROUNDING));
    }

    #[test]
    fn angles_are_those_between_the_edges() {
        let degrees = [80.0, 95.0, 110.0];
        let cell = by_angles([3.0, 4.0, 5.0], degrees).unwrap();
        let [a, b, c] = cell.vectors;
        let angle = |u, v| (dot(u, v) / (dot(u, u) * dot(v, v)).sqrt()).acos().to_degrees();
        for (got, wanted) in [angle(b, c), angle(a, c), angle(a, b)].into_iter().zip(degrees) {
            assert!((got - wanted).abs() < 1e-9, "{got} {wanted}");
        }
    }
}
