//! What the guide's tables hold, by what a survey has found.
//!
//! Walks from the eye go the ways of light backwards. Where one leaves a surface that the eye sees, by the cosine, and meets
//! another at some point, photons that leave that point along the same line land where they are seen: the density of these
//! lines, over that of photons that leave by the cosine, is the number of pixels in the place where they land. So cells
//! that hold many lines should get many photons. Where a lamp shines on what a walk meets, it should send photons there.

use super::found::{Edge, Found, Lit};
use super::table::{CELL, ROWS, SIDE, Shares, rows, weights_of};
use super::tables::{FACES, Guide, PARTS, SURFACES};
use crate::ranks::range_within;
use crate::sobol::sobol;
use glam::Vec3;

/// Fewer lines than this tell nothing.
const LEAST_EDGES: usize = 256;

/// A table of which so many lines are known trusts them and what is likely alike: for surfaces, all that face the same way.
const DOUBT: f64 = 128.0;

/// Walks are weighted by one over the brightness of their tile of the image: its photons are noise in proportion to that. Tiles
/// of `2^TILE_BITS` along either axis.
const TILE_BITS: u32 = 4;

/// The share of the mean square that is added to the square of a tile's brightness: that of the metric, relative mean square
/// errors of blocks.
const FLOOR: f64 = 0.01;

/// Runs of so many walks belong to one half or the other, in turn. Neighbouring numbers would divide the image: of Sobol points
/// the lowest bit of the number is the highest of the place.
const HALVED: u32 = 64;

/// The share of the places that lie before the box of parts, and of those behind it, along each axis.
const OUTSIDE: usize = 50;
/// Of so many places, at most.
const MOST_PLACES: usize = 4096;

/// The values of the cells of a table, and what they are known by.
#[derive(Clone, Copy, Default)]
struct Values {
    cells: [[f64; SIDE]; SIDE],
    sum: f64,
    squares: f64,
}

impl Values {
    fn add(&mut self, [u, v]: [usize; 2], weight: f64) {
        self.cells[u][v] += weight;
        self.sum += weight;
        self.squares += weight * weight;
    }

    fn extend(&mut self, other: &Self) {
        for (cells, others) in self.cells.iter_mut().flatten().zip(other.cells.iter().flatten()) {
            *cells += others;
        }
        self.sum += other.sum;
        self.squares += other.squares;
    }

    /// Whether a line has been found, of a weight that counts.
    fn is_known(&self) -> bool {
        self.squares > 0.0
    }

    /// The shares of the cells, by these values and by what is thought likely without them.
    fn shares(&self, likely: &Shares) -> Shares {
        // Lines of equal weight that would tell as much.
        let lines = if self.is_known() { self.sum * self.sum / self.squares } else { 0.0 };
        let (known, scale) = (lines + DOUBT, if self.sum > 0.0 { lines / self.sum } else { 0.0 });
        std::array::from_fn(|u| {
            std::array::from_fn(|v| (self.cells[u][v] * scale + likely[u][v] * DOUBT) / known)
        })
    }
}

/// All cells alike.
const EVEN: Shares = [[CELL; SIDE]; SIDE];

/// The rows of all tables of surfaces. Those that face the same way are likely to be alike.
fn rows_of_surfaces(tables: &[Values]) -> impl Iterator<Item = [[f32; SIDE]; ROWS]> {
    let faces = FACES as usize;
    let of_face = |face: usize| {
        let mut all = Values::default();
        tables.iter().skip(face).step_by(faces).for_each(|values| all.extend(values));
        all.shares(&EVEN)
    };
    let likely: Vec<Shares> = (0..faces).map(of_face).collect();
    // Of most tables nothing is known: their shares are those that are likely, bit for bit, as `DOUBT` is a power of two.
    let rows_of_likely: Vec<_> = likely.iter().map(rows).collect();
    tables.iter().enumerate().map(move |(table, values)| {
        let face = table % faces;
        if values.is_known() { rows(&values.shares(&likely[face])) } else { rows_of_likely[face] }
    })
}

