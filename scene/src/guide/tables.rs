//! The tables of a guide, and which of them a surface has.

use super::table::{Guided, ROWS, SIDE, Shares, guided, probabilities, rows};
use glam::Vec3;

/// Parts of the scene along its longest axis.
pub const PARTS: u32 = 4;
/// Parts differ in the axis nearest to their normals, and in its sign.
pub const FACES: u32 = 6;
/// Tables of surfaces.
pub const SURFACES: u32 = PARTS * PARTS * PARTS * FACES;

/// Where photons should go.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Guide {
    /// The least corner of the box of parts.
    pub low: Vec3,
    /// Parts per unit of length.
    pub scale: f32,
    /// For each table of surfaces the rows of its cells: cumulative probabilities along the first number, and for each cell of
    /// it along the second.
    pub rows: Vec<[f32; SIDE]>,
    /// The probabilities of the cells of directions from lamps.
    pub departures: Shares,
    /// The variance that photons are expected to leave, over that of photons that are not guided.
    pub expected: f64,
}

impl Guide {
    /// Bytes of the tables, here and in an engine, and of what they are made from: the values of both halves of the walks and the
    /// shares, with reserve.
    pub(crate) const BYTES: u64 = SURFACES as u64 * (ROWS * SIDE * 8 + 4 * SIDE * SIDE * 8) as u64;

    /// The guide whose tables of surfaces, from number 0 on, and of directions from lamps have these shares, each together 1, of
    /// what is not spread evenly. Parts begin at `low`, and there are `scale` of them per unit of length.
    pub fn of_shares(low: Vec3, scale: f32, surfaces: impl Iterator<Item = Shares>, lamps: &Shares) -> Self {
        Self::of_rows(low, scale, surfaces.map(|shares| rows(&shares)), lamps)
    }

    /// As [`Self::of_shares`], by the rows of the tables of surfaces.
    pub(super) fn of_rows(
        low: Vec3,
        scale: f32,
        surfaces: impl Iterator<Item = [[f32; SIDE]; ROWS]>,
        lamps: &Shares,
    ) -> Self {
        let rows = surfaces.take(SURFACES as usize).flatten().collect();
        Self { low, scale, rows, departures: probabilities(lamps), expected: 1.0 }
    }

    /// The table of a surface that faces `normal` at `point`.
    pub fn surface(&self, point: Vec3, normal: Vec3) -> u32 {
        let [x, y, z] = ((point - self.low) * self.scale).to_array().map(part);
        let face = face(normal);
        ((x * PARTS + y) * PARTS + z) * FACES + face
    }

    /// Bends two uniform numbers by a table.
    pub fn guided(&self, table: u32, u: f32, v: f32) -> Guided {
        guided(self.table(table), u, v)
    }

    /// The rows of a table.
    pub(super) fn table(&self, number: u32) -> &[[f32; SIDE]] {
        let first = number as usize * ROWS;
        &self.rows[first..first + ROWS]
    }
}

/// The part along an axis, for a place in parts from the low corner on.
fn part(x: f32) -> u32 {
    let last = (PARTS - 1) as f32;
    let inner = if x > 0.0 { x } else { 0.0 };
    (if inner < last { inner } else { last }) as u32
}

/// The axis nearest to a normal, and whether it points backwards.
fn face(normal: Vec3) -> u32 {
    let Vec3 { x, y, z } = normal.abs();
    let axis = if x >= y && x >= z {
        0
    } else if y >= z {
        1
    } else {
        2
    };
    2 * axis + u32::from(normal[axis as usize] < 0.0)
}
