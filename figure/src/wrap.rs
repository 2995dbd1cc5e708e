//! Particles moved into their periodic cell.

use glam::{DMat3, DVec3};
use importers::Cell;

/// Moves each position into `cell` along the vectors by which it repeats.
pub(crate) fn wrap(positions: &mut [[f64; 3]], cell: &Cell) {
    let origin = DVec3::from_array(cell.origin);
    let vectors = DMat3::from_cols_array_2d(&cell.vectors);
    let shares_of = vectors.inverse();
    for position in positions {
        let place = DVec3::from_array(*position);
        let shares = shares_of * (place - origin);
        let turns =
            DVec3::from_array([0, 1, 2].map(|i| if cell.periodic[i] { shares[i].floor() } else { 0.0 }));
        if turns != DVec3::ZERO && turns.is_finite() {
            *position = (place - vectors * turns).to_array();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_come_into_a_slanting_cell() {
        let vectors = [[4.0, 0.0, 0.0], [2.0, 4.0, 0.0], [0.0, 0.0, 2.0]];
        let cell = Cell { origin: [1.0, 0.0, 0.0], vectors, periodic: [true, true, false] };
        let mut positions = [[2.0, 0.5, 1.0], [2.5, -3.0, 5.0], [1.0, 0.0, 0.0], [13.0, 8.5, -1.0]];
        wrap(&mut positions, &cell);
        assert_eq!(positions, [[2.0, 0.5, 1.0], [4.5, 1.0, 5.0], [1.0, 0.0, 0.0], [5.0, 0.5, -1.0]]);
    }
}