/// The values of all tables.
#[derive(Clone)]
struct Learnt {
    surfaces: Vec<Values>,
    lamps: Values,
}

impl Learnt {
    /// By what half of the walks have found: those in runs of even or of odd numbers.
    fn of(parity: u32, guide: &Guide, weights: &Weights, found: &[Found]) -> Self {
        let mut learnt =
            Self { surfaces: vec![Values::default(); SURFACES as usize], lamps: Values::default() };
        let is_one = |walk: u32| walk / HALVED % 2 == parity;
        for edge in found.iter().flat_map(|found| &found.edges).filter(|edge| is_one(edge.walk)) {
            let table = guide.surface(edge.point, edge.normal) as usize;
            learnt.surfaces[table].add(cell_of(reversed(edge)), weights.of(edge.walk));
        }
        for Lit { walk, arrival, .. } in found.iter().flat_map(Found::arrivals).filter(|lit| is_one(lit.walk))
        {
            let way = arrival.point - arrival.source;
            let direction = way * (1.0 / way.dot(way).sqrt());
            learnt.lamps.add(cell_of(direction), weights.of(*walk) * f64::from(arrival.flux));
        }
        learnt
    }

    fn extend(&mut self, other: &Self) {
        for (values, others) in self.surfaces.iter_mut().zip(&other.surfaces) {
            values.extend(others);
        }
        self.lamps.extend(&other.lamps);
    }

    /// The guide of these values, with parts as in `guide`.
    fn guide(&self, &Guide { low, scale, .. }: &Guide) -> Guide {
        Guide::of_rows(low, scale, rows_of_surfaces(&self.surfaces), &self.lamps.shares(&EVEN))
    }

    /// The mean weight, by the tables of `guide`, of photons that arrive as these did: in proportion to it is the variance.
    fn mean_weight(&self, guide: &Guide) -> f64 {
        let of_table = |(table, values)| (values, weights_of(guide.table(table)));
        let of_lamps = (&self.lamps, guide.departures.map(|row| row.map(|p| CELL / p)));
        let known = (0..).zip(&self.surfaces).filter(|(_, values)| values.is_known());
        mean_weight(known.map(of_table)) * mean_weight(std::iter::once(of_lamps))
    }
}

impl Guide {
    /// The guide by what the first `walks` walks have found, before the first iteration; `None` if it is expected to leave no
    /// less than `limit` of the variance.
    ///
    /// That is judged by half of the walks, for tables that the other half makes: all tables suit the walks that make them.
    pub fn learn(walks: u32, found: &[Found], limit: f64) -> Option<Self> {
        let edges = || found.iter().flat_map(|found| &found.edges);
        if edges().count() < LEAST_EDGES {
            return None;
        }
        let (low, scale) = box_of_parts(edges());
        let parts = Self { low, scale, ..Self::default() };
        let weights = Weights::new(walks, found);
        let [mut half, other] = [0, 1].map(|parity| Learnt::of(parity, &parts, &weights, found));
        let expected = other.mean_weight(&half.guide(&parts));
        if expected >= limit {
            return None;
        }
        half.extend(&other);
        Some(Self { expected, ..half.guide(&parts) })
    }
}

/// The mean weight of what cells hold.
fn mean_weight<'a>(tables: impl Iterator<Item = (&'a Values, Shares)>) -> f64 {
    let (mut sum, mut of_weights) = (0.0, 0.0);
    for (values, weights) in tables {
        for (value, weight) in values.cells.iter().flatten().zip(weights.iter().flatten()) {
            sum += value;
            of_weights += value * weight;
        }
    }
    if sum > 0.0 { of_weights / sum } else { 1.0 }
}

/// What a photon is worth to a walk's pixel, over the mean: one over the brightness of its tile.
struct Weights {
    /// Of each tile.
    weights: Vec<f64>,
    /// Of each walk the tile.
    tiles: Vec<u8>,
}

