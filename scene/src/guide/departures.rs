//! Directions of photons that leave lamps: each cell of directions gets a run of an iteration's photons.

use super::table::{CELL, SIDE, Shares, WIDTH};

/// Photons are given to cells, and to what they are aimed at, in multiples of this, but for the last: no vector of photons is
/// of two.
pub const RUN: u32 = 16;

/// Of fewer photons in an iteration none are guided as they leave: cells would have hardly any.
const LEAST_PHOTONS: u32 = 8192;

/// Which photons of an iteration leave into which cell of directions.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Departures {
    /// The first photon after those of each cell.
    ends: Vec<u32>,
    /// What photons of each cell weigh.
    weights: Vec<f32>,
}

/// The cell of directions of a photon.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// Its low corner in the unit square, in cells.
    pub corner: [f32; 2],
    /// What the photon weighs.
    pub weight: f32,
}

impl Cell {
    /// Two uniform numbers, moved into the cell.
    pub fn place(&self, u: f32, v: f32) -> (f32, f32) {
        ((self.corner[0] + u) * WIDTH, (self.corner[1] + v) * WIDTH)
    }
}

impl Departures {
    /// Those of so many photons, by the probabilities of the cells; `None` if there are too few.
    pub fn new(probabilities: &Shares, photons: u32) -> Option<Self> {
        if photons < LEAST_PHOTONS {
            return None;
        }
        let (mut sum, mut before) = (0.0, 0);
        let mut departures = Self::default();
        for probability in probabilities.iter().flatten() {
            sum += probability;
            let is_last = departures.ends.len() + 1 == SIDE * SIDE;
            let end = (sum * f64::from(photons)) as u32;
            let end = if is_last { photons } else { end - end % RUN };
            departures.weights.push((CELL * f64::from(photons) / f64::from(end - before)) as f32);
            departures.ends.push(end);
            before = end;
        }
        Some(departures)
    }

    /// The cell of a photon. Those of a run of [`RUN`] have the same.
    pub fn cell(&self, photon: u32) -> Cell {
        let cell = self.ends.partition_point(|&end| end <= photon);
        let corner = [(cell / SIDE) as f32, (cell % SIDE) as f32];
        Cell { corner, weight: self.weights[cell] }
    }
}
