//! A table of cells with probabilities, by which two uniform numbers are bent.

/// Cells along either number.
pub const SIDE: usize = 8;

/// Rows of a table: one for the first number, and for each of its cells one for the second.
pub const ROWS: usize = SIDE + 1;

/// The least share of the photons of a table that is spread evenly over its cells: no photon weighs more than its inverse.
pub const EVEN_SHARE: f64 = 3.0 / 8.0;

/// Probabilities are multiples of one over this, so that differences of cumulative ones are exact.
const UNIT: f64 = 65536.0;

/// Two numbers bent by a table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Guided {
    /// The first, in \[0, 1\].
    pub u: f32,
    /// The second, in \[0, 1\].
    pub v: f32,
    /// One over the density of both together.
    pub weight: f32,
}

/// A number for each cell of a table.
pub type Shares = [[f64; SIDE]; SIDE];

/// The width and the area of a cell in the unit square.
pub(super) const WIDTH: f32 = 1.0 / SIDE as f32;
const AREA: f32 = 1.0 / (SIDE * SIDE) as f32;

/// The share of a cell of all.
pub(super) const CELL: f64 = 1.0 / (SIDE * SIDE) as f64;

/// The probabilities of cells that have these shares, together 1, of what is not spread evenly.
pub(super) fn probabilities(shares: &Shares) -> Shares {
    shares.map(|row| row.map(|share| (1.0 - EVEN_SHARE) * share + EVEN_SHARE * CELL))
}

/// The rows of a table whose cells have these shares.
pub(super) fn rows(shares: &Shares) -> [[f32; SIDE]; ROWS] {
    let probabilities = probabilities(shares);
    let mut rows = [[0.0; SIDE]; ROWS];
    rows[0] = cumulate(&probabilities.map(|row| row.iter().sum()));
    for (row, probabilities) in rows[1..].iter_mut().zip(&probabilities) {
        *row = cumulate(probabilities);
    }
    rows
}

/// Cumulative probabilities: that of each cell or one before. The last is 1.
fn cumulate(probabilities: &[f64; SIDE]) -> [f32; SIDE] {
    let all: f64 = probabilities.iter().sum();
    let mut sum = 0.0;
    probabilities.map(|probability| {
        sum += probability;
        (f64::from((sum / all * UNIT + 0.5) as u32) / UNIT) as f32
    })
}

/// Bends two uniform numbers by the rows of a table.
///
/// Each is mapped within its cell, so strata stay strata. Rounding may give the upper end of the last cell, which is 1: a
/// direction as good as others.
pub(super) fn guided(rows: &[[f32; SIDE]], u: f32, v: f32) -> Guided {
    let (cell, u, of_u) = bend(&rows[0], u);
    let (_, v, of_v) = bend(&rows[1 + cell], v);
    Guided { u, v, weight: AREA / (of_u * of_v) }
}

/// The weight of each cell of a table: that of [`guided`] numbers in it.
pub(super) fn weights_of(table: &[[f32; SIDE]]) -> Shares {
    let width = |row: &[f32; SIDE], cell: usize| row[cell] - if cell > 0 { row[cell - 1] } else { 0.0 };
    std::array::from_fn(|u| {
        let of_u = width(&table[0], u);
        std::array::from_fn(|v| f64::from(AREA / (of_u * width(&table[1 + u], v))))
    })
}

/// The cell that a uniform number chooses by cumulative probabilities, the number bent into it, and the cell's probability.
fn bend(row: &[f32; SIDE], u: f32) -> (usize, f32, f32) {
    let cell = row[..SIDE - 1].iter().filter(|&&end| end <= u).count();
    let before = if cell > 0 { row[cell - 1] } else { 0.0 };
    let probability = row[cell] - before;
    (cell, (cell as f32 + (u - before) / probability) * WIDTH, probability)
}