// A tile is told by a byte.
const _: () = assert!(2 * TILE_BITS <= u8::BITS);

impl Weights {
    fn new(walks: u32, found: &[Found]) -> Self {
        let tiles = tiles_of(walks);
        let mut sums = vec![(0.0, 0.0); 1 << (2 * TILE_BITS)];
        for tile in &tiles {
            sums[usize::from(*tile)].1 += 1.0;
        }
        for lit in found.iter().flat_map(|found| &found.lit) {
            sums[usize::from(tiles[lit.walk as usize])].0 += f64::from(lit.arrival.flux);
        }
        let mean = sums.iter().map(|(flux, _)| flux).sum::<f64>() / f64::from(walks.max(1));
        let weight = |&(flux, walks): &(f64, f64)| {
            let brightness = if walks > 0.0 { flux / walks } else { 0.0 };
            let square = brightness * brightness + FLOOR * mean * mean;
            if square > 0.0 { mean / square.sqrt() } else { 1.0 }
        };
        Self { weights: sums.iter().map(weight).collect(), tiles }
    }

    fn of(&self, walk: u32) -> f64 {
        self.weights[usize::from(self.tiles[walk as usize])]
    }
}

/// The tiles of so many walks.
fn tiles_of(walks: u32) -> Vec<u8> {
    /// As Sobol points, tiles are the exclusive or of what the low bits of the number and the other bits contribute.
    const LOW: u32 = 256;
    let low: Vec<u8> = (0..LOW).map(tile_of).collect();
    let run = |first: u32| {
        let high = tile_of(first);
        low.iter().take((walks - first).min(LOW) as usize).map(move |low| low ^ high)
    };
    (0..walks).step_by(LOW as usize).flat_map(run).collect()
}

/// The tile of the image in which a walk begins: as engines begin them, by its Sobol point.
fn tile_of(walk: u32) -> u8 {
    let [x, y] = [0, 1].map(|d| sobol(walk, d) >> (u32::BITS - TILE_BITS));
    (y << TILE_BITS | x) as u8
}

/// The low corner and the scale of a box of parts, which holds nearly all places.
fn box_of_parts<'a>(edges: impl Iterator<Item = &'a Edge>) -> (Vec3, f32) {
    let points: Vec<Vec3> = edges.take(MOST_PLACES).map(|edge| edge.point).collect();
    let outside = points.len() / OUTSIDE;
    let range = |axis: usize| range_within(points.iter().map(|point| point[axis]).collect(), outside);
    let ranges = [0, 1, 2].map(range);
    let longest = ranges.iter().map(|[low, high]| high - low).fold(0.0, f32::max);
    let scale = if longest > 0.0 { PARTS as f32 / longest } else { 0.0 };
    (Vec3::from(ranges.map(|[low, _]| low)), scale)
}

/// The point of the unit sphere that [the cosine's map](super) takes to the direction of an edge: the direction is that of
/// the normal plus this point.
fn reversed(edge: &Edge) -> Vec3 {
    edge.direction * (2.0 * edge.direction.dot(edge.normal)) - edge.normal
}

/// The cell of the two numbers that are mapped to a point of the unit sphere: the height, and the turn around the axis z.
fn cell_of(point: Vec3) -> [usize; 2] {
    let Vec3 { x, y, z } = point;
    let height = (0.5 * (1.0 - z) * SIDE as f32) as usize;
    let (quarter, along, across) = match (x >= 0.0, y >= 0.0) {
        (true, true) => (0, x, y),
        (false, true) => (1, y, -x),
        (false, false) => (2, -x, -y),
        (true, false) => (3, -y, x),
    };
    [height.min(SIDE - 1), 2 * quarter + usize::from(across >= along)]
}

// Octants are the cells of a turn.
const _: () = assert!(SIDE == 8);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_of_walks_are_those_of_their_points() {
        for walks in [0, 1, 255, 256, 257, 1000] {
            assert_eq!(tiles_of(walks), (0..walks).map(tile_of).collect::<Vec<u8>>());
        }
    }
}
